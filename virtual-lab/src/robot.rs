//! The virtual robot and its log of a pass. The log holds the planned pose, the controller's force reading, and the
//! commanded speed.

use glam::{DVec2, DVec3};
use sim::PassRecord;

use super::frame::Frame;
use super::motion::Route;
use super::ripple::Ripple;
use random::Stream;
use robot::{Controller, LogRow, Tool};
use trials::trial::{Log, RPM};

/// Time between two rows [s]: 100 Hz.
const PERIOD: f64 = 0.01;
/// Speed of the descent [m/s].
const APPROACH_SPEED: f64 = 2e-3;
/// Height above the surface at which the log begins [m].
const CLEARANCE: f64 = 0.5e-3;
/// Speed of the retraction at the end [m/s], and time for which the log continues [s].
const RETRACT: (f64, f64) = (20e-3, 0.15);
/// Resolution of the logged places [m], forces [N] and speeds [rpm].
const STEPS: (f64, f64, f64) = (1e-6, 0.01, 1.0);

/// Sizes of the robot's errors.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Robot {
    /// Noise of the force sensor, standard deviation [N].
    pub force_noise: f64,
    /// Noise of the spindle's tachometer, standard deviation [rpm].
    pub speed_noise: f64,
    /// Noise of the logged place along x, y and z, standard deviation [m].
    pub pose_jitter: f64,
    /// Lateral deviation of the tool from the planned line, absent from the log [m].
    pub wander: f64,
    /// Correlation length of this deviation [m].
    pub wander_length: f64,
    /// Offset of the logged places in the scans' frame [m]; its direction is drawn for each campaign.
    pub frame_shift: f64,
    /// Rotation of the robot's frame about the scan's centre [rad]; its sign is drawn for each campaign.
    pub frame_turn: f64,
    /// Delay by which a logged place is older than the force in the same row [s].
    pub pose_delay: f64,
    /// Ripple of the true force about the force that the controller holds, relative standard deviation [1]; the log
    /// shows it.
    pub force_ripple: f64,
}

impl Robot {
    /// Small errors.
    pub fn clean() -> Self {
        Self {
            force_noise: 0.2,
            speed_noise: 4.0,
            pose_jitter: 2e-6,
            wander: 5e-6,
            wander_length: 8e-3,
            frame_shift: 0.0,
            frame_turn: 0.0,
            pose_delay: 0.0,
            force_ripple: 0.0,
        }
    }

    /// Larger errors of every kind.
    pub fn hard() -> Self {
        Self { force_noise: 0.4, pose_jitter: 5e-6, wander: 20e-6, ..Self::clean() }
    }

    /// Start and end heights of the search for the touch, above its expected height [m], and the speed [m/s].
    pub(super) fn descent() -> ([f64; 2], f64) {
        ([CLEARANCE, -CLEARANCE], APPROACH_SPEED)
    }

    /// The log of a pass.
    pub(super) fn log(&self, pass: &PassRun, stream: &mut Stream) -> Log {
        let end = pass.touch + pass.way.duration();
        let rows = ((end + RETRACT.1) / PERIOD).floor() as usize;
        let row = |k: usize| {
            let time = k as f64 * PERIOD;
            let posed = time - self.pose_delay;
            let level = pass.level(posed.min(end)) + RETRACT.0 * (posed - end).max(0.0);
            let mut jitter = || self.pose_jitter * stream.normal();
            let jitter = DVec3::new(jitter(), jitter(), jitter());
            let force = if time > end { 0.0 } else { pass.force_reading(time) };
            let force = force + self.force_noise * stream.normal();
            let rpm = pass.spindle_speed / RPM + self.speed_noise * stream.normal();
            let place = pass.frame.logged(pass.way.at(posed - pass.touch)).extend(level) + jitter;
            LogRow {
                // A rounded product of two decimals equals the decimal in the file.
                time: (time * 1e6).round() / 1e6,
                position: (place / STEPS.0).round() * STEPS.0,
                force: (force / STEPS.1).round() * STEPS.1,
                spindle_speed: (rpm / STEPS.2).round() * STEPS.2 * RPM,
                approach: DVec3::Z,
            }
        };
        Log { rows: (0..=rows).map(row).collect(), ..Log::default() }
    }
}

/// True motion and force of a pass.
pub(super) struct PassRun<'a> {
    /// The simulated pass.
    pub(super) record: &'a PassRecord,
    /// The commanded route.
    pub(super) way: &'a Route,
    /// Time at which the force reaches the share of the setpoint at which the feed starts [s].
    pub(super) touch: f64,
    /// Controller of the force.
    pub(super) controller: Controller,
    /// Force setpoint [N].
    pub(super) force_setpoint: f64,
    /// Commanded spindle speed [rad/s].
    pub(super) spindle_speed: f64,
    /// The robot's frame.
    pub(super) frame: Frame,
    /// Force ripple that the controller does not follow; `None` without one.
    pub(super) ripple: Option<Ripple>,
}

impl PassRun<'_> {
    /// The two logged values around a time, and the interpolation weight of the second.
    fn around(&self, time: f64) -> (&robot::LogRow, &robot::LogRow, f64) {
        // The record ends with a row in the air, which a robot would not have at this time.
        let end = self.record.log.iter().rposition(|row| row.force > 0.0).map_or(0, |last| last + 1);
        let log = &self.record.log[..end.max(2)];
        let after = log.partition_point(|row| row.time < time).clamp(1, log.len() - 1);
        let (a, b) = (&log[after - 1], &log[after]);
        (a, b, ((time - a.time) / (b.time - a.time)).clamp(0.0, 1.0))
    }

    /// Height of the tool's reference point [m].
    fn level(&self, time: f64) -> f64 {
        let (a, b, t) = self.around(time);
        a.position.z + (b.position.z - a.position.z) * t
    }

    /// Reading of the force sensor [N]: the force that the controller followed, with the ripple that it did not follow.
    fn force_reading(&self, time: f64) -> f64 {
        self.followed(time) * self.ripple.as_ref().map_or(1.0, |ripple| 1.0 + ripple.at(time))
    }

    /// Force that the controller followed [N], as a mean since the row before. It is computed from the tool's motion by
    /// the controller's law `mass · z'' = (F - setpoint) - damping · z'`; before the touch it is the simulated force.
    fn followed(&self, time: f64) -> f64 {
        let since = (time - PERIOD).max(self.touch);
        let Controller::Admittance { mass, damping, .. } = self.controller else {
            return if time < self.touch { 0.0 } else { self.force_setpoint };
        };
        if time - since < 0.1 * PERIOD {
            let (a, b, t) = self.around(time);
            return a.force + (b.force - a.force) * t;
        }
        let speed =
            |from: f64, to: f64| if to > from { (self.level(to) - self.level(from)) / (to - from) } else { 0.0 };
        let (now, before) = (speed(since, time), speed((since - PERIOD).max(self.touch), since));
        (self.force_setpoint + damping * now + mass * (now - before) / (time - since)).max(0.0)
    }
}

/// Height of a tool's reference point at which it touches a surface from above [m].
///
/// - `height`: height of the surface [m], by place [m]
pub(super) fn touching(tool: &Tool, place: DVec2, step: f64, height: impl Fn(DVec2) -> f64) -> f64 {
    let (along, across) = tool.half_footprint(CLEARANCE);
    let (nx, ny) = ((along / step).ceil() as i32, (across / step).ceil() as i32);
    let points = (-ny..=ny).flat_map(|j| (-nx..=nx).map(move |i| step * DVec2::new(f64::from(i), f64::from(j))));
    let reach = |at: DVec2| match tool {
        Tool::Wheel(wheel) => (wheel.radius * wheel.radius - at.x * at.x).max(0.0).sqrt(),
        _ => 0.0,
    };
    points.map(|at| height(place + at) + reach(at)).fold(f64::NEG_INFINITY, f64::max)
}
