//! Winding numbers of all voxels of a closed surface, by counting crossings along the lattice's columns.
//!
//! Upwards from a point of winding number w, each crossing from inside to outside takes 1 off and each other one adds
//! 1, until 0 is left far above. So w is the sum of the signs of the normals' z over the triangles above. This holds
//! for nested, overlapping and touching bodies, as long as each edge is passed equally often both ways.
//!
//! What a triangle adds is itself a sum over its edges, and an edge's part depends on the edge and its direction only:
//! in a closed surface all parts cancel pair by pair, whatever the rounding. No crossing is lost or counted twice at
//! shared edges and vertices, and a voxel can be wrong only if it is on the surface to within the rounding of f64.

use std::ops::Range;

use glam::DVec3;
use rayon::prelude::*;

use super::facet::Facet;
use super::scatter::BrickTriangles;
use super::skin::Skin;
use crate::grid::{BRICK_SIDE, BrickGrid};
use crate::index::entry_brick;

/// Inside voxels of a brick: bit z + 8 y of word x.
pub(super) type InsideMask = [u64; BRICK_SIDE];

/// A brick's columns along z; column (x, y) is number 8 x + y.
const COLUMNS: usize = BRICK_SIDE * BRICK_SIDE;

/// Signed crossings of each of a brick's columns, sorted by how many of its voxels lie below them.
type Crossings = [[i32; BRICK_SIDE + 1]; COLUMNS];

/// Most stacks of bricks handed to one task; any number gives the same result.
const STACKS: usize = 8;

/// Where inside is.
#[derive(Default)]
pub(super) struct Insides {
    /// Inside voxels of each touched brick.
    pub(super) masks: Vec<InsideMask>,
    /// Runs of index entries between touched bricks that are wholly inside.
    pub(super) gaps: Vec<Range<usize>>,
    /// Most bodies around one voxel.
    pub(super) deepest: i32,
}

/// Inside voxels of each touched brick, and the untouched bricks inside.
pub(super) fn insides(near: &BrickTriangles, skin: &Skin, grid: &BrickGrid) -> Insides {
    let of_stack = |stack: Range<usize>| pulp::Arch::new().dispatch(Stack { bricks: stack, near, skin, grid });
    let stacks = near.stacks(grid.dims.z as usize).into_par_iter().with_max_len(STACKS);
    let stacks: Vec<Insides> = stacks.map(of_stack).collect();
    let mut all = Insides { masks: Vec::with_capacity(near.brick_count()), ..Insides::default() };
    for stack in stacks {
        all.masks.extend(stack.masks);
        all.gaps.extend(stack.gaps);
        all.deepest = all.deepest.max(stack.deepest);
    }
    all
}

/// Going down the bricks above one another, from outside: a call that is compiled for each kind of lanes.
struct Stack<'a> {
    bricks: Range<usize>,
    near: &'a BrickTriangles,
    skin: &'a Skin,
    grid: &'a BrickGrid,
}

impl pulp::NullaryFnOnce for Stack<'_> {
    type Output = Insides;

    #[inline(always)]
    fn call(self) -> Insides {
        let Self { bricks, near, skin, grid } = self;
        let mut insides = Insides::default();
        let mut above = [0; COLUMNS];
        let mut entry_above = None;
        for b in bricks.rev() {
            let entry = near.entry(b);
            // Where no surface is, all columns are alike.
            if let Some(end) = entry_above.filter(|&end| end > entry + 1 && above[0] > 0) {
                insides.gaps.push(entry + 1..end);
            }
            entry_above = Some(entry);
            let low = (grid.origin + entry_brick(entry, grid.dims)).as_dvec3() * BRICK_SIDE as f64;
            let mut crossings = [[0; BRICK_SIDE + 1]; COLUMNS];
            for &near in near.triangles(b) {
                if skin.serves_sign(near) {
                    add_crossings(&skin.facets[near.index()], low, &mut crossings);
                }
            }
            insides.masks.push(mask(&crossings, &mut above, &mut insides.deepest));
        }
        insides.masks.reverse();
        insides
    }
}

/// Makes the distances of inside voxels negative; returns how many there are.
pub(super) fn apply(mask: &InsideMask, phi: &mut [f32]) -> usize {
    for (offset, value) in phi.iter_mut().enumerate() {
        if mask[offset >> 6] >> (offset & 63) & 1 == 1 {
            *value = -*value;
        }
    }
    mask.iter().map(|word| word.count_ones() as usize).sum()
}

/// Goes down a brick's columns; `above` holds the winding number over the brick, then that below it.
#[inline(always)]
fn mask(crossings: &Crossings, above: &mut [i32; COLUMNS], deepest: &mut i32) -> InsideMask {
    let mut mask = InsideMask::default();
    for (column, (crossings, winding)) in crossings.iter().zip(above).enumerate() {
        for z in (0..BRICK_SIDE).rev() {
            *winding += crossings[z + 1];
            *deepest = (*deepest).max(*winding);
            mask[column / BRICK_SIDE] |= u64::from(*winding > 0) << (column % BRICK_SIDE * BRICK_SIDE + z);
        }
        *winding += crossings[0];
    }
    mask
}

/// Adds where a triangle crosses the columns of the brick whose first voxel is at `low` [voxels].
///
/// Heights are those of the whole lattice, not of the brick, so that two bricks agree whose a crossing is.
#[inline(always)]
fn add_crossings(facet: &Facet, low: DVec3, crossings: &mut Crossings) {
    let (least, most) = facet.bounds();
    let side = BRICK_SIDE as f64;
    if least.cmpge(low + side).any() || most.cmplt(low).any() {
        return;
    }
    let first_row = (least.y - low.y).ceil().max(0.0) as usize;
    let rows = ((most.y - low.y).floor() as usize + 1).min(BRICK_SIDE);
    for row in first_row..rows {
        let Some([up, down]) = edges_at(&facet.corners, low.y + row as f64) else { continue };
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

/// Where a triangle's outline passes `y` upwards and where downwards.
#[inline(always)]
pub(super) fn edges_at(corners: &[DVec3; 3], y: f64) -> Option<[DVec3; 2]> {
    let (mut up, mut down) = (None, None);
    for i in 0..3 {
        let (from, to) = (corners[i], corners[(i + 1) % 3]);
        if (from.y <= y) != (to.y <= y) {
            // From the lower end, so that both triangles at an edge compute the same.
            let (low, high) = if from.y < to.y { (from, to) } else { (to, from) };
            let at = low + (high - low) * ((y - low.y) / (high.y - low.y));
            if from.y <= y { up = Some(at) } else { down = Some(at) }
        }
    }
    Some([up?, down?])
}
