//! Assigns triangles to the bricks that they can affect.
//!
//! The loop runs over triangles, not over voxels: a triangle's brick range is bisected until a piece is too far from
//! it. The cost of long slivers is therefore proportional to their surface, not to their bounding box.

use std::ops::Range;

use glam::{DVec3, IVec3};
use rayon::prelude::*;

use super::facet::Facet;
use super::skin::Skin;
use crate::grid::{BRICK_SIDE, BrickGrid};

/// Triangles of each touched brick; bricks in index order, triangles in the skin's order.
#[derive(Default)]
pub(super) struct BrickTriangles {
    entries: Vec<u32>,
    places: Vec<Place>,
    /// Triangles of the bricks of each slab.
    slabs: Vec<Vec<NearTriangle>>,
}

/// Location of the triangles of a brick.
struct Place {
    slab: usize,
    triangles: Range<usize>,
}

/// Index of a triangle; the highest bit is set if it may cross columns within the brick.
#[derive(Clone, Copy, Default)]
pub(super) struct NearTriangle(u32);

const CROSSES: u32 = 1 << 31;

impl NearTriangle {
    pub(super) fn index(self) -> usize {
        (self.0 & !CROSSES) as usize
    }

    pub(super) fn crosses(self) -> bool {
        self.0 & CROSSES != 0
    }
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
    pub(super) fn triangles(&self, b: usize) -> &[NearTriangle] {
        let Place { slab, triangles } = &self.places[b];
        &self.slabs[*slab][triangles.clone()]
    }

    /// Runs of touched bricks in the same column, each from low to high; `height` is the index's extent along z.
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

/// Number of triangles per task; the result does not depend on it.
const CHUNK: usize = 256;

/// Greatest number of slabs, which are runs of index entries whose triangles one task sorts; the result does not depend
/// on it.
const SLABS: usize = 16;

/// A brick's index entry and a triangle near it.
type Pair = (u32, NearTriangle);

/// Pairs of each slab.
type SlabPairs = [Vec<Pair>; SLABS];

/// Assigns each facet of a skin to the bricks within `reach` [voxels] of it.
pub(super) fn scatter(skin: &Skin, grid: &BrickGrid, reach: f64) -> BrickTriangles {
    let entries = grid.dims.as_usizevec3().element_product();
    let slab = entries.div_ceil(SLABS).next_power_of_two();
    let scattered: Vec<SlabPairs> = skin
        .facets
        .par_chunks(CHUNK)
        .enumerate()
        .with_max_len(1)
        .map(|(chunk, facets)| {
            pulp::Arch::new().dispatch(ScatterChunk { first: chunk * CHUNK, facets, skin, grid, reach, slab })
        })
        .collect();
    gather(&scattered, slab)
}

/// Compiled by `pulp` for each instruction set; all functions that it calls are inlined.
struct ScatterChunk<'a> {
    /// Index of the first facet.
    first: usize,
    facets: &'a [Facet],
    skin: &'a Skin,
    grid: &'a BrickGrid,
    /// Reach of the facets that serve the distance [voxels].
    reach: f64,
    /// Index entries per slab, a power of two.
    slab: usize,
}

impl pulp::NullaryFnOnce for ScatterChunk<'_> {
    type Output = SlabPairs;

    #[inline(always)]
    fn call(self) -> SlabPairs {
        let Self { first, facets, skin, grid, reach, slab } = self;
        let (mut slabs, mut pieces) = (SlabPairs::default(), Vec::new());
        for (i, facet) in facets.iter().enumerate() {
            let reach = skin.reach(first + i, reach) * (1.0 + 1e-6);
            let outline = Outline { bounds: facet.bounds(), slabs: facet.slabs(), reach };
            outline.touched_bricks(
                &mut pieces,
                #[inline(always)]
                |brick, crosses| {
                    if let Some(entry) = grid.entry(brick) {
                        let mark = if crosses { CROSSES } else { 0 };
                        let pair = (entry as u32, NearTriangle((first + i) as u32 | mark));
                        slabs[entry >> slab.trailing_zeros()].push(pair);
                    }
                },
            );
        }
        slabs
    }
}

/// Sorts the pairs of all tasks by entry, `slab` entries at a time.
fn gather(scattered: &[SlabPairs], slab: usize) -> BrickTriangles {
    let sorted: Vec<BrickTriangles> =
        (0..SLABS).into_par_iter().with_max_len(1).map(|at| gather_slab(scattered, at, slab)).collect();
    let mut near = BrickTriangles::default();
    for slab in sorted {
        near.entries.extend(slab.entries);
        near.places.extend(slab.places);
        near.slabs.extend(slab.slabs);
    }
    near
}

/// Counting sort of the pairs of a slab by entry; those of one entry keep their order.
fn gather_slab(scattered: &[SlabPairs], at: usize, slab: usize) -> BrickTriangles {
    let pairs = || scattered.iter().flat_map(|slabs| &slabs[at]);
    let mut count = vec![0u32; slab];
    pairs().for_each(|&(entry, _)| count[entry as usize & (slab - 1)] += 1);
    let mut near = BrickTriangles::default();
    // From here on, a touched entry's count is the position of its next triangle.
    let mut total = 0;
    for (entry, count) in count.iter_mut().enumerate().filter(|(_, count)| **count > 0) {
        let start = total;
        total += *count;
        *count = start;
        near.entries.push((at * slab + entry) as u32);
        near.places.push(Place { slab: at, triangles: start as usize..total as usize });
    }
    let mut triangles = vec![NearTriangle::default(); total as usize];
    for &(entry, triangle) in pairs() {
        let place = &mut count[entry as usize & (slab - 1)];
        triangles[*place as usize] = triangle;
        *place += 1;
    }
    near.slabs.push(triangles);
    near
}

/// Bounds of a triangle, and its reach [voxels].
struct Outline {
    bounds: (DVec3, DVec3),
    slabs: [(DVec3, f64, f64); 4],
    reach: f64,
}

impl Outline {
    /// Calls `touch` with every brick that may contain a voxel within reach, and with true if the triangle's box meets
    /// the brick's box, which extends one voxel farther than its voxels. `pieces` is working memory.
    #[inline(always)]
    fn touched_bricks(&self, pieces: &mut Vec<Piece>, mut touch: impl FnMut(IVec3, bool)) {
        let size = BRICK_SIDE as f64;
        let (low, high) = self.bounds;
        let first = ((low - self.reach - (size - 1.0)) / size).ceil().as_ivec3();
        let last = ((high + self.reach) / size).floor().as_ivec3();
        pieces.push((first, last));
        while let Some((first, last)) = pieces.pop() {
            let extent = last - first + 1;
            // The voxels of a piece span one voxel less than its bricks.
            let half = (extent.as_dvec3() * size - 1.0) * 0.5;
            let corner = first.as_dvec3() * size;
            if self.is_beyond(corner + half, half) {
                continue;
            }
            if extent == IVec3::ONE {
                touch(first, low.cmplt(corner + size).all() && high.cmpge(corner).all());
                continue;
            }
            let (left, right) = halves(first, last, extent);
            pieces.push(right);
            pieces.push(left);
        }
    }

    /// True if a box around `centre` is certainly out of reach: by the gaps between it and the triangle's box, or by
    /// the gaps along the normal and one direction perpendicular to it.
    #[inline(always)]
    fn is_beyond(&self, centre: DVec3, half: DVec3) -> bool {
        let (low, high) = self.bounds;
        let apart = (low - (centre + half)).max((centre - half) - high).max(DVec3::ZERO);
        let limit = self.reach * self.reach;
        if apart.length_squared() > limit {
            return true;
        }
        let gap = |&(direction, middle, width): &(DVec3, f64, f64)| {
            let reach = width + direction.abs().dot(half);
            ((direction.dot(centre) - middle).abs() - reach).max(0.0)
        };
        let [plane, edges @ ..] = &self.slabs;
        let along = gap(plane);
        let across = edges.iter().map(gap).fold(0.0, f64::max);
        along * along + across * across > limit
    }
}

type Piece = (IVec3, IVec3);

#[inline(always)]
fn halves(first: IVec3, last: IVec3, extent: IVec3) -> (Piece, Piece) {
    let axis = if extent.x >= extent.y && extent.x >= extent.z {
        0
    } else if extent.y >= extent.z {
        1
    } else {
        2
    };
    let middle = first[axis] + extent[axis] / 2;
    let (mut left_last, mut right_first) = (last, first);
    left_last[axis] = middle - 1;
    right_first[axis] = middle;
    ((first, left_last), (right_first, last))
}
