//! One exposure mask as data: the distance of each tile from the border of the exposed region.

use std::collections::BTreeMap;

use effects::CompiledModel;
use glam::DVec2;
use nalgebra::{DMatrix, DVector};
use sdf_bake::{HeightMap, PixelGrid};

use super::border::{Border, BorderDistance};
use super::covariance::{Freedom, Whitener};
use super::evidence::{Agreement, EvidenceError};
use super::observation::{Observation, Untouched};
use super::tiles::{TileGrid, Tiles};
use super::totals::Total;
use crate::criteria::{
    BORDER_FLOOR_LEAST, BORDER_MAJORITY_RADIUS, BORDER_SCATTER_LEAST, BORDER_TILE_ERROR_LEAST, COATING_ERROR_RATIO,
    PART_SHIFT_SIGMA, SMOOTH_ERROR_EXPOSURE,
};
use trial_simulation::SimulatedPass;
use trials::measure::median;
use trials::trial::ExposureMask;

/// Ratio of the standard deviation of a normal variable to its mean absolute value.
const MEAN_TO_SIGMA: f64 = 1.2533;

/// An exposure mask as data.
#[derive(Clone, Debug)]
pub struct ExposureView {
    /// The mask.
    pub measured: ExposureMask,
    /// Tiles that the tool may have touched.
    pub tiles: Tiles,
    /// Standard deviation of the border's position at single pixels [m].
    pub scatter: f64,
    odd: usize,
    distances: Vec<f64>,
    reach: f64,
    whitener: Whitener,
}

impl ExposureView {
    /// Converts a mask to data.
    ///
    /// - `free`: for each pixel, true if no tool came near it before this mask
    /// - `reach`: distance from the border beyond which a tile only shows on which side it is [m]
    ///
    /// Returns `None` if no tile was touched.
    pub fn new(measured: ExposureMask, free: &[bool], side: usize, reach: f64) -> Option<Self> {
        let pixels = measured.pixels;
        let tiles = TileGrid { pixels, side }.tiles(|at| measured.exposed[at].is_some() && !free[at]);
        let majority = majority(&measured);
        let field: Vec<f64> = majority.iter().map(|share| share - 0.5).collect();
        let border = Border::new(&field, pixels);
        let is_odd = |&at: &usize| measured.exposed[at].is_some_and(|seen| seen != (majority[at] > 0.5));
        let odd = (0..pixels.len()).filter(is_odd).count();
        let scatter = (MEAN_TO_SIGMA * odd as f64 / border.crossings().max(1) as f64).max(BORDER_SCATTER_LEAST);
        let distances = border_distances(&tiles, &field, &border, reach);
        let error = (scatter / (side as f64).sqrt()).max(BORDER_TILE_ERROR_LEAST) * pixels.pitch;
        let sharing = sharing(&distances, side as f64 * pixels.pitch, reach);
        let variances = sharing.into_iter().map(|tiles| tiles * error * error);
        let noise = DMatrix::from_diagonal(&DVector::from_iterator(tiles.len(), variances));
        let columns = DMatrix::from_fn(tiles.len(), 2, |k, axis| -distances[k].away[axis]);
        let whitener = Whitener::new(noise, Freedom::around_zero(columns, &[PART_SHIFT_SIGMA; 2]))?;
        let distances = distances.iter().map(|place| place.distance).collect();
        let scatter = scatter * pixels.pitch;
        (!tiles.is_empty()).then_some(Self { measured, tiles, scatter, odd, distances, reach, whitener })
    }

    /// Least distance [m] that pixels of this pitch resolve: the scatter of the border, but at least half a pixel.
    pub fn border_floor(&self) -> f64 {
        self.scatter.max(BORDER_FLOOR_LEAST * self.measured.pixels.pitch)
    }

    /// [`Self::border_distance`] of a perfect model [m], from pixels near the border that differ from most of their
    /// neighbours.
    pub fn border_noise(&self) -> f64 {
        self.odd as f64 / self.border_length() * self.measured.pixels.pitch
    }

    /// Distance across the border over which the simulated dose changes by the exposure threshold [m]; median over the
    /// border.
    ///
    /// - `margin`: simulated dose minus the exposure threshold, one per pixel
    pub fn border_width(&self, margin: &[f64]) -> f64 {
        let pixels = self.measured.pixels;
        let inside = |i: usize, j: usize| i > 0 && j > 0 && i + 1 < pixels.nx && j + 1 < pixels.ny;
        let width = |at: usize| {
            let (i, j) = (at % pixels.nx, at / pixels.nx);
            let crosses = |to: usize| (margin[at] >= 0.0) != (margin[to] >= 0.0);
            if !inside(i, j) || !(crosses(at + 1) || crosses(at + pixels.nx)) {
                return None;
            }
            let slope = DVec2::new(margin[at + 1] - margin[at - 1], margin[at + pixels.nx] - margin[at - pixels.nx]);
            Some(2.0 * pixels.pitch / slope.length()).filter(|width| width.is_finite())
        };
        median((0..pixels.len()).filter_map(width).collect()).unwrap_or(0.0)
    }

    /// Mean distance between the measured and the simulated border [m]: the area of disagreement over the border's
    /// length.
    pub fn border_distance(&self, margin: &[f64]) -> f64 {
        let wrong = |&(_, at): &(usize, usize)| self.measured.exposed[at] != Some(margin[at] >= 0.0);
        let disagree = self.tiles.pixels().filter(wrong).count() as f64;
        disagree / self.border_length() * self.measured.pixels.pitch
    }

    /// Standard deviation of the exposed area [m²], with independent errors of the border's pixels.
    pub fn area_sigma(&self) -> f64 {
        self.border_floor() * self.measured.pixels.pitch * self.border_length().sqrt()
    }

    /// Simulated share of exposed pixels around each pixel, minus one half; from the pixels that are known in the mask.
    fn simulated_field(&self, margin: &[f64]) -> Vec<f64> {
        let covered = covered(margin, self.measured.pixels);
        let known: Vec<Option<f64>> = (self.measured.exposed.iter().zip(covered))
            .map(|(seen, share)| seen.and(Some(share).filter(|share| share.is_finite())))
            .collect();
        shares_around(&known, self.measured.pixels).into_iter().map(|share| share - 0.5).collect()
    }

    /// Length of the measured border [pixels]; at least one.
    fn border_length(&self) -> f64 {
        let field: Vec<f64> = majority(&self.measured).iter().map(|share| share - 0.5).collect();
        Border::new(&field, self.measured.pixels).crossings().max(1) as f64
    }
}

impl Observation for ExposureView {
    fn tiles(&self) -> &Tiles {
        &self.tiles
    }

    fn whitener(&self) -> &Whitener {
        &self.whitener
    }

    /// Dose minus the exposure threshold.
    fn predicted(
        &self,
        (pass, model): (&SimulatedPass, &CompiledModel),
        _: &dyn Fn(&HeightMap) -> HeightMap,
    ) -> Result<Vec<f64>, EvidenceError> {
        Ok(pass.surface.dose_margin(model)?.expect("a sanded surface has doses"))
    }

    /// Measured minus simulated distance of each tile from the border, whitened. Both borders are those of the share of
    /// exposed pixels around each pixel, which is rounder than the region's own.
    fn whitened(&self, predicted: &[f64]) -> Vec<f64> {
        let field = self.simulated_field(predicted);
        let simulated = border_distances(&self.tiles, &field, &Border::new(&field, self.measured.pixels), self.reach);
        let difference: Vec<f64> =
            self.distances.iter().zip(simulated).map(|(measured, place)| measured - place.distance).collect();
        self.whitener.whiten(&difference)
    }

    fn agreement(&self, predicted: &[f64], _: Untouched) -> Agreement {
        let (rms, floor) = (self.border_distance(predicted), self.border_floor());
        let scale = COATING_ERROR_RATIO * self.border_width(predicted);
        let smooth_error = SMOOTH_ERROR_EXPOSURE * scale;
        Agreement { about: String::new(), rms, floor, noise: self.border_noise(), scale, smooth_error }
    }

    /// Exposed area over all tiles [m²].
    fn total(&self, predicted: &[f64], _: &HeightMap) -> Total {
        let pixel = self.measured.pixels.pitch.powi(2);
        let area =
            |is_bare: &dyn Fn(usize) -> bool| pixel * self.tiles.pixels().filter(|&(_, at)| is_bare(at)).count() as f64;
        let measured = area(&|at| self.measured.exposed[at] == Some(true));
        let predicted = area(&|at| predicted[at] >= 0.0);
        Total { about: String::new(), measured, predicted, sigma: self.area_sigma() }
    }

    /// Range of border shifts that each tile resolves; 0 for tiles out of reach.
    fn removed(&self, _: &HeightMap) -> Vec<f64> {
        self.distances.iter().map(|distance| if distance.abs() < self.reach { self.reach } else { 0.0 }).collect()
    }

    /// A shift of the border.
    fn smooth_error(&self, removed: &[f64], error: f64) -> Vec<f64> {
        removed.iter().map(|reach| if *reach > 0.0 { error } else { 0.0 }).collect()
    }

    fn as_exposure(&self) -> Option<&ExposureView> {
        Some(self)
    }
}

/// Locates all tiles relative to the border of a field.
fn border_distances(tiles: &Tiles, field: &[f64], border: &Border, reach: f64) -> Vec<BorderDistance> {
    let above = tiles.means(|at| f64::from(u8::from(field[at] > 0.0)));
    tiles.centres.iter().zip(above).map(|(centre, above)| border.distance_from(*centre, above > 0.5, reach)).collect()
}

/// For each tile, the number of tiles that locate the same border segment, one tile side long; for tiles out of reach,
/// the number across a straight border.
fn sharing(places: &[BorderDistance], side: f64, reach: f64) -> Vec<f64> {
    let piece = |nearest: DVec2| ((nearest.x / side).floor() as i64, (nearest.y / side).floor() as i64);
    let mut tiles: BTreeMap<(i64, i64), f64> = BTreeMap::new();
    places
        .iter()
        .filter_map(|place| place.nearest)
        .for_each(|nearest| *tiles.entry(piece(nearest)).or_default() += 1.0);
    let count = |place: &BorderDistance| place.nearest.map_or(2.0 * reach / side, |nearest| tiles[&piece(nearest)]);
    places.iter().map(|place| count(place).max(1.0)).collect()
}

/// Share of exposed pixels around each pixel.
fn majority(mask: &ExposureMask) -> Vec<f64> {
    let seen: Vec<Option<f64>> = mask.exposed.iter().map(|seen| seen.map(|seen| f64::from(u8::from(seen)))).collect();
    shares_around(&seen, mask.pixels)
}

/// Mean of the known values around each pixel; 0 where there are none.
fn shares_around(values: &[Option<f64>], pixels: PixelGrid) -> Vec<f64> {
    let (nx, ny) = (pixels.nx as i64, pixels.ny as i64);
    let around = |at: usize| {
        let (i, j) = (at as i64 % nx, at as i64 / nx);
        let columns = (i - BORDER_MAJORITY_RADIUS).max(0)..=(i + BORDER_MAJORITY_RADIUS).min(nx - 1);
        let rows = (j - BORDER_MAJORITY_RADIUS).max(0)..=(j + BORDER_MAJORITY_RADIUS).min(ny - 1);
        let known = rows.flat_map(|j| columns.clone().map(move |i| (j * nx + i) as usize));
        let (sum, count) =
            known.filter_map(|at| values[at]).fold((0.0, 0.0), |(sum, count), value| (sum + value, count + 1.0));
        if count > 0.0 { sum / count } else { 0.0 }
    };
    (0..pixels.len()).map(around).collect()
}

/// Exposed share of each pixel, from the simulated dose minus the exposure threshold: linear between the places where
/// a straight border touches the pixel's first and last corner. NaN where the dose is unknown.
fn covered(margin: &[f64], pixels: PixelGrid) -> Vec<f64> {
    let slope = |at: usize, step: usize, is_inside: [bool; 2]| {
        let (low, high) = (at - step * usize::from(is_inside[0]), at + step * usize::from(is_inside[1]));
        step as f64 * (margin[high] - margin[low]) / (high - low).max(1) as f64
    };
    let share = |at: usize| {
        let (i, j) = (at % pixels.nx, at / pixels.nx);
        let along = slope(at, 1, [i > 0, i + 1 < pixels.nx]);
        let across = slope(at, pixels.nx, [j > 0, j + 1 < pixels.ny]);
        let reach = along.abs() + across.abs();
        let resolved = 0.5 + margin[at] / reach;
        if reach > 0.0 || margin[at].is_nan() {
            resolved.clamp(0.0, 1.0)
        } else {
            f64::from(u8::from(margin[at] >= 0.0))
        }
    };
    (0..pixels.len()).map(share).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    const PIXELS: PixelGrid = PixelGrid { origin: DVec2::ZERO, pitch: 0.5e-3, nx: 60, ny: 50 };

    /// Margin of a disc, positive inside; discs of different numbers lie differently on the pixels.
    fn disc(radius: f64, number: usize) -> Vec<f64> {
        let centre = DVec2::new(14.3e-3, 12.1e-3) + PIXELS.pitch * DVec2::new(0.618, 0.414) * number as f64;
        let places = (0..PIXELS.len()).map(|at| PIXELS.position(at % PIXELS.nx, at / PIXELS.nx));
        places.map(|place| radius - place.distance(centre)).collect()
    }

    fn view(margin: &[f64]) -> ExposureView {
        let exposed = margin.iter().map(|margin| Some(*margin >= 0.0)).collect();
        let mask = ExposureMask { pixels: PIXELS, exposed };
        ExposureView::new(mask, &vec![false; PIXELS.len()], 4, 3e-3).unwrap()
    }

    #[test]
    fn a_disc_covers_its_area() {
        let area = covered(&disc(6.2e-3, 0), PIXELS).iter().sum::<f64>() * PIXELS.pitch.powi(2);
        assert!((area / (std::f64::consts::PI * 6.2e-3f64.powi(2)) - 1.0).abs() < 2e-3, "{area}");
        assert!(covered(&[f64::NAN; 3000], PIXELS).iter().all(|share| share.is_nan()));
    }

    /// Mean difference between the borders of a measured and a simulated disc [px], over tiles near the border of a few
    /// discs.
    fn mean_difference(measured: f64, simulated: impl Fn(&ExposureView, &[f64]) -> Vec<f64>) -> f64 {
        let differences = (0..20).flat_map(|number| {
            let margin = disc(measured, number);
            let view = view(&margin);
            let field = simulated(&view, &margin);
            let places = border_distances(&view.tiles, &field, &Border::new(&field, PIXELS), view.reach);
            let near = view.distances.iter().zip(places).filter(|(distance, _)| distance.abs() < 1.5e-3);
            near.map(|(distance, place)| (distance - place.distance) / PIXELS.pitch).collect::<Vec<_>>()
        });
        let (sum, count) = differences.fold((0.0, 0.0), |(sum, count), difference| (sum + difference, count + 1.0));
        sum / count
    }

    #[test]
    fn a_right_model_has_the_border_of_a_small_region() {
        // The majority's border lies inside that of a small disc. Both borders are rounded alike.
        for radius in [3.1e-3, 4.4e-3] {
            let unlike = mean_difference(radius, |_, margin| margin.to_vec());
            let alike = mean_difference(radius, ExposureView::simulated_field);
            println!("{radius}: {unlike} {alike}");
            assert!(alike.abs() < 0.04 && unlike < -0.1, "{radius}: {alike} and {unlike}");
        }
    }

    #[test]
    fn a_larger_region_moves_the_border_by_its_own_distance() {
        let grown = |view: &ExposureView, margin: &[f64]| {
            let grown: Vec<f64> = margin.iter().map(|margin| margin + 0.3 * PIXELS.pitch).collect();
            view.simulated_field(&grown)
        };
        let moved = mean_difference(6.2e-3, grown);
        assert!((moved + 0.3).abs() < 0.03, "{moved}");
    }
}
