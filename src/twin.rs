//! A trial simulated: its part made from the scan before, its passes along the logged paths, its scans as the same
//! instrument would see them.

use glam::DVec3;
use sdf_bake::heights::{HeightsError, SlabOptions};
use sdf_bake::BrickGrid;
use sim::effect::{CompiledModel, Reset, States, StepValues};
use sim::{PassError, PassRecord, Path, PathError, PathSample, Process, Profilometer, Progress, TOOL_CELLS, run_pass};
use thiserror::Error;

use crate::trial::{Contact, Controller, ExposureMask, Pass, PassScan, Tool, ToolPath, Trial};

/// Coating that is assumed where a trial does not say [m].
const COATING: f64 = 50e-6;

/// Why a trial cannot be simulated.
#[derive(Debug, Error)]
pub enum TwinError {
    /// The scan before does not make a part.
    #[error("the scan before: {0}")]
    Part(#[from] HeightsError),
    /// A log is no path.
    #[error("the log of pass {pass}: {error}")]
    Path {
        /// From 1.
        pass: usize,
        /// What is wrong with it.
        error: PathError,
    },
    /// A pass failed.
    #[error("pass {pass}: {error}")]
    Pass {
        /// From 1.
        pass: usize,
        /// Why.
        error: PassError,
    },
    /// A formula of the scanner.
    #[error("the scan after pass {pass}: {error}")]
    Scan {
        /// From 1.
        pass: usize,
        /// Which formula.
        error: sim::effect::RunError,
    },
}

/// A trial ready to be simulated again and again.
pub struct Twin<'a> {
    /// The trial.
    pub trial: &'a Trial,
    /// The part before the first pass.
    pub part: BrickGrid,
    tool: sim::Tool,
    passes: Vec<Planned>,
}

/// A pass ready to be run.
struct Planned {
    path: Path,
    process: Process,
    /// Time at which the logged tool touched the part [s].
    approach: f64,
}

/// What a simulated pass leaves.
#[derive(Clone, Debug)]
pub struct SimulatedPass {
    /// Log and figures.
    pub record: PassRecord,
    /// What the instrument sees afterwards.
    pub scan: PassScan,
    /// Share of the scanned area whose coating is gone; `None` when grinding.
    pub exposed_share: Option<f64>,
}

impl<'a> Twin<'a> {
    /// Makes the part and the paths of a trial.
    ///
    /// - `voxel`: of the part's field [m]; the scan's pitch puts every pixel on a lattice line
    /// - `replay`: keep to the logged heights instead of simulating the controller
    ///
    /// # Errors
    /// [`TwinError`] when the scan makes no part or a log no path.
    pub fn new(trial: &'a Trial, voxel: f64, replay: bool) -> Result<Self, TwinError> {
        let options = SlabOptions { margin: trial.tool.half_width() + 4.0 * voxel, ..SlabOptions::with_voxel(voxel) };
        let (mut part, _) = BrickGrid::from_heights(&trial.scans.before, &options)?;
        if let Some(material) = &trial.scans.material {
            part.label_columns(&material.pixels, &material.labels);
        }
        let tool = simulated_tool(&trial.tool);
        let mut passes = Vec::new();
        for (i, pass) in trial.passes.iter().enumerate() {
            let controller = controller(trial, replay);
            let logged = ToolPath::of(&pass.log, &trial.tool, pass.force_setpoint);
            let path = path(&logged, trial, &tool, controller).map_err(|error| TwinError::Path { pass: i + 1, error })?;
            let approach = logged.contact.map_or(0.0, |contact| contact.start);
            passes.push(Planned { path, process: process(pass, trial, controller), approach });
        }
        Ok(Self { trial, part, tool, passes })
    }

    /// Changes how every pass is controlled and stepped.
    pub fn change_process(&mut self, change: impl Fn(&mut Process)) {
        self.passes.iter_mut().for_each(|planned| change(&mut planned.process));
    }

    /// The tool's states at the start of a campaign.
    pub fn fresh_states(model: &CompiledModel) -> States {
        States::new(model, TOOL_CELLS)
    }

    /// Time simulated by all passes [s].
    pub fn duration(&self) -> f64 {
        self.passes.iter().map(|planned| planned.path.duration()).sum()
    }

    /// Simulates all passes. The tool carries its `states` from trial to trial unless this one begins with a fresh one.
    /// Returns the passes and the part after them.
    ///
    /// - `first_row`: passes of the campaign before this trial's first: the row of its per-pass parameters
    ///
    /// # Errors
    /// [`TwinError`] when a pass fails.
    pub fn run(
        &self,
        model: &CompiledModel,
        states: &mut States,
        first_row: usize,
        progress: &mut dyn FnMut(usize, Progress),
    ) -> Result<(Vec<SimulatedPass>, BrickGrid), TwinError> {
        if self.trial.fresh {
            states.reset(model, Reset::FreshTool);
        }
        states.reset(model, Reset::Trial);
        let mut part = self.part.clone();
        let (mut passes, mut trial_time) = (Vec::new(), 0.0);
        for (i, Planned { path, process, approach }) in self.passes.iter().enumerate() {
            let pass = sim::Pass {
                number: i + 1,
                row: first_row + i,
                trial_time,
                approach: *approach,
                ..sim::Pass::first(&self.tool, path, process, model)
            };
            let record = run_pass(&mut part, pass, states, &mut |at| progress(i, at))
                .map_err(|error| TwinError::Pass { pass: i + 1, error })?;
            trial_time += path.duration();
            let scan = self.see(&part, model, i, first_row).map_err(|error| TwinError::Scan { pass: i + 1, error })?;
            let exposed_share = match &scan {
                PassScan::Exposure(mask) => Some(exposed_share(mask)),
                PassScan::Heights(_) => None,
            };
            passes.push(SimulatedPass { record, scan, exposed_share });
        }
        Ok((passes, part))
    }

    /// The part as the instrument sees it after a pass.
    fn see(
        &self,
        part: &BrickGrid,
        model: &CompiledModel,
        pass: usize,
        first_row: usize,
    ) -> Result<PassScan, sim::effect::RunError> {
        let instrument = Profilometer::sharp(self.trial.scans.before.pixels);
        Ok(match &self.trial.passes[pass].scan {
            PassScan::Heights(_) => PassScan::Heights(instrument.heights(part)),
            PassScan::Exposure(_) => {
                let mut step = StepValues::new();
                step.scan_row = first_row + pass;
                let threshold = model.exposure_threshold(&step)?;
                let doses = instrument.channel(part, &part.dose);
                let exposed = doses.iter().map(|dose| dose.is_finite().then_some(*dose >= threshold)).collect();
                PassScan::Exposure(ExposureMask { pixels: instrument.pixels, exposed })
            }
        })
    }
}

/// Share of the pixels with an answer that are exposed.
pub fn exposed_share(mask: &ExposureMask) -> f64 {
    let known = mask.exposed.iter().flatten();
    known.clone().filter(|exposed| **exposed).count() as f64 / known.count().max(1) as f64
}


fn simulated_tool(tool: &Tool) -> sim::Tool {
    match *tool {
        Tool::Wheel { radius, width, .. } => sim::Wheel::cylinder(radius, width).into(),
        Tool::Pad { radius } => sim::Pad { radius }.into(),
    }
}

fn controller(trial: &Trial, replay: bool) -> sim::Controller {
    match trial.controller {
        Some(Controller::Admittance { mass, damping, period }) if !replay => {
            sim::Controller::Admittance { mass, damping, period }
        }
        Some(Controller::Ideal) if !replay => sim::Controller::Ideal,
        _ => sim::Controller::Replay,
    }
}

fn process(pass: &Pass, trial: &Trial, controller: sim::Controller) -> Process {
    Process {
        controller,
        force_setpoint: pass.force_setpoint,
        spindle_speed: pass.spindle_speed,
        coating: trial.coating.unwrap_or(COATING),
        ..Process::default()
    }
}

/// The logged path up to the end of contact. A controller finds its own height from the first contact on: its path stays
/// at the height that the tool had then.
fn path(
    logged: &ToolPath,
    trial: &Trial,
    tool: &sim::Tool,
    controller: sim::Controller,
) -> Result<Path, PathError> {
    let contact = logged.contact.unwrap_or(Contact { start: 0.0, end: f64::INFINITY });
    let touch = logged.at(contact.start).centre;
    let poses = logged.poses.iter().take_while(|pose| pose.time <= contact.end);
    let samples = poses.map(|pose| {
        let leads = controller == sim::Controller::Replay || pose.time <= contact.start;
        let height = if leads { 0.0 } else { (pose.centre - touch).dot(pose.approach) };
        let across = match trial.tool {
            Tool::Wheel { .. } => pose.axis,
            Tool::Pad { .. } => DVec3::Y.reject_from_normalized(pose.approach).normalize(),
        };
        PathSample::from_centre(pose.time, pose.centre - pose.approach * height, (pose.approach, across), tool)
    });
    Path::from_samples(samples.collect())
}
