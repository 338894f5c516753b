//! Writing what a sheet lost back into the field, Eq. (1): `∂φ/∂t = r |∇φ|`.
//!
//! A voxel rises with its closest surface point (extension velocities, Adalsteinsson and Sethian 1999): by how far the
//! columns there have sunk, interpolated between them, times the field's own steepness along the column. So the zero set
//! moves by exactly what its columns sank. Then voxels farther than [`KEPT_VOXELS`], which carry no zero set, take their distance anew from one
//! voxel nearer to the surface along the normal, layer by layer.

use glam::{DVec2, IVec3};
use sdf_bake::BrickGrid;
use sdf_bake::channels::Scalar;
use sdf_bake::redistance::KEPT_VOXELS;

use crate::sheet::{NO_SURFACE, Sheet};

/// Area ratio up to which a column's whole band is written.
const STEEPEST: f64 = 2.0;
/// Bounds of the field's steepness that are believed.
const STEEPNESS: (f64, f64) = (0.3, 2.0);

/// Writes the recession of a sheet into the field it was read from.
pub fn commit(grid: &mut BrickGrid, sheet: &mut Sheet) {
    if !grid.dose.is_empty() {
        let dosed = (0..sheet.window.lines()).filter(|&line| sheet.dose[line] > 0.0);
        dosed.for_each(|line| write_near(grid, sheet, line, Scalar::Dose, sheet.dose[line]));
    }
    let Some(lines) = lines_to_change(sheet) else { return };
    open_bricks(grid, sheet, &lines);
    for &line in &lines {
        raise(grid, sheet, line);
    }
    if !grid.removed.is_empty() {
        for &line in &lines {
            write_near(grid, sheet, line, Scalar::Removed, sheet.removed[line]);
        }
    }
    sheet.set_slopes();
    let below: Vec<i32> = lines.iter().map(|&line| floor(sheet.height[line] / sheet.pitch)).collect();
    let layers = lines.iter().map(|&line| reach(grid, sheet.area_ratio(line))).max().unwrap_or(0);
    let mut renewed = Vec::new();
    for layer in 1..=layers {
        // All are found before any is written, so that the order of the lines does not matter.
        renewed.clear();
        for (&line, &below) in lines.iter().zip(&below) {
            for (k, side) in [(below + layer, 1), (below + 1 - layer, -1)] {
                renewed.extend(renewed_far(grid, sheet, line, (k, side)));
            }
        }
        renewed.drain(..).for_each(|far| write_far(grid, sheet, &far));
    }
}

/// Lines whose voxels may have a receded column as their closest surface point.
fn lines_to_change(sheet: &Sheet) -> Option<Vec<usize>> {
    let [rows, across] = sheet.window.size;
    let receded = |line: &usize| sheet.height[*line] < sheet.read_height[*line];
    let (mut low, mut high) = ([usize::MAX; 2], [0; 2]);
    for line in (0..sheet.window.lines()).filter(receded) {
        for (d, at) in [line / across, line % across].into_iter().enumerate() {
            (low[d], high[d]) = (low[d].min(at), high[d].max(at));
        }
    }
    if low[0] == usize::MAX {
        return None;
    }
    let from = |d: usize| low[d].saturating_sub(2);
    let to = |d: usize, size: usize| (high[d] + 2).min(size - 1);
    let rows = from(0)..=to(0, rows);
    let lines = rows.flat_map(|row| (from(1)..=to(1, across)).map(move |place| row * across + place));
    Some(lines.filter(|&line| sheet.read_height[line] > NO_SURFACE).collect())
}

/// Gives bricks to what lies ahead of the receding surface.
fn open_bricks(grid: &mut BrickGrid, sheet: &mut Sheet, lines: &[usize]) {
    let mut last = IVec3::MAX;
    for &line in lines {
        let (i, j) = sheet.window.place(line);
        let below = floor(sheet.height[line] / sheet.pitch) - reach(grid, sheet.area_ratio(line));
        let brick = sheet.facing.voxel(i, j, below) >> 3;
        if brick != last {
            if let Some(slot) = grid.open_inside_brick(brick) {
                sheet.lattice.opened(brick, slot);
            }
            last = brick;
        }
    }
}

/// Writes a line's value of a channel to the voxels around its surface.
fn write_near(grid: &mut BrickGrid, sheet: &Sheet, line: usize, channel: Scalar, value: f64) {
    if sheet.height[line] <= NO_SURFACE {
        return;
    }
    let below = floor(sheet.height[line] / sheet.pitch);
    for k in below - 1..=below + 2 {
        if let Some(at) = sheet.lattice.place(sheet.on[line], k) {
            grid.scalar_mut(channel)[at] = value as f32;
        }
    }
}

/// Raises the band's voxels of a line.
fn raise(grid: &mut BrickGrid, sheet: &Sheet, line: usize) {
    let below = floor(sheet.read_height[line] / sheet.pitch);
    let (area_ratio, on) = (sheet.area_ratio(line), sheet.on[line]);
    let beside = [below, below + 1].map(|k| f64::from(sheet.lattice.phi(grid, on, k)));
    for (side, first, mut nearer) in [(1, below + 1, beside[0]), (-1, below, beside[1])] {
        for step in 0..reach(grid, area_ratio) {
            let Some(at) = sheet.lattice.place(on, first + side * step) else { break };
            let phi = f64::from(grid.phi[at]);
            let rise = (phi - nearer) * f64::from(side);
            if grid.phi[at].abs() >= grid.band || rise <= 0.0 {
                break;
            }
            let sunk = sunk_at(sheet, line, phi);
            if sunk > 0.0 {
                let steepness = (rise / sheet.pitch * area_ratio).clamp(STEEPNESS.0, STEEPNESS.1) / area_ratio;
                grid.phi[at] = ((phi + sunk * steepness) as f32).min(grid.band);
            }
            nearer = phi;
        }
    }
}

/// The whole number at or below a value that fits an `i32`; the library's function is a call on plain x86-64.
fn floor(value: f64) -> i32 {
    let near = value as i32;
    near - i32::from(f64::from(near) > value)
}

/// Voxels above or below the surface that a column's share of the band covers.
fn reach(grid: &BrickGrid, area_ratio: f64) -> i32 {
    (f64::from(grid.band) / grid.voxel * area_ratio.min(STEEPEST)).ceil() as i32 + 1
}

/// How far [m] the column has sunk on which the closest surface point of a voxel lies, which has the value `phi` [m] on
/// a line.
fn sunk_at(sheet: &Sheet, line: usize, phi: f64) -> f64 {
    let shift = phi / (sheet.area_ratio(line) * sheet.pitch);
    let at = DVec2::from(sheet.slope[line]) * shift;
    bilinear(sheet, line, at, |near| Some(sheet.read_height[near] - sheet.height[near])).unwrap_or(0.0)
}

/// Interpolates between the columns around a line, `at` [columns] away from it; `None` beyond the window, or where a
/// column has no value.
fn bilinear(sheet: &Sheet, line: usize, at: DVec2, value: impl Fn(usize) -> Option<f64>) -> Option<f64> {
    let [rows, across] = sheet.window.size;
    let own = [line / across, line % across];
    let (row, column) = (own[0] as f64 + at.x, own[1] as f64 + at.y);
    if !(row >= 0.0 && column >= 0.0 && row <= (rows - 1) as f64 && column <= (across - 1) as f64) {
        return None;
    }
    let (r, c) = ((row as usize).min(rows - 2), (column as usize).min(across - 2));
    let (fr, fc) = (row - r as f64, column - c as f64);
    let first = r * across + c;
    let mut sum = 0.0;
    for (near, weight) in [
        (first, (1.0 - fr) * (1.0 - fc)),
        (first + 1, (1.0 - fr) * fc),
        (first + across, fr * (1.0 - fc)),
        (first + across + 1, fr * fc),
    ] {
        if weight > 0.0 {
            sum += weight * value(near)?;
        }
    }
    Some(sum)
}

/// A voxel that carries no zero set, with its new distance.
struct Far {
    line: usize,
    k: i32,
    at: usize,
    phi: f32,
}

/// Voxel `k` of a line, on a side of the surface; `None` where it carries the zero set, or has no nearer one.
fn renewed_far(grid: &BrickGrid, sheet: &Sheet, line: usize, (k, side): (i32, i32)) -> Option<Far> {
    let kept = (KEPT_VOXELS * sheet.pitch) as f32;
    let at = sheet.lattice.place(sheet.on[line], k)?;
    let old = grid.phi[at];
    let wrong_side = old * (side as f32) < 0.0;
    if old.abs() <= kept || wrong_side {
        return None;
    }
    let distance = distance_from_nearer(grid, sheet, line, k, side)?;
    Some(Far { line, k, at, phi: (distance as f32).clamp(kept, grid.band) * side as f32 })
}

/// Writes a distance; a voxel that was beyond the band takes the label of the one above it.
fn write_far(grid: &mut BrickGrid, sheet: &Sheet, far: &Far) {
    if grid.phi[far.at] == -grid.band && !grid.label.is_empty() {
        let above = sheet.lattice.place(sheet.on[far.line], far.k + 1);
        grid.label[far.at] = above.map_or(0, |above| grid.label[above]);
    }
    grid.phi[far.at] = far.phi;
}

/// Distance [m] of voxel `k` of a line from the surface: that of the point one voxel of height nearer to it on the
/// normal, and the way there.
fn distance_from_nearer(grid: &BrickGrid, sheet: &Sheet, line: usize, k: i32, side: i32) -> Option<f64> {
    let slope = DVec2::from(sheet.slope[line]);
    let area_ratio = sheet.area_ratio(line);
    let value = |near: usize| {
        let phi = f64::from(sheet.lattice.phi(grid, sheet.on[near], k - side));
        (phi.abs() < f64::from(grid.band)).then_some(phi)
    };
    let nearer = bilinear(sheet, line, slope * f64::from(side), value)?;
    Some((nearer * f64::from(side)).max(0.0) + sheet.pitch * area_ratio)
}
