//! One measurement after a pass as data. Each kind of scan implements [`Observation`] in a file of its own: heights of a
//! ground surface (`height_view`), masks of exposed substrate (`exposure_view`).

use std::fmt::Debug;

use effects::CompiledModel;
use sdf_bake::HeightMap;

use super::covariance::Whitener;
use super::evidence::{Agreement, EvidenceError};
use super::exposure_view::ExposureView;
use super::height_view::HeightView;
use super::tiles::Tiles;
use super::totals::Total;
use crate::criteria::CURVE_MASK_STEP;
use trial_simulation::SimulatedPass;

/// Scan of a workpiece before its first pass.
#[derive(Clone, Copy)]
pub struct Untouched<'a> {
    /// Its heights.
    pub heights: &'a HeightMap,
    /// Root mean square noise of one scan [m].
    pub noise: f64,
}

/// One scan as data: what a simulation predicts for it, and how both are compared. Predictions have one value for each
/// pixel, in the quantity of the scan.
pub trait Observation: Debug + Send + Sync {
    /// The tiles that the tool may have touched.
    fn tiles(&self) -> &Tiles;

    /// Whitener of the tiles: noise and nuisance degrees of freedom.
    fn whitener(&self) -> &Whitener;

    /// Values that the instrument would report after a simulated pass, one for each pixel.
    ///
    /// - `instrument`: applies the instrument's own errors to a surface
    ///
    /// # Errors
    /// If a formula of the model gives no finite number.
    fn predicted(
        &self,
        simulated: (&SimulatedPass, &CompiledModel),
        instrument: &dyn Fn(&HeightMap) -> HeightMap,
    ) -> Result<Vec<f64>, EvidenceError>;

    /// Measured minus predicted values of the tiles, whitened.
    fn whitened(&self, predicted: &[f64]) -> Vec<f64>;

    /// Change of [`Observation::whitened`] per unit of a further removal of `removal` at each pixel.
    fn response(&self, predicted: &[f64], removal: &[f64]) -> Vec<f64> {
        let more: Vec<f64> = predicted.iter().zip(removal).map(|(own, more)| own + CURVE_MASK_STEP * more).collect();
        let usual = self.whitened(predicted);
        self.whitened(&more).iter().zip(&usual).map(|(more, usual)| (more - usual) / CURVE_MASK_STEP).collect()
    }

    /// Change of [`Observation::whitened`] from a prediction to another, times a factor.
    fn difference_of(&self, from: &[f64], to: &[f64], factor: f64) -> Vec<f64> {
        let (from, to) = (self.whitened(from), self.whitened(to));
        to.iter().zip(&from).map(|(to, from)| factor * (to - from)).collect()
    }

    /// Agreement with a prediction; its name is left empty.
    fn agreement(&self, predicted: &[f64], before: Untouched) -> Agreement;

    /// Total removal up to the scan; its name is left empty.
    fn total(&self, predicted: &[f64], before: &HeightMap) -> Total;

    /// Root mean square of measured minus predicted values without registration; `None` if there is nothing to register.
    fn raw_rms(&self, _predicted: &[f64]) -> Option<f64> {
        None
    }

    /// Size of the removal that each tile shows, to which smooth errors are proportional [m].
    fn removed(&self, before: &HeightMap) -> Vec<f64>;

    /// Standard deviation of the simulation's smooth error in each tile [m].
    ///
    /// - `removed`: as in [`Observation::removed`]
    /// - `error`: [`Agreement::smooth_error`] of the scan
    fn smooth_error(&self, removed: &[f64], error: f64) -> Vec<f64>;

    /// Contribution of the lattice error to the whitened tiles.
    fn lattice_field(&self) -> Vec<f64> {
        vec![0.0; self.tiles().len()]
    }

    /// The view itself, if it is of heights.
    fn as_heights(&self) -> Option<&HeightView> {
        None
    }

    /// The view itself, if it is of exposed substrate.
    fn as_exposure(&self) -> Option<&ExposureView> {
        None
    }
}
