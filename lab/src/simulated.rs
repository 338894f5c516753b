//! Simulation of all passes of a campaign, with the covariates of each place of the surface.

use effects::CompiledModel;
use rayon::prelude::*;
use sdf_bake::HeightMap;

use crate::{EvidenceError, Nuisances, ScanEvidence, ScanView};
use trial_simulation::{CampaignError, CampaignSimulation, SimulatedPass, Simulation, Variation};

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
    /// Nuisance parameters of its predictions.
    pub nuisances: Nuisances,
    /// Predicted scans of each trial and pass; empty where there is no scan.
    predicted: Vec<Vec<Vec<f64>>>,
}

impl Simulated {
    /// Simulates all passes, calibration and evaluation, with each model.
    ///
    /// # Errors
    /// If a model cannot be simulated.
    pub fn all(evidence: &ScanEvidence, models: &[&CompiledModel]) -> Result<Vec<Self>, EvidenceError> {
        let trials: Result<Vec<Simulation>, CampaignError> =
            evidence.simulation.trials().par_iter().map(watched).collect();
        let simulation = CampaignSimulation::of(trials?, evidence.simulation.stop.clone());
        let run = |model: &&CompiledModel| {
            let passes = simulation.run(model)?;
            let nuisances = evidence.nuisances_of((&passes, model))?;
            let mut predicted: Vec<Vec<Vec<f64>>> =
                passes.iter().map(|passes| vec![Vec::new(); passes.len()]).collect();
            for view in &evidence.views {
                predicted[view.trial][view.pass] = evidence.predicted(view, (&passes, model), nuisances)?;
            }
            Ok(Self { model: (*model).clone(), passes, nuisances, predicted })
        };
        models.par_iter().map(run).collect()
    }

    /// The pass after which a scan was taken.
    pub fn pass(&self, view: &ScanView) -> &SimulatedPass {
        &self.passes[view.trial][view.pass]
    }

    /// The prediction of a scan, one value for each pixel.
    pub fn predicted(&self, view: &ScanView) -> &[f64] {
        &self.predicted[view.trial][view.pass]
    }

    /// The ground surface as the instrument sees it; `None` when sanding.
    pub fn heights(&self, view: &ScanView) -> Option<HeightMap> {
        let pixels = view.data.as_heights()?.measured.pixels;
        Some(HeightMap { pixels, heights: self.predicted(view).to_vec() })
    }

    /// True for each pixel of a mask that shows substrate.
    pub fn exposed(&self, view: &ScanView) -> Vec<bool> {
        self.predicted(view).iter().map(|margin| *margin >= 0.0).collect()
    }
}
