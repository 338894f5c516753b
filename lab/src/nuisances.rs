//! Nuisance parameters of predictions: a simulated surface is blurred like the instrument's, and corrected by the share
//! of the lattice error that the data contain, before it is compared with a scan. Every model determines them again.

use effects::{CompiledModel, Signal};
use rayon::prelude::*;
use sdf_bake::HeightMap;

use super::evidence::{Evidence, EvidenceError, Split};
use super::fit::robust_sum;
use super::frame::{FrameValues, QUANTITIES};
use super::scans::{ScanEvidence, ScanView};
use super::simulation_errors::{change_without_lattice_error, lattice_share, without_lattice_error};
use crate::criteria::{BLUR_WIDEST, CHANGED_HEIGHT};
use trial_simulation::{SimulatedPass, blurred};
use trials::measure::least_of;

/// Number of blurs tried at first, and the change at which the search ends [pixels].
const BLUR_STEPS: usize = 6;
const SETTLED_BLUR: f64 = 3e-4;

/// Largest share of the lattice error at rims: the whole error of a second-order simulation (Richardson 1911).
const RIM_SHARE_MOST: f64 = 4.0 / 3.0;

/// Nuisance parameters of predictions.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Nuisances {
    /// Standard deviation of the instrument's lateral blur [m].
    pub blur: f64,
    /// Share of the measured lattice error that the data contain away from rims [1].
    pub lattice_share: f64,
    /// The same at rims, which converge differently and are no data [1].
    pub rim_share: f64,
    /// Most probable frame and clock [prior standard deviations].
    pub frame: FrameValues,
}

/// ModelPasses passes of each trial, and the model that produced them.
pub type ModelPasses<'a> = (&'a [Vec<SimulatedPass>], &'a CompiledModel);

impl ScanEvidence<'_> {
    /// Returns a simulated surface as the instrument sees it.
    pub fn as_scanned(&self, view: &ScanView, simulated: &HeightMap, nuisances: Nuisances) -> HeightMap {
        let before = &self.simulation.trials()[view.trial].trial.scans.before;
        let mut seen = blurred(simulated, (before, CHANGED_HEIGHT), nuisances.blur);
        if let Some(frame) = &self.frame {
            frame.add_to(&mut seen.heights, (view.trial, view.pass), nuisances.frame);
        }
        let (Some(error), Some(data)) = (&self.simulation_errors, view.data.as_heights()) else { return seen };
        let (_, error) = error.of(view.trial, view.pass);
        let add = |height: &mut f64, share: f64, at: usize| *height += share * error[at];
        seen.heights.iter_mut().enumerate().for_each(|(at, height)| add(height, nuisances.lattice_share, at));
        let beyond = nuisances.rim_share - nuisances.lattice_share;
        data.rims.pixels().for_each(|(_, at)| add(&mut seen.heights[at], beyond, at));
        seen
    }

    /// Prediction of a scan: values that the instrument would report, one for each pixel.
    ///
    /// # Errors
    /// If a formula of the scanner gives no finite number.
    pub fn predicted(
        &self,
        view: &ScanView,
        (passes, model): ModelPasses,
        nuisances: Nuisances,
    ) -> Result<Vec<f64>, EvidenceError> {
        let pass = &passes[view.trial][view.pass];
        let predicted = view.data.predicted((pass, model), &|surface| self.as_scanned(view, surface, nuisances))?;
        Ok(self.with_missed_dose(view, predicted, nuisances.lattice_share))
    }

    /// The nuisance parameters with which a model agrees best with the calibration scans.
    ///
    /// # Errors
    /// If a formula of the scanner gives no finite number.
    pub fn nuisances_of(&self, (passes, model): ModelPasses) -> Result<Nuisances, EvidenceError> {
        if let Some(nuisances) = self.nuisances {
            return Ok(nuisances);
        }
        let blur = self.blur_of((passes, model))?;
        let left = self.whitened((passes, model), Split::Calibration, blur)?;
        let lattice_share = lattice_share(&left, &self.lattice_field_of(Split::Calibration));
        if self.process().signal() == Signal::Dose {
            return Ok(Nuisances { lattice_share, ..Nuisances::default() });
        }
        let alone = self.whitened_alone((passes, model), Split::Calibration, blur)?;
        let frame = self.frame.as_ref().map_or([0.0; QUANTITIES], |frame| frame.most_likely(&alone));
        let even = Nuisances { blur, lattice_share, rim_share: 0.0, frame };
        Ok(Nuisances { rim_share: self.rim_share(passes, even), ..even })
    }

    /// The share of the lattice error with which simulated rims agree best with those of the calibration scans.
    fn rim_share(&self, passes: &[Vec<SimulatedPass>], even: Nuisances) -> f64 {
        let (mut products, mut squares) = (0.0, 0.0);
        for view in self.of(Split::Calibration) {
            let (Some(error), Some(data)) = (&self.simulation_errors, view.data.as_heights()) else { continue };
            let Some(simulated) = passes[view.trial][view.pass].scan.heights() else { continue };
            let (left, (_, error)) =
                (data.left(&self.as_scanned(view, simulated, even).heights), error.of(view.trial, view.pass));
            for (left, error) in data.rims.means(|at| left[at]).into_iter().zip(data.rims.means(|at| error[at])) {
                products += if left.is_finite() { left * error } else { 0.0 };
                squares += error * error;
            }
        }
        if squares > 0.0 { (products / squares).clamp(0.0, RIM_SHARE_MOST) } else { even.lattice_share }
    }

    /// Fixes the nuisance parameters at those of a model.
    ///
    /// # Errors
    /// If the model cannot be simulated.
    pub fn fix_nuisances(&mut self, model: &CompiledModel) -> Result<(), EvidenceError> {
        self.nuisances = None;
        let passes = self.simulate(model, Split::Calibration)?;
        self.nuisances = Some(self.nuisances_of((&passes, model))?);
        Ok(())
    }

    /// Measured minus simulated tiles of a split, independent with variance one where the model is right.
    ///
    /// # Errors
    /// If a formula of the scanner gives no finite number.
    pub(super) fn scan_residuals(&self, simulated: ModelPasses, split: Split) -> Result<Vec<f64>, EvidenceError> {
        self.residuals_through(simulated, split, self.blur_of(simulated)?)
    }

    /// As [`Self::scan_residuals`], with a known blur [m].
    pub(super) fn residuals_through(
        &self,
        simulated: ModelPasses,
        split: Split,
        blur: f64,
    ) -> Result<Vec<f64>, EvidenceError> {
        let left = self.whitened(simulated, split, blur)?;
        Ok(without_lattice_error(&left, &self.lattice_field_of(split)))
    }

    /// Blur of the instrument [m] with which the simulated rims of the cut agree best with those of the calibration
    /// scans. A stiff contact and a sharp instrument leave similar rims.
    pub(super) fn blur_of(&self, simulated: ModelPasses) -> Result<f64, EvidenceError> {
        if let Some(nuisances) = self.nuisances {
            return Ok(nuisances.blur);
        }
        if self.process().signal() == Signal::Dose {
            return Ok(0.0);
        }
        let pitch = self.simulation.trials()[0].trial.scans.before.pixels.pitch;
        let field = self.lattice_field_of(Split::Calibration);
        let cost = |blur: f64| -> Result<f64, EvidenceError> {
            let left = self.whitened(simulated, Split::Calibration, blur)?;
            Ok(robust_sum(&without_lattice_error(&left, &field)))
        };
        least_of(cost, ([0.0, BLUR_WIDEST * pitch], BLUR_STEPS), SETTLED_BLUR * pitch)
    }

    /// Measured minus simulated tiles of a split, whitened, with a given blur [m], before the lattice error is removed.
    fn whitened(&self, simulated: ModelPasses, split: Split, blur: f64) -> Result<Vec<f64>, EvidenceError> {
        let mut whitened = self.whitened_alone(simulated, split, blur)?;
        self.whiten_frame(&mut whitened, split);
        Ok(whitened)
    }

    /// As [`Self::whitened`], scan by scan; frame and clock, which the scans share, are not yet removed.
    pub(super) fn whitened_alone(
        &self,
        simulated: ModelPasses,
        split: Split,
        blur: f64,
    ) -> Result<Vec<f64>, EvidenceError> {
        let views: Vec<&ScanView> = self.of(split).collect();
        let scan = |view: &&ScanView| self.whitened_scan(view, simulated, blur);
        Ok(views.par_iter().map(scan).collect::<Result<Vec<_>, _>>()?.concat())
    }

    fn whitened_scan(&self, view: &ScanView, simulated: ModelPasses, blur: f64) -> Result<Vec<f64>, EvidenceError> {
        let predicted = self.predicted(view, simulated, Nuisances { blur, ..Nuisances::default() })?;
        Ok(view.data.whitened(&predicted))
    }

    /// Contribution of the lattice error to the whitened tiles of a split.
    pub(super) fn lattice_field_of(&self, split: Split) -> Vec<f64> {
        let mut field: Vec<f64> = self.of(split).flat_map(|view| view.data.lattice_field()).collect();
        self.whiten_frame(&mut field, split);
        field
    }

    /// Whitens separately whitened scans for frame and clock. Held-out scans decide nothing, and stay as they are.
    fn whiten_frame(&self, whitened: &mut [f64], split: Split) {
        if let (Some(frame), Split::Calibration) = (&self.frame, split) {
            frame.whiten(whitened);
        }
    }

    /// Converts a change of the calibration tiles, each scan whitened separately, to a change of the residuals: without
    /// the part that frame, clock and lattice absorb.
    pub(super) fn change_seen(&self, change: &[f64], lattice_field: &[f64]) -> Vec<f64> {
        let mut change = change.to_vec();
        self.whiten_frame(&mut change, Split::Calibration);
        change_without_lattice_error(&change, lattice_field)
    }
}
