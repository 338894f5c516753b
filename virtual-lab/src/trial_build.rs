//! True course of a trial, with another lattice, shorter steps and another time quadrature than a fit uses.

use effects::{CompiledModel, Hook, Process, Reset, RunError, Signal, States, StepValues, Variable};
use glam::{DVec2, DVec3};
use sdf_bake::channels::Scalar;
use sdf_bake::heights::{HeightsError, SlabOptions};
use sdf_bake::{BrickGrid, HeightMap, PixelGrid};
use sim::settings::TOUCH;
use sim::{PassRecord, Path, Profilometer, run_pass};

use super::Experiment;
use super::answer::TrueTrial;
use super::experiment_error::ExperimentError;
use super::fault::Fault;
use super::frame::Frame;
use super::motion::Route;
use super::plan::{Plan, ProcessDefaults, Setting, role};
use super::ripple::Ripple;
use super::robot::{PassRun, Robot, touching};
use super::surface::Workpiece;
use random::Stream;
use robot::Controller;
use trials::trial::{
    ForceInput, FrameErrors, FrameOffset, HeldTool, LabelMap, Pass, PassScan, RPM, Role, Scans, Trial,
};

/// Voxel of the true part [scan pitches]: finer than half a pixel, and not a divisor of it, so that lattice lines and
/// pixels do not coincide.
const VOXEL: f64 = 0.44;
/// Distance of the tool per step [voxels]: half the usual one, in addition to the smaller voxel.
const STEP_VOXELS: f64 = 0.25;
/// Width of the wheel [m].
const WHEEL_WIDTH: f64 = 20e-3;
/// Margin of the part beyond the scan and half the tool's width [m].
const BEYOND: f64 = 1e-3;
/// Virtual mass [kg], damping [N s/m] and period [s] of the controllers. The true controller is stepped at its period.
const GRINDING_CONTROLLER: (f64, f64, f64) = (2.0, 1500.0, 2e-3);
const SANDING_CONTROLLER: (f64, f64, f64) = (1.0, 400.0, 5e-3);
/// Thickness of the coating [m].
const COATING: f64 = 60e-6;

/// One trial while it is made.
pub(super) struct TrialBuild<'a> {
    experiment: &'a Experiment,
    model: &'a CompiledModel,
    bench: ProcessDefaults,
    name: String,
    /// Number of the trial, from 0.
    number: usize,
    pixels: PixelGrid,
    /// Least and greatest x of bead or panel [m].
    ends: [f64; 2],
    piece: Workpiece,
    tool: HeldTool,
    controller: Controller,
    part: BrickGrid,
    trial_time: f64,
    /// True if a pass was made on the workpiece.
    is_worked: bool,
}

/// Command for a pass.
pub(super) struct PassCommand {
    pub(super) way: Route,
    /// Force setpoint [N].
    pub(super) force_setpoint: f64,
    /// Spindle speed [rad/s].
    pub(super) spindle_speed: f64,
}

impl<'a> TrialBuild<'a> {
    /// Draws the workpiece of a trial and makes the part.
    pub(super) fn new(experiment: &'a Experiment, model: &'a CompiledModel, k: usize) -> Result<Self, ExperimentError> {
        Self::named(experiment, model, k, &format!("trial-{}", k + 1))
    }

    /// The same under another name, which seeds its workpiece and all other draws.
    fn named(
        experiment: &'a Experiment,
        model: &'a CompiledModel,
        number: usize,
        name: &str,
    ) -> Result<Self, ExperimentError> {
        let (bench, name) = (ProcessDefaults::of(experiment.process, experiment.size), name.to_owned());
        let mut stream = Stream::of(experiment.seed, &format!("{name}/workpiece"));
        let length = (stream.between(bench.length) * 1e3).round() * 1e-3;
        let (piece, extent, ends) = match experiment.process.signal() {
            Signal::Height => {
                let plate = Workpiece::plate_length(length);
                let start = 0.5 * (plate - length);
                (Workpiece::bead(length, &mut stream), plate, [start, start + length])
            }
            Signal::Dose => (Workpiece::panel(DVec2::new(0.5 * length, 0.0), &mut stream), length, [0.0, length]),
        };
        let (tool, controller) = tooling(experiment.process, &bench);
        let pixels = scanned(&bench, extent);
        let part =
            true_part(&piece, &pixels, &tool).map_err(|error| ExperimentError::Part { trial: name.clone(), error })?;
        Ok(Self {
            experiment,
            model,
            bench,
            name,
            number,
            pixels,
            ends,
            piece,
            tool,
            controller,
            part,
            trial_time: 0.0,
            is_worked: false,
        })
    }

    /// Scans, runs all passes with a tool of given `states`, and scans again.
    ///
    /// - `row`: number of earlier passes of the campaign
    /// - `done`: called after each pass
    pub(super) fn run(
        mut self,
        (settings, states, row): (&[Setting], &mut States, usize),
        done: &(dyn Fn() + Sync),
    ) -> Result<(Trial, TrueTrial), ExperimentError> {
        let scans = self.scans()?;
        if self.model.needs(Hook::Height).contains(&Variable::RemovedDepth) {
            self.part.scalar_or_zero(Scalar::Removed);
        }
        states.reset(self.model, Reset::FreshTool);
        self.wear(states, row)?;
        states.reset(self.model, Reset::Trial);
        let (mut passes, mut truth) = (Vec::new(), TrueTrial::default());
        for (pass, setting) in settings.iter().enumerate() {
            let at = (pass + 1, row + pass);
            let (made, removed) = self.made(&self.order(setting), states, at)?;
            match self.experiment.process.signal() {
                Signal::Height => truth.removed_by_law_mm3.push(removed * 1e9),
                Signal::Dose => truth.exposed_share.push(self.exposed_share()),
            }
            passes.push(Pass { role: role((self.number, self.experiment.trials), (pass, settings.len())), ..made });
            done();
        }
        Ok((self.trial(scans, passes), truth))
    }

    /// Runs a pass and scans the result. Returns the pass and the removed volume [m³].
    pub(super) fn made(
        &mut self,
        order: &PassCommand,
        states: &mut States,
        at: (usize, usize),
    ) -> Result<(Pass, f64), ExperimentError> {
        let (record, touch) = self.pass(order, states, at)?;
        let PassCommand { way, force_setpoint, spindle_speed } = order;
        let (controller, frame, ripple) = (self.controller, self.frame(), Ripple::of(self.model, at.1));
        let (force_setpoint, spindle_speed) = (*force_setpoint, *spindle_speed);
        let ran = PassRun { record: &record, way, touch, controller, force_setpoint, spindle_speed, frame, ripple };
        let pass = Pass {
            log: self.experiment.robot.log(&ran, &mut self.stream(&format!("pass-{}/log", at.0))),
            scan: self.scan_after(at)?,
            role: Role::Calibration,
            force_setpoint,
            feed: way.mean_feed(),
            spindle_speed,
            direction: way.direction(),
        };
        Ok((pass, record.removed_volume))
    }

    /// Command for a pass of the plan.
    fn order(&self, setting: &Setting) -> PassCommand {
        let (force_setpoint, spindle_speed) = self.setpoints(setting);
        let way = Route::of(self.experiment.process, &self.bench, self.ends, setting);
        PassCommand { way, force_setpoint, spindle_speed }
    }

    /// Runs the tool on another workpiece before the trial.
    fn wear(&self, states: &mut States, row: usize) -> Result<(), ExperimentError> {
        if self.experiment.earlier_passes == 0 {
            return Ok(());
        }
        let mut other = Self::named(self.experiment, self.model, self.number, &format!("{}/earlier", self.name))?;
        let usual = Plan::Paper.settings(1);
        for (pass, setting) in usual[0].iter().cycle().take(self.experiment.earlier_passes).enumerate() {
            other.pass(&other.order(setting), states, (pass + 1, row))?;
        }
        Ok(())
    }

    /// The robot's frame.
    fn frame(&self) -> Frame {
        let end = self.pixels.position(self.pixels.nx - 1, self.pixels.ny - 1);
        Frame::of(&self.experiment.robot, self.experiment.seed, 0.5 * (self.pixels.origin + end))
    }

    pub(super) fn trial(&self, scans: Scans, passes: Vec<Pass>) -> Trial {
        let sands = self.experiment.process.signal() == Signal::Dose;
        Trial {
            folder: self.name.clone().into(),
            name: self.name.clone(),
            process: self.experiment.process,
            tool: self.tool.clone(),
            fresh: true,
            scans,
            controller: match self.experiment.force_input {
                ForceInput::Setpoint => self.controller,
                ForceInput::Log => Controller::Ideal,
            },
            force_input: self.experiment.force_input,
            frame_errors: FrameErrors::default(),
            frame_offset: FrameOffset::default(),
            coating: sands.then_some(COATING),
            passes,
            columns: Vec::new(),
            notes: Vec::new(),
            findings: Vec::new(),
        }
    }

    fn stream(&self, purpose: &str) -> Stream {
        Stream::of(self.experiment.seed, &format!("{}/{purpose}", self.name))
    }

    /// The true model.
    pub(super) fn model(&self) -> &'a CompiledModel {
        self.model
    }

    /// Continues with the same workpiece in another trial, whose name seeds its draws.
    pub(super) fn goes_on_as(&mut self, name: String) {
        (self.name, self.trial_time) = (name, 0.0);
    }

    /// Holds the tool in the air before a pass for a pause [s].
    pub(super) fn pause(
        &mut self,
        (order, pause): (&PassCommand, f64),
        states: &mut States,
        (number, row): (usize, usize),
    ) -> Result<(), ExperimentError> {
        self.trial_time += pause;
        let path = Path::from_samples(order.way.samples(&self.tool.shape));
        let path = path.map_err(|error| ExperimentError::Path { trial: self.name.clone(), pass: number, error })?;
        let settings = self.settings(order);
        let first = sim::Pass::first(&self.tool.shape, &path, &settings, self.model);
        let pass = sim::Pass { number, row, trial_time: self.trial_time, ..first };
        sim::rest(&pass, states, pause).map_err(|error| self.scan_error(number, error))
    }

    /// Nominal force setpoint [N] and spindle speed [rad/s] of a pass, rounded as an operator sets them.
    fn setpoints(&self, setting: &Setting) -> (f64, f64) {
        let force = (setting.force * self.bench.force * 10.0).round() / 10.0;
        (force, (setting.speed * self.bench.rpm / 10.0).round() * 10.0 * RPM)
    }

    /// The scan before and its repetition, by a scanner without faults.
    pub(super) fn scans(&self) -> Result<Scans, ExperimentError> {
        let scan = |purpose: &str| {
            let scanned = self.experiment.instrument.heights(&self.part, self.pixels, None, &mut self.stream(purpose));
            scanned.map_err(|error| self.scan_error(0, error))
        };
        let place = |k: usize| self.pixels.position(k % self.pixels.nx, k / self.pixels.nx);
        let labels = || (0..self.pixels.len()).map(|k| self.piece.label(place(k))).collect();
        let grinds = self.experiment.process.signal() == Signal::Height;
        Ok(Scans {
            is_nominal: false,
            before: scan("before")?,
            repeats: (0..self.experiment.repeats).map(|k| scan(&repeat(k))).collect::<Result<_, _>>()?,
            material: grinds.then(|| LabelMap { pixels: self.pixels, labels: labels() }),
        })
    }

    fn scan_error(&self, pass: usize, error: RunError) -> ExperimentError {
        ExperimentError::Scan { trial: self.name.clone(), pass, error }
    }

    fn scan_after(&self, (pass, row): (usize, usize)) -> Result<PassScan, ExperimentError> {
        let (instrument, mut stream) = (&self.experiment.instrument, self.stream(&format!("pass-{pass}/scan")));
        if self.experiment.process.signal() == Signal::Dose {
            let mut step = StepValues::new();
            (step.scan_row, step.pass_row) = (row, row);
            step.set(Variable::PassNumber, pass as f64);
            let threshold = self.model.exposure_threshold(&step).map_err(|error| self.scan_error(pass, error))?;
            return Ok(PassScan::Exposure(instrument.mask(&self.part, self.pixels, threshold, &mut stream)));
        }
        let marks = self.stream(&format!("pass-{pass}/marks"));
        let fault = Fault { model: self.model, pass, row, piece: &self.piece, marks };
        let map = instrument.heights(&self.part, self.pixels, Some(fault), &mut stream);
        map.map(PassScan::Heights).map_err(|error| self.scan_error(pass, error))
    }

    /// Share of the scanned area whose coating is gone.
    fn exposed_share(&self) -> f64 {
        let doses = Profilometer::sharp(self.pixels).channel(&self.part, &self.part.dose);
        doses.iter().filter(|dose| **dose >= 1.0).count() as f64 / doses.len() as f64
    }

    /// Runs a pass on the part. Returns the pass, and the time of the touch.
    fn pass(
        &mut self,
        order: &PassCommand,
        states: &mut States,
        (number, row): (usize, usize),
    ) -> Result<(PassRecord, f64), ExperimentError> {
        let tool = self.tool.shape.clone();
        let way = &order.way;
        let settings = self.settings(order);
        let trial = || self.name.clone();
        let no_path = |error| ExperimentError::Path { trial: trial(), pass: number, error };
        let failed = |error| ExperimentError::Pass { trial: trial(), pass: number, error };
        let surface = |place: DVec2| self.piece.height(place);
        let level = touching(&tool, way.at(0.0), self.part.voxel, surface);
        let (reach, speed) = Robot::descent();
        // The present surface may lie far below the first one.
        let deep = if self.is_worked { self.ground_below(way, surface) } else { 0.0 };
        let levels = [level + reach[0] - deep, level + reach[1] - deep];
        let descent = way.descent(levels, speed, &tool).map_err(no_path)?;
        let base = sim::Pass {
            number,
            row,
            trial_time: self.trial_time,
            ..sim::Pass::first(&tool, &descent, &settings, self.model)
        };
        let seeking = sim::PassSettings { controller: Controller::Replay, ..settings };
        let trying = sim::Pass { settings: &seeking, approach: descent.duration(), ..base };
        let sought = run_pass(&mut self.part.clone(), trying, &mut states.clone(), &mut |_| {}).map_err(failed)?;
        let meets = |row: &&robot::LogRow| row.force > TOUCH * settings.force_setpoint && row.time > 0.0;
        let touch = sought.log.iter().find(meets).map(|row| row.time);
        let touch = touch.ok_or_else(|| ExperimentError::NoTouch { trial: trial(), pass: number })?;
        let levels = [levels[0], levels[0] - speed * touch];
        let mut stream = self.stream(&format!("pass-{number}/wander"));
        let path = way.path((levels, touch), &self.experiment.robot, &tool, &mut stream).map_err(no_path)?;
        let pass = sim::Pass { path: &path, approach: touch, ..base };
        let record = run_pass(&mut self.part, pass, states, &mut |_| {}).map_err(failed)?;
        self.trial_time += path.duration();
        self.is_worked = true;
        Ok((record, touch))
    }

    /// Depth of the present surface below the first one at the start of the route [m].
    fn ground_below(&self, way: &Route, first: impl Fn(DVec2) -> f64) -> f64 {
        let place = way.at(0.0);
        let pixel = PixelGrid { origin: place, pitch: self.part.voxel, nx: 1, ny: 1 };
        (first(place) - Profilometer::sharp(pixel).heights(&self.part).heights[0]).max(0.0)
    }

    fn settings(&self, order: &PassCommand) -> sim::PassSettings {
        sim::PassSettings {
            controller: self.controller,
            force_setpoint: order.force_setpoint,
            spindle_speed: order.spindle_speed,
            step_voxels: STEP_VOXELS,
            quasi_static: false,
            coating: COATING,
            ..sim::PassSettings::default()
        }
    }
}

/// The tool and the force controller.
fn tooling(process: Process, bench: &ProcessDefaults) -> (HeldTool, Controller) {
    let radius = bench.tool_radius;
    let (tool, (mass, damping, period)) = match process.signal() {
        Signal::Height => (HeldTool::wheel(radius, WHEEL_WIDTH, DVec3::Y), GRINDING_CONTROLLER),
        Signal::Dose => (HeldTool::pad(radius), SANDING_CONTROLLER),
    };
    (tool, Controller::Admittance { mass, damping, period })
}

/// Pixels of a scan of a workpiece of this length [m].
fn scanned(bench: &ProcessDefaults, length: f64) -> PixelGrid {
    let count = |extent: f64| (extent / bench.pitch).round() as usize + 1;
    let origin = DVec2::new(0.0, -0.5 * bench.width);
    PixelGrid { origin, pitch: bench.pitch, nx: count(length), ny: count(bench.width) }
}

/// The true surface on a lattice finer than the scan, extended beyond its border by half the tool's width.
fn true_part(piece: &Workpiece, scan: &PixelGrid, tool: &HeldTool) -> Result<BrickGrid, HeightsError> {
    let voxel = VOXEL * scan.pitch;
    let margin = tool.half_width() + BEYOND;
    let low = ((scan.origin - margin) / voxel).floor();
    let high = ((scan.position(scan.nx - 1, scan.ny - 1) + margin) / voxel).ceil();
    let count = (high - low).as_uvec2() + 1;
    let pixels = PixelGrid { origin: low * voxel, pitch: voxel, nx: count.x as usize, ny: count.y as usize };
    let map = HeightMap::from_function(pixels, |place| piece.height(place));
    let (mut part, _) = BrickGrid::from_heights(&map, &SlabOptions { margin: 0.0, ..SlabOptions::with_voxel(voxel) })?;
    let place = |k: usize| pixels.position(k % pixels.nx, k / pixels.nx);
    let labels: Vec<u16> = (0..pixels.len()).map(|k| piece.label(place(k))).collect();
    if labels.iter().any(|&label| label != 0) {
        part.label_columns(&pixels, &labels);
    }
    Ok(part)
}

/// Name of the random stream of a repeated scan, counted from 0.
fn repeat(number: usize) -> String {
    if number == 0 { "repeat".to_owned() } else { format!("repeat-{}", number + 1) }
}
