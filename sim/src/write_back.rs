//! Writes the recession of a height field back into the distance field, Eq. (1): `∂φ/∂t = r |∇φ|`.
//!
//! A voxel moves with its closest surface point (extension velocities, Adalsteinsson and Sethian 1999). Its φ rises by
//! the recession of the columns there, interpolated between columns, times the field's own steepness along the column.
//! So the zero set moves by exactly the recession of its columns. Then the voxels away from the zero set are
//! reinitialised.

mod reinitialize;

use glam::{DVec2, IVec3};
use sdf_bake::BrickGrid;
use sdf_bake::channels::Scalar;
use shaders::constants::STEEPEST;

use self::reinitialize::reinitialize;
use crate::height_field::{HeightField, NO_SURFACE};
use crate::region::Region;

/// Bounds to which the field's measured steepness is clamped.
const STEEPNESS: (f64, f64) = (0.3, 2.0);

/// Writes the recession of a height field into the distance field it was read from.
pub fn write_back(grid: &mut BrickGrid, height_field: &mut HeightField) {
    if !grid.dose.is_empty() {
        let dosed = (0..height_field.window.lines()).filter(|&line| height_field.dose[line] > 0.0);
        dosed.for_each(|line| write_near(grid, height_field, line, Scalar::Dose, height_field.dose[line]));
    }
    let sunk: Vec<f64> =
        height_field.read_height.iter().zip(&height_field.height).map(|(read, now)| read - now).collect();
    let Some(changed) = changed_part(height_field, &sunk) else { return };
    let columns = columns_to_change(grid, height_field, &changed);
    open_bricks(grid, height_field, &columns);
    for column in &columns {
        raise(grid, height_field, &sunk, column);
    }
    if !grid.removed.is_empty() {
        for &Column { line, .. } in &columns {
            write_near(grid, height_field, line, Scalar::Removed, height_field.removed[line]);
        }
    }
    height_field.set_slopes_of(&changed);
    reinitialize(grid, height_field, (&columns, &changed));
}

/// A column whose voxels may change, and its position in the window.
struct Column {
    line: usize,
    row: usize,
    across: usize,
    /// Number of voxels above or below the surface that lie within the band.
    reach: i32,
}

/// The part of the window whose voxels may have a receded column as their closest surface point. `sunk` is the
/// recession of each column [m].
fn changed_part(height_field: &HeightField, sunk: &[f64]) -> Option<Region> {
    let [rows, across] = height_field.window.size;
    let (mut low, mut high) = ([usize::MAX; 2], [0; 2]);
    for (row, sunk) in sunk.chunks_exact(across).enumerate() {
        let Some(first) = sunk.iter().position(|sunk| *sunk > 0.0) else { continue };
        let last = sunk.iter().rposition(|sunk| *sunk > 0.0).unwrap_or(first);
        (low, high) = ([low[0].min(row), low[1].min(first)], [row, high[1].max(last)]);
    }
    if low[0] == usize::MAX {
        return None;
    }
    let range = |d: usize, size: usize| low[d].saturating_sub(2)..(high[d] + 3).min(size);
    Some(Region { rows: range(0, rows), columns: range(1, across) })
}

/// Columns of a part of the window that have a surface.
fn columns_to_change(grid: &BrickGrid, height_field: &HeightField, part: &Region) -> Vec<Column> {
    let across = height_field.window.size[1];
    let column = |line: usize| {
        let reach = reach(grid, height_field.area_ratio(line));
        Column { line, row: line / across, across: line % across, reach }
    };
    part.lines(across).filter(|&line| height_field.read_height[line] > NO_SURFACE).map(column).collect()
}

/// Allocates bricks ahead of the receding surface.
fn open_bricks(grid: &mut BrickGrid, height_field: &mut HeightField, columns: &[Column]) {
    let mut last = IVec3::MAX;
    for &Column { line, reach, .. } in columns {
        let (i, j) = height_field.window.place(line);
        let below = floor(height_field.height[line] / height_field.pitch) - reach;
        let brick = height_field.facing.voxel(i, j, below) >> 3;
        if brick != last {
            if let Some(slot) = grid.open_inside_brick(brick) {
                height_field.lattice.opened(brick, slot);
            }
            last = brick;
        }
    }
}

/// Writes a column's value of a channel to the voxels around its surface.
fn write_near(grid: &mut BrickGrid, height_field: &HeightField, line: usize, channel: Scalar, value: f64) {
    if height_field.height[line] <= NO_SURFACE {
        return;
    }
    let below = floor(height_field.height[line] / height_field.pitch);
    for k in below - 1..=below + 2 {
        if let Some(at) = height_field.lattice.place(height_field.on[line], k) {
            grid.scalar_mut(channel)[at] = value as f32;
        }
    }
}

/// Raises φ at a column's voxels within the band.
fn raise(grid: &mut BrickGrid, height_field: &HeightField, sunk: &[f64], column: &Column) {
    let line = column.line;
    if is_still(grid, height_field, sunk, column) {
        return;
    }
    let below = floor(height_field.read_height[line] / height_field.pitch);
    let (area_ratio, on, slope) =
        (height_field.area_ratio(line), height_field.on[line], DVec2::from(height_field.slope[line]));
    let (per_pitch, flatness) = (1.0 / height_field.pitch, 1.0 / area_ratio);
    let beside = [below, below + 1].map(|k| f64::from(height_field.lattice.phi(grid, on, k)));
    for (side, first, mut nearer) in [(1, below + 1, beside[0]), (-1, below, beside[1])] {
        for step in 0..column.reach {
            let Some(at) = height_field.lattice.place(on, first + side * step) else { break };
            let phi = f64::from(grid.phi[at]);
            let rise = (phi - nearer) * f64::from(side);
            if grid.phi[at].abs() >= grid.band || rise <= 0.0 {
                break;
            }
            // The closest surface point lies on another column.
            let around = BilinearStencil::of(height_field, column, slope * (phi * flatness * per_pitch));
            let sunk = around.map_or(0.0, |around| around.mean(sunk, height_field.window.size[1]));
            if sunk > 0.0 {
                let steepness = (rise * per_pitch * area_ratio).clamp(STEEPNESS.0, STEEPNESS.1) * flatness;
                grid.phi[at] = ((phi + sunk * steepness) as f32).min(grid.band);
            }
            nearer = phi;
        }
    }
}

/// True if no column near one receded that holds the closest surface point of any of its voxels within the band.
fn is_still(grid: &BrickGrid, height_field: &HeightField, sunk: &[f64], column: &Column) -> bool {
    let [rows, across] = height_field.window.size;
    let flatness = 1.0 / height_field.area_ratio(column.line);
    let most = height_field.slope[column.line].map(|slope| slope.abs() * f64::from(grid.band) * flatness);
    let reach = most.map(|way| floor(way / height_field.pitch) as usize + 1);
    let range = |at: usize, reach: usize, size: usize| at.saturating_sub(reach)..(at + reach + 1).min(size);
    let places = range(column.across, reach[1], across);
    range(column.row, reach[0], rows)
        .all(|row| sunk[row * across + places.start..row * across + places.end].iter().all(|sunk| *sunk <= 0.0))
}

/// Floor of a value that fits an `i32`; the library's function is a call on plain x86-64.
fn floor(value: f64) -> i32 {
    let near = value as i32;
    near - i32::from(f64::from(near) > value)
}

/// Number of voxels above or below the surface that lie within the band along a column.
fn reach(grid: &BrickGrid, area_ratio: f64) -> i32 {
    (f64::from(grid.band) / grid.voxel * area_ratio.min(STEEPEST)).ceil() as i32 + 1
}

/// The four columns around a point of the window, with their bilinear weights.
struct BilinearStencil {
    /// The first column: the one of the lower row and place.
    first: usize,
    weights: [f64; 4],
}

impl BilinearStencil {
    /// The columns around the point at offset `at` [columns] from a column; `None` beyond the window.
    #[inline(always)]
    fn of(height_field: &HeightField, column: &Column, at: DVec2) -> Option<Self> {
        let [rows, across] = height_field.window.size;
        let (row, place) = (column.row as f64 + at.x, column.across as f64 + at.y);
        if !(row >= 0.0 && place >= 0.0 && row <= (rows - 1) as f64 && place <= (across - 1) as f64) {
            return None;
        }
        // Positions in a window fit an `i32`, to which a processor converts faster.
        let (r, c) = ((row as i32 as usize).min(rows - 2), (place as i32 as usize).min(across - 2));
        let (fr, fc) = (row - r as f64, place - c as f64);
        let weights = [(1.0 - fr) * (1.0 - fc), (1.0 - fr) * fc, fr * (1.0 - fc), fr * fc];
        Some(Self { first: r * across + c, weights })
    }

    /// The four columns of a window `across` columns wide.
    #[inline(always)]
    fn lines(&self, across: usize) -> [usize; 4] {
        [self.first, self.first + 1, self.first + across, self.first + across + 1]
    }

    /// Weighted mean of per-column values.
    #[inline(always)]
    fn mean(&self, values: &[f64], across: usize) -> f64 {
        self.lines(across).into_iter().zip(self.weights).map(|(line, weight)| weight * values[line]).sum()
    }
}
