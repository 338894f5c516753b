//! One scan of a ground surface as data: registered on the untouched area, cut into tiles, with the covariance of noise
//! and nuisance degrees of freedom.

use effects::CompiledModel;
use glam::DVec2;
use nalgebra::{DMatrix, DVector};
use sdf_bake::HeightMap;

use super::covariance::{Freedom, Whitener};
use super::evidence::{Agreement, EvidenceError};
use super::observation::{Observation, Untouched};
use super::pose_columns::{
    Frame, PLACE_FREEDOMS, POSE_FREEDOMS, cut_columns, place_columns, pose_column, pose_columns, slopes,
};
use super::simulation_errors::ScanErrors;
use super::tile_noise::TileNoise;
use super::tiles::{TileGrid, Tiles};
use super::totals::Total;
use crate::criteria::{
    PART_SHIFT_SIGMA, PASS_BEGIN_SIGMA, PASS_END_SIGMA, POSE_HEIGHT_SIGMA, POSE_SHIFT_SIGMA, POSE_TILT_SIGMA,
    RIM_NOISE_SHARE, SCAN_NOISE_DECAY_SIGMAS, SMOOTH_ERROR_REMOVAL,
};
use trial_simulation::SimulatedPass;
use trials::measure::despiked;

/// Prior standard deviations of a scan's pose: height, tilt along x and y over the map's half diagonal, shift along x
/// and y, turn over the half diagonal [m].
const POSE_SIGMAS: [f64; POSE_FREEDOMS] =
    [POSE_HEIGHT_SIGMA, POSE_TILT_SIGMA, POSE_TILT_SIGMA, POSE_SHIFT_SIGMA, POSE_SHIFT_SIGMA, POSE_SHIFT_SIGMA];
/// Ratio of the side of the untouched surface's tiles to the other tiles' side; the untouched surface is larger.
pub(super) const COARSE: usize = 2;
/// Number of pose degrees of freedom that the untouched surface determines: height and tilts.
const HELD: usize = 3;

/// A scan as data.
#[derive(Clone, Debug)]
pub struct HeightView {
    /// The scan without spikes.
    pub measured: HeightMap,
    /// Tiles that the tool may have touched.
    pub tiles: Tiles,
    /// Noise of a tile's mean.
    pub noise: TileNoise,
    slopes: Vec<DVec2>,
    cut: Vec<DVec2>,
    /// Contribution of the lattice error to the whitened tiles; zeros until it is known.
    lattice_field: Vec<f64>,
    /// All tiles that the tool may have touched, rims included; reported errors are over them.
    pub judged: Tiles,
    /// The same tiles before spikes were removed, and the removed depth of each [m].
    whole: (Tiles, Vec<f64>),
    /// Those of them that are rims.
    pub rims: Tiles,
    /// Degrees of freedom of the scan's pose and of the cut's place, for the tiles before rims were found.
    place: Freedom,
    /// Height change of each pixel where passes begin a row of their logs earlier or end one later [m]; empty until
    /// known.
    ends: [Vec<f64>; 2],
    whitener: Whitener,
    /// Removed depth of each tile up to this scan [m].
    pub(super) removed: Vec<f64>,
    /// Removed depth at which the noise of the scan before has fallen to 1/e [m].
    noise_depth: f64,
    /// Share of the previous scan's noise that remains in each tile.
    pub before_share: Vec<f64>,
}

impl HeightView {
    /// Converts a scan to data.
    ///
    /// - `measured`, `before`: scans without spikes
    /// - `free`: for each pixel, true if no tool came near it before this scan
    /// - `side`: side of a tile [pixels], with the noise of a tile and of one twice as wide
    ///
    /// Returns `None` if no tile was touched.
    pub fn new(
        measured: HeightMap,
        before: &HeightMap,
        free: &[bool],
        (side, [noise, coarse]): (usize, [TileNoise; 2]),
    ) -> Option<Self> {
        let pixels = measured.pixels;
        let change: Vec<f64> = measured.heights.iter().zip(&before.heights).map(|(a, b)| a - b).collect();
        let cut = slopes(&HeightMap { pixels, heights: change.clone() });
        let slopes = slopes(&measured);
        let known = |at: usize| change[at].is_finite() && slopes[at].is_finite();
        let alone = TileGrid { pixels, side: COARSE * side }.tiles(|at| known(at) && free[at]);
        let untouched = Whitener::new(
            coarse.covariance(&alone, &vec![1.0; alone.len()]),
            Freedom::around_zero(pose_columns(&alone, &slopes), &POSE_SIGMAS),
        )?;
        let pose = untouched.degrees_of_freedom(&alone.means(|at| change[at]));
        let tiles = TileGrid { pixels, side }.tiles(|at| known(at) && !free[at]);
        let columns = pose_columns(&tiles, &slopes);
        let planes = &columns * &pose.mean;
        let removed = tiles.means(|at| -change[at]).into_iter().zip(planes.iter());
        let removed: Vec<f64> = removed.map(|(removed, lift)| (removed + lift).max(0.0)).collect();
        let noise_depth = SCAN_NOISE_DECAY_SIGMAS * noise.sigma();
        let before_share = shares(&removed, noise_depth);
        let covariance = noise.covariance(&tiles, &before_share);
        let shift = cut_columns(&tiles, &cut);
        let shift = Freedom::around_zero(shift, &[PART_SHIFT_SIGMA; 2]);
        let place = Freedom { columns, ..pose }.and(shift);
        let whitener = Whitener::new(covariance, place.clone())?;
        (!tiles.is_empty()).then_some(Self {
            measured,
            lattice_field: vec![0.0; tiles.len()],
            judged: tiles.clone(),
            whole: (tiles.clone(), removed.clone()),
            removed,
            noise_depth,
            rims: tiles.of_which(&[]),
            place,
            ends: [Vec::new(), Vec::new()],
            tiles,
            noise,
            slopes,
            cut,
            whitener,
            before_share,
        })
    }

    /// Refines the data with a simulation near the best values. Pixels that stick out of the difference are spikes that
    /// a steep rim has hidden, and are left out. Tiles in which the lattice error scatters more than
    /// [`RIM_NOISE_SHARE`] of the noise are rims and no data, because the lattice does not resolve a rim within a
    /// pixel. In the other tiles this scatter is an error of the tile's mean. A rim along the tile has the same error
    /// in each of its pixels, so the error is that of one line of them.
    ///
    /// Returns `None` if the covariance is not positive definite.
    pub fn beside(self, errors: &ScanErrors) -> Option<Self> {
        let ScanErrors { simulated, lattice, ends, noise_depth } = *errors;
        let left =
            self.measured.heights.iter().zip(&simulated.heights).map(|(measured, simulated)| measured - simulated);
        let (_, spikes) = despiked(&HeightMap { heights: left.collect(), ..simulated.clone() });
        let (tiles, removed) = &self.whole;
        let tiles = tiles.without(&spikes);
        let (means, squares) = (tiles.means(|at| lattice[at]), tiles.means(|at| lattice[at] * lattice[at]));
        let scatter: Vec<f64> = (means.iter().zip(squares))
            .map(|(mean, square)| (square - mean * mean).max(0.0) / tiles.grid.side as f64)
            .collect();
        let most = (RIM_NOISE_SHARE * self.noise.sigma()).powi(2);
        let kept: Vec<usize> = (0..tiles.len()).filter(|&k| scatter[k] <= most).collect();
        let is_rim = |k: &usize| kept.binary_search(k).is_err();
        let rims = tiles.of_which(&(0..tiles.len()).filter(is_rim).collect::<Vec<_>>());
        let of = |values: &[f64]| -> Vec<f64> { kept.iter().map(|&k| values[k]).collect() };
        let (judged, tiles, removed) = (tiles.clone(), tiles.of_which(&kept), of(removed));
        let before_share = shares(&removed, noise_depth);
        let own = DMatrix::from_diagonal(&DVector::from_vec(of(&scatter)));
        let covariance = self.noise.covariance(&tiles, &before_share) + own;
        let columns = place_columns(&tiles, [&self.slopes, &self.cut]);
        let ends_means = ends.each_ref().map(|heights| tiles.means(|at| heights[at]));
        let ends_columns = DMatrix::from_vec(tiles.len(), 2, ends_means.concat());
        let of_ends = Freedom::around_zero(ends_columns, &[PASS_BEGIN_SIGMA, PASS_END_SIGMA]);
        let whitener = Whitener::new(covariance, Freedom { columns, ..self.place.clone() }.and(of_ends))?;
        let lattice_field = whitener.whitened_field(&of(&means));
        let ends = ends.clone();
        Some(Self { lattice_field, whitener, judged, tiles, removed, noise_depth, before_share, rims, ends, ..self })
    }

    /// Measured minus simulated height of each tile [m].
    pub fn difference(&self, simulated: &[f64]) -> Vec<f64> {
        self.tiles.means(|at| {
            let difference = self.measured.heights[at] - simulated[at];
            if difference.is_finite() { difference } else { 0.0 }
        })
    }

    /// Whitener of tiles of another scan of such a workpiece, with the same prior of the pose.
    ///
    /// - `scan`, `change`: heights of that scan, and its heights minus those of the scan before [m]
    ///
    /// Returns `None` if the covariance is not positive definite.
    pub fn whitener_of(
        &self,
        (scan, change): (&HeightMap, &HeightMap),
        tiles: &Tiles,
        noise: &TileNoise,
    ) -> Option<Whitener> {
        let columns = place_columns(tiles, [&slopes(scan), &slopes(change)]);
        let removed: Vec<f64> = tiles.means(|at| -change.heights[at]).into_iter().map(|depth| depth.max(0.0)).collect();
        let covariance = noise.covariance(tiles, &shares(&removed, self.noise_depth));
        Whitener::new(covariance, Freedom { columns, ..self.place.clone() })
    }

    /// Measured minus simulated height of each pixel after the best-fitting pose [m], NaN where it is not known.
    pub fn left(&self, simulated: &[f64]) -> Vec<f64> {
        self.left_at(simulated, &self.whitener.degrees_of_freedom(&self.difference(simulated)).mean)
    }

    /// As [`HeightView::left`], with height and tilt from the untouched surface, and with the simulated ends of passes:
    /// so a poor model does not bias them.
    pub fn left_held(&self, simulated: &[f64]) -> Vec<f64> {
        let mut pose = self.whitener.degrees_of_freedom(&self.difference(simulated)).mean;
        pose.rows_mut(0, HELD).copy_from(&self.whitener.expected().mean.rows(0, HELD));
        let ends = pose.len() - PLACE_FREEDOMS;
        pose.rows_mut(PLACE_FREEDOMS, ends).fill(0.0);
        self.left_at(simulated, &pose)
    }

    /// Measured heights without the height and tilt of the scan, which the untouched surface shows [m].
    pub fn levelled(&self) -> Vec<f64> {
        let mut pose = DVector::zeros(HELD);
        pose.copy_from(&self.whitener.expected().mean.rows(0, HELD));
        self.left_at(&vec![0.0; self.measured.heights.len()], &pose)
    }

    fn left_at(&self, simulated: &[f64], pose: &DVector<f64>) -> Vec<f64> {
        let frame = Frame::of(self.measured.pixels);
        let lift = |at: usize| {
            let cut = if self.cut[at].is_finite() { self.cut[at] } else { DVec2::ZERO };
            let column = pose_column(frame, self.measured.pixels, at, self.slopes[at]);
            let own = [-cut.x, -cut.y];
            let ends = self.ends.iter().filter(|heights| !heights.is_empty()).map(|heights| heights[at]);
            column.into_iter().chain(own).chain(ends).zip(pose.iter()).map(|(c, p)| c * p).sum::<f64>()
        };
        let left = |at: usize| self.measured.heights[at] - simulated[at] - lift(at);
        (0..self.measured.heights.len()).map(left).collect()
    }

    /// Standard deviation of a weighted sum of the tiles' differences from [`HeightView::left_held`]: from noise, from
    /// height and tilt as the untouched surface determines them, and from shifts as all data determine them.
    pub fn held_sigma(&self, weights: &[f64]) -> f64 {
        let expected = &self.whitener.expected().covariance;
        let mut covariance = self.whitener.degrees_of_freedom(&vec![0.0; self.tiles.len()]).covariance;
        for k in (0..HELD).chain(PLACE_FREEDOMS..covariance.ncols()) {
            covariance.row_mut(k).fill(0.0);
            covariance.column_mut(k).fill(0.0);
        }
        covariance.view_mut((0, 0), (HELD, HELD)).copy_from(&expected.view((0, 0), (HELD, HELD)));
        self.whitener.sigma_of_sum_given(weights, &covariance)
    }

    /// Simulated removed volume under all tiles, and the volume of the residual [m³].
    pub fn volumes(&self, before: &HeightMap, simulated: &[f64]) -> (f64, f64) {
        let left = self.left_held(simulated);
        let sum = |value: &dyn Fn(usize) -> f64| {
            let known = self.tiles.pixels().map(|(_, at)| value(at)).filter(|value| value.is_finite());
            known.sum::<f64>() * self.measured.pixels.pitch.powi(2)
        };
        (sum(&|at| before.heights[at] - simulated[at]), sum(&|at| left[at]))
    }

    /// Standard deviation of the volume under all tiles, from noise and the scan's pose [m³].
    pub fn volume_sigma(&self) -> f64 {
        let mut areas = vec![0.0; self.tiles.len()];
        let pixel = self.measured.pixels.pitch.powi(2);
        self.tiles.pixels().for_each(|(tile, _)| areas[tile] += pixel);
        self.held_sigma(&areas)
    }
}

impl Observation for HeightView {
    fn tiles(&self) -> &Tiles {
        &self.tiles
    }

    fn whitener(&self) -> &Whitener {
        &self.whitener
    }

    fn predicted(
        &self,
        (pass, _): (&SimulatedPass, &CompiledModel),
        instrument: &dyn Fn(&HeightMap) -> HeightMap,
    ) -> Result<Vec<f64>, EvidenceError> {
        Ok(instrument(pass.scan.heights().expect("a simulated scan is like the real one")).heights)
    }

    fn whitened(&self, predicted: &[f64]) -> Vec<f64> {
        self.whitener.whiten(&self.difference(predicted))
    }

    fn response(&self, _: &[f64], removal: &[f64]) -> Vec<f64> {
        self.whitener.whitened_field(&self.tiles.means(|at| removal[at]))
    }

    /// The difference of the predictions themselves: both have the same noise and pose. Pixels without one change nothing.
    fn difference_of(&self, from: &[f64], to: &[f64], factor: f64) -> Vec<f64> {
        let change = |(from, to): (&f64, &f64)| if (to - from).is_finite() { to - from } else { 0.0 };
        let removal: Vec<f64> = from.iter().zip(to).map(|pair| -(factor * change(pair))).collect();
        self.response(from, &removal)
    }

    /// Spikes that a steep rim has hidden until the simulation was subtracted are left out.
    fn agreement(&self, predicted: &[f64], before: Untouched) -> Agreement {
        let (left, _) = despiked(&HeightMap { pixels: self.measured.pixels, heights: self.left(predicted) });
        let left = left.heights;
        let before_share = shares(&self.whole.1, self.noise_depth);
        let (mut squares, mut floor, mut removed, mut count) = (0.0, 0.0, 0.0, 0.0);
        for (tile, at) in self.judged.pixels().filter(|(_, at)| left[*at].is_finite()) {
            squares += left[at] * left[at];
            floor += before.noise * before.noise * (1.0 + before_share[tile].powi(2));
            removed += before.heights.heights[at] - predicted[at];
            count += 1.0;
        }
        let (floor, scale) = ((floor / count).sqrt(), removed / count);
        let smooth_error = SMOOTH_ERROR_REMOVAL * scale;
        Agreement { about: String::new(), rms: (squares / count).sqrt(), floor, noise: floor, scale, smooth_error }
    }

    /// Removed volume under all tiles [m³].
    fn total(&self, predicted: &[f64], before: &HeightMap) -> Total {
        let area = self.measured.pixels.pitch.powi(2);
        let left = self.left_held(predicted);
        let (mut removed, mut missing) = (0.0, 0.0);
        for (_, at) in self.tiles.pixels().filter(|(_, at)| left[*at].is_finite() && before.heights[*at].is_finite()) {
            removed += area * (before.heights[at] - predicted[at]);
            missing += area * left[at];
        }
        Total { about: String::new(), measured: removed - missing, predicted: removed, sigma: self.volume_sigma() }
    }

    fn raw_rms(&self, predicted: &[f64]) -> Option<f64> {
        let raw = self.tiles.pixels().map(|(_, at)| self.measured.heights[at] - predicted[at]);
        let (sum, count) =
            raw.filter(|raw| raw.is_finite()).fold((0.0, 0.0), |(sum, count), raw| (sum + raw * raw, count + 1.0));
        Some((sum / f64::max(count, 1.0)).sqrt())
    }

    fn removed(&self, before: &HeightMap) -> Vec<f64> {
        let removed = self.tiles.means(|at| before.heights[at] - self.measured.heights[at]);
        removed.into_iter().map(|removed| if removed.is_finite() { removed.max(0.0) } else { 0.0 }).collect()
    }

    fn smooth_error(&self, removed: &[f64], _: f64) -> Vec<f64> {
        removed.iter().map(|removed| SMOOTH_ERROR_REMOVAL * removed).collect()
    }

    fn lattice_field(&self) -> Vec<f64> {
        self.lattice_field.clone()
    }

    fn as_heights(&self) -> Option<&HeightView> {
        Some(self)
    }
}

/// Share of the previous scan's noise that remains after removal of a depth [m].
fn shares(removed: &[f64], noise_depth: f64) -> Vec<f64> {
    removed.iter().map(|removed| (-removed / noise_depth).exp()).collect()
}
