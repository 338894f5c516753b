//! Simulation of all passes of a campaign, with the covariates of each place of the surface.

use effects::CompiledModel;
use rayon::prelude::*;
use sdf_bake::HeightMap;

use crate::{EvidenceError, Observation, ScanEvidence, ScanView};
use trial_simulation::{CampaignError, CampaignSimulation, SimulatedPass, Simulation, Variation};
use trials::trial::PassScan;

/// The same simulation, which also records the covariates of each place.
fn watched<'a>(simulation: &Simulation<'a>) -> Result<Simulation<'a>, CampaignError> {
    let own = simulation.again(simulation.part.voxel, &Variation::default());
    let mut own = own.map_err(|error| CampaignError { trial: simulation.trial.name.clone(), error })?;
    own.covariates = true;
    Ok(own)
}

/// All passes simulated with one model.
pub struct Simulated {
    /// The model.
    pub model: CompiledModel,
    /// Passes of each trial.
    pub passes: Vec<Vec<SimulatedPass>>,
    /// Observation of the simulated surfaces.
    pub observation: Observation,
}

impl Simulated {
    /// Simulates all passes, calibration and evaluation, with each model.
    ///
    /// # Errors
    /// If a model cannot be simulated.
    pub fn all(evidence: &ScanEvidence, models: &[&CompiledModel]) -> Result<Vec<Self>, EvidenceError> {
        let trials: Result<Vec<Simulation>, CampaignError> =
            evidence.simulation.trials.par_iter().map(watched).collect();
        let simulation = CampaignSimulation { trials: trials?, stop: evidence.simulation.stop.clone() };
        let run = |model: &&CompiledModel| {
            let passes = simulation.run(model)?;
            let observation = evidence.observation_of((&passes, model))?;
            Ok(Self { model: (*model).clone(), passes, observation })
        };
        models.par_iter().map(run).collect()
    }

    /// The pass after which a scan was taken.
    pub fn pass(&self, view: &ScanView) -> &SimulatedPass {
        &self.passes[view.trial][view.pass]
    }

    /// The ground surface as the instrument sees it; `None` when sanding.
    pub fn heights(&self, evidence: &ScanEvidence, view: &ScanView) -> Option<HeightMap> {
        match &self.pass(view).scan {
            PassScan::Heights(map) => Some(evidence.seen(view, map, self.observation)),
            PassScan::Exposure(_) => None,
        }
    }

    /// Dose minus exposure threshold at each pixel; empty when grinding.
    pub fn margin(&self, view: &ScanView) -> Vec<f64> {
        self.pass(view).surface.dose_margin(&self.model).ok().flatten().unwrap_or_default()
    }

    /// True for each pixel that shows substrate.
    pub fn exposed(&self, view: &ScanView) -> Vec<bool> {
        self.margin(view).iter().map(|margin| *margin >= 0.0).collect()
    }
}
