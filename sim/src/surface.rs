//! Intersection of a line with the workpiece's surface.
//!
//! The trilinear interpolant of a curved surface lies below it by up to h²κ/8; at 0.5 mm voxels that is as much as the
//! depth of a light contact. So φ is corrected by its second differences, which makes it third order; the field itself
//! and its zero set stay as they are.

use glam::{DVec3, IVec3, Vec3};
use sdf_bake::BrickGrid;
use sdf_bake::grid::{BRICK_VOXELS, INSIDE, OUTSIDE, cell_corner, trilinear, trilinear_gradient};

/// Slope of φ along a line below which the line counts as grazing the surface.
const GRAZING: f64 = 0.2;
/// Evaluations of φ after which a line counts as missing the surface.
const EVALUATIONS: usize = 40;

/// Signed distance [m] along `axis` (unit, out of the part) from `start` to the surface; `None` if it is not met.
///
/// `down` [m] is the distance below `start` in which the surface is searched for.
pub fn way_to_surface(grid: &BrickGrid, start: DVec3, axis: DVec3, down: f64) -> Option<f64> {
    let near = 0.25 * grid.voxel;
    let (mut way, mut cell) = (0.0, Cell::at(grid, start));
    for _ in 0..EVALUATIONS {
        if way < -down {
            return None;
        }
        cell.move_to(start + axis * way);
        let (phi, slope) = (cell.phi(), cell.gradient().dot(axis) / grid.voxel);
        if phi.abs() <= near && slope > GRAZING {
            way -= (phi - cell.chord_error()) / slope;
            return Some(polish(cell, start, axis, way));
        }
        // φ is 1-Lipschitz: on a grazing line, |φ| is a safe step.
        way -= phi / slope.clamp(0.5, 1.0);
    }
    None
}

/// Newton's method on the corrected φ from a point next to the surface. A step has an error of a few per cent, so after
/// a step of a thousandth of a voxel the next would be lost in the rounding of φ.
fn polish(mut cell: Cell, start: DVec3, axis: DVec3, mut way: f64) -> f64 {
    let voxel = cell.grid.voxel;
    for _ in 0..3 {
        cell.move_to(start + axis * way);
        let slope = cell.gradient().dot(axis) / voxel;
        let step = (cell.phi() - cell.chord_error()) / slope.max(GRAZING);
        way -= step;
        if step.abs() < 1e-3 * voxel {
            break;
        }
    }
    way
}

/// The eight voxels around a point.
struct Cell<'a> {
    grid: &'a BrickGrid,
    corner: IVec3,
    at: Vec3,
    values: [f32; 8],
    /// Second differences of φ along x, y and z at the eight voxels [m], once they are needed.
    bends: Option<[[f32; 8]; 3]>,
}

impl<'a> Cell<'a> {
    fn at(grid: &'a BrickGrid, point: DVec3) -> Self {
        let (corner, at) = grid.cell(point);
        let values = if (corner & 7).max_element() < 7 {
            grid.cell_phi(corner)
        } else {
            let bricks = Bricks::new(grid, corner, corner + 1);
            let [x, y, z] = &bricks.places;
            std::array::from_fn(|i| bricks.value(x[i >> 2] + y[i >> 1 & 1] + z[i & 1]))
        };
        Self { grid, corner, at, values, bends: None }
    }

    /// Moves to the voxels around another point; within the cell they stay the same.
    fn move_to(&mut self, point: DVec3) {
        let (corner, at) = self.grid.cell(point);
        if corner == self.corner {
            self.at = at;
        } else {
            *self = Self::at(self.grid, point);
        }
    }

    fn phi(&self) -> f64 {
        trilinear(&self.values, self.at).into()
    }

    /// Gradient [m per voxel].
    fn gradient(&self) -> DVec3 {
        trilinear_gradient(&self.values, self.at).as_dvec3()
    }

    /// Excess of the trilinear value over a quadratic through the neighbours [m]: Σ f(1-f)/2 · h²φ_ii.
    fn chord_error(&mut self) -> f64 {
        let bends = self.bends.get_or_insert_with(|| bends(self.grid, self.corner, &self.values));
        let mut error = 0.0;
        for (axis, bent) in bends.iter().enumerate() {
            let f = self.at[axis];
            error += 0.5 * f * (1.0 - f) * trilinear(bent, self.at);
        }
        error.into()
    }
}

/// Second differences of φ [m] along each axis at the corners of a cell, from its `values`; 0 beside a voxel beyond the
/// band.
fn bends(grid: &BrickGrid, corner: IVec3, values: &[f32; 8]) -> [[f32; 8]; 3] {
    let bricks = Bricks::new(grid, corner - 1, corner + 2);
    let mut bends = [[0.0; 8]; 3];
    for (axis, bent) in bends.iter_mut().enumerate() {
        let (one, other) = ((axis + 1) % 3, (axis + 2) % 3);
        for k in 0..4 {
            let (step, other_step) = (k >> 1, k & 1);
            let (i, bit) = ((step << (2 - one)) | (other_step << (2 - other)), 4 >> axis);
            let beside = bricks.places[one][1 + step] + bricks.places[other][1 + other_step];
            let before = bricks.value(beside + bricks.places[axis][0]);
            let after = bricks.value(beside + bricks.places[axis][3]);
            let (low, high) = (values[i], values[i | bit]);
            if before.abs() < grid.band && after.abs() < grid.band {
                bent[i] = before - 2.0 * low + high;
                bent[i | bit] = low - 2.0 * high + after;
            }
        }
    }
    bends
}

/// Up to four voxels along each axis, in up to two bricks, each looked up once.
struct Bricks<'a> {
    grid: &'a BrickGrid,
    /// Slots of the bricks, in the order of [`cell_corner`].
    slots: [u32; 8],
    /// Of each voxel along x, y and z: its brick's share of the index among the slots times [`BRICK_VOXELS`], plus its
    /// share of the index among the brick's values.
    places: [[usize; 4]; 3],
}

impl<'a> Bricks<'a> {
    /// The bricks of all voxels from `first` to `last`, which are less than four voxels apart.
    fn new(grid: &'a BrickGrid, first: IVec3, last: IVec3) -> Self {
        let low: IVec3 = first >> 3;
        let more: IVec3 = (last >> 3) - low;
        let slot = |i: usize| {
            let step = cell_corner(i);
            if step.cmple(more).all() { grid.slot(low + step) } else { OUTSIDE }
        };
        let place = |axis: usize, step: usize| {
            let voxel = first[axis] + step as i32;
            let brick = (((voxel >> 3) - low[axis]) as usize) << (2 - axis);
            brick * BRICK_VOXELS + (((voxel & 7) as usize) << (6 - 3 * axis))
        };
        let places = std::array::from_fn(|axis| std::array::from_fn(|step| place(axis, step)));
        Self { grid, slots: std::array::from_fn(slot), places }
    }

    /// φ [m] at the sum of a voxel's places along x, y and z.
    #[inline(always)]
    fn value(&self, place: usize) -> f32 {
        match self.slots[place / BRICK_VOXELS] {
            OUTSIDE => self.grid.band,
            INSIDE => -self.grid.band,
            slot => self.grid.phi[slot as usize * BRICK_VOXELS + place % BRICK_VOXELS],
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
