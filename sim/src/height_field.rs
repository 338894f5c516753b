//! The workpiece's surface under a tool, as a height field of columns along the distance field's own lattice lines.
//!
//! Columns run along the lattice axis nearest to the approach axis, one on each lattice line. On a line the distance
//! field is known at every voxel, so the surface height is a root of a cubic in one variable: it needs no interpolation
//! across lines, and is fourth order where the surface is smooth.

mod read;
mod slopes;

use std::cell::OnceCell;
use std::ops::Range;

use glam::{DVec3, IVec3};

use self::slopes::Bend;
use crate::lattice_line::{Lattice, Line};
use crate::region::Region;

/// Height of a column without a surface [m]: finite, so that sums over columns stay finite.
pub const NO_SURFACE: f64 = -1e6;

/// Distance that means "no edge near" [m].
const NO_EDGE: f64 = 1.0;

/// The lattice axis along which columns run, and which way is up.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Facing {
    axis: usize,
    up: i32,
}

impl Facing {
    /// The lattice axis nearest to an approach axis.
    pub fn of(approach: DVec3) -> Self {
        let axis = approach.abs().max_position();
        Self { axis, up: if approach[axis] < 0.0 { -1 } else { 1 } }
    }

    /// The two lattice axes across the columns.
    pub fn across(&self) -> (usize, usize) {
        ((self.axis + 1) % 3, (self.axis + 2) % 3)
    }

    /// Transforms a vector of the distance field's frame into (u, v, up).
    pub fn height_field(&self, v: DVec3) -> DVec3 {
        let (a, b) = self.across();
        DVec3::new(v[a], v[b], f64::from(self.up) * v[self.axis])
    }

    /// Transforms a vector (u, v, up) into the distance field's frame.
    pub fn world(&self, s: DVec3) -> DVec3 {
        let (a, b) = self.across();
        let mut v = DVec3::ZERO;
        (v[a], v[b], v[self.axis]) = (s.x, s.y, f64::from(self.up) * s.z);
        v
    }

    /// The axis of the columns, 0 to 2.
    pub(crate) fn axis(&self) -> usize {
        self.axis
    }

    /// 1 or -1: the columns run along the axis or opposite to it.
    pub(crate) fn up(&self) -> i32 {
        self.up
    }

    /// The voxel at lattice indices (i, j) across and `k` up.
    pub fn voxel(&self, i: i32, j: i32, k: i32) -> IVec3 {
        let (a, b) = self.across();
        let mut voxel = IVec3::ZERO;
        (voxel[a], voxel[b], voxel[self.axis]) = (i, j, self.up * k);
        voxel
    }
}

/// A rectangle of lattice lines.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Window {
    /// Index of the first line along u and v [voxels].
    pub low: [i32; 2],
    /// Number of lines along u and v.
    pub size: [usize; 2],
}

impl Window {
    /// The smallest window around points (u, v, up) [m], `margin` lines wider on each side.
    pub fn around(points: impl Iterator<Item = DVec3>, voxel: f64, margin: i32) -> Self {
        let (mut low, mut high) = (DVec3::INFINITY, DVec3::NEG_INFINITY);
        for point in points {
            (low, high) = (low.min(point), high.max(point));
        }
        let first = [low.x, low.y].map(|x| (x / voxel).floor() as i32 - margin);
        let last = [high.x, high.y].map(|x| (x / voxel).ceil() as i32 + margin);
        Self { low: first, size: [0, 1].map(|d| (last[d] - first[d] + 1).max(3) as usize) }
    }

    /// Returns true if this window contains another one, except `slack` lines on each side.
    pub fn holds(&self, other: &Self, slack: i32) -> bool {
        (0..2).all(|d| {
            let end = |window: &Self| window.low[d] + window.size[d] as i32;
            other.low[d] + slack >= self.low[d] && end(other) - slack <= end(self)
        })
    }

    /// Number of lines.
    pub fn lines(&self) -> usize {
        self.size[0] * self.size[1]
    }

    /// Lattice indices of all lines, row by row.
    fn rows(&self) -> impl Iterator<Item = (i32, Range<i32>)> {
        let Self { low: [i, j], size: [rows, across] } = *self;
        (i..i + rows as i32).map(move |i| (i, j..j + across as i32))
    }

    /// Lattice indices of a line.
    pub fn place(&self, line: usize) -> (i32, i32) {
        (self.low[0] + (line / self.size[1]) as i32, self.low[1] + (line % self.size[1]) as i32)
    }
}

/// The height field of a window; columns are ordered v fastest.
#[derive(Clone, Debug)]
pub struct HeightField {
    /// Axis and direction of the columns.
    pub facing: Facing,
    /// Distance between columns [m].
    pub pitch: f64,
    /// Window of the columns.
    pub window: Window,
    /// The distance field's lattice lines in the window, and that of each column.
    pub(crate) lattice: Lattice,
    pub(crate) on: Vec<Line>,
    /// Position of each column, u and v [m].
    place: Vec<[f64; 2]>,
    /// Height of the surface when it was read [m], or [`NO_SURFACE`].
    pub read_height: Vec<f64>,
    /// Current height of the surface [m].
    pub height: Vec<f64>,
    /// Lowest and highest height of the surface [m]; lowest > highest without a surface.
    levels: (f64, f64),
    /// Slopes of the surface along u and v [1].
    pub slope: Vec<[f64; 2]>,
    /// Surface area per area of the lattice, 1/cos of the slope.
    area_ratio: Vec<f64>,
    /// Coating dose D [1].
    pub dose: Vec<f64>,
    /// Depth removed so far [m]; 0 if the field does not store it.
    pub removed: Vec<f64>,
    /// Weld id, 0 for base metal.
    pub label: Vec<u16>,
    /// Cached result of [`HeightField::edge_distances`].
    edges: OnceCell<Vec<f64>>,
}

impl HeightField {
    /// Lowers the surface of a column by a recession of `way` [m] along its normal.
    pub fn recede(&mut self, line: usize, way: f64) {
        self.removed[line] += way;
        self.height[line] -= way * self.area_ratio(line);
        self.levels.0 = self.levels.0.min(self.height[line]);
    }

    /// Lowest and highest height of the surface [m]; lowest > highest without a surface.
    pub(crate) fn levels(&self) -> (f64, f64) {
        self.levels
    }

    /// Position of each column, u and v [m].
    pub(crate) fn places(&self) -> &[[f64; 2]] {
        &self.place
    }

    /// A column's surface point as (u, v, up) [m].
    pub fn point(&self, line: usize) -> DVec3 {
        let [u, v] = self.place[line];
        DVec3::new(u, v, self.height[line])
    }

    /// Surface area per area of the lattice, 1/cos of the slope.
    pub fn area_ratio(&self, line: usize) -> f64 {
        self.area_ratio[line]
    }

    /// The same for all columns.
    pub(crate) fn area_ratios(&self) -> &[f64] {
        &self.area_ratio
    }

    /// Tangent of the angle between the surface's normal and an approach axis.
    pub fn slope_against(&self, line: usize, approach: DVec3) -> f64 {
        let [u, v] = self.slope[line];
        let cosine = (DVec3::new(-u, -v, 1.0).normalize().dot(self.facing.height_field(approach))).clamp(1e-6, 1.0);
        (1.0 - cosine * cosine).sqrt() / cosine
    }

    /// Distance [m] of each column from the nearest edge of the part, across the columns. An edge is a column without a
    /// surface, or a step of more than two pitches. It is 1 m if no edge is in the window. Computed on first use.
    pub fn edge_distances(&self) -> &[f64] {
        self.edges.get_or_init(|| self.measure_edges())
    }

    /// Chamfer distances (Borgefors 1986).
    fn measure_edges(&self) -> Vec<f64> {
        let [rows, across] = self.window.size;
        let mut distance: Vec<f64> = self.height.iter().map(|&h| if h > NO_SURFACE { NO_EDGE } else { 0.0 }).collect();
        let diagonal = std::f64::consts::SQRT_2;
        let steps = [(-1, -1, diagonal), (-1, 0, 1.0), (-1, 1, diagonal), (0, -1, 1.0)];
        for sign in [1, -1] {
            for n in 0..rows * across {
                let line = if sign > 0 { n } else { rows * across - 1 - n };
                for (dr, dc, way) in steps {
                    let (r, c) = ((line / across) as i64 + sign * dr, (line % across) as i64 + sign * dc);
                    if r < 0 || c < 0 || r >= rows as i64 || c >= across as i64 {
                        continue;
                    }
                    let other = r as usize * across + c as usize;
                    let step = self.height[line] - self.height[other] > 2.0 * self.pitch;
                    let reach = if step { 0.5 * self.pitch } else { distance[other] + way * self.pitch };
                    distance[line] = distance[line].min(reach);
                }
            }
        }
        distance
    }

    /// Computes the slopes from the current heights.
    pub fn set_slopes(&mut self) {
        let [rows, across] = self.window.size;
        pulp::Arch::new().dispatch(Bend { height_field: self, rows: 0..rows, columns: 0..across });
    }

    /// The same in a region of the height field and around it.
    pub fn set_slopes_in(&mut self, region: &Region) {
        self.set_slopes_of(&region.grown());
    }

    /// The same for the columns of a rectangle.
    pub(crate) fn set_slopes_of(&mut self, Region { rows, columns }: &Region) {
        let (rows, columns) = (rows.clone(), columns.clone());
        pulp::Arch::new().dispatch(Bend { height_field: self, rows, columns });
    }
}

#[cfg(test)]
mod tests {
    use sdf_bake::BrickGrid;

    use super::*;

    #[test]
    fn a_ball_is_read_to_fourth_order_from_every_side() {
        let worst = |voxel: f64, approach: DVec3| {
            let half = DVec3::splat(0.02);
            let grid = BrickGrid::from_distance(-half, half, voxel, 3.0, |p| p.length() - 0.02);
            let facing = Facing::of(approach);
            let lines = (0.008 / voxel) as i32;
            let window = Window { low: [-lines; 2], size: [2 * lines as usize + 1; 2] };
            let height_field = HeightField::read(&grid, facing, window, 0.021, -0.03);
            let off = |line: usize| (facing.world(height_field.point(line)).length() - 0.02).abs();
            (0..window.lines()).map(off).fold(0.0, f64::max)
        };
        for approach in [DVec3::X, DVec3::NEG_Y, DVec3::Z, DVec3::new(0.1, 0.2, -0.9)] {
            let (coarse, fine) = (worst(0.001, approach), worst(0.0005, approach));
            println!("ball read along {approach}: within {coarse:.1e} m at 1 mm, {fine:.1e} m at 0.5 mm");
            assert!(coarse < 1e-7 && fine < 2e-8);
        }
    }

    #[test]
    fn windows_of_one_line_have_no_slopes() {
        let half = DVec3::splat(0.004);
        let grid = BrickGrid::from_distance(-half, half, 0.5e-3, 3.0, |p| p.z);
        for size in [[1, 1], [1, 4], [4, 1], [2, 2]] {
            let height_field =
                HeightField::read(&grid, Facing::of(DVec3::Z), Window { low: [0, 0], size }, 0.002, -0.002);
            assert!(
                height_field.slope.iter().all(|slope| *slope == [0.0; 2])
                    && height_field.area_ratio.iter().all(|&ratio| ratio == 1.0)
            );
        }
    }

    #[test]
    fn slopes_end_at_walls_and_lines_without_a_surface_say_so() {
        let half = DVec3::new(0.01, 0.01, 0.004);
        let grid = BrickGrid::from_distance(-half, half, 0.5e-3, 3.0, |p| {
            let q = p.abs() - half;
            q.max(DVec3::ZERO).length() + q.max_element().min(0.0)
        });
        let window = Window { low: [15, 0], size: [10, 3] };
        let height_field = HeightField::read(&grid, Facing::of(DVec3::Z), window, 0.005, -0.02);
        let column = |i: i32| height_field.height[((i - 15) * 3 + 1) as usize];
        assert!((column(19) - 0.004).abs() < 1e-8, "{}", column(19));
        assert_eq!(column(21), NO_SURFACE);
        assert!(height_field.slope.iter().all(|s| s[0].abs() < 0.5 && s[1].abs() < 0.5));
    }
}
