//! Intersection of a line with the workpiece's surface.
//!
//! The trilinear interpolant of a curved surface lies below it by up to h²κ/8; at 0.5 mm voxels that is as much as the
//! depth of a light contact. So φ is corrected by its second differences, which makes it third order; the field itself
//! and its zero set stay as they are.

use glam::{DVec3, IVec3, Vec3};
use sdf_bake::BrickGrid;
use sdf_bake::grid::{BRICK_VOXELS, INSIDE, OUTSIDE, cell_corner, trilinear, trilinear_gradient, voxel_offset};

/// Slope of φ along a line below which the line counts as grazing the surface.
const GRAZING: f64 = 0.2;
/// Evaluations of φ after which a line counts as missing the surface.
const EVALUATIONS: usize = 40;

/// Signed distance [m] along `axis` (unit, out of the part) from `start` to the surface; `None` if it is not met.
///
/// `down` [m] is the distance below `start` in which the surface is searched for.
pub fn way_to_surface(grid: &BrickGrid, start: DVec3, axis: DVec3, down: f64) -> Option<f64> {
    let near = 0.25 * grid.voxel;
    let mut way = 0.0;
    for _ in 0..EVALUATIONS {
        if way < -down {
            return None;
        }
        let cell = Cell::at(grid, start + axis * way);
        let (phi, slope) = (cell.phi(), cell.gradient().dot(axis) / grid.voxel);
        if phi.abs() <= near && slope > GRAZING {
            return Some(polish(grid, start, axis, way - (phi - cell.chord_error(grid)) / slope));
        }
        // φ is 1-Lipschitz: on a grazing line, |φ| is a safe step.
        way -= phi / slope.clamp(0.5, 1.0);
    }
    None
}

/// Newton's method on the corrected φ from a point next to the surface. A step has an error of a few per cent, so after
/// a step of a thousandth of a voxel the next would be lost in the rounding of φ.
fn polish(grid: &BrickGrid, start: DVec3, axis: DVec3, mut way: f64) -> f64 {
    for _ in 0..3 {
        let cell = Cell::at(grid, start + axis * way);
        let slope = cell.gradient().dot(axis) / grid.voxel;
        let step = (cell.phi() - cell.chord_error(grid)) / slope.max(GRAZING);
        way -= step;
        if step.abs() < 1e-3 * grid.voxel {
            break;
        }
    }
    way
}

/// The eight voxels around a point.
struct Cell {
    corner: IVec3,
    at: Vec3,
    values: [f32; 8],
}

impl Cell {
    fn at(grid: &BrickGrid, point: DVec3) -> Self {
        let (corner, at) = grid.cell(point);
        let values = if (corner & 7).max_element() < 7 {
            grid.cell_phi(corner)
        } else {
            let bricks = Bricks::new(grid, corner, corner + 1);
            std::array::from_fn(|i| bricks.phi(corner + cell_corner(i)))
        };
        Self { corner, at, values }
    }

    fn phi(&self) -> f64 {
        trilinear(&self.values, self.at).into()
    }

    /// Gradient [m per voxel].
    fn gradient(&self) -> DVec3 {
        trilinear_gradient(&self.values, self.at).as_dvec3()
    }

    /// Excess of the trilinear value over a quadratic through the neighbours [m]: Σ f(1-f)/2 · h²φ_ii.
    fn chord_error(&self, grid: &BrickGrid) -> f64 {
        let bricks = Bricks::new(grid, self.corner - 1, self.corner + 2);
        let mut error = 0.0;
        for (axis, bit) in [4usize, 2, 1].into_iter().enumerate() {
            let f = self.at[axis];
            let mut bent = [0f32; 8];
            for i in (0..8).filter(|i| i & bit == 0) {
                let (low, high) = (self.values[i], self.values[i | bit]);
                let before = bricks.phi(self.corner + cell_corner(i) - IVec3::AXES[axis]);
                let after = bricks.phi(self.corner + cell_corner(i) + 2 * IVec3::AXES[axis]);
                if before.abs() < grid.band && after.abs() < grid.band {
                    bent[i] = before - 2.0 * low + high;
                    bent[i | bit] = low - 2.0 * high + after;
                }
            }
            error += 0.5 * f * (1.0 - f) * trilinear(&bent, self.at);
        }
        error.into()
    }
}

/// Up to two bricks along each axis, each looked up once.
struct Bricks<'a> {
    grid: &'a BrickGrid,
    /// Lowest brick.
    low: IVec3,
    /// Slots of the bricks, in the order of [`cell_corner`].
    slots: [u32; 8],
}

impl<'a> Bricks<'a> {
    /// The bricks of all voxels from `first` to `last`, which are less than eight voxels apart.
    fn new(grid: &'a BrickGrid, first: IVec3, last: IVec3) -> Self {
        let low: IVec3 = first >> 3;
        let more: IVec3 = (last >> 3) - low;
        let slot = |i: usize| {
            let step = cell_corner(i);
            if step.cmple(more).all() { grid.slot(low + step) } else { OUTSIDE }
        };
        Self { grid, low, slots: std::array::from_fn(slot) }
    }

    /// φ at a voxel of these bricks [m].
    fn phi(&self, voxel: IVec3) -> f32 {
        let step: IVec3 = (voxel >> 3) - self.low;
        match self.slots[(4 * step.x + 2 * step.y + step.z) as usize] {
            OUTSIDE => self.grid.band,
            INSIDE => -self.grid.band,
            slot => self.grid.phi[slot as usize * BRICK_VOXELS + voxel_offset(voxel)],
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_ball_is_met_to_third_order_along_slanted_lines() {
        let worst = |voxel: f64| {
            let half = DVec3::splat(0.02);
            let grid = BrickGrid::from_distance(-half, half, voxel, 3.0, |p| p.length() - 0.02);
            let axis = DVec3::new(0.1, -0.2, 1.0).normalize();
            let error = |i: usize| {
                let start = DVec3::new(1e-3 * (i % 11) as f64, 0.7e-3 * (i / 11) as f64, 0.021);
                let way = way_to_surface(&grid, start, axis, 0.01).expect("the ball lies below");
                ((start + axis * way).length() - 0.02).abs()
            };
            (0..121).map(error).fold(0.0, f64::max)
        };
        let (coarse, fine) = (worst(0.001), worst(0.0005));
        println!("ball of 20 mm: surface met within {coarse:.1e} m at 1 mm, {fine:.1e} m at 0.5 mm");
        assert!(coarse < 3e-7 && fine < coarse / 6.0, "{coarse}, {fine}");
    }

    #[test]
    fn a_line_that_misses_says_so() {
        let half = DVec3::splat(0.01);
        let grid = BrickGrid::from_distance(-half, half, 0.0005, 3.0, |p| p.length() - 0.01);
        assert_eq!(way_to_surface(&grid, DVec3::new(0.0, 0.0, 0.02), DVec3::Z, 0.005), None);
        assert_eq!(way_to_surface(&grid, DVec3::new(0.03, 0.0, 0.0), DVec3::Z, 0.1), None);
        let from_inside = way_to_surface(&grid, DVec3::new(0.0, 0.0, 0.005), DVec3::Z, 0.0);
        assert!((from_inside.expect("the way out") - 0.005).abs() < 1e-7);
    }
}
