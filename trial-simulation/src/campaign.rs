//! Simulation of all trials of a campaign in order; the tool wears from one to the next unless it is replaced.

use std::ops::Range;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};

use effects::{CompiledModel, Reset, RowCounts};
use rayon::prelude::*;
use thiserror::Error;

use crate::recent::Recent;
use crate::simulation::{SimulatedPass, Simulation, SimulationError, Variation};
use trials::trial::Trial;

/// Error of a campaign that cannot be simulated.
#[derive(Debug, Error)]
#[error("{trial}: {error}")]
pub struct CampaignError {
    /// Name of the trial.
    pub trial: String,
    /// The cause, with a hint.
    pub error: SimulationError,
}

/// Flag that ends simulations before their next trial once it is true.
pub type Stop = Arc<AtomicBool>;

/// The trials of a campaign, prepared for repeated simulation.
pub struct CampaignSimulation<'a> {
    /// Trials in chronological order.
    trials: Vec<Simulation<'a>>,
    /// Flag that ends a simulation in progress.
    pub stop: Stop,
    recent: Recent,
}

impl<'a> CampaignSimulation<'a> {
    /// Builds the parts and paths of all trials.
    ///
    /// - `voxel`: of the fields [m]; `None` takes the pitch of each trial's scan
    ///
    /// # Errors
    /// The first trial whose scan gives no valid part or whose log gives no valid path.
    pub fn new(trials: &'a [Trial], voxel: Option<f64>, replay: bool) -> Result<Self, CampaignError> {
        let simulation = |trial: &'a Trial| {
            let voxel = voxel.unwrap_or(trial.scans.before.pixels.pitch);
            Simulation::new(trial, voxel, replay).map_err(|error| CampaignError { trial: trial.name.clone(), error })
        };
        Ok(Self::of(trials.par_iter().map(simulation).collect::<Result<_, _>>()?, Stop::default()))
    }

    /// A campaign of trials that are prepared already, in chronological order.
    pub fn of(trials: Vec<Simulation<'a>>, stop: Stop) -> Self {
        Self { trials, stop, recent: Recent::default() }
    }

    /// Trials in chronological order.
    pub fn trials(&self) -> &[Simulation<'a>] {
        &self.trials
    }

    /// Limits the steps of each pass; `None` removes the limit.
    pub fn limit_steps(&mut self, most: Option<usize>) {
        let trials = self.trials.iter_mut();
        trials.for_each(|trial| trial.change_settings(|settings| settings.most_steps = most));
        self.recent.forget_longer(most.unwrap_or(usize::MAX));
    }

    /// The same trials on other lattices.
    ///
    /// - `ratio`: new voxel size divided by the current one
    ///
    /// # Errors
    /// The first trial that cannot be simulated on such a lattice.
    pub fn on_voxels(&self, ratio: f64) -> Result<Self, CampaignError> {
        let simulation = |own: &Simulation<'a>| {
            own.again(ratio * own.part.voxel, &Variation::default())
                .map_err(|error| CampaignError { trial: own.trial.name.clone(), error })
        };
        Ok(Self::of(self.trials.par_iter().map(simulation).collect::<Result<_, _>>()?, self.stop.clone()))
    }

    /// The same trials with small variations of the measured inputs.
    ///
    /// - `variation`: maps a trial's index to its variation
    ///
    /// # Errors
    /// The first trial that cannot be simulated with its variation.
    pub fn varied<'v>(&self, variation: impl Fn(usize) -> Variation<'v> + Sync) -> Result<Self, CampaignError> {
        let simulation = |(number, own): (usize, &Simulation<'a>)| {
            own.again(own.part.voxel, &variation(number))
                .map_err(|error| CampaignError { trial: own.trial.name.clone(), error })
        };
        let trials = self.trials.par_iter().enumerate().map(simulation).collect::<Result<_, _>>()?;
        Ok(Self::of(trials, self.stop.clone()))
    }

    /// Row counts for a model with parameters per pass or per scan of the campaign.
    pub fn rows(&self) -> RowCounts {
        let passes = self.trials.iter().map(|simulation| simulation.trial.passes.len()).sum();
        RowCounts { passes, scans: passes }
    }

    /// Simulates all trials. Trials that share a tool, from one fresh tool to the next, run in order; such groups run
    /// in parallel, unless a state of the model outlasts the tool. Returns the passes of each trial.
    ///
    /// # Errors
    /// The first trial that fails.
    pub fn run(&self, model: &CompiledModel) -> Result<Vec<Vec<SimulatedPass>>, CampaignError> {
        let all: Vec<usize> = self.trials.iter().map(|simulation| simulation.trial.passes.len()).collect();
        self.run_first(model, &all)
    }

    /// As [`CampaignSimulation::run`], but only the first passes of each trial. The latest result is kept: the same
    /// model again is not simulated.
    ///
    /// - `passes`: number of passes of each trial
    ///
    /// # Errors
    /// The first trial that fails.
    pub fn run_first(&self, model: &CompiledModel, passes: &[usize]) -> Result<Vec<Vec<SimulatedPass>>, CampaignError> {
        let lasting = model
            .effects()
            .flat_map(|effect| &effect.states)
            .any(|state| state.reset == Reset::Never && !state.is_held());
        let begins = |&k: &usize| k == 0 || (self.trials[k].trial.fresh && !lasting);
        let starts: Vec<usize> = (0..self.trials.len()).filter(begins).collect();
        let ends = starts.iter().skip(1).copied().chain([self.trials.len()]);
        let groups: Vec<Range<usize>> = starts.iter().zip(ends).map(|(start, end)| *start..end).collect();
        let known = if self.stop.load(Ordering::Relaxed) { None } else { self.recent.find(model, passes, &groups) };
        if let Some(known) = known {
            return Ok(known);
        }
        let run = |group: &Range<usize>| self.run_group(model, passes, group.clone());
        let ran: Vec<_> = groups.par_iter().map(run).collect::<Result<_, _>>()?;
        let ran = ran.into_iter().flatten().collect();
        self.recent.keep(model, &ran);
        Ok(ran)
    }

    fn run_group(
        &self,
        model: &CompiledModel,
        passes: &[usize],
        group: Range<usize>,
    ) -> Result<Vec<Vec<SimulatedPass>>, CampaignError> {
        let mut tool = Simulation::fresh_states(model);
        let mut row = self.trials[..group.start].iter().map(|simulation| simulation.trial.passes.len()).sum();
        let run = |(simulation, passes): (&Simulation, &usize)| {
            if self.stop.load(Ordering::Relaxed) {
                let trial = simulation.trial.name.clone();
                return Err(CampaignError { trial, error: SimulationError::Stopped });
            }
            let ran = simulation.run_first(*passes, model, (&mut tool, row), &mut |_, _| {});
            row += simulation.trial.passes.len();
            ran.map(|(passes, _)| passes).map_err(|error| CampaignError { trial: simulation.trial.name.clone(), error })
        };
        self.trials[group.clone()].iter().zip(&passes[group]).map(run).collect()
    }
}
