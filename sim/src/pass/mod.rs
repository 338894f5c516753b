//! One pass: the tool follows its path, the controller holds the force, the surface recedes.
//!
//! While the tool moves a fraction of a voxel the contact is stepped on a [`Sheet`] read from the field; then what was
//! lost is written back and the next sheet is read. Steps are as long as the tool needs for half a voxel, unless the
//! controller's own dynamics matter: then they fall to its period.

mod force_balance;
mod idle_pause;

pub use idle_pause::rest;

use shaders::constants::APPROACH_STEP;
use shaders::constants::BENT;
use shaders::constants::COMMIT_RECESSION;
use shaders::constants::FORCE_JUMP;
use shaders::constants::INERTIA;
pub use shaders::constants::TOUCH;
use std::cell::RefCell;

use sdf_bake::BrickGrid;
use sdf_bake::channels::Scalar;

use crate::clock::{Clock, Phase};
use crate::commit::commit;
use crate::control::{Controller, Motion};
use crate::covariates::Covariates;
use crate::extent::Extent;
use crate::path::Path;
use crate::physics::Physics;
use crate::record::{LogRow, PassRecord};
use crate::settings::{LONGEST_STEP, PassError, Process};
use crate::sheet::Sheet;
use crate::step::{EndForce, Step};
use crate::step_values::Moment;
use crate::tool::{Pose, Tool};
use crate::tool_cells::{CellSums, ToolCells};
use effects::{CompiledModel, Hook, PoseChange, Reset, RunError, States, Variable};

/// Times that are one [s]: a step of what rounding leaves would make all that follow it short, too.
const CLOCK: f64 = 1e-9;

/// How far a pass is.
#[derive(Clone, Copy, Debug)]
pub struct Progress {
    /// Time simulated [s].
    pub time: f64,
    /// Time of the whole pass [s].
    pub duration: f64,
    /// Force now [N]; 0 in the air.
    pub force: f64,
}

/// What a pass is made with.
#[derive(Clone, Copy)]
pub struct Pass<'a> {
    /// What presses on the part.
    pub tool: &'a Tool,
    /// Where it goes.
    pub path: &'a Path,
    /// How it is controlled.
    pub process: &'a Process,
    /// What it does to the part.
    pub model: &'a CompiledModel,
    /// Number of the pass in its trial, from 1.
    pub number: usize,
    /// Row of parameters that have one value per pass, from 0.
    pub row: usize,
    /// Time since the trial's first pass began, pauses included [s].
    pub trial_time: f64,
    /// Until then the tool keeps to its path, unless the force exceeds [`TOUCH`] of the setpoint before [s]; then the
    /// controller takes over.
    pub approach: f64,
    /// Where to add up what each place of the surface goes through; `None` costs nothing.
    pub covariates: Option<&'a RefCell<Covariates>>,
    /// Where to sum up the time that each phase of the work takes; `None` costs nothing.
    pub clock: Option<&'a Clock>,
}

impl<'a> Pass<'a> {
    /// The first pass of a trial.
    pub fn first(tool: &'a Tool, path: &'a Path, process: &'a Process, model: &'a CompiledModel) -> Self {
        Self {
            tool,
            path,
            process,
            model,
            number: 1,
            row: 0,
            trial_time: 0.0,
            approach: 0.0,
            covariates: None,
            clock: None,
        }
    }
}

/// Runs one pass: changes `grid` and the tool's `states`, returns the log and what was removed.
///
/// # Errors
/// A setting out of range, a band that is too thin, a contact too soft for the setpoint from beginning to end, more
/// steps than allowed, or a formula that gives no finite number: then the field holds the last good state.
pub fn run_pass(
    grid: &mut BrickGrid,
    pass: Pass,
    states: &mut States,
    progress: &mut dyn FnMut(Progress),
) -> Result<PassRecord, PassError> {
    pass.process.check(grid, pass.tool)?;
    let longest_step = pass.process.longest_step(pass.model)?;
    states.reset(pass.model, Reset::Pass);
    let duration = pass.path.duration();
    let mut runner = Runner { longest_step, ..Runner::new(grid, pass, states) };
    while runner.time < duration {
        let time = runner.time;
        if let Some(most) = pass.process.most_steps.filter(|most| runner.record.steps >= *most) {
            runner.write_back();
            return Err(PassError::TooManySteps { time, most });
        }
        match runner.advance(duration) {
            Ok(force) => progress(Progress { time: runner.time, duration, force }),
            Err(error) => {
                runner.write_back();
                return Err(PassError::Formula { time, error });
            }
        }
    }
    runner.write_back();
    if runner.is_too_soft && runner.record.contact_time == 0.0 {
        let Process { force_setpoint: setpoint, search_reach: reach, .. } = *pass.process;
        return Err(PassError::TooSoft { setpoint, reach });
    }
    let (mut record, grinds) = (runner.record, runner.physics.grinds());
    if grinds {
        grid.release_uniform_bricks();
    }
    record.finish(duration);
    Ok(record)
}

/// A part under a tool.
struct Runner<'a> {
    grid: &'a mut BrickGrid,
    pass: Pass<'a>,
    physics: Physics<'a>,
    sheet: Option<Sheet>,
    /// The sheet before, where the surface stays as it was.
    last_sheet: Option<Sheet>,
    step: Step,
    time: f64,
    motion: Motion,
    /// Who leads: the path during the approach, then the controller.
    controller: Controller,
    pose_change: PoseChange,
    moment: Moment,
    /// Length of the next step [s], where the controller limits it.
    dt: f64,
    /// Longest step that the effects on the controller stand [s].
    longest_step: f64,
    /// Longest step that may begin on each piece of the path [s].
    longest_steps: Vec<f64>,
    /// Surface that sheets are read for.
    extent: Extent,
    /// Way of the tool since the sheet was read [m].
    travelled: f64,
    /// Recession since the sheet's slopes were taken, at most [m].
    bent: f64,
    /// Whether `step` holds one that was applied to this sheet and ends where the next begins.
    goes_on: bool,
    /// Force at the end of the last step, and of the one that is tried.
    end: EndForce,
    step_end: EndForce,
    /// Whether the tool touched and went as deep as it may without meeting the setpoint.
    is_too_soft: bool,
    record: PassRecord,
}

impl<'a> Runner<'a> {
    fn new(grid: &'a mut BrickGrid, pass: Pass<'a>, states: &'a mut States) -> Self {
        if let Some(clock) = pass.clock {
            clock.skip();
        }
        let mut physics = Physics::new(pass.model, states, pass.process.coating);
        physics.clock = pass.clock;
        if physics.sands() {
            grid.scalar_or_zero(Scalar::Dose);
        }
        let scanner = pass.model.needs(Hook::Height);
        if physics.wants(Variable::RemovedDepth) || scanner.contains(&Variable::RemovedDepth) {
            grid.scalar_or_zero(Scalar::Removed);
        }
        let longest_steps = pass.process.longest_steps(pass.tool, pass.path, grid.voxel, physics.grinds());
        let controller = if pass.approach > 0.0 { Controller::Replay } else { pass.process.controller };
        let travel = if controller == Controller::Ideal { pass.process.search_reach } else { 0.0 };
        Self {
            controller,
            extent: Extent::of(pass.tool, 2.0 * grid.voxel),
            grid,
            physics,
            sheet: None,
            last_sheet: None,
            step: Step::default(),
            time: 0.0,
            motion: Motion { travel, speed: 0.0 },
            pose_change: PoseChange { offset: [0.0; 3], roll: 0.0, pitch: 0.0 },
            moment: Moment::new(&pass),
            dt: LONGEST_STEP,
            longest_step: LONGEST_STEP,
            longest_steps,
            travelled: 0.0,
            bent: 0.0,
            goes_on: false,
            end: EndForce::default(),
            step_end: EndForce::default(),
            is_too_soft: false,
            record: PassRecord::default(),
            pass,
        }
    }

    /// The tool on its path, as the robot believes it to be.
    fn nominal(&self, time: f64, travel: f64) -> Pose {
        self.pass.path.at(time).pose(self.pass.tool).lifted(travel)
    }

    /// The tool as the model's effects have it.
    fn pose(&self, time: f64, travel: f64) -> Pose {
        self.nominal(time, travel).changed(&self.pose_change)
    }

    /// One step. Returns the force at its end [N].
    fn advance(&mut self, duration: f64) -> Result<f64, RunError> {
        let on_piece = self.longest_steps[self.pass.path.piece(self.time)];
        self.take_over();
        let rest = duration - self.time;
        let period = match self.controller {
            Controller::Admittance { period, .. } => period,
            _ => f64::INFINITY,
        };
        let mut dt = on_piece.min(self.dt).min(self.longest_step).min(rest);
        if !self.pass.process.quasi_static {
            dt = dt.min(period);
        }
        if self.comes_down() {
            dt = dt.min(APPROACH_STEP).min(self.pass.approach - self.time);
        }
        self.moment.enter(&self.pass, self.nominal(self.time, 0.0), self.time, &mut self.physics.step);
        let spindle = self.physics.model.spindle_speed(&self.physics.step, self.physics.states)?;
        self.moment.set_spindle(spindle, &mut self.physics.step);
        self.pose_change = self.physics.pose_change()?;
        loop {
            let Some(motion) = self.find_motion(dt)? else {
                self.stay_in_air(dt)?;
                return Ok(0.0);
            };
            if dt > period && self.is_fast(motion, dt) {
                dt = (0.25 * dt).max(period);
                continue;
            }
            self.dt = 2.0 * dt;
            return self.accept(motion, if rest - dt < CLOCK { rest } else { dt });
        }
    }

    /// Longest way of the tool in a step [m].
    fn step_way(&self) -> f64 {
        self.pass.process.ways(self.pass.tool, self.grid.voxel, self.physics.grinds()).0
    }

    /// Way of the tool after which a sheet is written back [m].
    fn commit_way(&self) -> f64 {
        self.pass.process.ways(self.pass.tool, self.grid.voxel, self.physics.grinds()).1
    }

    /// Whether the path still leads the tool to the part.
    fn comes_down(&self) -> bool {
        self.pass.approach - self.time > CLOCK
    }

    /// Ends the approach when its time is up or the tool touches.
    fn take_over(&mut self) {
        let Pass { process, .. } = self.pass;
        let touches = self.physics.step.get(Variable::Force) > TOUCH * process.force_setpoint;
        if self.controller != process.controller && (touches || !self.comes_down()) {
            self.controller = process.controller;
        }
    }

    /// Whether an admittance moves too fast for a step of `dt` [s] to follow it.
    fn is_fast(&self, motion: Motion, dt: f64) -> bool {
        let Controller::Admittance { mass, .. } = self.controller else { return false };
        let setpoint = self.pass.process.force_setpoint;
        let inertial_force = (mass * (motion.speed - self.motion.speed) / dt).abs();
        inertial_force > INERTIA * setpoint || (self.step_end.force - self.end.force).abs() > FORCE_JUMP * setpoint
    }

    /// Takes the step that `find_motion` prepared. Returns the force at its end [N].
    fn accept(&mut self, motion: Motion, dt: f64) -> Result<f64, RunError> {
        let middle = self.pose(self.time + 0.5 * dt, 0.5 * (self.motion.travel + motion.travel));
        let sheet = self.sheet.as_mut().expect("a sheet was read");
        self.step.complete((self.pass.tool, &middle), sheet, &mut self.physics, dt)?;
        let (contact, end_force) = self.step.contact(&middle, sheet);
        let cells = self.physics.model.needs_tool_cells();
        let sums = if cells {
            self.step.cell_sums((self.pass.tool, &middle), sheet, &self.physics, dt).means()
        } else {
            CellSums::default()
        };
        self.physics.advance_cells(&self.step, sheet, dt)?;
        if let Some(covariates) = self.pass.covariates {
            let slip_speed = |point| self.physics.slip_speed(self.pass.tool, middle.local(point));
            let begun = self.pass.trial_time + self.time;
            covariates.borrow_mut().add(sheet, self.step.squares(), slip_speed, (begun, dt));
        }
        let (removal, receded) = self.step.apply(sheet, self.pass.process.coating);
        self.bent += self.step.recession_max();
        if self.bent > BENT * self.grid.voxel {
            self.step.bend(sheet);
            self.bent = 0.0;
        }
        let extent = self.step.extent(&middle, sheet);
        let width = extent.map_or(0.0, |extent| extent.y.1 - extent.y.0);
        self.extent = extent.unwrap_or(self.extent);
        self.moment.leave((&contact, &removal), (motion, self.motion), width, dt);
        self.moment.publish(&mut self.physics.step);
        self.advance_states(&sums, dt)?;
        let way = self.nominal(self.time + dt, 0.0).centre - self.nominal(self.time, 0.0).centre;
        self.travelled += way.length();
        self.motion = motion;
        self.end = self.step_end;
        if self.physics.grinds() {
            self.step.go_on();
            self.goes_on = true;
        }
        self.time += dt;
        let row = self.log_row(end_force);
        self.record.push(row, (&contact, &removal), dt, self.pass.process.force_setpoint);
        self.physics.lap(Phase::Apply);
        // Half a step of slack: steps of equal ways would end on the limit itself, on a side that rounding decides.
        let far = self.travelled + 0.5 * way.length() > self.commit_way();
        if self.physics.grinds() && (far || receded > COMMIT_RECESSION * self.grid.voxel) {
            self.write_back();
        }
        Ok(end_force)
    }

    fn advance_states(&mut self, sums: &CellSums, dt: f64) -> Result<(), RunError> {
        let Physics { model, states, step, .. } = &mut self.physics;
        sums.advance(&ToolCells::of(self.pass.tool), model, states, (step, dt))
    }

    fn stay_in_air(&mut self, dt: f64) -> Result<(), RunError> {
        self.write_back();
        self.extent = Extent::of(self.pass.tool, 2.0 * self.grid.voxel);
        self.motion = Motion { travel: self.pass.process.search_reach, speed: 0.0 };
        self.moment.leave_air();
        self.moment.publish(&mut self.physics.step);
        self.advance_states(&CellSums::default(), dt)?;
        self.time += dt;
        let row = self.log_row(0.0);
        self.record.push_air(row);
        Ok(())
    }

    fn log_row(&self, force: f64) -> LogRow {
        let pose = self.nominal(self.time, self.motion.travel);
        LogRow {
            time: self.time,
            position: pose.centre,
            approach: pose.approach,
            force,
            spindle_speed: self.physics.step.get(Variable::SpindleSpeed),
        }
    }

    /// Writes the sheet's losses into the field and puts it aside.
    fn write_back(&mut self) {
        if let Some(mut sheet) = self.sheet.take() {
            commit(self.grid, &mut sheet);
            self.physics.lap(Phase::Write);
            self.last_sheet = (!self.physics.grinds()).then_some(sheet);
        }
        self.travelled = 0.0;
        self.bent = 0.0;
        self.goes_on = false;
    }
}
