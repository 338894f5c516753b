//! One exposure mask as data: the share of each tile that shows substrate.

use glam::DVec2;
use nalgebra::{DMatrix, DVector};
use sdf_bake::PixelGrid;

use super::covariance::{Freedom, Whitener};
use super::tiles::{TileGrid, Tiles};
use crate::trial::ExposureMask;

/// How far tool and mask may disagree about where along x and y the part lies [m].
const SHIFT_SIGMA: f64 = 100e-6;
/// Pixels around one whose majority says what it should be, and the share of a normal law's spread in its mean size.
const NEIGHBOURS: i64 = 2;
const MEAN_TO_SIGMA: f64 = 1.2533;
/// Least scatter of the border: what a pixel's edge and the simulation's own grid do to it [pixels].
const LEAST_SCATTER: f64 = 0.3;
/// Pixels of a tile away from the border that may be wrong.
const STRAY: f64 = 0.7;

/// A mask as data.
#[derive(Clone, Debug)]
pub struct ExposureView {
    /// The mask.
    pub measured: ExposureMask,
    /// Tiles that the tool may have touched.
    pub tiles: Tiles,
    /// Standard deviation of the border's place [m].
    pub scatter: f64,
    shares: Vec<f64>,
    whitener: Whitener,
}

impl ExposureView {
    /// Makes data of a mask.
    ///
    /// - `free`: for each pixel, whether no tool came near it before this mask
    ///
    /// `None` where no tile was touched.
    pub fn new(measured: ExposureMask, free: &[bool], side: usize) -> Option<Self> {
        let pixels = measured.pixels;
        let tiles = TileGrid { pixels, side }.tiles(|at| measured.exposed[at].is_some() && !free[at]);
        let majority = majority(&measured);
        let border: Vec<bool> = (0..pixels.len()).map(|at| is_border(&majority, pixels, at)).collect();
        let odd = (0..pixels.len()).filter(|&at| measured.exposed[at].is_some_and(|seen| seen != (majority[at] > 0.5)));
        let length = border.iter().filter(|border| **border).count().max(1) as f64;
        let scatter = (MEAN_TO_SIGMA * odd.count() as f64 / length).max(LEAST_SCATTER);
        let shares = tiles.means(|at| f64::from(u8::from(measured.exposed[at] == Some(true))));
        let noise = DMatrix::from_diagonal(&variances(&tiles, &border, scatter));
        let slope = |at: usize| slope(&majority, pixels, at);
        let (x, y) = (tiles.means(|at| -slope(at).x), tiles.means(|at| -slope(at).y));
        let columns = DMatrix::from_columns(&[DVector::from_vec(x), DVector::from_vec(y)]);
        let whitener = Whitener::new(noise, Freedom::around_zero(columns, &[SHIFT_SIGMA; 2]))?;
        let scatter = scatter * pixels.pitch;
        (!tiles.is_empty()).then_some(Self { measured, tiles, scatter, shares, whitener })
    }

    /// Measured minus simulated share of each tile, whitened.
    ///
    /// - `margin`: simulated dose beyond the one from which substrate shows, one per pixel
    pub fn whitened(&self, margin: &[f64]) -> Vec<f64> {
        let pixels = self.measured.pixels;
        let simulated = self.tiles.means(|at| coverage(margin, pixels, at));
        let difference: Vec<f64> = self.shares.iter().zip(simulated).map(|(a, b)| a - b).collect();
        self.whitener.whiten(&difference)
    }

    /// The distance that a perfect model would leave [m]: the border's scatter, and half a pixel, for a mask says no more
    /// about where the border is.
    pub fn border_floor(&self) -> f64 {
        self.scatter.max(0.5 * self.measured.pixels.pitch)
    }

    /// Mean distance between the measured and the simulated border [m]: the area on which they disagree over the
    /// border's length.
    pub fn border_distance(&self, margin: &[f64]) -> f64 {
        let wrong = |&(_, at): &(usize, usize)| self.measured.exposed[at] != Some(margin[at] >= 0.0);
        let disagree = self.tiles.pixels().filter(wrong).count() as f64;
        disagree / self.border_length() * self.measured.pixels.pitch
    }

    /// Standard deviation of the area on which substrate shows [m²]: the border's pixels err independently.
    pub fn area_sigma(&self) -> f64 {
        self.border_floor() * self.measured.pixels.pitch * self.border_length().sqrt()
    }

    /// Length of the measured border [pixels]; at least one.
    fn border_length(&self) -> f64 {
        let (pixels, majority) = (self.measured.pixels, majority(&self.measured));
        (0..pixels.len()).filter(|&at| is_border(&majority, pixels, at)).count().max(1) as f64
    }
}

/// Part of a pixel that shows substrate, from the margin at its middle and the margin's slope.
fn coverage(margin: &[f64], pixels: PixelGrid, at: usize) -> f64 {
    let across = slope(margin, pixels, at).length() * pixels.pitch;
    if !margin[at].is_finite() {
        return 0.0;
    }
    if across > 0.0 { (0.5 + margin[at] / across).clamp(0.0, 1.0) } else { f64::from(u8::from(margin[at] >= 0.0)) }
}

/// Slope by central differences [1/m], one-sided at the map's edges, zero beside unknown pixels.
fn slope(values: &[f64], pixels: PixelGrid, at: usize) -> DVec2 {
    let (i, j) = (at % pixels.nx, at / pixels.nx);
    let along = |low: usize, high: usize, steps: usize| {
        let rise = values[high] - values[low];
        if rise.is_finite() && steps > 0 { rise / (steps as f64 * pixels.pitch) } else { 0.0 }
    };
    let ((i0, i1), (j0, j1)) = ((i.max(1) - 1, (i + 1).min(pixels.nx - 1)), (j.max(1) - 1, (j + 1).min(pixels.ny - 1)));
    let x = along(pixels.at(i0, j), pixels.at(i1, j), i1 - i0);
    DVec2::new(x, along(pixels.at(i, j0), pixels.at(i, j1), j1 - j0))
}

/// Share of exposed pixels around each pixel.
fn majority(mask: &ExposureMask) -> Vec<f64> {
    let (nx, ny) = (mask.pixels.nx as i64, mask.pixels.ny as i64);
    let around = |at: usize| {
        let (i, j) = (at as i64 % nx, at as i64 / nx);
        let columns = (i - NEIGHBOURS).max(0)..=(i + NEIGHBOURS).min(nx - 1);
        let rows = (j - NEIGHBOURS).max(0)..=(j + NEIGHBOURS).min(ny - 1);
        let known = rows.flat_map(|j| columns.clone().map(move |i| (j * nx + i) as usize));
        let (sum, count) = known
            .filter_map(|at| mask.exposed[at])
            .fold((0.0, 0.0), |(sum, count), seen| (sum + f64::from(u8::from(seen)), count + 1.0));
        if count > 0.0 { sum / count } else { 0.0 }
    };
    (0..mask.pixels.len()).map(around).collect()
}

/// Whether the border passes between a pixel and the next along x or y.
fn is_border(majority: &[f64], pixels: PixelGrid, at: usize) -> bool {
    let (i, j) = (at % pixels.nx, at / pixels.nx);
    let differs = |other: usize| (majority[at] > 0.5) != (majority[other] > 0.5);
    (i + 1 < pixels.nx && differs(at + 1)) || (j + 1 < pixels.ny && differs(at + pixels.nx))
}

/// Variance of each tile's share: the border's scatter along its way through the tile, and stray pixels.
fn variances(tiles: &Tiles, border: &[bool], scatter: f64) -> DVector<f64> {
    let pixels = (tiles.grid.side * tiles.grid.side) as f64;
    let shares = tiles.means(|at| f64::from(u8::from(border[at])));
    let variance = |share: f64| (scatter * scatter * share * pixels + STRAY * STRAY) / (pixels * pixels);
    DVector::from_iterator(tiles.len(), shares.into_iter().map(variance))
}
