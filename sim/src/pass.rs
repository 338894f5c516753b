//! One pass: the tool follows its path, the controller holds the force, the surface recedes.
//!
//! While the tool moves a fraction of a voxel the contact is stepped on a [`Sheet`] read from the field; then what was
//! lost is written back and the next sheet is read. Steps are as long as the tool needs for half a voxel, unless the
//! controller's own dynamics matter: then they fall to its period.

use sdf_bake::BrickGrid;

use crate::commit::commit;
use crate::control::{Balance, Controller, Motion, Response, admittance_sample};
use crate::path::Path;
use crate::physics::BaseLaw;
use crate::record::{LogRow, PassRecord};
use crate::settings::{PassError, Process};
use crate::sheet::{Facing, Sheet, Window};
use crate::step::Step;
use crate::tool::{Pose, Tool};

/// Recession after which a sheet is written back [voxels]: well within the distance that φ keeps beyond its zero set.
const COMMIT_RECESSION: f64 = 0.4;
/// Lines around the contact that a sheet holds in reserve.
const MARGIN: i32 = 3;
/// Surface sought below the tool while it is in contact [voxels].
const NEAR_BELOW: f64 = 4.0;
/// Longest step [s].
const LONGEST_STEP: f64 = 0.05;
/// Inertial force [setpoints] beyond which an admittance is stepped at its own period.
const INERTIA: f64 = 0.03;
/// Relative difference between force and setpoint that is good enough.
const FORCE_TOLERANCE: f64 = 1e-6;

/// How far a pass is.
#[derive(Clone, Copy, Debug)]
pub struct Progress {
    /// Time simulated [s].
    pub time: f64,
    /// Time of the whole pass [s].
    pub duration: f64,
    /// Force in this step [N]; 0 in the air.
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
    pub law: &'a BaseLaw,
}

/// A part under a tool.
struct Runner<'a> {
    grid: &'a mut BrickGrid,
    pass: Pass<'a>,
    sheet: Option<Sheet>,
    step: Step,
    time: f64,
    motion: Motion,
    /// Length of the next step [s], where the controller limits it.
    dt: f64,
    /// Half-extents of the contact in the tool's frame that sheets are read for: least and greatest x and y [m].
    extent: [(f64, f64); 2],
    /// Way of the tool since the sheet was read [m].
    travelled: f64,
    /// Recession since the sheet was read, at most [m].
    receded: f64,
    record: PassRecord,
}

/// Runs one pass: changes `grid`, returns the log and what was removed.
///
/// # Errors
/// A setting out of range, a band that is too thin, or a state that is no longer finite: then the field holds the last
/// good state.
pub fn run_pass(
    grid: &mut BrickGrid,
    pass: Pass,
    progress: &mut dyn FnMut(Progress),
) -> Result<PassRecord, PassError> {
    pass.process.check(grid, pass.tool)?;
    let before = grid.volume();
    let duration = pass.path.duration();
    let mut runner = Runner::new(grid, pass);
    while runner.time < duration {
        let force = runner.advance(duration)?;
        progress(Progress { time: runner.time, duration, force });
    }
    runner.write_back();
    let mut record = runner.record;
    grid.release_uniform_bricks();
    record.finish(duration, before - grid.volume());
    Ok(record)
}

impl<'a> Runner<'a> {
    fn new(grid: &'a mut BrickGrid, pass: Pass<'a>) -> Self {
        let travel = match pass.process.controller {
            Controller::Ideal => pass.process.search_reach,
            _ => 0.0,
        };
        let mut runner = Self {
            grid,
            pass,
            sheet: None,
            step: Step::default(),
            time: 0.0,
            motion: Motion { travel, speed: 0.0 },
            dt: LONGEST_STEP,
            extent: [(0.0, 0.0); 2],
            travelled: 0.0,
            receded: 0.0,
            record: PassRecord::default(),
        };
        runner.reset_extent();
        runner
    }

    fn voxel(&self) -> f64 {
        self.grid.voxel
    }

    fn pose(&self, time: f64, travel: f64) -> Pose {
        self.pass.path.at(time).pose(self.pass.tool).lifted(travel)
    }

    /// One step. Returns the force [N].
    fn advance(&mut self, duration: f64) -> Result<f64, PassError> {
        let speed = self.pass.path.velocity(self.time).length();
        let by_way = if speed > 0.0 { self.pass.process.step_voxels * self.voxel() / speed } else { LONGEST_STEP };
        let mut dt = by_way.min(self.dt).min(LONGEST_STEP).min(duration - self.time);
        let period = match self.pass.process.controller {
            Controller::Admittance { period, .. } => period,
            _ => f64::INFINITY,
        };
        loop {
            let Some(motion) = self.find_motion(dt) else {
                self.stay_in_air(dt);
                return Ok(0.0);
            };
            let inertia = self.inertial_force(motion, dt);
            if inertia > INERTIA * self.pass.process.force_setpoint && dt > period {
                dt = (0.25 * dt).max(period);
                continue;
            }
            self.dt = (2.0 * dt).max(self.dt.min(dt));
            return self.accept(motion, dt);
        }
    }

    fn inertial_force(&self, motion: Motion, dt: f64) -> f64 {
        match self.pass.process.controller {
            Controller::Admittance { mass, .. } => (mass * (motion.speed - self.motion.speed) / dt).abs(),
            _ => 0.0,
        }
    }

    /// Where the controller brings the tool in a step of `dt` [s]; `None` where it finds nothing to press on.
    /// Afterwards `step` holds the step to that motion on a sheet that is large enough.
    fn find_motion(&mut self, dt: f64) -> Option<Motion> {
        let mut searched = false;
        loop {
            self.read_sheet_if_needed(dt, searched);
            let motion = self.try_motion(dt);
            let sheet = self.sheet.as_ref().expect("a sheet was read");
            if motion.is_some() && self.step.reaches_border(sheet) && self.grow_extent() {
                self.write_back();
                continue;
            }
            if motion.is_none() && !searched && matches!(self.pass.process.controller, Controller::Ideal) {
                self.write_back();
                self.reset_extent();
                searched = true;
                continue;
            }
            return motion;
        }
    }

    fn in_air(&self) -> bool {
        matches!(self.pass.process.controller, Controller::Ideal) && self.motion.travel >= self.pass.process.search_reach
    }

    fn try_motion(&mut self, dt: f64) -> Option<Motion> {
        if self.in_air() {
            // An ideal controller is in balance from the first touch on.
            self.motion = self.try_step(0.0, self.time)?;
        }
        self.try_step(dt, self.time + dt)
    }

    /// Seeks the end of a step of `dt` [s] that ends at the path's place at `end` [s].
    fn try_step(&mut self, dt: f64, end: f64) -> Option<Motion> {
        let Pass { tool, process, law, .. } = self.pass;
        let start = self.pose(self.time, self.motion.travel);
        let end = self.pose(end, 0.0);
        let sheet = self.sheet.as_ref().expect("a sheet was read");
        self.step.begin(tool, &start, sheet);
        let from = self.motion;
        let (damping, mass) = match process.controller {
            Controller::Ideal => (0.0, 0.0),
            Controller::Admittance { mass, damping, period } if dt <= period => {
                let force = self.step.start_force(law, &start, sheet);
                let motion = admittance_sample(from, force, process.force_setpoint, (mass, damping), dt);
                self.step.end_at(tool, &end.lifted(motion.travel), sheet, law, dt);
                return Some(motion);
            }
            Controller::Admittance { mass, damping, .. } => (damping, mass),
            Controller::Replay => {
                self.step.end_at(tool, &end, sheet, law, dt);
                return Some(Motion::default());
            }
        };
        let balance = Balance {
            from,
            setpoint: process.force_setpoint,
            damping,
            mass,
            dt,
            tolerance: FORCE_TOLERANCE * process.force_setpoint,
            bounds: (-process.search_reach, process.search_reach),
        };
        let step = &mut self.step;
        let mut last = f64::NAN;
        let travel = balance.solve(from.travel + from.speed * dt, |travel| {
            let pose = end.lifted(travel);
            last = travel;
            let response = step.end_at(tool, &pose, sheet, law, dt);
            let depth = if response.force > 0.0 { 0.0 } else { step.end_gap(tool, &pose, sheet) };
            Response { force: response.force, stiffness: response.stiffness, depth }
        })?;
        if last != travel {
            step.end_at(tool, &end.lifted(travel), sheet, law, dt);
        }
        Some(Motion { travel, speed: if dt > 0.0 { (travel - from.travel) / dt } else { 0.0 } })
    }

    /// Takes the step that `find_motion` prepared. Returns the mean force [N].
    fn accept(&mut self, motion: Motion, dt: f64) -> Result<f64, PassError> {
        let middle = self.pose(self.time + 0.5 * dt, 0.5 * (self.motion.travel + motion.travel));
        let sheet = self.sheet.as_mut().expect("a sheet was read");
        let (contact, volume) = self.step.apply(&middle, sheet);
        if !(contact.force.is_finite() && volume.is_finite()) {
            return Err(PassError::NotFinite { time: self.time, force: contact.force });
        }
        if let Some(extent) = self.step.extent(&middle, sheet) {
            self.extent = extent;
        }
        self.receded += self.step.recession_max();
        self.travelled += (self.pose(self.time + dt, 0.0).centre - self.pose(self.time, 0.0).centre).length();
        self.motion = match self.pass.process.controller {
            Controller::Ideal => Motion { travel: motion.travel, speed: 0.0 },
            _ => motion,
        };
        self.time += dt;
        let row = LogRow {
            time: self.time,
            position: self.pose(self.time, self.motion.travel).centre,
            approach: middle.approach,
            force: contact.force,
            spindle_speed: self.pass.process.spindle_speed,
        };
        self.record.push(row, contact, volume, dt, self.pass.process.force_setpoint);
        if self.travelled > self.pass.process.commit_voxels * self.voxel()
            || self.receded > COMMIT_RECESSION * self.voxel()
        {
            self.write_back();
        }
        Ok(contact.force)
    }

    fn stay_in_air(&mut self, dt: f64) {
        self.write_back();
        self.reset_extent();
        self.motion = Motion { travel: self.pass.process.search_reach, speed: 0.0 };
        self.time += dt;
        let pose = self.pose(self.time, self.motion.travel);
        let row = LogRow {
            time: self.time,
            position: pose.centre,
            approach: pose.approach,
            force: 0.0,
            spindle_speed: self.pass.process.spindle_speed,
        };
        self.record.push_air(row);
    }

    /// Writes the sheet's losses into the field and drops it.
    fn write_back(&mut self) {
        if let Some(mut sheet) = self.sheet.take() {
            commit(self.grid, &mut sheet);
        }
        self.travelled = 0.0;
        self.receded = 0.0;
    }

    fn reset_extent(&mut self) {
        let (x, y) = self.pass.tool.half_footprint(2.0 * self.voxel());
        self.extent = [(-x, x), (-y, y)];
    }

    /// Makes the extent larger; `false` if it covers the tool already.
    fn grow_extent(&mut self) -> bool {
        let (x, y) = self.pass.tool.half_footprint(f64::INFINITY);
        let whole = [x, y];
        let covered = self.extent.iter().zip(whole).all(|(&(low, high), most)| low <= -most && high >= most);
        for ((low, high), most) in self.extent.iter_mut().zip(whole) {
            let more = 0.25 * (*high - *low) + 2.0 * self.grid.voxel;
            (*low, *high) = ((*low - more).max(-most), (*high + more).min(most));
        }
        !covered
    }

    /// Reads a sheet that holds the contact for the next steps, if there is none; `far` to seek the surface from the air.
    fn read_sheet_if_needed(&mut self, dt: f64, far: bool) {
        if self.sheet.is_some() {
            return;
        }
        let Pass { tool, path, process, .. } = self.pass;
        let speed = path.velocity(self.time).length();
        let ahead = if speed > 0.0 { (process.commit_voxels + 1.0) * self.voxel() / speed } else { 0.0 };
        let poses = [self.time, self.time + dt, self.time + ahead.max(dt)].map(|t| self.pose(t, self.motion.travel));
        let facing = Facing::of(poses[0].approach);
        let corners = poses.iter().flat_map(|pose| {
            let bottom = pose.centre - pose.frame.z * tool.drop();
            let [(back, front), (right, left)] = self.extent;
            [(back, right), (back, left), (front, right), (front, left)]
                .map(|(x, y)| facing.sheet(bottom + pose.frame.x * x + pose.frame.y * y))
        });
        let corners: Vec<_> = corners.collect();
        let window = Window::around(corners.iter().copied(), self.voxel(), MARGIN);
        let level = facing.sheet(poses[0].centre - poses[0].frame.z * tool.drop()).z;
        let below = if far || self.in_air() { 2.0 * process.search_reach } else { NEAR_BELOW * self.voxel() };
        let falling = (-self.motion.speed).max(0.0) * dt.max(LONGEST_STEP);
        let lowest = corners.iter().map(|corner| corner.z).fold(level, f64::min);
        self.sheet = Some(Sheet::read(self.grid, facing, window, level, lowest - below - falling));
    }
}
