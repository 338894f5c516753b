//! Fills the values of all touched bricks.

use std::ops::Range;

use rayon::prelude::*;

use super::columns;
use super::distance::{Brick, Distances, Scratch};
use super::options::BakeOptions;
use super::side::{Scene, Side};
use super::{scatter::BrickTriangles, sign};
use crate::grid::{BRICK_SIDE, BRICK_VOXELS, BrickGrid, INSIDE};
use crate::index::entry_brick;

/// Greatest number of bricks per task; the result does not depend on it.
const BRICKS: usize = 32;

/// Numbers of voxels, of a brick or of all bricks.
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

/// Fills the grid's bricks, up to `reach` [voxels] from the triangles; returns the total numbers of voxels.
pub(super) fn fill(scene: &Scene, options: &BakeOptions, reach: f64, grid: &mut BrickGrid) -> Counts {
    let mut phi = vec![0.0; scene.near.brick_count() * BRICK_VOXELS];
    let frame = &*grid;
    let counts: Vec<Counts> = phi
        .par_chunks_exact_mut(BRICK_VOXELS)
        .enumerate()
        .with_max_len(BRICKS)
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

/// Moves the bricks that contain a part of the band, or both signs, into the grid, and marks the others inside or
/// outside.
fn collect(mut phi: Vec<f32>, counts: &[Counts], near: &BrickTriangles, grid: &mut BrickGrid) {
    let mut runs: Vec<Range<usize>> = Vec::new();
    for (b, brick) in counts.iter().enumerate() {
        let at = entry_brick(near.entry(b), grid.dims);
        if brick.in_band > 0 || (brick.inside > 0 && brick.inside < BRICK_VOXELS) {
            grid.index.set(at, grid.bricks.len() as u32);
            grid.bricks.push(grid.origin + at);
            let values = b * BRICK_VOXELS..(b + 1) * BRICK_VOXELS;
            match runs.last_mut() {
                Some(run) if run.end == values.start => run.end = values.end,
                _ => runs.push(values),
            }
        } else if brick.inside > 0 {
            grid.index.set(at, INSIDE);
        }
    }
    close_gaps(&mut phi, &runs);
    phi.truncate(grid.bricks.len() * BRICK_VOXELS);
    grid.phi = phi;
}

/// Moves runs of values to the start, one after the other, both halves in parallel.
fn close_gaps(phi: &mut [f32], runs: &[Range<usize>]) {
    let (lower, upper) = runs.split_at(runs.partition_point(|run| run.start < phi.len() / 2));
    let kept: usize = lower.iter().map(Range::len).sum();
    let middle = upper.first().map_or(phi.len(), |run| run.start);
    let (low, high) = phi.split_at_mut(middle);
    let (_, head) = rayon::join(|| pack(low, 0, lower, 0), || pack(high, middle, upper, middle - kept));
    low[kept..kept + head.len()].copy_from_slice(&head);
}

/// Moves runs to the start of `values`, without the first `ahead` of their values, which are returned.
///
/// - `first`: index of the first of `values` in the runs' numbering
fn pack(values: &mut [f32], first: usize, runs: &[Range<usize>], ahead: usize) -> Vec<f32> {
    let mut head = Vec::with_capacity(ahead);
    let mut end = 0;
    for run in runs {
        let start = run.start - first;
        let split = start + run.len().min(ahead - head.len());
        head.extend_from_slice(&values[start..split]);
        let rest = split..run.end - first;
        let length = rest.len();
        if end < rest.start {
            values.copy_within(rest, end);
        }
        end += length;
    }
    head
}
