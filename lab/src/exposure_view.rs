//! One exposure mask as data: the distance of each tile from the border of the exposed region.

use std::f64::consts::TAU;

use effects::CompiledModel;
use glam::DVec2;
use nalgebra::DMatrix;
use sdf_bake::HeightMap;

use super::border_noise::{BorderNoise, BorderResidual};
use super::covariance::{Freedom, Whitener};
use super::evidence::{Agreement, EvidenceError};
use super::observation::{Observation, Untouched};
use super::tiles::{TileGrid, Tiles};
use super::totals::Total;
use crate::criteria::{
    BORDER_FLOOR_LEAST, BORDER_MAJORITY_RADIUS, BORDER_SCATTER_LEAST, COATING_ERROR_RATIO, PART_SHIFT_SIGMA,
    SMOOTH_ERROR_BORDER, SMOOTH_ERROR_EXPOSURE,
};
use trial_simulation::SimulatedPass;
use trials::measure::{Border, BorderDistance, between, covered, majority, median, shares_around};
use trials::trial::ExposureMask;

/// Ratio of the standard deviation of a normal variable to its mean absolute value.
const MEAN_TO_SIGMA: f64 = 1.2533;

/// Distance on both sides of a pixel over which the slope of the dose is taken [pixels].
const WIDTH_REACH: usize = BORDER_MAJORITY_RADIUS;

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
    places: Vec<BorderDistance>,
    reach: f64,
    /// Noise of the border's position along it.
    pub noise: BorderNoise,
    /// Distance across the border nearest to each tile over which the simulated dose changes by one, relative to the
    /// median; one until it is known.
    widths: Vec<f64>,
    /// Contribution of the lattice error to the whitened tiles; zeros until it is known.
    lattice_field: Vec<f64>,
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
        let majority = majority(&measured, BORDER_MAJORITY_RADIUS);
        let field: Vec<f64> = majority.iter().map(|share| share - 0.5).collect();
        let border = Border::new(&field, pixels);
        let is_odd = |&at: &usize| measured.exposed[at].is_some_and(|seen| seen != (majority[at] > 0.5));
        let odd = (0..pixels.len()).filter(is_odd).count();
        let scatter = (MEAN_TO_SIGMA * odd as f64 / border.crossings().max(1) as f64).max(BORDER_SCATTER_LEAST);
        let places = border_distances(&tiles, &field, &border, reach);
        let scatter = scatter * pixels.pitch;
        let side = side as f64 * pixels.pitch;
        let noise = BorderNoise::expected(scatter, (side, pixels.pitch));
        let whitener = whitener(&places, (&noise, &vec![1.0; tiles.len()]), (side, reach))?;
        let (widths, lattice_field) = (vec![1.0; tiles.len()], vec![0.0; tiles.len()]);
        let own = Self { measured, tiles, scatter, odd, places, reach, noise, widths, lattice_field, whitener };
        (!own.tiles.is_empty()).then_some(own)
    }

    /// Refines the data with simulations near the best values.
    ///
    /// - `noise`: fitted noise of the border; `None` keeps the expected one
    /// - `margins`: simulated dose minus the exposure threshold, on the usual lattice and on a finer one
    ///
    /// Returns `None` if the covariance is not positive definite.
    pub(super) fn beside(self, noise: Option<BorderNoise>, margins: [&[f64]; 2]) -> Option<Self> {
        let noise = noise.unwrap_or(self.noise);
        let pitch = self.measured.pixels.pitch;
        let most = self.reach / noise.tile.sigma();
        let widths = self.widths(margins[1]);
        let ratios: Vec<f64> = widths.iter().map(|width| noise.ratio(*width, pitch).min(most)).collect();
        let whitener = whitener(&self.places, (&noise, &ratios), (self.tile_side(), self.reach))?;
        let [usual, finer] = margins.map(|margins| self.difference(margins));
        let moved: Vec<f64> = usual.iter().zip(finer).map(|(usual, finer)| usual - finer).collect();
        let usual = median(widths.clone()).filter(|usual| *usual > 0.0).unwrap_or(1.0);
        let widths = widths.into_iter().map(|width| width / usual).collect();
        Some(Self { widths, lattice_field: whitener.whitened_field(&moved), whitener, noise, ..self })
    }

    /// Side of a tile [m].
    pub(super) fn tile_side(&self) -> f64 {
        self.tiles.grid.side as f64 * self.measured.pixels.pitch
    }

    /// Residuals of the border at the tiles within reach.
    pub(super) fn border_residuals(&self, margin: &[f64]) -> Vec<BorderResidual> {
        let places = self.places.iter().zip(self.difference(margin)).zip(self.widths(margin));
        let residual = |((place, distance), width): ((&BorderDistance, f64), f64)| {
            Some(BorderResidual { place: place.nearest?, distance, width })
        };
        places.filter_map(residual).collect()
    }

    /// Distance [m] across the border nearest to each tile over which the simulated dose changes by one.
    fn widths(&self, margin: &[f64]) -> Vec<f64> {
        let pixels = self.measured.pixels;
        let field = self.simulated_field(margin);
        let places = border_distances(&self.tiles, &field, &Border::new(&field, pixels), self.reach);
        let width = |place: &BorderDistance| {
            let at = pixels.nearest(place.nearest?)?;
            let (i, j) = (at % pixels.nx, at / pixels.nx);
            let slope = |at: usize, count: usize, step: usize, from: usize| {
                let (low, high) = (at.saturating_sub(WIDTH_REACH), (at + WIDTH_REACH).min(count - 1));
                (margin[from + high * step] - margin[from + low * step]) / ((high - low) as f64 * pixels.pitch)
            };
            let slope = DVec2::new(slope(i, pixels.nx, 1, j * pixels.nx), slope(j, pixels.ny, pixels.nx, i));
            Some(slope.length().recip()).filter(|width| width.is_finite())
        };
        let widths: Vec<Option<f64>> = places.iter().map(width).collect();
        let usual = median(widths.iter().copied().flatten().collect()).unwrap_or(0.0);
        widths.into_iter().map(|width| width.unwrap_or(usual)).collect()
    }

    /// Measured minus simulated distance of each tile from the border [m]. Both borders are those of the share of exposed
    /// pixels around each pixel, which is rounder than the region's own.
    fn difference(&self, predicted: &[f64]) -> Vec<f64> {
        let field = self.simulated_field(predicted);
        let simulated = border_distances(&self.tiles, &field, &Border::new(&field, self.measured.pixels), self.reach);
        self.places.iter().zip(simulated).map(|(measured, place)| measured.distance - place.distance).collect()
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
        shares_around(&known, self.measured.pixels, BORDER_MAJORITY_RADIUS)
            .into_iter()
            .map(|share| share - 0.5)
            .collect()
    }

    /// Length of the measured border [pixels]; at least one.
    fn border_length(&self) -> f64 {
        let field: Vec<f64> =
            majority(&self.measured, BORDER_MAJORITY_RADIUS).iter().map(|share| share - 0.5).collect();
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

    fn whitened(&self, predicted: &[f64]) -> Vec<f64> {
        self.whitener.whiten(&self.difference(predicted))
    }

    fn lattice_field(&self) -> Vec<f64> {
        self.lattice_field.clone()
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
        self.places.iter().map(|place| if place.nearest.is_some() { self.reach } else { 0.0 }).collect()
    }

    /// A shift of the border, which an error of the dose moves the farther the less the dose changes across it.
    fn smooth_error(&self, removed: &[f64], error: f64) -> Vec<f64> {
        let error = SMOOTH_ERROR_BORDER * error;
        let here = |(reach, width): (&f64, &f64)| if *reach > 0.0 { (error * width).min(*reach) } else { 0.0 };
        removed.iter().zip(&self.widths).map(here).collect()
    }

    fn as_exposure(&self) -> Option<&ExposureView> {
        Some(self)
    }
}

/// Locates the centres of all tiles relative to the border of a field.
fn border_distances(tiles: &Tiles, field: &[f64], border: &Border, reach: f64) -> Vec<BorderDistance> {
    let is_above = |centre: DVec2| between(field, tiles.grid.pixels, centre) > 0.0;
    tiles.centres.iter().map(|&centre| border.distance_from(centre, is_above(centre), reach)).collect()
}

/// Whitener of tiles that measure a border: its noise, and the shift of the part.
///
/// - `side`: side of a tile [m]
/// - `noise`: noise of the border, and its ratio to that where the dose is exact, one per tile
fn whitener(
    places: &[BorderDistance],
    (noise, ratios): (&BorderNoise, &[f64]),
    (side, reach): (f64, f64),
) -> Option<Whitener> {
    // Tiles out of reach only show on which side of the border they lie: all tiles across a straight border count once,
    // and so do those along the length that shares its noise.
    let tile = &noise.tile;
    let alike = (2.0 * reach / side * (TAU.sqrt() * tile.length / side).max(1.0)).max(1.0);
    let between = |i: usize, j: usize| match (places[i].nearest, places[j].nearest) {
        (Some(one), Some(other)) => tile.between((one, other), i == j),
        _ if i == j => alike * tile.sigma().powi(2),
        _ => 0.0,
    };
    let covariance = DMatrix::from_fn(places.len(), places.len(), |i, j| ratios[i] * ratios[j] * between(i, j));
    let columns = DMatrix::from_fn(places.len(), 2, |k, axis| -places[k].away[axis]);
    Whitener::new(covariance, Freedom::around_zero(columns, &[PART_SHIFT_SIGMA; 2]))
}

#[cfg(test)]
mod tests {
    use sdf_bake::PixelGrid;

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

    /// Mean difference between the borders of a measured and a simulated disc [px], over tiles near the border of a few
    /// discs.
    fn mean_difference(measured: f64, simulated: impl Fn(&ExposureView, &[f64]) -> Vec<f64>) -> f64 {
        let differences = (0..20).flat_map(|number| {
            let margin = disc(measured, number);
            let view = view(&margin);
            let field = simulated(&view, &margin);
            let places = border_distances(&view.tiles, &field, &Border::new(&field, PIXELS), view.reach);
            let near = view.places.iter().zip(places).filter(|(measured, _)| measured.distance.abs() < 1.5e-3);
            near.map(|(measured, place)| (measured.distance - place.distance) / PIXELS.pitch).collect::<Vec<_>>()
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

    /// Margin of the half plane beside a slanted line, and its distances from places.
    fn slanted(shift: f64) -> (Vec<f64>, impl Fn(DVec2) -> f64) {
        let distance = move |place: DVec2| DVec2::new(0.28, 0.96).dot(place) - 11e-3 - shift;
        let places = (0..PIXELS.len()).map(|at| PIXELS.position(at % PIXELS.nx, at / PIXELS.nx));
        (places.map(distance).collect(), distance)
    }

    #[test]
    fn a_border_near_the_centre_of_a_tile_has_its_side() {
        // The border moves over the centres of tiles in steps of a twentieth of a pixel.
        for number in 0..40 {
            let (margin, distance) = slanted(0.05 * PIXELS.pitch * f64::from(number));
            let view = view(&margin);
            for (tile, place) in
                view.tiles.centres.iter().zip(&view.places).filter(|(_, place)| place.nearest.is_some())
            {
                let error = (place.distance - distance(*tile)) / PIXELS.pitch;
                assert!(error.abs() < 0.4, "{number}, {tile}: off by {error} pixels");
            }
        }
    }

    #[test]
    fn the_lattice_error_moves_a_border_as_the_finer_lattice_does() {
        let [(measured, _), (usual, _), (finer, _)] = [0.0, 0.3, 0.1].map(|shift| slanted(shift * PIXELS.pitch));
        let view = view(&measured).beside(None, [&usual, &finer]).unwrap();
        let (left, finer) = (view.whitened(&usual), view.whitened(&finer));
        assert!(view.lattice_field.iter().any(|field| field.abs() > 0.1));
        for ((left, field), finer) in left.iter().zip(&view.lattice_field).zip(finer) {
            assert!((left - field - finer).abs() < 1e-9, "{left} less {field} is not {finer}");
        }
    }

    #[test]
    fn a_gentle_slope_of_the_dose_makes_a_border_uncertain() {
        let (margin, _) = slanted(0.0);
        let noise = BorderNoise { dose: 0.02, ..BorderNoise::expected(0.1e-3, (2e-3, PIXELS.pitch)) };
        let sigma = |width: f64| {
            let margin: Vec<f64> = margin.iter().map(|distance| distance / width).collect();
            let view = view(&margin).beside(Some(noise), [&margin, &margin]).unwrap();
            let near = view.places.iter().position(|place| place.distance.abs() < 1e-3).unwrap();
            let mut weights = vec![0.0; view.tiles.len()];
            weights[near] = 1.0;
            view.whitener.sigma_of_sum_given(&weights, &DMatrix::zeros(2, 2))
        };
        let (steep, gentle) = (sigma(0.1e-3), sigma(10e-3));
        // Two hundredths of ten millimetres, beside the resolution of 0.065 mm.
        let expected = (0.2f64 / (0.5 / 60.0f64.sqrt())).hypot(1.0);
        assert!((gentle / steep / expected - 1.0).abs() < 0.02, "{steep} and {gentle}");
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
