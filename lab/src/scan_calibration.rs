//! Calibration against scans, which then hold the simulation errors near the calibrated model.

use effects::{CompiledModel, Library, Model, Signal};

use super::calibrate::fit_roughly;
use super::calibration::{Calibration, Order};
use super::diagnose::with_values;
use super::error::LabError;
use super::evidence::{Evidence, EvidenceError, Split};
use super::frame::FrameFreedom;
use super::scans::ScanEvidence;
use super::simulation_errors::SimulationErrors;
use crate::criteria::{COARSE_VOXEL_RATIO, SIMULATION_LEAST_STEPS, SIMULATION_STEP_RATIO};

/// Message on masks to which no rate can be fitted.
const COATED_EVERYWHERE: &str = "no mask of a calibration pass shows the substrate: sand at least one of them through \
                                 the coating somewhere, or give a pass after it";

impl<'a> ScanEvidence<'a> {
    /// Measures the errors of the simulation near a model. From then on the lattice error is a degree of freedom of the
    /// data. In ground surfaces, spikes that rims have hidden are found and left out. For masks, the noise of the border is
    /// fitted to the residuals.
    ///
    /// # Errors
    /// If the model cannot be simulated on a finer lattice.
    pub fn measure_simulation_errors(&mut self, model: &CompiledModel) -> Result<(), EvidenceError> {
        self.frame = None;
        if self.process().signal() == Signal::Dose {
            self.measure_mask_errors(model)?;
            self.frame = FrameFreedom::of_moved(self, model)?;
            return Ok(());
        }
        let error = SimulationErrors::new(self, model)?;
        for view in &mut self.views {
            let Some(data) = view.data.as_heights() else { continue };
            let informed = data.clone().beside(&error.beside(view.trial, view.pass));
            let informed = informed.expect("a covariance grows with what is added to it");
            view.data = Box::new(informed);
        }
        self.simulation_errors = Some(error);
        self.frame = FrameFreedom::of_moved(self, model)?;
        Ok(())
    }

    /// Calibrates a model and the smaller models on the way to it: first roughly, then with the lattice error there.
    ///
    /// - `models`: the model, and its base law before any fit
    /// - `done`: called after each fit with its name
    ///
    /// # Errors
    /// As [`Calibration::new`], or if no mask of a calibration pass has an exposed pixel.
    pub fn calibrated(
        &mut self,
        (model, start): (&Model, &Model),
        library: &Library,
        (order, done): (Order, &dyn Fn(&str)),
    ) -> Result<Calibration, LabError> {
        if self.is_coated_everywhere() {
            return Err(EvidenceError::NoData(COATED_EVERYWHERE.to_owned()).into());
        }
        let compiled = CompiledModel::new(model, library, self.rows())?;
        self.limit_steps(&compiled)?;
        let rough = fit_roughly(self, &compiled)?;
        self.measure_simulation_errors(&rough.model)?;
        // A poor fit is no good start for the next one.
        let from = if rough.is_poor() { model.clone() } else { with_values(model, &rough) };
        let calibration = Calibration::new(self, (&from, start), library, (order, done))?;
        self.renewed(calibration)
    }

    /// True if there are masks of calibration passes, none with an exposed pixel.
    fn is_coated_everywhere(&self) -> bool {
        let masks: Vec<_> = self.of(Split::Calibration).filter_map(|view| view.data.as_exposure()).collect();
        !masks.is_empty() && masks.iter().all(|mask| mask.measured.exposed.iter().all(|seen| *seen != Some(true)))
    }

    /// Continues a calibration with the lattice error at its best values.
    ///
    /// # Errors
    /// If the model cannot be simulated.
    pub fn renewed(&mut self, calibration: Calibration) -> Result<Calibration, LabError> {
        if self.process().signal() != Signal::Dose {
            self.follow_frame(&calibration.last().fit)?;
        }
        self.measure_simulation_errors(&calibration.last().fit.model)?;
        calibration.renewed(self)
    }

    /// Simulates a model once, and from then on abandons simulations that take far more steps. Prepares the coarser
    /// lattice, too.
    ///
    /// # Errors
    /// If the model cannot be simulated.
    pub fn limit_steps(&mut self, model: &CompiledModel) -> Result<(), EvidenceError> {
        self.abandon_longer(model)?;
        self.prepare_lattices();
        Ok(())
    }

    /// The same for measurements that are simulated on one lattice.
    ///
    /// # Errors
    /// If the model cannot be simulated.
    pub(super) fn abandon_longer(&mut self, model: &CompiledModel) -> Result<(), EvidenceError> {
        let passes = self.simulate(model, Split::Calibration)?;
        let most = passes.iter().flatten().map(|pass| pass.record.steps).max().unwrap_or(0);
        self.most_steps = Some(SIMULATION_STEP_RATIO * most.max(SIMULATION_LEAST_STEPS));
        self.simulation.limit_steps(self.most_steps);
        Ok(())
    }

    /// Limits the steps of simulations, and prepares the same trials on the coarser lattice. Masks whose noise is known have
    /// none: it moves borders by more than that noise.
    pub(super) fn prepare_lattices(&mut self) {
        let is_precise = self.mask_errors.is_some();
        self.coarse = (!is_precise).then(|| self.simulation.on_voxels(COARSE_VOXEL_RATIO).ok()).flatten();
        self.simulation.limit_steps(self.most_steps);
        self.coarse.iter_mut().for_each(|coarse| coarse.limit_steps(self.most_steps));
    }
}
