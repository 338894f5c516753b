//! Parts that the tests photograph.

use glam::DVec3;
use sdf_bake::{BrickGrid, Scalar};

pub const VOXEL: f64 = 0.5e-3;

pub fn cuboid(p: DVec3, centre: DVec3, half: DVec3) -> f64 {
    let q = (p - centre).abs() - half;
    q.max(DVec3::ZERO).length() + q.max_element().min(0.0)
}

/// A channel of a grid from a function of position.
pub fn channel<T>(grid: &BrickGrid, value: impl Fn(DVec3) -> T) -> Vec<T> {
    (0..grid.phi.len()).map(|at| value(grid.position(grid.voxel_of(at)))).collect()
}

/// A plate with a rib and a bead in the corner between them, away from the origin.
pub fn bracket() -> BrickGrid {
    let centre = DVec3::new(0.011, -0.023, 0.007);
    let half = DVec3::new(0.024, 0.018, 0.011);
    let bead = move |p: DVec3| {
        let q = p - centre;
        q.with_y((q.y.abs() - 0.011).max(0.0)).with_z(q.z + 0.006).length() - 0.005
    };
    let plate = move |p: DVec3| cuboid(p - centre, DVec3::new(0.0, 0.0, -0.008), DVec3::new(0.024, 0.018, 0.003));
    let rib = move |p: DVec3| cuboid(p - centre, DVec3::new(-0.002, 0.0, 0.003), DVec3::new(0.002, 0.014, 0.008));
    let shape = move |p: DVec3| plate(p).min(rib(p)).min(bead(p));
    let mut grid = BrickGrid::from_distance(centre - half, centre + half, VOXEL, 3.0, shape);
    grid.label = channel(&grid, |p| if bead(p) < VOXEL { 1 + u16::from(p.y > centre.y) } else { 0 });
    grid
}

/// The bracket with its bead ground at one end.
pub fn ground() -> BrickGrid {
    let mut grid = bracket();
    *grid.scalar_mut(Scalar::Removed) = channel(&grid, |p| ((p.y + 0.021) * 0.02).clamp(0.0, 2e-4) as f32);
    grid
}

/// The bracket with its coating sanded on one side of an oblique border.
pub fn sanded() -> BrickGrid {
    let mut grid = bracket();
    *grid.scalar_mut(Scalar::Dose) = channel(&grid, |p| (0.5 + 90.0 * (p.x + 0.4 * p.y)).clamp(0.0, 1.3) as f32);
    grid
}
