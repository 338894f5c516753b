//! Exposure: cosine-weighted share of the hemisphere above a surface point that is free of the part.

use std::f64::consts::TAU;

use glam::DVec3;
use rayon::prelude::*;
use sdf_bake::query::MeshQuery;

/// Settings of the exposure measurement.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ExposureRays {
    /// Distance beyond which nothing occludes [m].
    pub reach: f64,
    /// Height above the surface at which rays start [m].
    pub lift: f64,
    /// Number of rays; the result is a multiple of 1/rays.
    pub rays: u32,
}

/// Cosine-weighted share of the hemisphere above a point that is free up to the reach, in [0, 1].
///
/// 1 on a convex solid, 1/2 in the corner between two perpendicular walls. The directions are a Hammersley set (1960)
/// mapped to the cosine-weighted hemisphere, so the share of free rays approximates the integral without random noise.
pub fn exposure(query: &MeshQuery, position: DVec3, normal: DVec3, settings: ExposureRays) -> f64 {
    let (side, front) = normal.any_orthonormal_pair();
    let origin = position + settings.lift * normal;
    let free = |i: u32| {
        let height_squared = (f64::from(i) + 0.5) / f64::from(settings.rays);
        let (sin, cos) = (TAU * radical_inverse(i)).sin_cos();
        let out = (1.0 - height_squared).sqrt();
        let direction = out * (cos * side + sin * front) + height_squared.sqrt() * normal;
        !query.occluded(origin, direction, settings.reach)
    };
    let free = (0..settings.rays).filter(|&i| free(i)).count();
    free as f64 / f64::from(settings.rays.max(1))
}

/// Exposures of many points, given as (position, normal); the same for any number of threads.
pub fn exposures(query: &MeshQuery, points: &[(DVec3, DVec3)], settings: ExposureRays) -> Vec<f64> {
    points.par_iter().map(|&(position, normal)| exposure(query, position, normal, settings)).collect()
}

/// Radical inverse: the bits of a number mirrored at the binary point (van der Corput's sequence, 1935), in [0, 1).
fn radical_inverse(i: u32) -> f64 {
    f64::from(i.reverse_bits()) / 2f64.powi(32)
}
