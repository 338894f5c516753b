//! Simulation of one trial under many models at once.

use effects::CompiledModel;
use rayon::prelude::*;

use super::{RunState, SimulatedPass, Simulation, SimulationError, columns};

/// Result of a trial under one model.
#[derive(Debug, Default)]
pub struct ModelRun {
    /// The completed passes.
    pub passes: Vec<SimulatedPass>,
    /// The error that ended it before its last pass.
    pub stopped: Option<SimulationError>,
}

impl ModelRun {
    fn add(&mut self, pass: Result<SimulatedPass, SimulationError>) {
        match pass {
            Ok(pass) => self.passes.push(pass),
            Err(error) => self.stopped = Some(error),
        }
    }
}

impl Simulation<'_> {
    /// Simulates the trial under many models at once, each from the beginning with a fresh tool: on the device in one
    /// submission, otherwise on all threads. A run that fails returns its error and its earlier passes, and does not
    /// stop the others.
    pub fn run_models(&self, models: &[CompiledModel]) -> Vec<ModelRun> {
        match self.device {
            Some(device) => self.run_on(device, models),
            None => models.par_iter().map(|model| self.run_model(model)).collect(),
        }
    }

    /// The trial under one model on the CPU.
    fn run_model(&self, model: &CompiledModel) -> ModelRun {
        let mut run = ModelRun::default();
        let mut state = self.start(model, Self::fresh_states(model), 0);
        while run.stopped.is_none() && run.passes.len() < self.passes.len() {
            run.add(self.run_pass(model, &mut state, &mut |_| {}));
        }
        run
    }

    /// The trial under many models on a device, pass by pass.
    fn run_on(&self, device: &shaders::Device, models: &[CompiledModel]) -> Vec<ModelRun> {
        let mut states: Vec<RunState> =
            models.iter().map(|model| self.start(model, Self::fresh_states(model), 0)).collect();
        let mut runs: Vec<ModelRun> = models.iter().map(|_| ModelRun::default()).collect();
        for (run, model) in runs.iter_mut().zip(models) {
            run.stopped = columns::check(self.trial, model).err().map(SimulationError::from);
        }
        for number in 1..=self.passes.len() {
            for ((run, state), model) in runs.iter_mut().zip(&mut states).zip(models) {
                if run.stopped.is_none() {
                    run.stopped = self.rest(&self.next_pass(model, state), &mut state.tool).err();
                }
            }
            let alive: Vec<usize> = (0..models.len()).filter(|&n| runs[n].stopped.is_none()).collect();
            let outcomes = self.run_alive(device, number, &alive, (models, &states));
            let mut of_run: Vec<Option<_>> = models.iter().map(|_| None).collect();
            alive.into_iter().zip(outcomes).for_each(|(n, outcome)| of_run[n] = Some(outcome));
            let each = runs.par_iter_mut().zip(&mut states).zip(models).zip(of_run);
            each.for_each(|(((run, state), model), outcome)| {
                if let Some(outcome) = outcome {
                    run.add(self.after(model, (state, number), outcome));
                }
            });
        }
        runs
    }

    /// Runs one pass of the runs that have not failed.
    fn run_alive(
        &self,
        device: &shaders::Device,
        pass: usize,
        alive: &[usize],
        (models, states): (&[CompiledModel], &[RunState]),
    ) -> Vec<Result<sim::gpu::Outcome, sim::gpu::GpuError>> {
        let trial = |&n: &usize| {
            // Before the first pass all runs have the same part, which the device then stores once.
            let part = if pass == 1 { &*self.part } else { &states[n].part };
            sim::gpu::Trial { part, pass: self.next_pass(&models[n], &states[n]), tool: &states[n].tool }
        };
        let trials: Vec<sim::gpu::Trial> = alive.iter().map(trial).collect();
        sim::gpu::run_batch(device, &trials, sim::gpu::Settings::default(), &mut |_, _| {})
    }

    /// The pass of a run in a batch.
    fn after(
        &self,
        model: &CompiledModel,
        (state, pass): (&mut RunState, usize),
        outcome: Result<sim::gpu::Outcome, sim::gpu::GpuError>,
    ) -> Result<SimulatedPass, SimulationError> {
        let failed = |error: sim::gpu::GpuError| SimulationError::Pass { pass, error: error.into() };
        let sim::gpu::Outcome { part, tool, record } = outcome.map_err(failed)?;
        (state.part, state.tool) = (part, tool);
        self.count(state);
        self.scanned(model, state, record.map_err(failed)?)
    }
}
