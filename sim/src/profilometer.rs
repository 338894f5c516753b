//! A virtual profilometer: the surface of a field as an instrument above it measures it.
//!
//! Along each lattice line parallel to z the topmost surface is the root of the cubic through the four voxels around
//! the sign change. This is third order or better if φ is a distance. Pixels between lattice lines take the bicubic of
//! the lines around them; then the instrument's lateral blur is applied. If all pixels are on lattice lines, as for a
//! scan whose pitch is a multiple of the voxel, only those lines are read.

use glam::{DVec2, IVec2, IVec3};
use rayon::prelude::*;
use sdf_bake::grid::{BRICK_SIDE, BRICK_VOXELS, INSIDE, OUTSIDE, voxel_offset};
use sdf_bake::{BrickGrid, HeightMap, PixelGrid};

use crate::crossing::way_to_zero;

/// Distance from a lattice line up to which a pixel counts as on it [voxels].
const ON_LINE: f64 = 1e-6;

/// A virtual profilometer.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Profilometer {
    /// Its pixels.
    pub pixels: PixelGrid,
    /// Turn of the pixels about their middle [rad], positive from x to y.
    pub turn: f64,
    /// Standard deviation of its lateral blur, a Gaussian [m]; 0 for none.
    pub blur: f64,
}

/// Crossing of a lattice line with the topmost surface.
#[derive(Clone, Copy)]
struct Crossing {
    /// Voxel below the surface on the line.
    below: IVec3,
    /// Distance from that voxel to the surface [voxels], 0 to 1.
    way: f64,
}

/// Lattice lines around an instrument's pixels.
struct Lines {
    /// Lattice index of the first line [voxels].
    first: IVec2,
    nx: usize,
    ny: usize,
}

impl Profilometer {
    /// An instrument without blur.
    pub fn sharp(pixels: PixelGrid) -> Self {
        Self { pixels, turn: 0.0, blur: 0.0 }
    }

    /// Position of a pixel on the part [m].
    fn place(&self, k: usize) -> DVec2 {
        let PixelGrid { nx, ny, .. } = self.pixels;
        let place = self.pixels.position(k % nx, k / nx);
        if self.turn == 0.0 {
            return place;
        }
        let middle = 0.5 * (self.pixels.origin + self.pixels.position(nx - 1, ny - 1));
        middle + DVec2::from_angle(self.turn).rotate(place - middle)
    }

    /// Heights of the topmost surface [m]; NaN where there is no surface.
    pub fn heights(&self, grid: &BrickGrid) -> HeightMap {
        let read = |crossing: Crossing| (f64::from(crossing.below.z) + crossing.way) * grid.voxel;
        HeightMap { pixels: self.pixels, heights: self.sampled(grid, read) }
    }

    /// A channel of the field on the topmost surface, for instance the coating dose; NaN where there is no surface.
    ///
    /// - `values`: one per voxel in the order of `phi`, shape `[bricks, 512]`; empty where all are 0
    pub fn channel(&self, grid: &BrickGrid, values: &[f32]) -> Vec<f64> {
        let at = |voxel: IVec3| match grid.slot(voxel >> 3) {
            OUTSIDE | INSIDE => f64::NAN,
            _ if values.is_empty() => 0.0,
            slot => f64::from(values[slot as usize * BRICK_VOXELS + voxel_offset(voxel)]),
        };
        self.sampled(grid, |Crossing { below, way }| {
            let (low, high) = (at(below), at(below + IVec3::Z));
            low + (high - low) * way
        })
    }

    /// True for pixels that show substrate, where the dose has reached 1; `None` where there is no surface.
    ///
    /// - `dose`: coating dose of each voxel in the order of `phi`, 1 where the coating is gone
    pub fn exposed(&self, grid: &BrickGrid, dose: &[f32]) -> Vec<Option<bool>> {
        let share = |dose: f64| (!dose.is_nan()).then_some(dose >= 1.0);
        self.channel(grid, dose).into_iter().map(share).collect()
    }

    /// Values of `read` on the surface at the pixels, blurred.
    fn sampled(&self, grid: &BrickGrid, read: impl Fn(Crossing) -> f64 + Sync) -> Vec<f64> {
        let value = |line: IVec2| topmost(grid, line).map_or(f64::NAN, &read);
        let place = |k: usize| self.place(k) / grid.voxel;
        let count = self.pixels.len();
        let sharp: Vec<f64> = if (0..count).all(|k| is_on_line(place(k))) {
            (0..count).into_par_iter().map(|k| value(place(k).round().as_ivec2())).collect()
        } else {
            let lines = Lines::around((0..count).map(place));
            let on_lines: Vec<f64> = (0..lines.nx * lines.ny).into_par_iter().map(|k| value(lines.line(k))).collect();
            (0..count).into_par_iter().map(|k| lines.at(&on_lines, place(k))).collect()
        };
        blurred(sharp, self.pixels.nx, self.blur / self.pixels.pitch)
    }
}

/// True if a point [voxels] is on a lattice line.
fn is_on_line(place: DVec2) -> bool {
    (place - place.round()).abs().max_element() < ON_LINE
}

/// The topmost surface on the lattice line at indices (x, y) [voxels].
fn topmost(grid: &BrickGrid, line: IVec2) -> Option<Crossing> {
    let side = BRICK_SIDE as i32;
    let mut above: Option<f32> = None;
    for brick in (grid.origin.z..grid.origin.z + grid.dims.z).rev() {
        let slot = grid.slot(line.extend(brick * side) >> 3);
        if slot == OUTSIDE {
            above = Some(grid.band);
            continue;
        }
        for z in (brick * side..(brick + 1) * side).rev() {
            let voxel = line.extend(z);
            let phi = match slot {
                INSIDE => -grid.band,
                slot => grid.phi[slot as usize * BRICK_VOXELS + voxel_offset(voxel)],
            };
            if phi < 0.0 {
                return above.map(|above| Crossing { below: voxel, way: way_up(grid, voxel, phi, above) });
            }
            above = Some(phi);
        }
    }
    None
}

/// Distance [voxels] from a voxel below the surface to the surface on its line.
fn way_up(grid: &BrickGrid, below: IVec3, low: f32, high: f32) -> f64 {
    let (before, after) = (grid.phi_at(below - IVec3::Z), grid.phi_at(below + 2 * IVec3::Z));
    way_to_zero([before, low, high, after].map(f64::from), grid.band.into())
}

impl Lines {
    /// The lines under all pixels [voxels], with two more on each side for the bicubic.
    fn around(mut places: impl Iterator<Item = DVec2>) -> Self {
        let first = places.next().unwrap_or_default();
        let (low, high) = places.fold((first, first), |(low, high), place| (low.min(place), high.max(place)));
        let (low, high) = (low.floor().as_ivec2() - 2, high.ceil().as_ivec2() + 2);
        Self { first: low, nx: (high.x - low.x + 1) as usize, ny: (high.y - low.y + 1) as usize }
    }

    fn line(&self, k: usize) -> IVec2 {
        self.first + IVec2::new((k % self.nx) as i32, (k / self.nx) as i32)
    }

    /// Bicubic interpolation between the lines' values at a point [voxels]; bilinear where the sixteen are not all
    /// known, NaN where the four are not.
    fn at(&self, values: &[f64], place: DVec2) -> f64 {
        let local = place - self.first.as_dvec2();
        let value = |i: usize, j: usize| values[j * self.nx + i];
        if is_on_line(local) {
            let nearest = local.round();
            return value(nearest.x as usize, nearest.y as usize);
        }
        let corner = local.floor();
        let (i, j, t) = (corner.x as usize, corner.y as usize, local - corner);
        let sum = |wx: &[f64], wy: &[f64], i: usize, j: usize| {
            let row = |b: usize| (0..wx.len()).map(|a| wx[a] * value(i + a, j + b)).sum::<f64>();
            (0..wy.len()).map(|b| wy[b] * row(b)).sum::<f64>()
        };
        let bicubic = sum(&cubic_weights(t.x), &cubic_weights(t.y), i - 1, j - 1);
        if bicubic.is_nan() { sum(&[1.0 - t.x, t.x], &[1.0 - t.y, t.y], i, j) } else { bicubic }
    }
}

/// Lagrange weights of the four points around a cell at `t` (0 to 1).
fn cubic_weights(t: f64) -> [f64; 4] {
    let (a, b, c, d) = (t + 1.0, t, t - 1.0, t - 2.0);
    [-b * c * d / 6.0, a * c * d / 2.0, -a * b * d / 2.0, a * b * c / 6.0]
}

/// Gaussian blur of rows of `nx` values with a standard deviation of `sigma` [pixels]. Missing values stay missing and
/// have no weight for their neighbours.
fn blurred(values: Vec<f64>, nx: usize, sigma: f64) -> Vec<f64> {
    if sigma <= 0.0 || values.is_empty() {
        return values;
    }
    let kernel = kernel(sigma);
    let ny = values.len() / nx;
    let along_x = blurred_lines(&values, (nx, 1), (ny, nx), &kernel);
    blurred_lines(&along_x, (ny, nx), (nx, 1), &kernel)
}

/// Weights from the middle outwards. Below 0.8 pixels a sampled Gaussian is too narrow: there three weights match the
/// variance.
fn kernel(sigma: f64) -> Vec<f64> {
    if sigma < 0.8 {
        return vec![1.0 - sigma * sigma, 0.5 * sigma * sigma];
    }
    (0..=(4.0 * sigma).ceil() as usize).map(|k| (-0.5 * (k as f64 / sigma).powi(2)).exp()).collect()
}

/// Blurs along lines of `count` values `stride` apart; the starts of the lines are given in the same way.
fn blurred_lines(
    values: &[f64],
    (count, stride): (usize, usize),
    (lines, line_stride): (usize, usize),
    kernel: &[f64],
) -> Vec<f64> {
    let mut out = values.to_vec();
    for line in 0..lines {
        for k in 0..count {
            let at = |k: usize| line * line_stride + k * stride;
            if values[at(k)].is_nan() {
                continue;
            }
            let (mut sum, mut weights) = (0.0, 0.0);
            let reach = kernel.len() - 1;
            for near in k.saturating_sub(reach)..(k + reach + 1).min(count) {
                let (value, weight) = (values[at(near)], kernel[near.abs_diff(k)]);
                if !value.is_nan() {
                    (sum, weights) = (sum + weight * value, weights + weight);
                }
            }
            out[at(k)] = sum / weights;
        }
    }
    out
}
