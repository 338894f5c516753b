//! Offset of a trial's logs from the frame of its scans and the clock of its forces.

use glam::{DQuat, DVec2, DVec3};
use robot::LogRow;

use super::log::Log;
use super::{HeldTool, Pass, Trial};

/// Transform of logged poses from the robot's frame and clock to those of scans and forces.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct FrameOffset {
    /// Shift along x and y [m].
    pub shift: DVec2,
    /// Rotation about z, before the shift [rad].
    pub yaw: f64,
    /// Centre of the rotation [m].
    pub about: DVec2,
    /// Time by which a logged pose is later than the force in its row [s].
    pub lag: f64,
}

/// Prior standard deviations of the errors of a robot's frame and clock; 0 means exact.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct FrameErrors {
    /// Shift of the frame along x and y [m].
    pub shift: f64,
    /// Turn of the frame about z [rad].
    pub yaw: f64,
    /// Delay of the poses behind the forces [s].
    pub lag: f64,
}

impl Default for FrameErrors {
    /// Typical errors of robot calibration, 0.1 to 1 mm, and of logging, up to 0.2 s (the sources of `path-offset` and
    /// `clock-offset`).
    fn default() -> Self {
        Self { shift: 0.5e-3, yaw: 5e-3, lag: 0.1 }
    }
}

impl FrameOffset {
    /// The composition of this transform and a further one. Angles are small: their products with shifts are neglected.
    #[must_use]
    pub fn and(&self, more: &Self) -> Self {
        Self {
            shift: self.shift + more.shift,
            yaw: self.yaw + more.yaw,
            about: if self.yaw == 0.0 { more.about } else { self.about },
            lag: self.lag + more.lag,
        }
    }

    /// Root mean square displacement of the poses of logs by this offset [m], each weighted by its force, because the
    /// scans show the tool only where it presses; NaN if it presses nowhere. A shift along a steady feed and the
    /// opposite delay cancel.
    pub fn displacement<'a>(&self, logs: impl Iterator<Item = &'a Log>) -> f64 {
        let (mut squares, mut forces) = (0.0, 0.0);
        for log in logs {
            for (row, moved) in log.rows.iter().zip(self.of_log(log).rows) {
                let force = row.force.max(0.0);
                squares += force * row.position.distance_squared(moved.position);
                forces += force;
            }
        }
        (squares / forces).sqrt()
    }

    /// Transforms the poses of a log; forces and all other columns keep their times.
    pub fn of_log(&self, log: &Log) -> Log {
        let turn = DQuat::from_rotation_z(self.yaw);
        let about = self.about.extend(0.0);
        let row = |row: &LogRow| {
            let (position, approach) = pose_at(&log.rows, row, row.time + self.lag);
            let position = about + turn * (position - about) + self.shift.extend(0.0);
            LogRow { position, approach: turn * approach, ..*row }
        };
        Log { rows: log.rows.iter().map(row).collect(), ..log.clone() }
    }

    /// Transforms the logs of all passes of a trial as it was read.
    pub fn of_trial(&self, trial: &Trial) -> Trial {
        let turn = DQuat::from_rotation_z(self.yaw);
        let moved =
            |pass: &Pass| Pass { log: self.of_log(&pass.log), direction: turn * pass.direction, ..pass.clone() };
        Trial {
            passes: trial.passes.iter().map(moved).collect(),
            tool: self.of_tool(&trial.tool),
            frame_offset: *self,
            ..trial.clone()
        }
    }

    /// Rotates the axis of a tool.
    pub fn of_tool(&self, tool: &HeldTool) -> HeldTool {
        let axis = tool.axis.map(|axis| DQuat::from_rotation_z(self.yaw) * axis);
        HeldTool { axis, ..tool.clone() }
    }
}

/// Position and approach axis at a time, linear between rows and extrapolated beyond the ends; those of `own` at its
/// own time.
fn pose_at(rows: &[LogRow], own: &LogRow, time: f64) -> (DVec3, DVec3) {
    if time == own.time || rows.len() < 2 {
        return (own.position, own.approach);
    }
    let after = rows.partition_point(|row| row.time < time).clamp(1, rows.len() - 1);
    let (a, b) = (&rows[after - 1], &rows[after]);
    let t = (time - a.time) / (b.time - a.time);
    let approach = a.approach.lerp(b.approach, t.clamp(0.0, 1.0));
    (a.position.lerp(b.position, t), approach.try_normalize().unwrap_or(own.approach))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn log() -> Log {
        let row = |k: usize| LogRow {
            time: 1.0 + 0.01 * k as f64,
            position: DVec3::new(1e-4 * k as f64, 2e-3, 0.05),
            force: k as f64,
            spindle_speed: 600.0,
            approach: DVec3::Z,
        };
        Log { rows: (0..20).map(row).collect(), ..Log::default() }
    }

    #[test]
    fn a_log_that_is_not_off_keeps_every_bit() {
        assert_eq!(FrameOffset { about: DVec2::new(0.3, 0.1), ..FrameOffset::default() }.of_log(&log()).rows.len(), 20);
        assert_eq!(FrameOffset::default().of_log(&log()), log());
    }

    #[test]
    fn a_shift_along_the_feed_cancels_a_delay_where_the_tool_presses() {
        let delay = FrameOffset { lag: 0.025, ..FrameOffset::default() };
        let both = FrameOffset { shift: DVec2::new(-2.5e-4, 0.0), ..delay };
        assert!(both.displacement([&log()].into_iter()) < 1e-12);
        let mut back = log();
        back.rows.iter_mut().for_each(|row| row.position.x *= -1.0);
        assert!((both.displacement([&back].into_iter()) - 5e-4).abs() < 1e-12);
        let there_and_back = both.displacement([&log(), &back].into_iter());
        assert!((there_and_back - 5e-4 / 2f64.sqrt()).abs() < 1e-12, "{there_and_back}");
        // Most of its rows are at rest in the air.
        let mut waits = log();
        let rest = |k: usize| LogRow { time: 0.01 * k as f64, force: 0.0, ..waits.rows[0] };
        waits.rows = (0..100).map(rest).chain(waits.rows.clone()).collect();
        assert!((delay.displacement([&waits].into_iter()) - 2.5e-4).abs() < 1e-12);
        assert!(both.displacement([&waits].into_iter()) < 1e-12);
        waits.rows.truncate(100);
        assert!(delay.displacement([&waits].into_iter()).is_nan());
    }

    #[test]
    fn poses_are_turned_shifted_and_taken_from_a_later_time() {
        let about = DVec2::new(1e-3, 2e-3);
        let frame_offset = FrameOffset { shift: DVec2::new(3e-4, -2e-4), yaw: 0.01, about, lag: 0.025 };
        let moved = frame_offset.of_log(&log());
        for (k, row) in moved.rows.iter().enumerate() {
            let arm = 1e-4 * (k as f64 + 2.5) - 1e-3;
            let place = DVec3::new(1e-3 + arm * 0.01f64.cos() + 3e-4, 2e-3 + arm * 0.01f64.sin() - 2e-4, 0.05);
            assert!(row.position.distance(place) < 1e-12, "{k}: {}", row.position);
            assert_eq!((row.force, row.time), (k as f64, 1.0 + 0.01 * k as f64));
        }
    }
}
