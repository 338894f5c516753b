//! Scans predicted on a coarser lattice: twice the voxel takes a fifth of the time. [`super::space_mapping`] makes the
//! prediction agree with the usual one.

use effects::{CompiledModel, Effect, Library, Model, Process, RowCounts};
use nalgebra::DMatrix;

use super::coordinates::Coordinate;
use super::evidence::{Agreement, Evidence, EvidenceError, Split};
use super::fit::Fit;
use super::observation::Observation;
use super::pass_trend::PassTrend;
use super::scans::ScanEvidence;
use super::totals::{Total, Totals};
use super::unlisted::Basis;
use crate::criteria::COARSE_VOXEL_RATIO;
use trial_simulation::{CampaignSimulation, SimulatedPass};

/// Scans as data for fits, predicted on a coarser lattice.
pub(super) struct CoarseScans<'e, 't> {
    pub(super) usual: &'e ScanEvidence<'t>,
    pub(super) simulation: &'e CampaignSimulation<'t>,
}

impl CoarseScans<'_, '_> {
    fn simulate(&self, model: &CompiledModel, split: Split) -> Result<Vec<Vec<SimulatedPass>>, EvidenceError> {
        Ok(self.simulation.run_first(model, &self.usual.needed(split))?)
    }
}

impl Evidence for CoarseScans<'_, '_> {
    fn process(&self) -> Process {
        self.usual.process()
    }

    fn rows(&self) -> RowCounts {
        self.usual.rows()
    }

    fn residuals(&self, model: &CompiledModel, split: Split) -> Result<Vec<f64>, EvidenceError> {
        let predict = || self.usual.seen_residuals((&self.simulate(model, split)?, model), split);
        self.usual.remembered((model, split, COARSE_VOXEL_RATIO), predict)
    }

    fn agreement(&self, model: &CompiledModel, split: Split) -> Result<Vec<Agreement>, EvidenceError> {
        self.usual.agreement(model, split)
    }

    fn coordinates(&self, model: &CompiledModel) -> Vec<Coordinate> {
        self.usual.coordinates(model)
    }

    fn size(&self, change: &[f64]) -> f64 {
        self.usual.size(change)
    }

    fn trend(&self, model: &CompiledModel) -> Result<Option<PassTrend>, EvidenceError> {
        self.usual.trend(model)
    }

    fn is_blind_to(&self, effect: &Effect) -> Option<String> {
        self.usual.is_blind_to(effect)
    }

    fn blocks(&self, split: Split) -> Vec<usize> {
        self.usual.blocks(split)
    }

    fn folds(&self) -> Vec<usize> {
        self.usual.folds()
    }

    fn pass_folds(&self) -> Vec<usize> {
        self.usual.pass_folds()
    }

    fn closure(&self) -> DMatrix<f64> {
        self.usual.closure()
    }

    fn smooth_errors(&self, model: &CompiledModel) -> Result<DMatrix<f64>, EvidenceError> {
        self.usual.smooth_errors(model)
    }

    fn bases(&self, model: (&Model, &Fit), library: &Library) -> Result<Vec<Basis>, EvidenceError> {
        self.usual.bases(model, library)
    }

    fn lattice_field(&self) -> Vec<f64> {
        self.usual.lattice_field()
    }
}

impl Totals for CoarseScans<'_, '_> {
    fn totals(&self, model: &CompiledModel, split: Split) -> Result<Vec<Total>, EvidenceError> {
        self.usual.totals_of((&self.simulate(model, split)?, model), split, Observation::default())
    }

    fn unregistered(&self, model: &CompiledModel, split: Split) -> Result<Vec<f64>, EvidenceError> {
        self.usual.unregistered(model, split)
    }
}
