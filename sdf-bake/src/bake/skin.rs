//! The triangles of a bake, each with what it is for.

use glam::DVec3;
use rayon::prelude::*;

use super::facet::Facet;
use super::scatter::NearTriangle;
use crate::Mesh;

/// A facet that serves the sign only matters where it crosses a column; this much is more than enough [voxels].
const CROSSING_REACH: f64 = 1.0;

/// Most facets handed to one task; any number gives the same result.
const FACETS: usize = 1024;

/// The three corners of a triangle [m].
pub(super) type Corners = [DVec3; 3];

/// Facets in three runs: for the sign only, for both sign and distance, for the distance only.
///
/// Most parts have the middle run alone. Patches over holes and walls inside another body tell inside from outside
/// without being surface; what is left of a wall that is partly inside is surface, and its whole tells the sides.
pub(super) struct Skin {
    pub(super) facets: Vec<Facet>,
    /// First facet that serves the distance.
    first_distance: usize,
    /// One past the last facet that serves the sign.
    sign_end: usize,
}

impl Skin {
    /// All triangles of a mesh, for both.
    pub(super) fn of(mesh: &Mesh, voxel: f64) -> Self {
        Self::new(&[], mesh, &[], voxel)
    }

    /// Corners [m] of those for the sign only, a mesh for both, corners of those for the distance only.
    pub(super) fn new(sign_only: &[Corners], both: &Mesh, distance_only: &[Corners], voxel: f64) -> Self {
        let first_distance = sign_only.len();
        let sign_end = first_distance + both.triangles.len();
        let facets = (0..sign_end + distance_only.len()).into_par_iter().with_max_len(FACETS).map(|i| {
            let corners = if i < first_distance {
                sign_only[i]
            } else if i < sign_end {
                both.corners(i - first_distance)
            } else {
                distance_only[i - sign_end]
            };
            Facet::new(corners, voxel)
        });
        Self { facets: facets.collect(), first_distance, sign_end }
    }

    /// Whether a facet serves the distance.
    pub(super) fn serves_distance(&self, near: NearTriangle) -> bool {
        near.index() >= self.first_distance
    }

    /// Whether a facet may tell inside from outside within the brick that it is near.
    pub(super) fn serves_sign(&self, near: NearTriangle) -> bool {
        near.crosses() && near.index() < self.sign_end
    }

    /// How far from a facet bricks matter; `band` in voxels.
    pub(super) fn reach(&self, facet: usize, band: f64) -> f64 {
        if facet < self.first_distance { CROSSING_REACH.min(band) } else { band }
    }
}
