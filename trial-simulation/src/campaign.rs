//! All trials of a campaign simulated in order, with a tool that wears from one to the next unless it is renewed.

use std::ops::Range;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};

use effects::{CompiledModel, Reset, RowCounts};
use rayon::prelude::*;
use thiserror::Error;

use crate::simulation::{SimulatedPass, Simulation, SimulationError, Variation};
use trials::trial::Trial;

/// Why a campaign cannot be simulated.
#[derive(Debug, Error)]
#[error("{trial}: {error}")]
pub struct CampaignError {
    /// Name of the trial.
    pub trial: String,
    /// The fault, with a hint.
    pub error: SimulationError,
}

/// Once it is true, simulations that hold it end before their next trial.
pub type Stop = Arc<AtomicBool>;

/// The trials of a campaign, ready to be simulated again and again.
pub struct CampaignSimulation<'a> {
    /// In the order in which they were made.
    pub trials: Vec<Simulation<'a>>,
    /// Ends what is under way.
    pub stop: Stop,
}

impl<'a> CampaignSimulation<'a> {
    /// Makes the parts and paths of all trials.
    ///
    /// - `voxel`: of the fields [m]; `None` takes the pitch of each trial's scan
    ///
    /// # Errors
    /// The first trial whose scan makes no part or whose log is no path.
    pub fn new(trials: &'a [Trial], voxel: Option<f64>, replay: bool) -> Result<Self, CampaignError> {
        let simulation = |trial: &'a Trial| {
            let voxel = voxel.unwrap_or(trial.scans.before.pixels.pitch);
            Simulation::new(trial, voxel, replay).map_err(|error| CampaignError { trial: trial.name.clone(), error })
        };
        Ok(Self { trials: trials.par_iter().map(simulation).collect::<Result<_, _>>()?, stop: Stop::default() })
    }

    /// The same trials on other lattices.
    ///
    /// - `ratio`: of their voxels to those of these
    ///
    /// # Errors
    /// The first trial that cannot be simulated on such a lattice.
    pub fn on_voxels(&self, ratio: f64) -> Result<Self, CampaignError> {
        let simulation = |own: &Simulation<'a>| {
            own.again(ratio * own.part.voxel, &Variation::default())
                .map_err(|error| CampaignError { trial: own.trial.name.clone(), error })
        };
        let trials = self.trials.par_iter().map(simulation).collect::<Result<_, _>>()?;
        Ok(Self { trials, stop: self.stop.clone() })
    }

    /// The same trials where what was measured is a little otherwise.
    ///
    /// - `variation`: of a trial, by its number
    ///
    /// # Errors
    /// The first trial that cannot be simulated so.
    pub fn varied<'v>(&self, variation: impl Fn(usize) -> Variation<'v> + Sync) -> Result<Self, CampaignError> {
        let simulation = |(number, own): (usize, &Simulation<'a>)| {
            own.again(own.part.voxel, &variation(number))
                .map_err(|error| CampaignError { trial: own.trial.name.clone(), error })
        };
        let trials = self.trials.par_iter().enumerate().map(simulation).collect::<Result<_, _>>()?;
        Ok(Self { trials, stop: self.stop.clone() })
    }

    /// Rows that a model needs which has a parameter for each pass or scan of the campaign.
    pub fn rows(&self) -> RowCounts {
        let passes = self.trials.iter().map(|simulation| simulation.trial.passes.len()).sum();
        RowCounts { passes, scans: passes }
    }

    /// Simulates all trials; those from one fresh tool to the next run in order, such groups beside each other, unless
    /// a state of the model outlasts the tool. Returns the passes of each trial.
    ///
    /// # Errors
    /// The first trial that fails.
    pub fn run(&self, model: &CompiledModel) -> Result<Vec<Vec<SimulatedPass>>, CampaignError> {
        let all: Vec<usize> = self.trials.iter().map(|simulation| simulation.trial.passes.len()).collect();
        self.run_first(model, &all)
    }

    /// As [`CampaignSimulation::run`], but only the first passes of each trial.
    ///
    /// - `passes`: how many of each trial
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
        let groups: Vec<(usize, usize)> = starts.iter().copied().zip(ends).collect();
        let run = |&(start, end): &(usize, usize)| self.run_group(model, passes, start..end);
        let groups: Vec<_> = groups.par_iter().map(run).collect::<Result<_, _>>()?;
        Ok(groups.into_iter().flatten().collect())
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
