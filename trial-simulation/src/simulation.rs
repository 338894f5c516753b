//! Simulation of a trial: its part from the scan before, its passes along the logged paths, its scans as reported by
//! the same instrument.

mod columns;
mod logged;
mod models;
mod part;

pub use columns::lacking;
pub use logged::PassEnds;
pub use models::ModelRun;

use std::cell::RefCell;
use std::sync::Arc;

use effects::{CompiledModel, Reset, States};
use robot::Controller;
use sdf_bake::heights::HeightsError;
use sdf_bake::{BrickGrid, HeightMap};
use sim::{
    Covariates, ExecutionError, Executor, ForceProfile, Measured, PassRecord, PassSettings, Path, PathError, Progress,
    TOOL_CELLS,
};
use thiserror::Error;

use crate::scanner::{SeenSurface, exposed_share};
use logged::{LoggedPass, rest};
use part::part_before;
use trials::trial::{FrameOffset, Pass, PassScan, Trial, TrialError};

/// Coating thickness if the trial does not give it [m].
const COATING: f64 = 50e-6;

/// Maximum number of steps of all passes of a trial: hours of work, at less than a millisecond each.
const MOST_STEPS: f64 = 3e7;

/// Error of a trial that cannot be simulated.
#[derive(Debug, Error)]
pub enum SimulationError {
    /// The scan before gives no valid part.
    #[error("the scan before: {0}")]
    Part(#[from] HeightsError),
    /// A log gives no valid path.
    #[error("the log of pass {pass}: {error}")]
    Path {
        /// Number of the pass, from 1.
        pass: usize,
        /// The cause, with a hint.
        error: PathError,
    },
    /// More steps than can be simulated in an acceptable time.
    #[error(
        "the passes take about {steps:.1e} steps, and {MOST_STEPS:.0e} are accepted: a larger voxel, a longer period_s or shorter \
         logs have fewer"
    )]
    TooLong {
        /// Approximate number of steps.
        steps: f64,
    },
    /// A state of an effect that no column of the trial measures.
    #[error(transparent)]
    Column(#[from] Box<TrialError>),
    /// The simulation was stopped by the caller.
    #[error("was stopped")]
    Stopped,
    /// A pass failed.
    #[error("pass {pass}: {error}")]
    Pass {
        /// Number of the pass, from 1.
        pass: usize,
        /// The cause.
        error: ExecutionError,
    },
    /// A formula of the tool's states failed in a pause.
    #[error("the pause before pass {pass}: {error}")]
    Rest {
        /// Number of the pass, from 1.
        pass: usize,
        /// The formula and the cause.
        error: effects::RunError,
    },
    /// A formula of the scanner failed.
    #[error("the scan after pass {pass}: {error}")]
    Scan {
        /// Number of the pass, from 1.
        pass: usize,
        /// The formula and the cause.
        error: effects::RunError,
    },
}

/// Variation of a trial's measured inputs relative to its files.
#[derive(Clone, Debug, Default)]
pub struct Variation<'a> {
    /// Shifts of the beginning and end of its passes.
    pub ends: PassEnds,
    /// Heights to add to the scan before [m]; NaN adds nothing.
    pub before: Option<&'a HeightMap>,
    /// Offset of the logs from the frame of the scans.
    pub frame_offset: FrameOffset,
}

/// A trial prepared for repeated simulation.
pub struct Simulation<'a> {
    /// The trial.
    pub trial: &'a Trial,
    /// The part before the first pass; variations that do not change it share it.
    pub part: Arc<BrickGrid>,
    /// True if passes also record the covariates of the scanned surface.
    pub covariates: bool,
    /// True if the tool follows the logged heights.
    pub replay: bool,
    /// Offset of the logs from the frame of the scans that the simulated passes use.
    pub frame_offset: FrameOffset,
    /// Graphics processor on which the passes run; `None` for the CPU.
    pub device: Option<&'a shaders::Device>,
    /// Timer of the CPU's time by phase.
    pub clock: Option<&'a sim::Clock>,
    /// True if heights were added to the scan before.
    is_before_varied: bool,
    passes: Vec<Planned>,
}

/// A pass ready to be simulated.
struct Planned {
    path: Path,
    settings: PassSettings,
    /// Quantities that formulas may read.
    measured: Vec<Measured>,
    /// Logged force, if the controller follows it.
    force: Option<ForceProfile>,
    /// Time at which the logged tool touched the part [s].
    approach: f64,
    /// Time in the air since the end of the path before [s].
    rest: f64,
}

/// Result of a simulated pass.
#[derive(Clone, Debug)]
pub struct SimulatedPass {
    /// Log and totals.
    pub record: PassRecord,
    /// Surface of the part at the instrument's pixels after the pass; scans under other parameter values of the scanner
    /// are computed from it.
    pub surface: SeenSurface,
    /// The scan that the instrument reports.
    pub scan: PassScan,
    /// Share of the scanned area that is exposed; `None` for grinding.
    pub exposed_share: Option<f64>,
    /// Covariates of the surface in this pass, if [`Simulation::covariates`] is true.
    pub covariates: Option<Covariates>,
}

/// A workpiece and its tool between two passes.
#[derive(Clone, Debug)]
pub struct RunState {
    /// The workpiece.
    pub part: BrickGrid,
    /// States of the tool.
    pub tool: States,
    /// Number of completed passes.
    pub passes: usize,
    /// Time since the first pass began [s].
    pub trial_time: f64,
    /// Number of passes of the campaign before the first one here: the row of their per-pass parameters.
    pub first_row: usize,
}

impl<'a> Simulation<'a> {
    /// Builds the part and the paths of a trial.
    ///
    /// - `voxel`: of the part's field [m]; with the scan's pitch every pixel lies on a lattice line
    /// - `replay`: follow the logged heights instead of simulating the controller
    ///
    /// # Errors
    /// [`SimulationError`] if the scan gives no valid part, a log no valid path, or a pass cannot be run with this tool
    /// on this part.
    pub fn new(trial: &'a Trial, voxel: f64, replay: bool) -> Result<Self, SimulationError> {
        Self::varied(trial, voxel, replay, &Variation::default())
    }

    /// As [`Simulation::new`], with a variation of the measured inputs.
    ///
    /// # Errors
    /// As [`Simulation::new`].
    pub fn varied(trial: &'a Trial, voxel: f64, replay: bool, variation: &Variation) -> Result<Self, SimulationError> {
        // Checked before the part is built, which takes long for voxels much wider than the scan's pixels.
        PassSettings::check_voxel(voxel, &trial.tool.shape)
            .map_err(|error| SimulationError::Pass { pass: 1, error: error.into() })?;
        let part = Arc::new(part_before(trial, voxel, variation)?);
        let own = Self::on_part(trial, part, replay, variation)?;
        Ok(Self { is_before_varied: variation.before.is_some(), ..own })
    }

    /// A trial on a part that was built earlier.
    fn on_part(
        trial: &'a Trial,
        part: Arc<BrickGrid>,
        replay: bool,
        variation: &Variation,
    ) -> Result<Self, SimulationError> {
        let (tool, voxel) = (&trial.tool.shape, part.voxel);
        let held = variation.frame_offset.of_tool(&trial.tool);
        let mut passes: Vec<Planned> = Vec::new();
        for (i, pass) in trial.passes.iter().enumerate() {
            let controller = if replay { Controller::Replay } else { trial.controller };
            let log = variation.frame_offset.of_log(&pass.log);
            let logged = LoggedPass::new((&log, pass.force_setpoint), &held, variation.ends);
            let approach = logged.taken_over;
            let path = logged.path(tool, controller).map_err(|error| SimulationError::Path { pass: i + 1, error })?;
            let rest = passes.last().map_or(0.0, |before| rest(&trial.passes[i - 1], before.path.duration(), pass));
            let settings = settings(pass, trial, controller);
            settings.check(&part, tool).map_err(|error| SimulationError::Pass { pass: i + 1, error: error.into() })?;
            let (measured, force) = (columns::measured(trial, pass), logged::force(pass, trial));
            passes.push(Planned { path, settings, measured, force, approach, rest });
        }
        let steps: f64 = passes.iter().map(|planned| planned.settings.expected_steps(&planned.path, voxel)).sum();
        if steps > MOST_STEPS {
            return Err(SimulationError::TooLong { steps });
        }
        Ok(Self {
            trial,
            part,
            covariates: false,
            replay,
            frame_offset: variation.frame_offset,
            device: None,
            clock: None,
            is_before_varied: false,
            passes,
        })
    }

    /// The same trial on other voxels [m], or with another variation of its measured inputs.
    ///
    /// # Errors
    /// As [`Simulation::new`].
    pub fn again(&self, voxel: f64, variation: &Variation) -> Result<Self, SimulationError> {
        let frame_offset = self.frame_offset.and(&variation.frame_offset);
        let variation = Variation { frame_offset, ..variation.clone() };
        // The part does not depend on where the log lies.
        if voxel == self.part.voxel && variation.before.is_none() && !self.is_before_varied {
            return Self::on_part(self.trial, self.part.clone(), self.replay, &variation);
        }
        Self::varied(self.trial, voxel, self.replay, &variation)
    }

    /// Changes the settings of all passes.
    pub fn change_settings(&mut self, change: impl Fn(&mut PassSettings)) {
        self.passes.iter_mut().for_each(|planned| change(&mut planned.settings));
    }

    /// The tool's states at the start of a campaign.
    pub fn fresh_states(model: &CompiledModel) -> States {
        States::new(model, TOOL_CELLS)
    }

    /// Simulated time of all passes after the first `done` [s].
    pub fn duration(&self, done: usize) -> f64 {
        self.passes[done..].iter().map(|planned| planned.path.duration()).sum()
    }

    /// State of the trial before its first pass. The tool keeps its states from the previous trial unless this one
    /// begins with a fresh tool.
    ///
    /// - `first_row`: see [`RunState::first_row`]
    pub fn start(&self, model: &CompiledModel, mut tool: States, first_row: usize) -> RunState {
        if self.trial.fresh {
            tool.reset(model, Reset::FreshTool);
        }
        tool.reset(model, Reset::Trial);
        RunState { part: BrickGrid::clone(&self.part), tool, passes: 0, trial_time: 0.0, first_row }
    }

    /// Simulates all passes with a tool in the given `states`. Returns the passes and the part after them.
    ///
    /// # Errors
    /// [`SimulationError`] if a pass fails.
    pub fn run(
        &self,
        model: &CompiledModel,
        states: &mut States,
        first_row: usize,
        progress: &mut dyn FnMut(usize, Progress),
    ) -> Result<(Vec<SimulatedPass>, BrickGrid), SimulationError> {
        self.run_first(self.passes.len(), model, (states, first_row), progress)
    }

    /// As [`Simulation::run`], but only the first passes.
    ///
    /// # Errors
    /// [`SimulationError`] if a pass fails.
    pub fn run_first(
        &self,
        passes: usize,
        model: &CompiledModel,
        (states, first_row): (&mut States, usize),
        progress: &mut dyn FnMut(usize, Progress),
    ) -> Result<(Vec<SimulatedPass>, BrickGrid), SimulationError> {
        let mut state = self.start(model, states.clone(), first_row);
        let each = (0..passes).map(|pass| self.run_pass(model, &mut state, &mut |at| progress(pass, at)));
        let passes = each.collect::<Result<_, _>>();
        *states = state.tool;
        Ok((passes?, state.part))
    }

    /// Simulates the next pass of a trial.
    ///
    /// # Errors
    /// [`SimulationError`] if it fails; `state` then holds the last good state.
    ///
    /// # Panics
    /// If all passes are done.
    pub fn run_pass(
        &self,
        model: &CompiledModel,
        state: &mut RunState,
        progress: &mut dyn FnMut(Progress),
    ) -> Result<SimulatedPass, SimulationError> {
        let pixels = &self.trial.scans.before.pixels;
        let covariates = self.covariates.then(|| RefCell::new(Covariates::over(pixels, state.part.voxel)));
        let pass = sim::Pass { covariates: covariates.as_ref(), ..self.next_pass(model, state) };
        columns::check(self.trial, model)?;
        self.rest(&pass, &mut state.tool)?;
        let number = pass.number;
        let record = Executor::from(self.device).run_pass(&mut state.part, pass, &mut state.tool, progress);
        let record = record.map_err(|error| SimulationError::Pass { pass: number, error })?;
        self.count(state);
        let seen = self.scanned(model, state, record)?;
        Ok(SimulatedPass { covariates: covariates.map(RefCell::into_inner), ..seen })
    }

    /// The next pass from a state.
    fn next_pass<'p>(&'p self, model: &'p CompiledModel, state: &RunState) -> sim::Pass<'p> {
        let Planned { path, settings, measured, force, approach, rest } = &self.passes[state.passes];
        sim::Pass {
            number: state.passes + 1,
            row: state.first_row + state.passes,
            trial_time: state.trial_time + rest,
            approach: *approach,
            measured,
            force: force.as_ref(),
            clock: self.clock,
            ..sim::Pass::first(&self.trial.tool.shape, path, settings, model)
        }
    }

    /// Advances the tool's states over the pause before a pass.
    fn rest(&self, pass: &sim::Pass, tool: &mut States) -> Result<(), SimulationError> {
        let rest = self.passes[pass.number - 1].rest;
        sim::rest(pass, tool, rest).map_err(|error| SimulationError::Rest { pass: pass.number, error })
    }

    /// Counts a completed pass.
    fn count(&self, state: &mut RunState) {
        let Planned { path, rest, .. } = &self.passes[state.passes];
        state.trial_time += rest + path.duration();
        state.passes += 1;
    }

    /// Names the feature of the trial that the GPU does not support; `None` if it supports all.
    pub fn refusal(&self, model: &CompiledModel) -> Option<String> {
        if self.covariates {
            return Some("maps of what each place goes through".to_owned());
        }
        sim::gpu::refusal(&self.next_pass(model, &self.start(model, Self::fresh_states(model), 0)))
    }

    /// The last pass of a state, with its scan.
    ///
    /// # Errors
    /// [`SimulationError::Scan`] if a formula of the scanner fails.
    pub fn scanned(
        &self,
        model: &CompiledModel,
        state: &RunState,
        record: PassRecord,
    ) -> Result<SimulatedPass, SimulationError> {
        let like = &self.trial.passes[state.passes - 1].scan;
        let rows = (state.passes, state.first_row + state.passes - 1);
        let surface = SeenSurface::of(&state.part, (self.trial.scans.before.pixels, like), model, rows);
        let scan = surface.reported(model).map_err(|error| SimulationError::Scan { pass: state.passes, error })?;
        let exposed_share = scan.mask().map(exposed_share);
        Ok(SimulatedPass { record, surface, scan, exposed_share, covariates: None })
    }
}

fn settings(pass: &Pass, trial: &Trial, controller: Controller) -> PassSettings {
    PassSettings {
        controller,
        force_setpoint: pass.force_setpoint,
        spindle_speed: pass.spindle_speed,
        coating: trial.coating.unwrap_or(COATING),
        ..PassSettings::default()
    }
}
