//! The virtual laboratory: trials with synthetic measurements in which effects are hidden, and the answer.
//!
//! An [`Experiment`] holds the options; [`Experiment::make`] makes the trials:
//!
//! 1. `hidden` draws the base law from its prior and adds the effects of the [`Choice`], from the library or
//!    [`outside`] it.
//! 2. `surface` draws each workpiece, a formula; `truth` samples it on a lattice finer than the scan and not aligned to
//!    its pixels.
//! 3. `plan` and `motion` define the passes; `truth` runs them with half the usual steps, at the controller's own
//!    period.
//! 4. [`Instrument`] scans the part, [`Robot`] writes its log with errors.
//! 5. [`Answer`] holds the hidden model and true results, open or behind a [`Seal`]; [`write`](write::write) writes the
//!    campaign.
//!
//! The measurements never come from the model that is fitted to them: lattice, steps, path and surface differ. The same
//! seed gives the same bytes on any number of threads.

mod answer;
mod experiment_error;
mod fault;
mod frame;
mod front_end;
mod hidden;
mod instrument;
mod motion;
mod noise;
pub mod outside;
mod plan;
mod planned;
mod ripple;
mod robot;
mod seal;
mod surface;
mod trial_build;
pub mod write;

use std::collections::BTreeMap;

use effects::{CompiledModel, EffectError, Library, ModelError, Process, Reset, RowCounts, States};
use rayon::prelude::*;
use sim::TOOL_CELLS;
use thiserror::Error;

use plan::Setting;
use trial_build::TrialBuild;
use trials::trial::{ForceInput, Trial};

pub use self::robot::Robot;
pub use answer::{ANSWER_FORMAT, Answer, HiddenEffect, Quantity, TrueTrial};
pub use experiment_error::ExperimentError;
pub use front_end::FrontEnd;
pub use hidden::{Choice, Hidden, visible_value};
pub use instrument::Instrument;
pub use plan::{Plan, Size};
pub use seal::{Key, SEAL_FORMAT, Seal, SealError};

/// A virtual experiment.
#[derive(Clone, Debug)]
pub struct Experiment {
    /// The process: grinding or sanding.
    pub process: Process,
    /// Plan of the passes: settings that differ between them.
    pub plan: Plan,
    /// Number of trials.
    pub trials: usize,
    /// Size of workpieces and scans.
    pub size: Size,
    /// Choice of the hidden effects.
    pub choice: Choice,
    /// Errors of the scanner.
    pub instrument: Instrument,
    /// Errors of the robot.
    pub robot: Robot,
    /// Number of passes of the tool on another workpiece before each trial; the trial counts the tool as fresh.
    pub earlier_passes: usize,
    /// Number of repeated scans of each workpiece before its first pass.
    pub repeats: usize,
    /// Force that the controller holds, as the trials state it.
    pub force_input: ForceInput,
    /// Planned trials that follow those of the plan, each on its own workpiece, as a list of stages.
    pub then: Vec<Vec<Trial>>,
    /// Laws and effects that the laboratory knows.
    pub library: Library,
    /// Seed of all random numbers.
    pub seed: u64,
}

/// Result of an experiment.
#[derive(Clone, Debug, PartialEq)]
pub struct Made {
    /// The trials in the form in which they are read from their folders.
    pub trials: Vec<Trial>,
    /// The hidden model and the true results.
    pub answer: Answer,
}

/// Reason for which an experiment cannot be made.
#[derive(Debug, Error)]
pub enum MakeError {
    /// The effects do not fit the process or the library.
    #[error(transparent)]
    Model(#[from] ModelError),
    /// An effect of the robot cannot be added to the library.
    #[error(transparent)]
    Effect(#[from] EffectError),
    /// A trial failed.
    #[error(transparent)]
    Truth(#[from] ExperimentError),
}

impl Experiment {
    /// A varied, clean experiment of full size with nothing hidden, whose library also contains the effects outside the
    /// built-in one.
    ///
    /// # Errors
    /// If the given library has an effect of the same name.
    pub fn new(process: Process, library: &Library, seed: u64) -> Result<Self, EffectError> {
        Ok(Self {
            process,
            plan: Plan::default(),
            trials: Plan::default().usual_trials(),
            size: Size::default(),
            choice: Choice::These(Vec::new()),
            instrument: Instrument::clean(),
            robot: Robot::clean(),
            earlier_passes: 0,
            repeats: 1,
            force_input: ForceInput::Setpoint,
            then: Vec::new(),
            library: outside::with_outside(library)?,
            seed,
        })
    }

    /// Makes the trials.
    ///
    /// # Errors
    /// [`MakeError`] if effects do not exist or do not act, or a pass fails.
    pub fn make(&self) -> Result<Made, MakeError> {
        self.make_reporting(&|| {})
    }

    /// As [`Experiment::make`], and calls `done` after each pass.
    ///
    /// # Errors
    /// As [`Experiment::make`].
    pub fn make_reporting(&self, done: &(dyn Fn() + Sync)) -> Result<Made, MakeError> {
        let model = self.true_model()?;
        let settings = self.plan.settings(self.trials);
        let lasting = model.effects().flat_map(|effect| &effect.states).any(|state| state.reset == Reset::Never);
        let run = |trials: &[usize]| self.run(&model, &settings, trials, done);
        let all: Vec<usize> = (0..self.trials).collect();
        // With a state that is never reset the trials must run in order.
        let groups: Vec<&[usize]> = if lasting { vec![&all] } else { all.chunks(1).collect() };
        let ran: Vec<Vec<_>> = groups.into_par_iter().map(run).collect::<Result<_, _>>()?;
        let then = self.make_planned(&model, done)?;
        let (trials, truths): (Vec<Trial>, Vec<TrueTrial>) = ran.into_iter().flatten().chain(then).unzip();
        let truths: BTreeMap<_, _> = trials.iter().map(|trial| trial.name.clone()).zip(truths).collect();
        Ok(Made { trials, answer: Answer::of(&model, self.seed, truths) })
    }

    /// Number of passes of all trials.
    pub fn passes(&self) -> usize {
        let then = self.then.iter().flatten().map(|stage| stage.passes.len());
        self.plan.settings(self.trials).iter().map(Vec::len).chain(then).sum()
    }

    /// Names of the effects that act, in the order in which they act.
    ///
    /// # Errors
    /// If effects do not exist or do not act.
    pub fn hidden_effects(&self) -> Result<Vec<String>, MakeError> {
        let model = self.true_model()?;
        Ok(answer::hidden(&model).iter().map(|effect| effect.name.clone()).collect())
    }

    /// The true model.
    fn true_model(&self) -> Result<CompiledModel, MakeError> {
        let rows = RowCounts { passes: self.passes(), scans: self.passes() };
        hidden::true_model(
            (self.process, self.size, rows),
            &self.choice,
            &self.library,
            (self.seed, self.robot.force_ripple),
        )
    }

    fn run(
        &self,
        model: &CompiledModel,
        settings: &[Vec<Setting>],
        trials: &[usize],
        done: &(dyn Fn() + Sync),
    ) -> Result<Vec<(Trial, TrueTrial)>, ExperimentError> {
        let mut states = States::new(model, TOOL_CELLS);
        trials.iter().map(|&trial| self.run_one(model, (settings, trial), &mut states, done)).collect()
    }

    fn run_one(
        &self,
        model: &CompiledModel,
        (settings, trial): (&[Vec<Setting>], usize),
        states: &mut States,
        done: &(dyn Fn() + Sync),
    ) -> Result<(Trial, TrueTrial), ExperimentError> {
        let row = settings[..trial].iter().map(Vec::len).sum();
        TrialBuild::new(self, model, trial)?.run((&settings[trial], states, row), done)
    }
}
