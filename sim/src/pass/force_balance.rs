//! Where the controller brings the tool in a step, on a sheet that is large enough for it.

use glam::DVec3;
use shaders::constants::LOOK_AHEAD;
use shaders::constants::NEAR_BELOW;

use super::{Pass, Runner};
use crate::clock::Phase;
use crate::control::{Balance, Controller, Motion, Response, admittance_sample, end_weight};
use crate::extent::{Extent, MARGIN};
use crate::physics::Physics;
use crate::region::Region;
use crate::settings::LONGEST_STEP;
use crate::sheet::{Facing, Sheet, Window};
use crate::step::EndForce;
use crate::tool::Pose;
use effects::RunError;

/// Lines of a sheet, unless the tool's next ways need more: some 40 MB.
const MOST_LINES: usize = 1 << 18;
/// Relative difference between force and setpoint that is good enough.
const FORCE_TOLERANCE: f64 = 1e-5;

impl Runner<'_> {
    /// Where the controller brings the tool in a step of `dt` [s]; `None` where it finds nothing to press on.
    /// Afterwards `step` holds the step to that motion on a sheet that is large enough.
    pub(super) fn find_motion(&mut self, dt: f64) -> Result<Option<Motion>, RunError> {
        let mut searched = false;
        loop {
            self.choose_sheet(dt, searched);
            let motion = self.try_motion(dt)?;
            let sheet = self.sheet.as_ref().expect("a sheet was read");
            if motion.is_some()
                && self.step.reaches_border(sheet)
                && let Some(extent) = self.extent.grown(self.pass.tool, self.grid.voxel)
            {
                self.write_back();
                self.extent = extent;
                continue;
            }
            if motion.is_none() && !searched && self.controller == Controller::Ideal {
                self.write_back();
                self.extent = Extent::of(self.pass.tool, 2.0 * self.grid.voxel);
                searched = true;
                continue;
            }
            return Ok(motion);
        }
    }

    pub(super) fn in_air(&self) -> bool {
        self.controller == Controller::Ideal && self.motion.travel >= self.pass.process.search_reach
    }

    fn try_motion(&mut self, dt: f64) -> Result<Option<Motion>, RunError> {
        let reads_anew = self.controller == Controller::Ideal && self.physics.grinds() && !self.goes_on;
        if self.in_air() || reads_anew {
            // An ideal controller is in balance from the first touch on, and on every new sheet: what it
            // reads from the field differs a little from what was written, beside walls most of all.
            let Some(motion) = self.try_step(0.0, self.time)? else { return Ok(None) };
            self.motion.travel = motion.travel;
        }
        self.try_step(dt, self.time + dt)
    }

    /// Seeks the end of a step of `dt` [s] that ends at the path's place at `contact_state` [s].
    fn try_step(&mut self, dt: f64, end: f64) -> Result<Option<Motion>, RunError> {
        let Pass { tool, process, .. } = self.pass;
        let start = self.pose(self.time, self.motion.travel);
        let grinds = self.physics.grinds();
        // Without recession the whole step is taken as its middle.
        let whole = self.pose(end, 0.0).centre - self.pose(self.time, 0.0).centre;
        let (end, sweep) =
            if grinds { (self.pose(end, 0.0), DVec3::ZERO) } else { (self.pose(0.5 * (self.time + end), 0.0), whole) };
        let sheet = self.sheet.as_ref().expect("a sheet was read");
        let (step, physics, from) = (&mut self.step, &mut self.physics, self.motion);
        if grinds && !std::mem::take(&mut self.goes_on) {
            step.begin((tool, &start), sheet, physics)?;
        }
        let mut end_at = |physics: &mut Physics, travel: f64| {
            let pose = end.lifted(travel);
            let force = if grinds {
                step.end_at((tool, &pose), sheet, physics, dt)
            } else {
                step.middle_at((tool, &pose, sweep), sheet, physics)
            }?;
            let depth = if force.force > 0.0 { 0.0 } else { step.end_gap(tool, &pose, sheet) };
            Ok((force, depth))
        };
        let (damping, mass) = match self.controller {
            Controller::Ideal => (0.0, 0.0),
            Controller::Admittance { mass, damping, period } if dt <= period * (1.0 + 1e-9) => {
                let reading = physics.force_reading(self.end.force)?;
                let motion = admittance_sample(from, reading, process.force_setpoint, (mass, damping), dt);
                self.step_end = end_at(physics, motion.travel)?.0;
                return Ok(Some(motion));
            }
            Controller::Admittance { mass, damping, .. } => (damping, mass),
            Controller::Replay => {
                self.step_end = end_at(physics, 0.0)?.0;
                return Ok(Some(Motion::default()));
            }
        };
        // A contact that has just begun tells nothing of how the force comes to rest; a step taken as its middle has its mean force.
        let is_fitted = grinds && damping > 0.0 && self.end.stiffness > 0.0;
        let (start_force, weight) = if is_fitted {
            let weight = end_weight(dt * self.end.stiffness / (damping + mass / dt));
            (physics.force_reading(self.end.force)?, weight)
        } else {
            (0.0, 1.0)
        };
        let balance = Balance {
            from,
            setpoint: process.force_setpoint,
            damping,
            mass,
            dt,
            start_force,
            weight,
            tolerance: FORCE_TOLERANCE * process.force_setpoint,
            bounds: (-process.search_reach, process.search_reach),
        };
        let mut force = EndForce::default();
        let travel = balance.solve(from.travel + from.speed * dt, |travel| {
            let (end, depth) = end_at(physics, travel)?;
            force = end;
            Ok(Response { force: physics.force_reading(end.force)?, stiffness: end.stiffness, depth })
        })?;
        self.step_end = force;
        self.is_too_soft |= travel.is_none() && force.force > 0.0;
        let speed = |travel: f64| if dt > 0.0 { (travel - from.travel) / dt } else { 0.0 };
        Ok(travel.map(|travel| Motion { travel, speed: speed(travel) }))
    }

    /// Sees to a sheet that holds the contact of a step, and looks at its region of it; `far` to seek the surface from the
    /// air.
    fn choose_sheet(&mut self, dt: f64, far: bool) {
        let end = self.time + dt;
        let poses = [self.time, end, end + self.time_for(LOOK_AHEAD * self.grid.voxel)];
        let poses = poses.map(|time| self.pose(time, self.motion.travel));
        let facing = Facing::of(poses[0].approach);
        let (window, _) = self.extent.window(self.pass.tool, &poses, facing, self.grid.voxel);
        let holds = |sheet: &Sheet| sheet.facing == facing && sheet.window.holds(&window, MARGIN);
        if !self.sheet.as_ref().is_some_and(holds) {
            self.write_back();
            self.read_sheet(dt, facing, far);
        }
        if let Some(sheet) = &self.sheet {
            self.step.look_at(Region::common(&sheet.window, &window));
        }
    }

    /// Time in which the tool moves by `way` [m]; 0 while it stands.
    fn time_for(&self, way: f64) -> f64 {
        let speed = self.pass.path.velocity(self.time).length();
        if speed > 0.0 { way / speed } else { 0.0 }
    }

    /// Reads a sheet that holds the contact for the next steps; `far` to seek the surface from the air.
    fn read_sheet(&mut self, dt: f64, facing: Facing, far: bool) {
        let Pass { tool, process, .. } = self.pass;
        let start = self.pose(self.time, self.motion.travel);
        let (window, lowest) = self.next_window(dt, facing);
        let level = facing.sheet(start.centre - start.frame.z * tool.drop()).z;
        let below = if far || self.in_air() || !self.physics.grinds() {
            2.0 * process.search_reach
        } else {
            NEAR_BELOW * self.grid.voxel
        };
        let falling = (-self.motion.speed).max(0.0) * LONGEST_STEP.max(dt);
        let before = self.last_sheet.take().filter(|sheet| sheet.facing == facing);
        let levels = (level, lowest.min(level) - below - falling);
        self.sheet = Some(Sheet::read_beside(before.as_ref(), self.grid, facing, window, levels));
        self.physics.lap(Phase::Read);
    }

    /// The window of the next sheet, and its lowest corner [m up]: of a surface that stays as it was read, as much as the tool
    /// will meet and a sheet may hold.
    fn next_window(&self, dt: f64, facing: Facing) -> (Window, f64) {
        let Pass { tool, path, .. } = self.pass;
        let until_written = self.time_for(self.commit_way() + self.step_way() + LOOK_AHEAD * self.grid.voxel);
        let window = |extent: &Extent, ahead: f64, count: f64| {
            let pose = |share: f64| self.pose(self.time + dt + ahead * share, self.motion.travel);
            let start = self.pose(self.time, self.motion.travel);
            let poses: Vec<Pose> =
                std::iter::once(start).chain((0..=count as usize).map(|k| pose(k as f64 / count))).collect();
            extent.window(tool, &poses, facing, self.grid.voxel)
        };
        if self.physics.grinds() {
            return window(&self.extent, until_written, (self.commit_way() / self.step_way()).ceil());
        }
        let extent = Extent::of(tool, 2.0 * self.grid.voxel).joined(&self.extent);
        let mut ahead = until_written.max(path.duration() - self.time - dt);
        loop {
            let found = window(&extent, ahead, (ahead / LONGEST_STEP).ceil().max(1.0));
            if ahead <= until_written || found.0.lines() <= MOST_LINES {
                return found;
            }
            ahead = (0.5 * ahead).max(until_written);
        }
    }
}
