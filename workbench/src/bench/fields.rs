//! Simulated workpiece after each pass of a model.

use std::sync::Arc;

use effects::CompiledModel;
use sdf_bake::BrickGrid;
use trial_simulation::{CampaignError, CampaignSimulation, Simulation};

/// Simulated fields of one trial: before the first pass, then after each pass.
pub(crate) struct TrialFields {
    /// One field more than there are passes.
    pub(crate) after: Vec<Arc<BrickGrid>>,
}

/// Simulates all passes of a campaign and keeps the field after each; tool wear continues from trial to trial.
///
/// # Errors
/// The error of the first trial that fails.
pub(super) fn fields(
    simulation: &CampaignSimulation,
    model: &CompiledModel,
) -> Result<Vec<TrialFields>, CampaignError> {
    let mut tool = Simulation::fresh_states(model);
    let mut row = 0;
    let mut of_trial = |own: &Simulation| {
        let failed = |error| CampaignError { trial: own.trial.name.clone(), error };
        let mut state = own.start(model, tool.clone(), row);
        let mut after = vec![Arc::new(state.part.clone())];
        for _ in &own.trial.passes {
            own.run_pass(model, &mut state, &mut |_| {}).map_err(failed)?;
            after.push(Arc::new(state.part.clone()));
        }
        row += own.trial.passes.len();
        tool = state.tool;
        Ok(TrialFields { after })
    };
    simulation.trials().iter().map(&mut of_trial).collect()
}
