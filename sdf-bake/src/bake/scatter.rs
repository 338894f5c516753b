//! Which triangles can matter to which brick.
//!
//! Triangles are walked, not voxels queried: a triangle's brick range is halved until a piece is too far from
//! it. Long slivers therefore cost what their surface costs, not what their bounding box does.

use std::ops::Range;

use glam::IVec3;
use rayon::prelude::*;

use super::facet::Facet;
use crate::grid::{BRICK_SIDE, BrickGrid};

/// Triangles of each touched brick; bricks in index order, triangles in mesh order.
pub(super) struct BrickTriangles {
    entries: Vec<u32>,
    first: Vec<usize>,
    triangles: Vec<u32>,
}

impl BrickTriangles {
    pub(super) fn brick_count(&self) -> usize {
        self.entries.len()
    }

    /// Index entry of touched brick `b`.
    pub(super) fn entry(&self, b: usize) -> usize {
        self.entries[b] as usize
    }

    /// Triangles within reach of touched brick `b`.
    pub(super) fn triangles(&self, b: usize) -> &[u32] {
        &self.triangles[self.first[b]..self.first[b + 1]]
    }

    /// Runs of touched bricks above one another, each from low to high; `height` is the index's extent along z.
    pub(super) fn stacks(&self, height: usize) -> Vec<Range<usize>> {
        let mut stacks = Vec::new();
        let mut first = 0;
        for run in self.entries.chunk_by(|&a, &b| a as usize / height == b as usize / height) {
            stacks.push(first..first + run.len());
            first += run.len();
        }
        stacks
    }
}

/// Triangles handed to one task; any number gives the same result.
const CHUNK: usize = 1024;

pub(super) fn scatter(facets: &[Facet], grid: &BrickGrid) -> BrickTriangles {
    let scattered: Vec<Vec<(u32, u32)>> = facets
        .par_chunks(CHUNK)
        .enumerate()
        .map(|(chunk, facets)| {
            let mut pairs = Vec::new();
            for (i, facet) in facets.iter().enumerate() {
                let triangle = (chunk * CHUNK + i) as u32;
                touched_bricks(facet, grid, |entry| pairs.push((entry as u32, triangle)));
            }
            pairs
        })
        .collect();
    gather(&scattered, grid.index.len())
}

/// Sorts (entry, triangle) pairs by counting; those of one entry keep their order.
fn gather(scattered: &[Vec<(u32, u32)>], entries: usize) -> BrickTriangles {
    let mut count = vec![0u32; entries];
    scattered.iter().flatten().for_each(|&(entry, _)| count[entry as usize] += 1);
    let mut near = BrickTriangles { entries: Vec::new(), first: vec![0], triangles: Vec::new() };
    // From here on, a touched entry's count is its brick.
    let mut total = 0;
    for (entry, count) in count.iter_mut().enumerate().filter(|(_, count)| **count > 0) {
        total += *count as usize;
        *count = near.entries.len() as u32;
        near.entries.push(entry as u32);
        near.first.push(total);
    }
    near.triangles = vec![0; total];
    let mut next = near.first.clone();
    for &(entry, triangle) in scattered.iter().flatten() {
        let at = &mut next[count[entry as usize] as usize];
        near.triangles[*at] = triangle;
        *at += 1;
    }
    near
}

/// Calls `touch` with the index entry of every brick that may hold a voxel within the band of the facet.
fn touched_bricks(facet: &Facet, grid: &BrickGrid, mut touch: impl FnMut(usize)) {
    let size = BRICK_SIDE as f64;
    let band = f64::from(grid.band) / grid.voxel * (1.0 + 1e-6);
    let (low, high) = facet.bounds();
    let first = ((low - band) / size).floor().as_ivec3();
    let last = ((high + band) / size).floor().as_ivec3();
    let mut pieces = vec![(first, last)];
    while let Some((first, last)) = pieces.pop() {
        let extent = last - first + 1;
        // The voxels of a piece span one voxel less than its bricks.
        let half = (extent.as_dvec3() * size - 1.0) * 0.5;
        let reach = half.length() + band;
        if facet.squared_distance(first.as_dvec3() * size + half) > reach * reach {
            continue;
        }
        if extent == IVec3::ONE {
            if let Some(entry) = grid.entry(first) {
                touch(entry);
            }
            continue;
        }
        let (left, right) = halves(first, last, extent);
        pieces.push(right);
        pieces.push(left);
    }
}

type Piece = (IVec3, IVec3);

fn halves(first: IVec3, last: IVec3, extent: IVec3) -> (Piece, Piece) {
    let axis = (0..3).max_by_key(|&a| extent[a]).unwrap_or(0);
    let middle = first[axis] + extent[axis] / 2;
    let (mut left_last, mut right_first) = (last, first);
    left_last[axis] = middle - 1;
    right_first[axis] = middle;
    ((first, left_last), (right_first, last))
}
