//! Step-wide variables of the model's formulas: time, feed, and results of the previous step.

use crate::control::Motion;
use crate::pose::Pose;
use crate::scheme::AppliedRemoval;
use crate::settings::Pass;
use crate::step::AcceptedStep;
use crate::tool_cells::ToolCells;
use effects::{StepValues, Variable};
use robot::Tool;

/// Memory of a pass from step to step, for formulas.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Moment {
    rim_radius: f64,
    width: f64,
    face_area: f64,
    /// Time since the first contact [s], and the distance since then [m].
    contact_time: f64,
    path_position: f64,
    touched: bool,
    feed_speed: f64,
    length: f64,
    force: f64,
    area: f64,
    pressure_mean: f64,
    patch_width: f64,
    lift_speed: f64,
    lift_acceleration: f64,
    removal_rate: f64,
    dose_volume_rate: f64,
}

impl Moment {
    pub(crate) fn new(pass: &Pass) -> Self {
        Self {
            rim_radius: pass.tool.rim_radius(),
            width: pass.tool.width(),
            face_area: ToolCells::of(pass.tool).face_areas().iter().sum(),
            length: pass.path.length(),
            ..Self::default()
        }
    }

    /// Sets the variables known before a step that starts at `time` [s] with the tool at `nominal`.
    pub(crate) fn enter(&mut self, pass: &Pass, nominal: Pose, time: f64, step: &mut StepValues) {
        let velocity = pass.path.velocity(time).reject_from_normalized(nominal.approach);
        self.feed_speed = velocity.length();
        let feed = velocity.normalize_or_zero();
        let along = feed.dot(nominal.frame.x);
        step.pass_row = pass.row;
        let spindle = pass.settings.spindle_speed;
        // A wheel's rim moves along -x under its centre.
        let cutting =
            if matches!(pass.tool, Tool::Wheel(_)) && along != 0.0 { -(along * spindle).signum() } else { 0.0 };
        for (variable, value) in [
            (Variable::Time, time),
            (Variable::TrialTime, pass.trial_time + time),
            (Variable::PassNumber, pass.number as f64),
            (Variable::FeedSpeed, self.feed_speed),
            (Variable::FeedX, feed.x),
            (Variable::FeedY, feed.y),
            (Variable::FeedAlong, along),
            (Variable::FeedAcross, feed.dot(nominal.frame.y)),
            (Variable::CuttingDirection, cutting),
            (Variable::ForceSetpoint, pass.force_setpoint(time..time)),
            (Variable::SpindleSetpoint, spindle),
            (Variable::SpindleSpeed, spindle),
            (Variable::ToolRadius, self.rim_radius),
            (Variable::ToolWidth, self.width),
            (Variable::ToolFaceArea, self.face_area),
        ] {
            step.set(variable, value);
        }
        self.publish(step);
    }

    /// Sets the spindle speed [rad/s] that the model gives.
    pub(crate) fn set_spindle(&self, speed: f64, step: &mut StepValues) {
        step.set(Variable::SpindleSpeed, speed);
        step.set(Variable::SlidingSpeed, speed.abs() * self.rim_radius);
    }

    /// Records the results of a step; `before` is the tool's motion at its start, `patch_width` in [m].
    pub(crate) fn leave(&mut self, taken: &AcceptedStep, before: Motion, patch_width: f64) {
        let AcceptedStep { motion, dt, contact, applied: AppliedRemoval { removal, .. }, .. } = taken;
        let speed = (motion.travel - before.travel) / dt;
        self.lift_acceleration = (speed - self.lift_speed) / dt;
        self.lift_speed = speed;
        self.force = contact.force;
        self.area = contact.area;
        self.pressure_mean = contact.pressure_mean();
        self.patch_width = patch_width;
        self.removal_rate = removal.volume / dt;
        self.dose_volume_rate = removal.coating_volume / dt;
        self.touched |= contact.force > 0.0;
        if self.touched {
            self.contact_time += dt;
            self.path_position += self.feed_speed * dt;
        }
    }

    /// As [`Moment::leave`] for a step in the air.
    pub(crate) fn leave_air(&mut self) {
        *self = Self {
            force: 0.0,
            area: 0.0,
            pressure_mean: 0.0,
            patch_width: 0.0,
            lift_speed: 0.0,
            lift_acceleration: 0.0,
            removal_rate: 0.0,
            dose_volume_rate: 0.0,
            ..*self
        };
    }

    /// Sets the variables that describe the previous step.
    pub(crate) fn publish(&self, step: &mut StepValues) {
        for (variable, value) in [
            (Variable::ContactTime, self.contact_time),
            (Variable::PathPosition, self.path_position),
            (Variable::PathRemaining, (self.length - self.path_position).max(0.0)),
            (Variable::Force, self.force),
            (Variable::ContactArea, self.area),
            (Variable::PressureMean, self.pressure_mean),
            (Variable::PatchWidth, self.patch_width),
            (Variable::LiftSpeed, self.lift_speed),
            (Variable::LiftAcceleration, self.lift_acceleration),
            (Variable::RemovalRate, self.removal_rate),
            (Variable::DoseVolumeRate, self.dose_volume_rate),
        ] {
            step.set(variable, value);
        }
    }
}
