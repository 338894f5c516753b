//! Winding numbers of all voxels of a closed surface, by counting crossings along the lattice's columns.
//!
//! Upwards from a point of winding number w, each crossing from inside to outside subtracts 1 and each other crossing
//! adds 1, until 0 remains far above. So w is the sum of the signs of the normals' z over the triangles above. This
//! holds for nested, overlapping and touching bodies, if each edge is used equally often in both directions.
//!
//! A column is crossed by exactly one of the triangles that share it, and a crossing belongs to exactly one brick; both
//! are decided by comparisons without rounding (`crossing.rs`). No crossing is lost or counted twice at shared edges
//! and vertices or between bricks. A voxel can be wrong only if it lies on the surface to within the rounding of f64.

use std::ops::Range;

use glam::DVec3;
use rayon::prelude::*;

use super::facet::Facet;
use super::scatter::BrickTriangles;
use super::skin::Skin;
use crate::crossing::Span;
use crate::grid::{BRICK_SIDE, BrickGrid};
use crate::index::entry_brick;

/// Inside voxels of a brick: bit z + 8 y of word x.
pub(super) type InsideMask = [u64; BRICK_SIDE];

/// A brick's columns along z; column (x, y) is number 8 x + y.
const COLUMNS: usize = BRICK_SIDE * BRICK_SIDE;

/// Signed crossings of each of a brick's columns, indexed by the number of its voxels below them.
type Crossings = [[i32; BRICK_SIDE + 1]; COLUMNS];

/// Greatest number of brick stacks per task; the result does not depend on it.
const STACKS: usize = 8;

/// Voxels and bricks that are inside.
#[derive(Default)]
pub(super) struct Insides {
    /// Inside voxels of each touched brick.
    pub(super) masks: Vec<InsideMask>,
    /// Runs of index entries between touched bricks that are entirely inside.
    pub(super) gaps: Vec<Range<usize>>,
    /// Greatest winding number found at a voxel.
    pub(super) deepest: i32,
}

/// Finds the inside voxels of each touched brick, and the untouched bricks inside.
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

/// Traverses the bricks of a stack downwards from outside; compiled by `pulp` for each instruction set.
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
            // Without surface between, all columns have equal winding numbers.
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

/// Makes the distances of inside voxels negative; returns the number of inside voxels.
pub(super) fn apply(mask: &InsideMask, phi: &mut [f32]) -> usize {
    for (offset, value) in phi.iter_mut().enumerate() {
        if mask[offset >> 6] >> (offset & 63) & 1 == 1 {
            *value = -*value;
        }
    }
    mask.iter().map(|word| word.count_ones() as usize).sum()
}

/// Traverses a brick's columns downwards. `above` holds the winding numbers above the brick, and afterwards those below
/// it.
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

/// Adds the crossings of a triangle with the columns of the brick whose first voxel is at `low` [voxels].
///
/// `low` is whole, so that sums with whole numbers are exact. Coordinates are compared in the whole lattice, not
/// relative to the brick: a crossing belongs to the one brick with `low.z <= height < low.z + 8`, and to the voxels
/// below it.
#[inline(always)]
fn add_crossings(facet: &Facet, low: DVec3, crossings: &mut Crossings) {
    let (least, most) = facet.bounds();
    let high = low + BRICK_SIDE as f64;
    if least.cmpge(high).any() || most.cmplt(low).any() {
        return;
    }
    let first_row = (least.y.ceil() - low.y).max(0.0) as usize;
    let rows = ((most.y.floor() - low.y) as usize + 1).min(BRICK_SIDE);
    for row in first_row..rows {
        let Some(span) = Span::at(&facet.corners, low.y + row as f64) else { continue };
        let first_column = (span.left.x.ceil() - low.x).max(0.0) as usize;
        for column in first_column..BRICK_SIDE {
            let x = low.x + column as f64;
            if x >= span.right.x {
                break;
            }
            let height = span.height(x);
            if low.z <= height && height < high.z {
                crossings[column * BRICK_SIDE + row][(height.ceil() - low.z) as usize] += span.sign;
            }
        }
    }
}
