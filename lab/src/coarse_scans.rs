//! Prediction of scans on a coarser lattice: twice the voxel takes a fifth of the time. [`super::space_mapping`]
//! corrects it to agree with the usual prediction.

use effects::CompiledModel;

use super::evidence::{EvidenceError, Split};
use super::nuisances::Nuisances;
use super::repredicted::Prediction;
use super::scans::ScanEvidence;
use super::totals::Total;
use crate::criteria::COARSE_VOXEL_RATIO;
use trial_simulation::{CampaignSimulation, SimulatedPass};

/// A prediction of scans on a coarser lattice.
pub(super) struct CoarseLattice<'e, 't> {
    pub(super) usual: &'e ScanEvidence<'t>,
    pub(super) simulation: &'e CampaignSimulation<'t>,
}

impl CoarseLattice<'_, '_> {
    fn simulate(&self, model: &CompiledModel, split: Split) -> Result<Vec<Vec<SimulatedPass>>, EvidenceError> {
        Ok(self.simulation.run_first(model, &self.usual.needed(split))?)
    }
}

impl Prediction for CoarseLattice<'_, '_> {
    fn residuals(&self, model: &CompiledModel, split: Split) -> Result<Vec<f64>, EvidenceError> {
        let predict = || self.usual.scan_residuals((&self.simulate(model, split)?, model), split);
        self.usual.remembered((model, split, COARSE_VOXEL_RATIO), predict)
    }

    fn totals(&self, model: &CompiledModel, split: Split) -> Result<Vec<Total>, EvidenceError> {
        self.usual.totals_of((&self.simulate(model, split)?, model), split, Nuisances::default())
    }
}
