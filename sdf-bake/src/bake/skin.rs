//! The triangles of a bake, each with its purpose.

use glam::DVec3;
use rayon::prelude::*;

use super::facet::Facet;
use super::scatter::NearTriangle;
use crate::Mesh;

/// Reach of a facet that serves the sign only [voxels]; it matters only where it crosses a column.
const CROSSING_REACH: f64 = 1.0;

/// Greatest number of facets per task; the result does not depend on it.
const FACETS: usize = 1024;

/// The three corners of a triangle [m].
pub(super) type Corners = [DVec3; 3];

/// Facets in three runs: for the sign only, for both sign and distance, for the distance only.
///
/// Most parts have the middle run only. Patches over holes and walls inside another body determine the sign without
/// being surface. A wall that is partly inside is split: the remaining pieces serve the distance, and the whole
/// triangle serves the sign.
pub(super) struct Skin {
    pub(super) facets: Vec<Facet>,
    /// First facet that serves the distance.
    first_distance: usize,
    /// One past the last facet that serves the sign.
    sign_end: usize,
}

impl Skin {
    /// All triangles of a mesh, for sign and distance.
    pub(super) fn of(mesh: &Mesh, voxel: f64) -> Self {
        Self::new(&[], mesh, &[], voxel)
    }

    /// Corners [m] of facets for the sign only, a mesh for both, corners of facets for the distance only.
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

    /// True if a facet serves the distance.
    pub(super) fn serves_distance(&self, near: NearTriangle) -> bool {
        near.index() >= self.first_distance
    }

    /// True if a facet may determine the sign within a brick near it.
    pub(super) fn serves_sign(&self, near: NearTriangle) -> bool {
        near.crosses() && near.index() < self.sign_end
    }

    /// Distance from a facet within which bricks are affected; `band` in voxels.
    pub(super) fn reach(&self, facet: usize, band: f64) -> f64 {
        if facet < self.first_distance { CROSSING_REACH.min(band) } else { band }
    }
}
