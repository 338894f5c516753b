//! A fitted model with the evidence that it was fitted to: the starting point of sliders and searches.

use std::path::PathBuf;

use effects::{Library, Model};
use lab::{Calibration, Diagnosis, Fit, FitOptions, LabError, OnProgress, Order, Result, Split};
use serde_json::Value;
use study::{CalibrationAnswer, Data, StudyReport, summary};
use trial_simulation::Stop;

use super::live::Live;

/// Fit on the fine lattice after a slider moves: two steps with the Jacobian of the coarse fit, which is not computed
/// again.
const FINE: FitOptions = FitOptions { derivatives: 0, steps: 2 };
/// Seed of a search: the default of `robofin diagnose`.
const SEED: u64 = 1;

/// A fitted model and its evidence.
pub(super) struct Engine<'m> {
    /// Effects that the model may contain.
    pub(super) library: Library,
    /// Calibration whose last fit is the fit of the whole model.
    pub(super) calibration: Calibration,
    data: Data<'m>,
}

/// Results of a fit for display.
pub(super) struct FitView {
    /// Result as `robofin calibrate` writes it.
    pub(super) answer: CalibrationAnswer,
    /// Content of the report page of `robofin calibrate`.
    pub(super) report: StudyReport,
    /// Simulated fields and residual maps; `None` for a table.
    pub(super) live: Option<Live>,
}

impl<'m> Engine<'m> {
    /// Fits a model as `robofin calibrate` does.
    ///
    /// - `data`: measurements that no other fit has used
    ///
    /// # Errors
    /// If the model cannot be simulated, or the fit was stopped.
    pub(super) fn new(
        mut data: Data<'m>,
        (model, library): (&Model, Library),
        (stop, on_progress): (&Stop, &dyn Fn(&str)),
    ) -> Result<Self> {
        if let Data::Scans(_, evidence) = &mut data {
            evidence.simulation.stop = stop.clone();
        }
        let model = data.fitting(model.clone(), &library)?;
        let start = data.start(&model, &library)?;
        let calibration = data.calibrated((&model, &start), &library, (Order::Joint, on_progress))?;
        Ok(Self { library, calibration, data })
    }

    /// Returns the fit of the whole model.
    pub(super) fn fit(&self) -> &Fit {
        &self.calibration.last().fit
    }

    /// Returns the text of the fitted model.
    pub(super) fn text(&self) -> String {
        self.calibration.model.to_text(&self.library)
    }

    /// Computes the results of the fit for display.
    ///
    /// - `model`: path of the model file in the replay commands
    ///
    /// # Errors
    /// If the model cannot be simulated, or was stopped.
    pub(super) fn shown(&mut self, model: PathBuf) -> Result<FitView> {
        let (answer, report) = CalibrationAnswer::new(&mut self.data, &self.calibration, &self.library, model)?;
        let fitted = &self.calibration.last().fit.model;
        let live = self.data.scans().map(|(_, evidence)| Live::new(evidence, fitted, &report)).transpose()?;
        self.data.free_nuisances();
        Ok(FitView { answer, report, live })
    }

    /// Returns the fit with one parameter fixed at a value [SI]; the other parameters are predicted from the Jacobian.
    ///
    /// # Errors
    /// If the model cannot be simulated.
    pub(super) fn held(&self, place: usize, value: f64) -> Result<Fit> {
        Ok(self.calibration.last().fit.held_at(self.data.evidence(), place, value)?)
    }

    /// Refines a fit with a fixed parameter on the fine lattice; returns it with the root mean square residual of the
    /// calibration passes, in the unit of errors.
    ///
    /// # Errors
    /// If the model cannot be simulated.
    pub(super) fn refined(&self, held: &Fit) -> Result<(Fit, f64)> {
        let evidence = self.data.evidence();
        let mut fit = Fit::unfitted(evidence, &held.model, held.coordinates.clone())?;
        fit.jacobian.copy_from(&held.jacobian);
        let fit = fit.refined(evidence, FINE);
        let agreement = evidence.agreement(&fit.model, Split::Calibration)?;
        let squares: f64 = agreement.iter().map(|scan| scan.rms * scan.rms).sum();
        let rms = (squares / agreement.len().max(1) as f64).sqrt() * evidence.unit().per_one();
        Ok((fit, rms))
    }

    /// Searches for one effect that the model lacks; returns the diagnosis as JSON, as `robofin study` writes it.
    ///
    /// # Errors
    /// If the model cannot be simulated, or was stopped.
    pub(super) fn searched(&mut self, on_progress: OnProgress) -> Result<Value> {
        let (model, fit) = (&self.calibration.model, self.calibration.last().fit.clone());
        let diagnosis = Diagnosis::within(self.data.evidence(), (model, fit), &self.library, (SEED, on_progress), 1)?;
        let summary = summary(&mut self.data, &diagnosis, &self.library);
        self.data.free_nuisances();
        serde_json::to_value(summary?).map_err(LabError::from)
    }
}
