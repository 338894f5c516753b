//! Winding numbers of all voxels of a closed surface, by counting crossings along the lattice's columns.
//!
//! Upwards from a point of winding number w, each crossing from inside to outside takes 1 off and each other one adds
//! 1, until 0 is left far above. So w is the sum of the signs of the normals' z over the triangles above. This holds
//! for nested, overlapping and touching bodies, as long as each edge is passed equally often both ways.
//!
//! What a triangle adds is itself a sum over its edges, and an edge's part depends on the edge and its direction only:
//! in a closed surface all parts cancel pair by pair, whatever the rounding. No crossing is lost or counted twice at
//! shared edges and vertices, and a voxel can be wrong only if it is on the surface to within the rounding of f64.

use glam::DVec3;
use rayon::prelude::*;

use super::facet::Facet;
use super::scatter::BrickTriangles;
use crate::grid::{BRICK_SIDE, BRICK_VOXELS, BrickGrid};
use crate::implicit::entry_brick;

/// Inside voxels of a brick: bit z + 8 y of word x.
pub(super) type InsideMask = [u64; BRICK_SIDE];

/// A brick's columns along z; column (x, y) is number 8 x + y.
const COLUMNS: usize = BRICK_SIDE * BRICK_SIDE;

/// Signed crossings of each of a brick's columns, sorted by how many of its voxels lie below them.
type Crossings = [[i32; BRICK_SIDE + 1]; COLUMNS];

/// Inside voxels of each touched brick.
pub(super) fn inside_masks(near: &BrickTriangles, facets: &[Facet], grid: &BrickGrid) -> Vec<InsideMask> {
    let stacks = near.stacks(grid.dims.z as usize);
    let masks: Vec<Vec<InsideMask>> = stacks
        .into_par_iter()
        .map(|stack| {
            let mut above = [0; COLUMNS];
            let mut masks: Vec<InsideMask> = stack
                .rev()
                .map(|b| {
                    let low = (grid.origin + entry_brick(near.entry(b), grid.dims)).as_dvec3() * BRICK_SIDE as f64;
                    let mut crossings = [[0; BRICK_SIDE + 1]; COLUMNS];
                    for &triangle in near.triangles(b) {
                        add_crossings(&facets[triangle as usize], low, &mut crossings);
                    }
                    mask(&crossings, &mut above)
                })
                .collect();
            masks.reverse();
            masks
        })
        .collect();
    masks.concat()
}

/// Makes the distances of inside voxels negative; returns how many there are.
pub(super) fn apply(mask: &InsideMask, phi: &mut [f32; BRICK_VOXELS]) -> usize {
    for (offset, value) in phi.iter_mut().enumerate() {
        if mask[offset >> 6] >> (offset & 63) & 1 == 1 {
            *value = -*value;
        }
    }
    mask.iter().map(|word| word.count_ones() as usize).sum()
}

/// Goes down a brick's columns; `above` holds the winding number over the brick, then that below it.
fn mask(crossings: &Crossings, above: &mut [i32; COLUMNS]) -> InsideMask {
    let mut mask = InsideMask::default();
    for (column, (crossings, winding)) in crossings.iter().zip(above).enumerate() {
        for z in (0..BRICK_SIDE).rev() {
            *winding += crossings[z + 1];
            mask[column / BRICK_SIDE] |= u64::from(*winding > 0) << (column % BRICK_SIDE * BRICK_SIDE + z);
        }
        *winding += crossings[0];
    }
    mask
}

/// Adds where a triangle crosses the columns of the brick whose first voxel is at `low` [voxels].
///
/// Heights are those of the whole lattice, not of the brick, so that two bricks agree whose a crossing is.
fn add_crossings(facet: &Facet, low: DVec3, crossings: &mut Crossings) {
    let (least, most) = facet.bounds();
    let side = BRICK_SIDE as f64;
    if least.cmpge(low + side).any() || most.cmplt(low).any() {
        return;
    }
    let first_row = (least.y - low.y).ceil().max(0.0) as usize;
    let rows = ((most.y - low.y).floor() as usize + 1).min(BRICK_SIDE);
    for row in first_row..rows {
        let Some([up, down]) = edges_at(facet, low.y + row as f64) else { continue };
        let (left, right, sign) = if up.x > down.x { (down, up, 1) } else { (up, down, -1) };
        let first_column = (left.x - low.x).ceil().max(0.0) as usize;
        for column in first_column..BRICK_SIDE {
            let x = low.x + column as f64;
            if x >= right.x {
                break;
            }
            let share = (x - left.x) / (right.x - left.x);
            let height = (left.z + share * (right.z - left.z)).clamp(least.z, most.z) - low.z;
            if (0.0..side).contains(&height) {
                crossings[column * BRICK_SIDE + row][height.ceil() as usize] += sign;
            }
        }
    }
}

/// Where the triangle's outline passes `y` upwards and where downwards.
fn edges_at(facet: &Facet, y: f64) -> Option<[DVec3; 2]> {
    let (mut up, mut down) = (None, None);
    for i in 0..3 {
        let (from, to) = (facet.corners[i], facet.corners[(i + 1) % 3]);
        if (from.y <= y) != (to.y <= y) {
            // From the lower end, so that both triangles at an edge compute the same.
            let (low, high) = if from.y < to.y { (from, to) } else { (to, from) };
            let at = low + (high - low) * ((y - low.y) / (high.y - low.y));
            if from.y <= y { up = Some(at) } else { down = Some(at) }
        }
    }
    Some([up?, down?])
}
