//! Scans predicted on a coarser lattice, with what that errs by at one model taken off: space mapping (Bandler et al. 2004,
//! additive output mapping). Twice the voxel takes a third to an eighth of the time; near the model of the correction the
//! residuals and their derivatives are those of the fine lattice.

use std::sync::Arc;

use effects::{CompiledModel, Effect, Process, RowCounts};

use super::coordinates::Coordinate;
use super::evidence::{Agreement, Evidence, EvidenceError, Split};
use super::observation::Observation;
use super::pass_trend::PassTrend;
use super::scans::ScanEvidence;
use super::totals::{Total, Totals};
use crate::criteria::COARSE_VOXEL_RATIO;
use trial_simulation::CampaignSimulation;
use trial_simulation::SimulatedPass;

/// Scans as data for fits, predicted on a coarser lattice.
pub(super) struct CoarseScans<'e, 't> {
    fine: &'e ScanEvidence<'t>,
    simulation: Arc<CampaignSimulation<'t>>,
    /// Whitened calibration residuals on the fine lattice minus those on this one [1].
    correction: Vec<f64>,
}

/// A coarser lattice, and what it errs by at one model.
pub struct Coarser<'t> {
    simulation: Arc<CampaignSimulation<'t>>,
    correction: Vec<f64>,
}

impl<'t> ScanEvidence<'t> {
    /// The coarser lattice, whose residuals agree with those of this one at a model.
    ///
    /// # Errors
    /// When the model cannot be simulated on one of the lattices.
    pub fn coarser_at(&self, model: &CompiledModel) -> Result<Coarser<'t>, EvidenceError> {
        let mut scans = CoarseScans::new(self, self.coarser()?);
        scans.correct_at(model)?;
        Ok(Coarser { simulation: scans.simulation.clone(), correction: scans.correction })
    }

    /// These scans, predicted on a coarser lattice.
    pub fn on<'e>(&'e self, coarser: &Coarser<'t>) -> Box<dyn Totals + 'e>
    where
        't: 'e,
    {
        let correction = coarser.correction.clone();
        Box::new(CoarseScans { fine: self, simulation: coarser.simulation.clone(), correction })
    }

    /// The same trials on the coarser lattice.
    ///
    /// # Errors
    /// The first trial that cannot be simulated there.
    pub(super) fn coarser(&self) -> Result<Arc<CampaignSimulation<'t>>, EvidenceError> {
        let mut simulation = self.simulation.on_voxels(COARSE_VOXEL_RATIO)?;
        for trial in &mut simulation.trials {
            trial.change_settings(|settings| settings.most_steps = self.most_steps);
        }
        Ok(Arc::new(simulation))
    }
}

impl<'e, 't> CoarseScans<'e, 't> {
    /// The same scans, with nothing taken off.
    pub(super) fn new(fine: &'e ScanEvidence<'t>, simulation: Arc<CampaignSimulation<'t>>) -> Self {
        Self { fine, simulation, correction: Vec::new() }
    }

    /// Makes the residuals of both lattices agree at a model.
    ///
    /// # Errors
    /// When the model cannot be simulated on one of the lattices.
    pub(super) fn correct_at(&mut self, model: &CompiledModel) -> Result<(), EvidenceError> {
        let split = Split::Calibration;
        let fine = self.fine.residuals(model, split)?;
        self.correction.clear();
        let coarse = self.residuals(model, split)?;
        self.correction = fine.iter().zip(coarse).map(|(fine, coarse)| fine - coarse).collect();
        Ok(())
    }

    fn simulate(&self, model: &CompiledModel, split: Split) -> Result<Vec<Vec<SimulatedPass>>, EvidenceError> {
        Ok(self.simulation.run_first(model, &self.fine.needed(split))?)
    }
}

impl Evidence for CoarseScans<'_, '_> {
    fn process(&self) -> Process {
        self.fine.process()
    }

    fn rows(&self) -> RowCounts {
        self.fine.rows()
    }

    fn residuals(&self, model: &CompiledModel, split: Split) -> Result<Vec<f64>, EvidenceError> {
        let passes = self.simulate(model, split)?;
        let mut residuals = self.fine.seen_residuals((&passes, model), split)?;
        if split == Split::Calibration {
            residuals.iter_mut().zip(&self.correction).for_each(|(residual, missing)| *residual += missing);
        }
        Ok(residuals)
    }

    fn agreement(&self, model: &CompiledModel, split: Split) -> Result<Vec<Agreement>, EvidenceError> {
        self.fine.agreement(model, split)
    }

    fn coordinates(&self, model: &CompiledModel) -> Vec<Coordinate> {
        self.fine.coordinates(model)
    }

    fn size(&self, change: &[f64]) -> f64 {
        self.fine.size(change)
    }

    fn trend(&self, model: &CompiledModel) -> Result<Option<PassTrend>, EvidenceError> {
        self.fine.trend(model)
    }

    fn is_blind_to(&self, effect: &Effect) -> Option<String> {
        self.fine.is_blind_to(effect)
    }

    fn blocks(&self, split: Split) -> Vec<usize> {
        self.fine.blocks(split)
    }
}

impl Totals for CoarseScans<'_, '_> {
    fn totals(&self, model: &CompiledModel, split: Split) -> Result<Vec<Total>, EvidenceError> {
        self.fine.totals_of((&self.simulate(model, split)?, model), split, Observation::default())
    }

    fn unregistered(&self, model: &CompiledModel, split: Split) -> Result<Vec<f64>, EvidenceError> {
        self.fine.unregistered(model, split)
    }
}
