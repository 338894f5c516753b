//! Reads a baked field voxel by voxel, and computes its sign by an independent exact method.
#![allow(dead_code, reason = "each test program uses some of them")]

use std::f64::consts::PI;

use glam::DVec3;
use sdf_bake::grid::{BRICK_VOXELS, voxel_at};
use sdf_bake::{BrickGrid, Mesh};

/// Position [m] and φ [m] of every `step`-th pooled voxel within the band.
pub(crate) fn band_points(grid: &BrickGrid, step: usize) -> Vec<(DVec3, f64)> {
    let in_band = grid.phi.iter().enumerate().filter(|(_, phi)| phi.abs() < grid.band);
    let point = |(at, &phi): (usize, &f32)| {
        (grid.position(voxel_at(grid.bricks[at / BRICK_VOXELS], at % BRICK_VOXELS)), f64::from(phi))
    };
    in_band.step_by(step).map(point).collect()
}

/// Winding number as the sum of all solid angles (van Oosterom & Strackee 1983).
pub(crate) fn summed_winding_number(mesh: &Mesh, point: DVec3) -> f64 {
    let angle = |t: usize| {
        let [a, b, c] = mesh.corners(t).map(|corner| corner - point);
        let [la, lb, lc] = [a.length(), b.length(), c.length()];
        a.dot(b.cross(c)).atan2(la * lb * lc + a.dot(b) * lc + b.dot(c) * la + c.dot(a) * lb)
    };
    (0..mesh.triangles.len()).map(angle).sum::<f64>() / (2.0 * PI)
}
