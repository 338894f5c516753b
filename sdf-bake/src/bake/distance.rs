//! Exact distance from a brick's voxels to its own triangles.
//!
//! The brick is an octree of three levels: 8 parts of 4³ voxels, each of 8 blocks of 2³. The eight children of a node
//! are processed in eight lanes. With `m` the least distance from a child's centre to any triangle and `r` the radius
//! of its voxels, a triangle farther than m + 2r from the centre is nearest to none of them and is not passed to the
//! next level.

use glam::{DVec3, Vec3};

use super::facet::{LocalFacet, Octet, larger, smaller};
use super::scatter::NearTriangle;
use super::skin::Skin;
use crate::BrickGrid;

/// Half the diagonal of 4³ and of 2³ voxels [voxels].
const PART_RADIUS: f32 = 2.598_077;
const BLOCK_RADIUS: f32 = 0.866_026;

/// Bound on the rounding error of f32 distances in a brick [voxels].
const MARGIN: f32 = 1e-4;

/// Working memory of one thread, reused for each brick.
#[derive(Default)]
pub(super) struct Scratch {
    facets: Vec<LocalFacet>,
    parts: Candidates,
    blocks: Candidates,
}

/// Triangles that may be nearest to a voxel of some child, with their squared distances from the children's centres.
#[derive(Default)]
struct Candidates {
    facets: Vec<u32>,
    squared: Vec<[f32; 8]>,
    /// Candidates of one child, with their squared distances from its centre.
    of_child: Vec<(f32, u32)>,
}

impl Candidates {
    fn clear(&mut self) {
        self.facets.clear();
        self.squared.clear();
    }

    #[inline(always)]
    fn within(&mut self, child: usize, limit: f32) -> &[(f32, u32)] {
        self.of_child.clear();
        let all = self.squared.iter().map(|squared| squared[child]).zip(self.facets.iter().copied());
        self.of_child.extend(all.filter(|&(squared, _)| squared <= limit));
        &self.of_child
    }

    /// Squared distance from each child's centre within which triangles matter; `reach` in voxels.
    #[inline(always)]
    fn limits(&self, radius: f32, reach: f32) -> [f32; 8] {
        let mut least = [f32::INFINITY; 8];
        for squared in &self.squared {
            for (least, &squared) in least.iter_mut().zip(squared) {
                *least = smaller(squared, *least);
            }
        }
        least.map(|least| smaller(least.sqrt() + 2.0 * radius, reach + radius) + MARGIN).map(|limit| limit * limit)
    }
}

/// A brick and the triangles that may be near it.
pub(super) struct Brick<'a> {
    /// Centre of its voxels [voxels].
    pub(super) centre: DVec3,
    /// Triangles near it.
    pub(super) triangles: &'a [NearTriangle],
    pub(super) skin: &'a Skin,
    /// Distance at which φ is truncated [voxels].
    pub(super) reach: f32,
}

/// Computes distances of a brick's voxels [m] into `phi`; compiled by `pulp` for each instruction set.
///
/// The output is the number of voxels within the band. The lane width changes no bit of it.
pub(super) struct Distances<'a> {
    pub(super) brick: Brick<'a>,
    pub(super) grid: &'a BrickGrid,
    /// Offset subtracted from all distances [m].
    pub(super) half_shell: f64,
    pub(super) scratch: &'a mut Scratch,
    pub(super) phi: &'a mut [f32],
}

impl pulp::NullaryFnOnce for Distances<'_> {
    type Output = usize;

    #[inline(always)]
    fn call(self) -> usize {
        let Self { brick, grid, half_shell, scratch, phi } = self;
        brick.distances(scratch, phi);
        let mut in_band = 0;
        for value in phi.iter_mut() {
            let metres = (f64::from(*value) * grid.voxel - half_shell) as f32;
            *value = if *value < brick.reach { smaller(larger(metres, -grid.band), grid.band) } else { grid.band };
            in_band += usize::from(value.abs() < grid.band);
        }
        in_band
    }
}

// Everything below is inlined into that call, so that it is compiled for the same instruction set.

impl Brick<'_> {
    /// Distance [voxels] from each voxel to the nearest of the brick's triangles, at most `reach`, into `distance`.
    #[inline(always)]
    fn distances(&self, scratch: &mut Scratch, distance: &mut [f32]) {
        let &Brick { centre, triangles, skin, reach } = self;
        distance.fill(reach);
        let Scratch { facets: local, parts, blocks } = scratch;
        local.clear();
        for near in triangles.iter().filter(|near| skin.serves_distance(**near)) {
            local.push(skin.facets[near.index()].seen_from(centre));
        }
        parts.squared.clear();
        let octet = Octet::new(Vec3::ZERO, 2.0);
        for facet in local.iter() {
            parts.squared.push(facet.squared_distances(&octet));
        }
        let part_limits = parts.limits(PART_RADIUS, reach);
        for part in 0..8 {
            let part_centre = corner(part) * 4.0 - 2.0;
            let octet = Octet::new(part_centre, 1.0);
            blocks.clear();
            for (i, squared) in parts.squared.iter().enumerate() {
                if squared[part] <= part_limits[part] {
                    blocks.facets.push(i as u32);
                    blocks.squared.push(local[i].squared_distances(&octet));
                }
            }
            let block_limits = blocks.limits(BLOCK_RADIUS, reach);
            for (block, limit) in block_limits.into_iter().enumerate() {
                let block_centre = part_centre + corner(block) * 2.0 - 1.0;
                let candidates = blocks.within(block, limit);
                if let Some(values) = block_distances(candidates, block_centre, local) {
                    let first = (corner(part) * 4.0 + corner(block) * 2.0).as_ivec3();
                    for (i, value) in values.iter().enumerate() {
                        let voxel = first + corner(i).as_ivec3();
                        distance[crate::grid::voxel_offset(voxel)] = smaller(value.sqrt(), reach);
                    }
                }
            }
        }
    }
}

/// Squared distances [voxels²] of a block's voxels; `None` without candidates.
#[inline(always)]
fn block_distances(candidates: &[(f32, u32)], centre: Vec3, local: &[LocalFacet]) -> Option<[f32; 8]> {
    let closest = candidates.iter().fold(None, |best: Option<&(f32, u32)>, candidate| match best {
        Some(best) if best.0 <= candidate.0 => Some(best),
        _ => Some(candidate),
    })?;
    let octet = Octet::new(centre, 0.5);
    let mut nearest = local[closest.1 as usize].squared_distances(&octet);
    let farthest = nearest.iter().fold(0.0, |a, &b| larger(b, a)).sqrt() + BLOCK_RADIUS + MARGIN;
    for &(squared, facet) in candidates {
        if squared <= farthest * farthest && facet != closest.1 {
            let squared = local[facet as usize].squared_distances(&octet);
            for (nearest, squared) in nearest.iter_mut().zip(squared) {
                *nearest = smaller(squared, *nearest);
            }
        }
    }
    Some(nearest)
}

/// Corner `i` of the unit cube, z fastest.
#[inline(always)]
fn corner(i: usize) -> Vec3 {
    crate::grid::cell_corner(i).as_vec3()
}
