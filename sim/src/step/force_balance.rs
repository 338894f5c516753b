//! Solves for the tool's motion in a step, on a height field that is large enough for the contact.

use shaders::constants::LOOK_AHEAD;

use super::Runner;
use crate::clock::Phase;
use crate::control::{Found, Motion, Response};
use crate::extent::Extent;
use crate::height_field::{Facing, Window};
use crate::physics::Physics;
use crate::pose::{Placement, Pose};
use crate::region::Region;
use crate::scheme::{EndForce, WindowRequest};
use crate::settings::{LONGEST_STEP, Pass};
use effects::RunError;
use robot::Controller;

impl Runner<'_> {
    /// Motion in a step of `dt` [s], or of a shorter one if the controller moves too fast for that; `None` if it finds
    /// no surface to press on. Returns the step's length [s] as well. Afterwards the scheme holds the step with that
    /// motion, on a height field that is large enough.
    pub(super) fn find_balance(&mut self, mut dt: f64) -> Result<(Option<Motion>, f64), RunError> {
        loop {
            dt = self.guide.foreseen_step(&mut self.physics, self.scheme.is_mean(), dt)?;
            match self.find_motion(dt)? {
                Found::Balance(motion) => return Ok((Some(motion), self.guide.take_step(dt))),
                Found::Nothing => return Ok((None, dt)),
                Found::TooFast => dt = self.guide.shorter_step(dt),
            }
        }
    }

    /// The same in a step of exactly `dt` [s].
    fn find_motion(&mut self, dt: f64) -> Result<Found<Motion>, RunError> {
        let mut searched = false;
        loop {
            self.choose_height_field(dt, searched);
            let found = self.try_motion(dt)?;
            if found.balance().is_some()
                && self.scheme.reaches_border(self.workpiece.height_field())
                && let Some(extent) = self.workpiece.extent.grown(self.pass.tool, self.workpiece.grid.voxel)
            {
                self.write_back();
                self.workpiece.extent = extent;
                continue;
            }
            if found == Found::Nothing && !searched && self.guide.controller == Controller::Ideal {
                self.write_back();
                self.workpiece.expect_touch(self.pass.tool);
                searched = true;
                continue;
            }
            return Ok(found);
        }
    }

    fn try_motion(&mut self, dt: f64) -> Result<Found<Motion>, RunError> {
        let begins = self.guide.controller == Controller::Ideal && !self.scheme.goes_on();
        if self.guide.is_in_air() || begins {
            // An ideal controller is balanced from the first touch on, and again on every new height field: the heights
            // read from the field differ slightly from those that were written, most of all beside side faces.
            let found = self.try_step(0.0)?;
            let Some(motion) = found.balance() else { return Ok(found) };
            self.guide.motion.travel = motion.travel;
        }
        self.try_step(dt)
    }

    /// Solves for the motion at the end of a step of `dt` [s].
    fn try_step(&mut self, dt: f64) -> Result<Found<Motion>, RunError> {
        let Self { pass: Pass { tool, .. }, guide, workpiece, scheme, physics, .. } = self;
        let (start, height_field, from) =
            (Placement::still(tool, guide.here()), workpiece.height_field(), guide.motion);
        let place = scheme.measured(tool, guide.time..guide.time + dt, &|time| guide.pose(time, 0.0));
        scheme.begin(&start, height_field, physics)?;
        let is_mean = scheme.is_mean();
        let mut force_at = |physics: &mut Physics, travel: f64| {
            let place = Placement { pose: place.pose.lifted(travel), ..place };
            let force = scheme.force_at(&place, height_field, physics, dt)?;
            let depth = if force.force > 0.0 { 0.0 } else { scheme.gap(&place, height_field) };
            Ok((force, depth))
        };
        if let Some(motion) = guide.blind_motion(physics, dt)? {
            guide.tried = force_at(physics, motion.travel)?.0;
            return Ok(Found::Balance(motion));
        }
        let balance = guide.balance(physics, is_mean, dt)?;
        // A static contact has the slope of its stiffness.
        let mut scale = if dt > 0.0 { guide.scale } else { 1.0 };
        let mut force = EndForce::default();
        let found = balance.solve(balance.foreseen(), &mut scale, |travel| {
            let (end, depth) = force_at(physics, travel)?;
            force = end;
            Ok(Response { force: physics.force_reading(end.force)?, stiffness: end.stiffness, depth })
        })?;
        guide.tried = force;
        if dt > 0.0 {
            guide.scale = scale;
        }
        guide.is_too_soft |= found == Found::Nothing && force.force > 0.0;
        let speed = |travel: f64| if dt > 0.0 { (travel - from.travel) / dt } else { 0.0 };
        Ok(found.map(|travel| Motion { travel, speed: speed(travel) }))
    }

    /// Ensures a height field that contains the contact of a step of `dt` [s], and sets the scheme's region in it;
    /// `far` to search for the surface from the air.
    fn choose_height_field(&mut self, dt: f64, far: bool) {
        let Self { pass: Pass { tool, .. }, guide, workpiece, .. } = &*self;
        let voxel = workpiece.grid.voxel;
        let end = guide.time + dt;
        let poses = [guide.time, end, end + guide.time_for(LOOK_AHEAD * voxel)];
        let poses = poses.map(|time| guide.pose(time, guide.motion.travel));
        let facing = Facing::of(poses[0].approach);
        let (window, _) = workpiece.extent.window(tool, &poses, facing, voxel);
        if !workpiece.holds(facing, &window) {
            self.write_back();
            self.read_height_field(dt, facing, far);
        }
        self.scheme.look_at(Region::common(&self.workpiece.height_field().window, &window));
    }

    /// Reads a height field that contains the contact of the next steps; `far` to search for the surface from the air.
    fn read_height_field(&mut self, dt: f64, facing: Facing, far: bool) {
        let Pass { tool, settings, .. } = self.pass;
        let (start, voxel) = (self.guide.here(), self.workpiece.grid.voxel);
        let (window, lowest) = self.next_window(dt, facing);
        let level = facing.height_field(start.centre - start.frame.z * tool.drop()).z;
        let below = if far || self.guide.is_in_air() {
            2.0 * settings.search_reach
        } else {
            self.scheme.below(settings.search_reach, voxel)
        };
        let falling = (-self.guide.motion.speed).max(0.0) * LONGEST_STEP.max(dt);
        self.workpiece.read(facing, window, (level, lowest.min(level) - below - falling));
        self.physics.lap(Phase::Read);
    }

    /// The window of the next height field, and its lowest corner [m up].
    fn next_window(&self, dt: f64, facing: Facing) -> (Window, f64) {
        let Self { pass: Pass { tool, path, .. }, guide, workpiece, step_limits, .. } = self;
        let voxel = workpiece.grid.voxel;
        let window = |extent: &Extent, ahead: f64, count: f64| {
            let pose = |share: f64| guide.pose(guide.time + dt + ahead * share, guide.motion.travel);
            let poses: Vec<Pose> =
                std::iter::once(guide.here()).chain((0..=count as usize).map(|k| pose(k as f64 / count))).collect();
            extent.window(tool, &poses, facing, voxel)
        };
        self.scheme.next_window(&WindowRequest {
            tool,
            extent: workpiece.extent,
            voxel,
            step_limits,
            until_written: guide.time_for(step_limits.height_field_way + step_limits.step_way + LOOK_AHEAD * voxel),
            until_end: path.duration() - guide.time - dt,
            window: &window,
        })
    }
}
