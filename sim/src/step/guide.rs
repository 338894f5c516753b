//! Motion of the tool: its position on the path, and the controller that sets its travel from there.

use shaders::constants::{APPROACH_STEP, FORCE_JUMP, INERTIA};

use crate::control::{Balance, Motion, StartContact, admittance_sample, end_weight};
use crate::physics::Physics;
use crate::pose::Pose;
use crate::scheme::EndForce;
use crate::settings::{LONGEST_STEP, Pass, PassSettings, TOUCH};
use effects::{PoseChange, RunError};
use robot::Controller;
use robot::LogRow;

/// Times closer than this are equal [s]; avoids a sliver step from rounding, which would shorten all later ones.
const CLOCK: f64 = 1e-9;
/// Relative tolerance of the force.
const FORCE_TOLERANCE: f64 = 1e-5;

/// Motion along the path under the controller of a pass.
pub(super) struct Guide<'a> {
    pass: Pass<'a>,
    /// Since the pass began [s].
    pub(super) time: f64,
    pub(super) motion: Motion,
    /// Controller at this time: [`Controller::Replay`] during the approach, then that of the settings.
    pub(super) controller: Controller,
    /// Offset and tilt that the model's effects add to the tool's pose.
    pub(super) pose_change: PoseChange,
    /// Length of the next step [s], where the controller limits it.
    limit: f64,
    /// Longest step that the effects on the controller allow [s].
    longest_step: f64,
    /// Force at the end of the last step, and of the trial step.
    end: EndForce,
    pub(super) tried: EndForce,
    /// Speed of the surface along the travel in the last step [m/s], from the change of the force.
    surface_speed: f64,
    /// Share of the stiffness that the last search for a balance has shown.
    pub(super) scale: f64,
    /// True if the tool touched and reached its search limit without reaching the setpoint.
    pub(super) is_too_soft: bool,
    /// Time at which the last step ends [s].
    pub(super) until: f64,
}

/// State of the controller between two stretches of a pass.
#[derive(Clone, Copy, Debug)]
pub(super) struct ControllerState {
    time: f64,
    motion: Motion,
    controller: Controller,
    limit: f64,
    end: EndForce,
    surface_speed: f64,
    scale: f64,
}

impl<'a> Guide<'a> {
    pub(super) fn new(pass: Pass<'a>, longest_step: f64) -> Self {
        let controller = if pass.approach > 0.0 { Controller::Replay } else { pass.settings.controller };
        let travel = if controller == Controller::Ideal { pass.settings.search_reach } else { 0.0 };
        Self {
            pass,
            time: 0.0,
            motion: Motion { travel, speed: 0.0 },
            controller,
            pose_change: PoseChange { offset: [0.0; 3], roll: 0.0, pitch: 0.0 },
            limit: LONGEST_STEP,
            longest_step,
            end: EndForce::default(),
            tried: EndForce::default(),
            surface_speed: 0.0,
            scale: 1.0,
            is_too_soft: false,
            until: pass.path.duration(),
        }
    }

    /// State to continue from in the next stretch.
    pub(super) fn course(&self) -> ControllerState {
        let Self { time, motion, controller, limit, end, surface_speed, scale, .. } = *self;
        ControllerState { time, motion, controller, limit, end, surface_speed, scale }
    }

    /// Continues from the end of the previous stretch.
    pub(super) fn take_up(&mut self, state: ControllerState) {
        let ControllerState { time, motion, controller, limit, end, surface_speed, scale } = state;
        (self.time, self.motion, self.controller, self.limit, self.end) = (time, motion, controller, limit, end);
        (self.surface_speed, self.scale) = (surface_speed, scale);
    }

    /// Pose of the tool from path and travel, without effects.
    pub(super) fn nominal(&self, time: f64, travel: f64) -> Pose {
        self.pass.path.at(time).pose(self.pass.tool).lifted(travel)
    }

    /// Pose of the tool with the model's effects.
    pub(super) fn pose(&self, time: f64, travel: f64) -> Pose {
        self.nominal(time, travel).changed(&self.pose_change)
    }

    /// The same at the current time.
    pub(super) fn here(&self) -> Pose {
        self.pose(self.time, self.motion.travel)
    }

    /// The same in the middle of a step of `dt` [s].
    pub(super) fn middle(&self, motion: Motion, dt: f64) -> Pose {
        self.pose(self.time + 0.5 * dt, 0.5 * (self.motion.travel + motion.travel))
    }

    /// Time in which the tool moves by `way` [m]; 0 at rest.
    pub(super) fn time_for(&self, way: f64) -> f64 {
        let speed = self.pass.path.velocity(self.time).length();
        if speed > 0.0 { way / speed } else { 0.0 }
    }

    /// True if an ideal controller has lifted the tool to the end of the search reach, away from the part.
    pub(super) fn is_in_air(&self) -> bool {
        self.controller == Controller::Ideal && self.motion.travel >= self.pass.settings.search_reach
    }

    /// True during the approach, in which the tool follows its path down to the part.
    fn comes_down(&self) -> bool {
        self.pass.approach - self.time > CLOCK
    }

    /// Ends the approach when its time is over, or when the `force` [N] shows a touch.
    pub(super) fn take_over(&mut self, force: f64) {
        let Pass { settings, .. } = self.pass;
        let touches = force > TOUCH * settings.force_setpoint;
        if self.controller != settings.controller && (touches || !self.comes_down()) {
            self.controller = settings.controller;
        }
    }

    /// Time between the controller's samples [s].
    fn period(&self) -> f64 {
        match self.controller {
            Controller::Admittance { period, .. } => period,
            _ => f64::INFINITY,
        }
    }

    /// Length of the next step [s]; `on_piece` [s] is the longest allowed on this segment of the path.
    pub(super) fn step_length(&self, on_piece: f64) -> f64 {
        let mut dt = on_piece.min(self.limit).min(self.longest_step).min(self.rest());
        if !self.pass.settings.quasi_static {
            dt = dt.min(self.period());
        }
        if self.comes_down() {
            dt = dt.min(APPROACH_STEP).min(self.pass.approach - self.time);
        }
        dt
    }

    /// Time until the last step ends [s].
    fn rest(&self) -> f64 {
        self.until - self.time
    }

    /// The longest step up to `dt` [s] in which an admittance controller is not foreseen to move too fast.
    pub(super) fn foreseen_step(&self, physics: &mut Physics, is_mean: bool, mut dt: f64) -> Result<f64, RunError> {
        while dt > self.period() && self.balance(physics, is_mean, dt)?.is_foreseen_too_fast() {
            dt = self.shorter_step(dt);
        }
        Ok(dt)
    }

    /// The step to be tried after one of `dt` [s] in which the controller moves too fast.
    pub(super) fn shorter_step(&self, dt: f64) -> f64 {
        (0.25 * dt).max(self.period())
    }

    /// Accepts a step of `dt` [s]: the next may be up to twice as long. Returns its length, extended to the end of the
    /// pass if that is near.
    pub(super) fn take_step(&mut self, dt: f64) -> f64 {
        self.limit = 2.0 * dt;
        let rest = self.rest();
        if rest - dt < CLOCK { rest } else { dt }
    }

    /// Motion in a step of `dt` [s] that does not depend on the force at its end: replay, or one sample of an
    /// admittance controller.
    pub(super) fn blind_motion(&self, physics: &mut Physics, dt: f64) -> Result<Option<Motion>, RunError> {
        match self.controller {
            Controller::Replay => Ok(Some(Motion::default())),
            Controller::Admittance { mass, damping, period } if dt <= period * (1.0 + 1e-9) => {
                let reading = physics.force_reading(self.end.force)?;
                let setpoint = self.pass.force_setpoint(self.time..self.time + dt);
                Ok(Some(admittance_sample(self.motion, reading, setpoint, (mass, damping), dt)))
            }
            _ => Ok(None),
        }
    }

    /// The balance that the controller seeks in a step of `dt` [s], Eq. (6). `is_mean`: forces are means over the step.
    pub(super) fn balance(&self, physics: &mut Physics, is_mean: bool, dt: f64) -> Result<Balance, RunError> {
        let PassSettings { force_setpoint, search_reach, .. } = *self.pass.settings;
        let (damping, mass) = match self.controller {
            Controller::Admittance { mass, damping, .. } => (damping, mass),
            Controller::Ideal | Controller::Replay => (0.0, 0.0),
        };
        let EndForce { force, stiffness } = self.end;
        let start = StartContact { force: physics.force_reading(force)?, stiffness, surface_speed: self.surface_speed };
        // A contact that has just begun has no stiffness, so the decay of the force is unknown.
        let is_fitted = !is_mean && damping > 0.0 && stiffness > 0.0;
        let weight = if is_fitted { end_weight(dt * stiffness / (damping + mass / dt)) } else { 1.0 };
        // A force at the end stands for the mean over an interval about the end; the mean over the step is that of its
        // two ends.
        let begin = if is_mean { self.time } else { self.time + 0.5 * dt };
        let held = begin..begin + dt;
        Ok(Balance {
            from: self.motion,
            start,
            setpoint: self.pass.force_setpoint(held),
            damping,
            mass,
            dt,
            weight,
            tolerance: FORCE_TOLERANCE * force_setpoint,
            bounds: (-search_reach, search_reach),
            allowed: (dt > self.period()).then_some((FORCE_JUMP * force_setpoint, INERTIA * force_setpoint)),
        })
    }

    /// Advances to the end of a step of `dt` [s]. Returns the distance moved by the tool [m].
    pub(super) fn follow(&mut self, motion: Motion, dt: f64) -> f64 {
        let way = self.nominal(self.time + dt, 0.0).centre - self.nominal(self.time, 0.0).centre;
        let (before, after) = (self.end, self.tried);
        let is_held = before.stiffness > 0.0 && after.stiffness > 0.0;
        self.surface_speed =
            if is_held { motion.speed + (after.force - before.force) / (after.stiffness * dt) } else { 0.0 };
        self.motion = motion;
        self.end = after;
        self.time += dt;
        way.length()
    }

    /// Waits in the air for `dt` [s].
    pub(super) fn stay_in_air(&mut self, dt: f64) {
        self.motion = Motion { travel: self.pass.settings.search_reach, speed: 0.0 };
        self.time += dt;
    }

    /// Row of the log at this time, for a force [N] and a spindle speed [rad/s].
    pub(super) fn log_row(&self, force: f64, spindle_speed: f64) -> LogRow {
        let pose = self.nominal(self.time, self.motion.travel);
        LogRow { time: self.time, position: pose.centre, approach: pose.approach, force, spindle_speed }
    }
}
