//! A trial simulated: its part made from the scan before, its passes along the logged paths, its scans as the same
//! instrument would see them.

mod columns;
mod logged;
mod models;

pub use columns::lacking;
pub use logged::PassEnds;
pub use models::ModelRun;

use std::cell::RefCell;

use effects::{CompiledModel, Reset, States};
use robot::Controller;
use sdf_bake::heights::{HeightsError, SlabOptions};
use sdf_bake::{BrickGrid, HeightMap};
use sim::{
    Covariates, ForceCourse, Measured, PassError, PassRecord, PassSettings, Path, PathError, Progress, TOOL_CELLS,
    run_pass,
};
use thiserror::Error;

use crate::scanner::{SeenSurface, exposed_share};
use logged::{LoggedPass, rest};
use trials::trial::{FrameOffset, Pass, PassScan, Trial, TrialError};

/// Coating that is assumed where a trial does not say [m].
const COATING: f64 = 50e-6;

/// Steps of all passes of a trial that are accepted: hours of work, at less than a millisecond each.
const MOST_STEPS: f64 = 3e7;

/// Why a trial cannot be simulated.
#[derive(Debug, Error)]
pub enum SimulationError {
    /// The scan before does not make a part.
    #[error("the scan before: {0}")]
    Part(#[from] HeightsError),
    /// A log is no path.
    #[error("the log of pass {pass}: {error}")]
    Path {
        /// From 1.
        pass: usize,
        /// The fault, with a hint.
        error: PathError,
    },
    /// More steps than end in a time that anyone waits.
    #[error(
        "the passes take about {steps:.1e} steps, and {MOST_STEPS:.0e} are accepted: a larger voxel, a longer period_s or shorter \
         logs have fewer"
    )]
    TooLong {
        /// Steps, about.
        steps: f64,
    },
    /// A state of an effect that no column of the trial measures.
    #[error(transparent)]
    Column(#[from] Box<TrialError>),
    /// Somebody wanted no more of it.
    #[error("was stopped")]
    Stopped,
    /// A pass failed.
    #[error("pass {pass}: {error}")]
    Pass {
        /// From 1.
        pass: usize,
        /// Why.
        error: PassError,
    },
    /// A pass failed on the graphics processor.
    #[error("pass {pass}: {error}")]
    Device {
        /// From 1.
        pass: usize,
        /// Why.
        error: sim::gpu::GpuError,
    },
    /// A formula of the tool's states in a pause.
    #[error("the pause before pass {pass}: {error}")]
    Rest {
        /// From 1.
        pass: usize,
        /// Which formula.
        error: effects::RunError,
    },
    /// A formula of the scanner.
    #[error("the scan after pass {pass}: {error}")]
    Scan {
        /// From 1.
        pass: usize,
        /// Which formula.
        error: effects::RunError,
    },
}

/// By how much what was measured of a trial is otherwise than its files say.
#[derive(Clone, Debug, Default)]
pub struct Variation<'a> {
    /// Begin and end of its passes.
    pub ends: PassEnds,
    /// Heights to add to the scan before [m]; NaN adds nothing.
    pub before: Option<&'a HeightMap>,
    /// Place of the logs in the frame of the scans.
    pub frame_offset: FrameOffset,
}

/// A trial ready to be simulated again and again.
pub struct Simulation<'a> {
    /// The trial.
    pub trial: &'a Trial,
    /// The part before the first pass.
    pub part: BrickGrid,
    /// Whether passes also tell what each place of the scanned surface went through.
    pub covariates: bool,
    /// Whether the tool keeps to the logged heights.
    pub replay: bool,
    /// Place of the logs in the frame of the scans, as the passes are simulated.
    pub frame_offset: FrameOffset,
    /// Where the passes run: a graphics processor, or the CPU.
    pub device: Option<&'a shaders::Device>,
    /// Where the CPU's time is summed up by phase.
    pub clock: Option<&'a sim::Clock>,
    passes: Vec<Planned>,
}

/// A pass ready to be run.
struct Planned {
    path: Path,
    settings: PassSettings,
    /// Quantities that formulas may read.
    measured: Vec<Measured>,
    /// Logged force, where it leads the controller.
    force: Option<ForceCourse>,
    /// Time at which the logged tool touched the part [s].
    approach: f64,
    /// Time in the air since the end of the path before [s].
    rest: f64,
}

/// What a simulated pass leaves.
#[derive(Clone, Debug)]
pub struct SimulatedPass {
    /// Log and figures.
    pub record: PassRecord,
    /// What the instrument's pixels show of the part afterwards: its scan under other parameter values of the scanner
    /// comes from here.
    pub surface: SeenSurface,
    /// What the instrument reports of it.
    pub scan: PassScan,
    /// Share of the scanned area whose coating is gone; `None` when grinding.
    pub exposed_share: Option<f64>,
    /// What each place of the surface went through in this pass, where [`Simulation::covariates`] asks for it.
    pub covariates: Option<Covariates>,
}

/// A workpiece and its tool between two passes of a trial.
#[derive(Clone, Debug)]
pub struct TrialState {
    /// The workpiece.
    pub part: BrickGrid,
    /// What the tool remembers.
    pub tool: States,
    /// Passes done.
    pub passes: usize,
    /// Time since the first pass began [s].
    pub trial_time: f64,
    /// Passes of the campaign before this trial's first: the row of its per-pass parameters.
    pub first_row: usize,
}

impl<'a> Simulation<'a> {
    /// Makes the part and the paths of a trial.
    ///
    /// - `voxel`: of the part's field [m]; the scan's pitch puts every pixel on a lattice line
    /// - `replay`: keep to the logged heights instead of simulating the controller
    ///
    /// # Errors
    /// [`SimulationError`] when the scan makes no part, a log no path, or a pass cannot be run with this tool on this part.
    pub fn new(trial: &'a Trial, voxel: f64, replay: bool) -> Result<Self, SimulationError> {
        Self::varied(trial, voxel, replay, &Variation::default())
    }

    /// As [`Simulation::new`], where what was measured is a little otherwise.
    ///
    /// # Errors
    /// As [`Simulation::new`].
    pub fn varied(trial: &'a Trial, voxel: f64, replay: bool, variation: &Variation) -> Result<Self, SimulationError> {
        let tool = &trial.tool.shape;
        // Before the part is made: voxels far wider than the scan's pixels take long.
        PassSettings::check_voxel(voxel, tool).map_err(|error| SimulationError::Pass { pass: 1, error })?;
        let options = SlabOptions { margin: trial.tool.half_width() + 4.0 * voxel, ..SlabOptions::with_voxel(voxel) };
        let mut before = trial.scans.checked_before();
        let added = variation.before.iter().flat_map(|map| &map.heights);
        before
            .heights
            .iter_mut()
            .zip(added)
            .for_each(|(height, added)| *height += if added.is_finite() { *added } else { 0.0 });
        let (mut part, _) = BrickGrid::from_heights(&before, &options)?;
        if let Some(material) = &trial.scans.material {
            part.label_columns(&material.pixels, &material.labels);
        }
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
            settings.check(&part, tool).map_err(|error| SimulationError::Pass { pass: i + 1, error })?;
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
            passes,
        })
    }

    /// The same trial on other voxels [m], or where what was measured is a little otherwise still.
    ///
    /// # Errors
    /// As [`Simulation::new`].
    pub fn again(&self, voxel: f64, variation: &Variation) -> Result<Self, SimulationError> {
        let frame_offset = self.frame_offset.and(&variation.frame_offset);
        Self::varied(self.trial, voxel, self.replay, &Variation { frame_offset, ..variation.clone() })
    }

    /// Changes how every pass is controlled and stepped.
    pub fn change_settings(&mut self, change: impl Fn(&mut PassSettings)) {
        self.passes.iter_mut().for_each(|planned| change(&mut planned.settings));
    }

    /// The tool's states at the start of a campaign.
    pub fn fresh_states(model: &CompiledModel) -> States {
        States::new(model, TOOL_CELLS)
    }

    /// Time simulated by all passes after the first `done` [s].
    pub fn duration(&self, done: usize) -> f64 {
        self.passes[done..].iter().map(|planned| planned.path.duration()).sum()
    }

    /// The trial before its first pass. The tool carries its states from trial to trial unless this one begins with a
    /// fresh one.
    ///
    /// - `first_row`: see [`TrialState::first_row`]
    pub fn start(&self, model: &CompiledModel, mut tool: States, first_row: usize) -> TrialState {
        if self.trial.fresh {
            tool.reset(model, Reset::FreshTool);
        }
        tool.reset(model, Reset::Trial);
        TrialState { part: self.part.clone(), tool, passes: 0, trial_time: 0.0, first_row }
    }

    /// Simulates all passes with a tool that remembers `states`. Returns the passes and the part after them.
    ///
    /// # Errors
    /// [`SimulationError`] when a pass fails.
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
    /// [`SimulationError`] when a pass fails.
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
    /// [`SimulationError`] when it fails; `state` then holds the last good one.
    ///
    /// # Panics
    /// If all passes are done.
    pub fn run_pass(
        &self,
        model: &CompiledModel,
        state: &mut TrialState,
        progress: &mut dyn FnMut(Progress),
    ) -> Result<SimulatedPass, SimulationError> {
        let pixels = &self.trial.scans.before.pixels;
        let covariates = self.covariates.then(|| RefCell::new(Covariates::over(pixels, state.part.voxel)));
        let pass = sim::Pass { covariates: covariates.as_ref(), ..self.next_pass(model, state) };
        columns::check(self.trial, model)?;
        self.rest(&pass, &mut state.tool)?;
        let number = pass.number;
        let record = match self.device {
            Some(device) => sim::gpu::run_pass(device, &mut state.part, pass, &mut state.tool, progress)
                .map_err(|error| SimulationError::Device { pass: number, error })?,
            None => run_pass(&mut state.part, pass, &mut state.tool, progress)
                .map_err(|error| SimulationError::Pass { pass: number, error })?,
        };
        self.count(state);
        let seen = self.seen(model, state, record)?;
        Ok(SimulatedPass { covariates: covariates.map(RefCell::into_inner), ..seen })
    }

    /// The pass that a state is before.
    fn next_pass<'p>(&'p self, model: &'p CompiledModel, state: &TrialState) -> sim::Pass<'p> {
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

    /// The pause before a pass.
    fn rest(&self, pass: &sim::Pass, tool: &mut States) -> Result<(), SimulationError> {
        let rest = self.passes[pass.number - 1].rest;
        sim::rest(pass, tool, rest).map_err(|error| SimulationError::Rest { pass: pass.number, error })
    }

    /// Counts a pass that is done.
    fn count(&self, state: &mut TrialState) {
        let Planned { path, rest, .. } = &self.passes[state.passes];
        state.trial_time += rest + path.duration();
        state.passes += 1;
    }

    /// What of the trial a graphics processor does not run; `None` where it runs all of it.
    pub fn refusal(&self, model: &CompiledModel) -> Option<String> {
        if self.covariates {
            return Some("maps of what each place goes through".to_owned());
        }
        sim::gpu::refusal(&self.next_pass(model, &self.start(model, Self::fresh_states(model), 0)))
    }

    /// The last pass of a state, with its scan.
    ///
    /// # Errors
    /// [`SimulationError::Scan`] when a formula of the scanner fails.
    pub fn seen(
        &self,
        model: &CompiledModel,
        state: &TrialState,
        record: PassRecord,
    ) -> Result<SimulatedPass, SimulationError> {
        let like = &self.trial.passes[state.passes - 1].scan;
        let rows = (state.passes, state.first_row + state.passes - 1);
        let surface = SeenSurface::of(&state.part, (self.trial.scans.before.pixels, like), model, rows);
        let scan = surface.reported(model).map_err(|error| SimulationError::Scan { pass: state.passes, error })?;
        let exposed_share = match &scan {
            PassScan::Exposure(mask) => Some(exposed_share(mask)),
            PassScan::Heights(_) => None,
        };
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
