//! Four points of a field at a time, in lanes: the same numbers as one by one, as every lane does the same operations.

use glam::{IVec3, Vec3, Vec3A, Vec4};

use super::field::Field;
use super::walk::WHOLE;

/// Points or vectors by their components, in voxels from the lowest voxel of the index.
#[derive(Clone, Copy)]
pub(crate) struct Four {
    pub(crate) axes: [Vec4; 3],
}

impl Four {
    /// Of single points.
    #[inline]
    pub(crate) fn of(points: &[Vec3; 4]) -> Self {
        let axis = |axis: usize| Vec4::new(points[0][axis], points[1][axis], points[2][axis], points[3][axis]);
        Self { axes: [axis(0), axis(1), axis(2)] }
    }

    /// The points moved along one direction, each by its own length.
    #[inline]
    pub(crate) fn moved(&self, direction: Vec3A, lengths: Vec4) -> Self {
        let [x, y, z] = self.axes;
        let along = |from: Vec4, slope: f32| from + slope * lengths;
        Self { axes: [along(x, direction.x), along(y, direction.y), along(z, direction.z)] }
    }

    /// Lowest corners of the points' cells; of the next lower cells for points on a border across an axis that is
    /// `backward`.
    #[inline]
    pub(crate) fn corners(&self, backward: [bool; 3]) -> Self {
        let corner = |at: Vec4, is_backward: bool| {
            let nearest = (at + WHOLE) - WHOLE;
            let is_beyond = if is_backward { nearest.cmpge(at) } else { nearest.cmpgt(at) };
            nearest - Vec4::select(is_beyond, Vec4::ONE, Vec4::ZERO)
        };
        let [x, y, z] = self.axes;
        Self { axes: [corner(x, backward[0]), corner(y, backward[1]), corner(z, backward[2])] }
    }

    /// Whole numbers as integers, for each point.
    #[inline]
    pub(crate) fn integers(&self) -> [IVec3; 4] {
        let [x, y, z] = self.axes.map(|axis| {
            (axis + WHOLE).to_array().map(|sum| (sum.to_bits() as i32).wrapping_sub(WHOLE.to_bits() as i32))
        });
        [
            IVec3::new(x[0], y[0], z[0]),
            IVec3::new(x[1], y[1], z[1]),
            IVec3::new(x[2], y[2], z[2]),
            IVec3::new(x[3], y[3], z[3]),
        ]
    }

    /// One of the points.
    #[inline]
    pub(crate) fn point(&self, lane: usize) -> Vec3A {
        Vec3A::new(self.axes[0][lane], self.axes[1][lane], self.axes[2][lane])
    }

    /// As [`trilinear`](sdf_bake::grid::trilinear) for each lane: at these points in the cells with the lowest corners
    /// `low` and the corner `values`.
    #[inline]
    pub(crate) fn trilinear(&self, low: &Self, values: &[[f32; 8]; 4]) -> Vec4 {
        let mix = |a: Vec4, b: Vec4, t: Vec4| a + (b - a) * t;
        let within = |axis: usize| self.axes[axis] - low.axes[axis];
        let corner = |i: usize| Vec4::new(values[0][i], values[1][i], values[2][i], values[3][i]);
        let along_z = |i: usize| mix(corner(i), corner(i + 1), within(2));
        let along_y = |i: usize| mix(along_z(i), along_z(i + 2), within(1));
        mix(along_y(0), along_y(4), within(0))
    }
}

impl Field<'_> {
    /// φ [m] at four points, trilinear.
    pub(crate) fn phi_of_four(&self, points: &[Vec3; 4]) -> Vec4 {
        let at = Four::of(points);
        let low = at.corners([false; 3]);
        let [a, b, c, d] = low.integers();
        at.trilinear(&low, &[self.cell_phi(a), self.cell_phi(b), self.cell_phi(c), self.cell_phi(d)])
    }
}

#[cfg(test)]
mod tests {
    use glam::DVec3;
    use sdf_bake::BrickGrid;
    use sdf_bake::grid::trilinear;

    use super::*;
    use crate::render::field::cell_of;

    #[test]
    fn four_points_have_the_values_of_each_alone() {
        let half = DVec3::splat(0.01);
        let grid = BrickGrid::from_distance(-half, half, 0.0005, 3.0, |p| p.length() - 0.01);
        let field = Field::new(&grid);
        let point = |i: i32| {
            let i = f64::from(i);
            field.in_voxels(DVec3::new((2.4 * i).cos(), (2.4 * i).sin(), (0.7 * i).sin()) * (0.0005 * (i % 30.0)))
        };
        for i in 0..2000 {
            let points = [point(i), point(i + 1), point(2 * i), Vec3::splat(i as f32 * 1e4)];
            let alone = |point: Vec3| {
                let (corner, within) = cell_of(point);
                trilinear(&field.cell_phi(corner), within)
            };
            assert_eq!(field.phi_of_four(&points).to_array(), points.map(alone), "from {i}");
        }
    }
}
