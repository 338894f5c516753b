//! The values of all touched bricks.

use rayon::prelude::*;

use super::columns;
use super::distance::{Brick, Distances, Scratch};
use super::options::BakeOptions;
use super::side::{Scene, Side};
use super::{scatter::BrickTriangles, sign};
use crate::grid::{BRICK_SIDE, BRICK_VOXELS, BrickGrid, INSIDE};
use crate::index::entry_brick;

/// Counts of voxels, of a brick or of all.
#[derive(Clone, Copy, Default)]
pub(super) struct Counts {
    pub(super) all: usize,
    pub(super) in_band: usize,
    pub(super) ambiguous: usize,
    pub(super) inside: usize,
}

impl Counts {
    pub(super) fn ambiguous_share(&self) -> f64 {
        self.ambiguous as f64 / self.all.max(1) as f64
    }
}

/// Fills the grid's bricks, up to `reach` [voxels] from the triangles; returns the sum of what they hold.
pub(super) fn fill(scene: &Scene, options: &BakeOptions, reach: f64, grid: &mut BrickGrid) -> Counts {
    let mut phi = vec![0.0; scene.near.brick_count() * BRICK_VOXELS];
    let frame = &*grid;
    let counts: Vec<Counts> = phi
        .par_chunks_exact_mut(BRICK_VOXELS)
        .enumerate()
        .map_init(Scratch::default, |scratch, (b, phi)| {
            let brick = frame.origin + entry_brick(scene.near.entry(b), frame.dims);
            let centre = brick.as_dvec3() * BRICK_SIDE as f64 + 3.5;
            let brick_triangles =
                Brick { centre, triangles: scene.near.triangles(b), skin: &scene.skin, reach: reach as f32 };
            let half_shell = options.half_shell();
            let distances = Distances { brick: brick_triangles, grid: frame, half_shell, scratch, phi: &mut *phi };
            let in_band = pulp::Arch::new().dispatch(distances);
            let (ambiguous, inside) = match &scene.side {
                Side::Columns(insides) => (0, columns::apply(&insides.masks[b], phi)),
                Side::Winding(surface) => sign::judge(brick, phi, surface, frame),
                Side::Normals(normals) => (0, sign::judge_by_normals(brick, phi, normals, frame)),
                Side::Shell => (0, phi.iter().filter(|&&phi| phi < 0.0).count()),
            };
            Counts { all: BRICK_VOXELS, in_band, ambiguous, inside }
        })
        .collect();
    collect(phi, &counts, &scene.near, grid);
    counts.iter().fold(Counts::default(), |sum, brick| Counts {
        all: sum.all + brick.all,
        in_band: sum.in_band + brick.in_band,
        ambiguous: sum.ambiguous + brick.ambiguous,
        inside: sum.inside + brick.inside,
    })
}

/// Moves the bricks that hold a part of the band, or both sides, into the grid, and says of the others where they are.
fn collect(mut phi: Vec<f32>, counts: &[Counts], near: &BrickTriangles, grid: &mut BrickGrid) {
    for (b, brick) in counts.iter().enumerate() {
        let at = entry_brick(near.entry(b), grid.dims);
        if brick.in_band > 0 || (brick.inside > 0 && brick.inside < BRICK_VOXELS) {
            let slot = grid.bricks.len();
            grid.index.set(at, slot as u32);
            grid.bricks.push(grid.origin + at);
            if slot < b {
                phi.copy_within(b * BRICK_VOXELS..(b + 1) * BRICK_VOXELS, slot * BRICK_VOXELS);
            }
        } else if brick.inside > 0 {
            grid.index.set(at, INSIDE);
        }
    }
    phi.truncate(grid.bricks.len() * BRICK_VOXELS);
    grid.phi = phi;
}
