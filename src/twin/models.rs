//! One trial under many models at once.

use rayon::prelude::*;
use sim::effect::CompiledModel;

use super::{SimulatedPass, TrialState, Twin, TwinError};

impl Twin<'_> {
    /// Simulates the trial under many models at once, each from the beginning with a fresh tool: on the device in one
    /// submission, else on all threads. A run that fails says why and does not stop the others.
    ///
    /// # Errors
    /// [`TwinError::Device`] where the device itself fails.
    pub fn run_models(
        &self,
        models: &[CompiledModel],
    ) -> Result<Vec<Result<Vec<SimulatedPass>, TwinError>>, TwinError> {
        let Some(device) = self.device else {
            let one = |model: &CompiledModel| Ok(self.run(model, &mut Self::fresh_states(model), 0, &mut |_, _| {})?.0);
            return Ok(models.par_iter().map(one).collect());
        };
        let mut states: Vec<TrialState> =
            models.iter().map(|model| self.start(model, Self::fresh_states(model), 0)).collect();
        let mut runs: Vec<Result<Vec<SimulatedPass>, TwinError>> = models.iter().map(|_| Ok(Vec::new())).collect();
        for number in 1..=self.passes.len() {
            for ((run, state), model) in runs.iter_mut().zip(&mut states).zip(models) {
                if run.is_ok()
                    && let Err(error) = self.rest(&self.next_pass(model, state), &mut state.tool)
                {
                    *run = Err(error);
                }
            }
            let alive: Vec<usize> = (0..models.len()).filter(|&n| runs[n].is_ok()).collect();
            let outcomes = self.run_alive(device, number, &alive, (models, &states))?;
            for (n, outcome) in alive.into_iter().zip(outcomes) {
                match self.after(&models[n], (&mut states[n], number), outcome) {
                    Ok(pass) => runs[n].iter_mut().for_each(|passes| passes.push(pass.clone())),
                    Err(error) => runs[n] = Err(error),
                }
            }
        }
        Ok(runs)
    }

    /// One pass of the runs that have not failed.
    fn run_alive(
        &self,
        device: &shaders::Device,
        pass: usize,
        alive: &[usize],
        (models, states): (&[CompiledModel], &[TrialState]),
    ) -> Result<Vec<Result<sim::gpu::Outcome, sim::gpu::GpuError>>, TwinError> {
        let trial = |&n: &usize| {
            // Before the first pass all are the same part, which the device then holds once.
            let part = if pass == 1 { &self.part } else { &states[n].part };
            sim::gpu::Trial { part, pass: self.next_pass(&models[n], &states[n]), tool: &states[n].tool }
        };
        let trials: Vec<sim::gpu::Trial> = alive.iter().map(trial).collect();
        let settings = sim::gpu::Settings::default();
        sim::gpu::run_batch(device, &trials, settings, &mut |_, _| {})
            .map_err(|error| TwinError::Device { pass, error })
    }

    /// The pass of a run in a batch.
    fn after(
        &self,
        model: &CompiledModel,
        (state, pass): (&mut TrialState, usize),
        outcome: Result<sim::gpu::Outcome, sim::gpu::GpuError>,
    ) -> Result<SimulatedPass, TwinError> {
        let failed = |error| TwinError::Device { pass, error };
        let sim::gpu::Outcome { part, tool, record } = outcome.map_err(failed)?;
        (state.part, state.tool) = (part, tool);
        self.count(state);
        self.seen(model, state, record.map_err(failed)?)
    }
}
