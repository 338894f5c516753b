//! A log as the path of the tool: poses over time, contact, feed.

use glam::DVec3;
use robot::LogRow;

use super::log::Log;
use super::{HeldTool, Pass};
use crate::measure::{MAD_TO_SIGMA, median};

/// Force above noise that counts as contact [robust standard deviations].
pub(super) const NOISE_SIGMAS: f64 = 5.0;
/// Range of the contact threshold, as shares of the setpoint.
const CONTACT_SHARE: (f64, f64) = (0.05, 0.5);
/// Number of consecutive rows above the threshold that make a contact.
pub(super) const CONTACT_ROWS: usize = 3;
/// Length of a gap between rows that counts as a jump of the clock [median periods].
const JUMP_PERIODS: f64 = 5.0;

/// Pose of the tool at a time.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ToolPose {
    /// Time since the first row [s].
    pub time: f64,
    /// Centre of a wheel or of a pad's face [m].
    pub centre: DVec3,
    /// Approach axis, unit, out of the part.
    pub approach: DVec3,
    /// Axis about which the tool spins, unit: the wheel's, across the approach axis; a pad's is the approach axis.
    pub axis: DVec3,
    /// Logged force [N].
    pub force: f64,
    /// Logged spindle speed [rad/s].
    pub spindle_speed: f64,
}

/// Interval of contact, since the first row.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Contact {
    /// First contact [s].
    pub start: f64,
    /// End of contact [s].
    pub end: f64,
}

/// A gap between rows.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ClockJump {
    /// Index of the row after the gap.
    pub row: usize,
    /// Its time since the first row [s].
    pub time: f64,
    /// Length of the gap [s].
    pub gap: f64,
}

/// A log as the path of a tool.
#[derive(Clone, Debug, PartialEq)]
pub struct ToolPath {
    /// One pose per row, times from 0 and increasing.
    pub poses: Vec<ToolPose>,
    /// Interval of contact; `None` if the tool never touched.
    pub contact: Option<Contact>,
    /// Median speed across the approach axis in motion [m/s].
    pub feed: f64,
    /// Gaps between rows, in order.
    pub jumps: Vec<ClockJump>,
}

/// Motion of the tool over a whole log.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Motion {
    /// Median speed across the approach axis in motion [m/s].
    pub(super) feed: f64,
    /// Direction from the first to the last row, unit; +x if the tool returned.
    pub(super) direction: DVec3,
    /// Median spindle speed [rad/s].
    pub(super) spindle_speed: f64,
    /// Median force in contact [N]: of the rows above half of the 95th percentile.
    pub(super) force: f64,
}

impl Pass {
    /// The pass's log as the path of `tool`.
    pub fn tool_path(&self, tool: &HeldTool) -> ToolPath {
        ToolPath::of(&self.log, tool, self.force_setpoint)
    }
}

impl ToolPath {
    /// A log as the path of a tool that was pressed on with `force_setpoint` [N].
    pub fn of(log: &Log, tool: &HeldTool, force_setpoint: f64) -> Self {
        let start = log.rows.first().map_or(0.0, |row| row.time);
        let poses: Vec<ToolPose> = log.rows.iter().map(|row| pose(row, tool, start)).collect();
        let contact = contact(&poses, force_setpoint);
        Self { contact, feed: Motion::of(log).feed, jumps: jumps(&poses), poses }
    }

    /// Time from the first to the last row [s].
    pub fn duration(&self) -> f64 {
        self.poses.last().map_or(0.0, |pose| pose.time)
    }

    /// The pose at a time [s], linear between rows and constant beyond the ends.
    pub fn at(&self, time: f64) -> ToolPose {
        let after = self.poses.partition_point(|pose| pose.time < time).clamp(1, self.poses.len() - 1);
        let (a, b) = (&self.poses[after - 1], &self.poses[after]);
        let t = ((time - a.time) / (b.time - a.time)).clamp(0.0, 1.0);
        ToolPose {
            time,
            centre: a.centre.lerp(b.centre, t),
            approach: a.approach.lerp(b.approach, t).normalize(),
            axis: a.axis.lerp(b.axis, t).normalize(),
            force: a.force + (b.force - a.force) * t,
            spindle_speed: a.spindle_speed + (b.spindle_speed - a.spindle_speed) * t,
        }
    }
}

fn pose(row: &LogRow, tool: &HeldTool, start: f64) -> ToolPose {
    let across = |axis: DVec3| axis.reject_from_normalized(row.approach).normalize_or(axis);
    let axis = tool.axis.map_or(row.approach, across);
    ToolPose {
        time: row.time - start,
        centre: row.position,
        approach: row.approach,
        axis,
        force: row.force,
        spindle_speed: row.spindle_speed,
    }
}

/// Interval from the first to the last run of rows whose force exceeds the noise.
fn contact(poses: &[ToolPose], force_setpoint: f64) -> Option<Contact> {
    let threshold = contact_threshold(poses.iter().map(|pose| pose.force), force_setpoint);
    let touches = |run: &[ToolPose]| run.iter().all(|pose| pose.force > threshold);
    let first = poses.windows(CONTACT_ROWS).position(touches)?;
    let last = poses.windows(CONTACT_ROWS).rposition(touches)? + CONTACT_ROWS - 1;
    Some(Contact { start: poses[first].time, end: poses[last].time })
}

/// Force above which the tool is in contact [N].
pub(super) fn contact_threshold(forces: impl Iterator<Item = f64> + Clone, force_setpoint: f64) -> f64 {
    let [least, most] = [CONTACT_SHARE.0, CONTACT_SHARE.1].map(|share| share * force_setpoint);
    (NOISE_SIGMAS * force_noise(forces)).clamp(least, most)
}

/// Robust standard deviation of the noise of consecutive forces [N].
pub(super) fn force_noise(forces: impl Iterator<Item = f64> + Clone) -> f64 {
    let steps = forces.clone().zip(forces.skip(1)).map(|(now, next)| (next - now).abs());
    // The difference of two rows has twice the variance of one.
    MAD_TO_SIGMA * median(steps.collect()).unwrap_or(0.0) / 2f64.sqrt()
}

fn jumps(poses: &[ToolPose]) -> Vec<ClockJump> {
    let gap = |pair: &[ToolPose]| pair[1].time - pair[0].time;
    let period = median(poses.windows(2).map(gap).collect()).unwrap_or(0.0);
    let long = poses.windows(2).enumerate().filter(|(_, pair)| gap(pair) > JUMP_PERIODS * period);
    long.map(|(k, pair)| ClockJump { row: k + 1, time: pair[1].time, gap: gap(pair) }).collect()
}

impl Motion {
    pub(super) fn of(log: &Log) -> Self {
        let speed = |pair: &[LogRow]| {
            let way = (pair[1].position - pair[0].position).reject_from_normalized(pair[1].approach);
            way.length() / (pair[1].time - pair[0].time)
        };
        let ends = log.rows.first().zip(log.rows.last());
        let way = ends.map_or(DVec3::ZERO, |(a, b)| (b.position - a.position).reject_from_normalized(a.approach));
        Self {
            feed: usual(log.rows.windows(2).map(speed).collect()),
            direction: way.try_normalize().unwrap_or(DVec3::X),
            spindle_speed: median(log.rows.iter().map(|row| row.spindle_speed).collect()).unwrap_or(0.0),
            force: usual(log.rows.iter().map(|row| row.force).collect()),
        }
    }
}

/// Median of the values above half of the 95th percentile: of a speed in motion, of a force in contact.
fn usual(mut values: Vec<f64>) -> f64 {
    values.sort_by(f64::total_cmp);
    let high = values.get(values.len() * 19 / 20).copied().unwrap_or(0.0);
    median(values[values.partition_point(|&value| value < 0.5 * high)..].to_vec()).unwrap_or(0.0)
}
