//! A logged pass as a path for the simulation, with the times of the controller's takeover and of the lift-off.

use glam::DVec3;
use robot::{Controller, Tool};
use sim::settings::TOUCH;
use sim::{ForceProfile, Path, PathError, PathSample};
use trials::trial::{Contact, ForceInput, HeldTool, Log, Pass, ToolPath, ToolPose, Trial};

/// Number of log rows from which the speed of descent is computed, enough to average out jitter.
const DESCENT_ROWS: usize = 8;
/// Share of the setpoint to which lower logged forces are raised: smaller values are the sensor's noise.
const LEAST_FORCE: f64 = 1e-3;

/// Shifts of a pass's beginning and end relative to the assumed ones [rows of the log]; each lies between two rows.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct PassEnds {
    /// Shift of the controller's takeover.
    pub taken_over: f64,
    /// Shift of the lift-off.
    pub lifted: f64,
}

/// A logged pass: poses, the time of the controller's takeover, and the pose at its end.
pub(super) struct LoggedPass {
    poses: ToolPath,
    /// Time of the controller's takeover [s].
    pub(super) taken_over: f64,
    end: Option<ToolPose>,
}

impl LoggedPass {
    /// - a log, and the force setpoint of its pass [N]
    pub(super) fn new((log, force_setpoint): (&Log, f64), tool: &HeldTool, ends: PassEnds) -> Self {
        let poses = ToolPath::of(log, tool, force_setpoint);
        let row = row_period(&poses);
        let taken_over = (handed_over(&poses, force_setpoint) + ends.taken_over * row).max(0.0);
        let contact = contact(&poses);
        let end = lifted_off(&poses, contact, (ends.lifted, row)).filter(|end| end.time > contact.end);
        Self { poses, taken_over, end }
    }

    /// The logged path up to the end of contact. A controller finds its own height from its takeover on: from there its
    /// path stays at the height to which the tool had descended.
    pub(super) fn path(&self, tool: &Tool, controller: Controller) -> Result<Path, PathError> {
        let touch = come_down(&self.poses, self.taken_over);
        let contact = contact(&self.poses);
        let poses = self.poses.poses.iter().take_while(|pose| pose.time <= contact.end).chain(&self.end);
        let samples = poses.map(|pose| {
            let leads = controller == Controller::Replay || pose.time < self.taken_over;
            let height = if leads { 0.0 } else { (pose.centre - touch).dot(pose.approach) };
            let across = match tool {
                Tool::Wheel(_) => pose.axis,
                _ => DVec3::Y.reject_from_normalized(pose.approach).normalize(),
            };
            PathSample::from_centre(pose.time, pose.centre - pose.approach * height, (pose.approach, across), tool)
        });
        Path::from_samples(samples.collect())
    }
}

/// The logged force as the controller's setpoint, if the trial says so; at least [`LEAST_FORCE`] of the setpoint.
pub(super) fn force(pass: &Pass, trial: &Trial) -> Option<ForceProfile> {
    let start = pass.log.rows.first()?.time;
    let rows = pass.log.rows.iter().map(|row| (row.time - start, row.force));
    let leads = trial.force_input == ForceInput::Log;
    leads.then(|| ForceProfile::new(rows, LEAST_FORCE * pass.force_setpoint))
}

fn contact(logged: &ToolPath) -> Contact {
    logged.contact.unwrap_or(Contact { start: 0.0, end: f64::INFINITY })
}

/// Mean time between two rows [s].
fn row_period(logged: &ToolPath) -> f64 {
    match &logged.poses[..] {
        [first, .., last] => (last.time - first.time) / (logged.poses.len() - 1) as f64,
        _ => 0.0,
    }
}

/// Time [s] from the end of a pass's path, `simulated` [s] after its first row, to the first row of the next pass. The
/// pause between two logs is 0 if the clock of the second restarts.
pub(super) fn rest(pass: &Pass, simulated: f64, after: &Pass) -> f64 {
    let times =
        |pass: &Pass| pass.log.rows.first().zip(pass.log.rows.last()).map(|(first, last)| (first.time, last.time));
    let (Some((first, last)), Some((next, _))) = (times(pass), times(after)) else { return 0.0 };
    (next - last).max(0.0) + (last - first - simulated).max(0.0)
}

/// Time of the controller's takeover [s]: the first row after the touch whose force exceeds [`TOUCH`] of the setpoint.
/// Until then the robot descends; a start some milliseconds too early leaves the tool too low over much of the path.
fn handed_over(logged: &ToolPath, force_setpoint: f64) -> f64 {
    let Some(contact) = logged.contact else { return 0.0 };
    let presses = |pose: &&ToolPose| pose.time >= contact.start && pose.force > TOUCH * force_setpoint;
    logged.poses.iter().find(presses).map_or(contact.start, |pose| pose.time)
}

/// Position [m] that a descending tool would have at `time` [s], extrapolated from the last rows before it. The row at
/// that time already contains motion by the controller.
fn come_down(logged: &ToolPath, time: f64) -> DVec3 {
    let end = logged.poses.partition_point(|pose| pose.time < time);
    let rows = &logged.poses[end.saturating_sub(DESCENT_ROWS)..end];
    match rows {
        [first, .., last] => {
            let speed = (last.centre - first.centre).dot(last.approach) / (last.time - first.time);
            last.centre + last.approach * speed * (time - last.time)
        }
        _ => logged.at(time).centre,
    }
}

/// The pose at lift-off, after the last row in contact: the point at which the line through the following, rising rows
/// begins, otherwise the middle between two rows. `None` if fewer than two rows are in contact.
///
/// - `later`: delay of the lift-off relative to that in rows, and the time between two rows [s]
fn lifted_off(logged: &ToolPath, contact: Contact, (later, row): (f64, f64)) -> Option<ToolPose> {
    let off = logged.poses.partition_point(|pose| pose.time <= contact.end);
    let [before, last] = logged.poses.get(off.checked_sub(2)?..off)? else { return None };
    let along = (last.centre - before.centre) / (last.time - before.time);
    let rise = match logged.poses.get(off..off + 2) {
        Some([off, after]) => rise_began(last, [off, after]),
        _ => None,
    };
    let time = rise.unwrap_or(last.time + 0.5 * row) + later * row;
    Some(ToolPose { time, centre: last.centre + along * (time - last.time), ..*last })
}

/// Time at which a tool began to rise [s], between the last row in contact and the first off the part; `None` if it did
/// not.
fn rise_began(last: &ToolPose, [off, after]: [&ToolPose; 2]) -> Option<f64> {
    let speed = (after.centre - off.centre).dot(last.approach) / (after.time - off.time);
    let rise = (off.centre - last.centre).dot(last.approach);
    (speed > 0.0).then(|| (off.time - rise / speed).clamp(last.time, off.time))
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A tool fed along x at 10 mm/s, with a row every 10 ms, in contact in the first `pressed` rows; then it rises at
    /// 5 mm/s from `lifted` [s] on.
    fn logged(rows: usize, pressed: usize, lifted: f64) -> LoggedPass {
        let pose = |i: usize| {
            let time = 0.01 * i as f64;
            let height = 0.05 + 0.005 * f64::max(time - lifted, 0.0);
            ToolPose {
                time,
                centre: DVec3::new(0.01 * time, 0.0, height),
                approach: DVec3::Z,
                axis: DVec3::Y,
                force: if i < pressed { 10.0 } else { 0.0 },
                spindle_speed: 600.0,
            }
        };
        let contact = Contact { start: 0.0, end: 0.01 * (pressed - 1) as f64 };
        let poses = (0..rows).map(pose).collect();
        let poses = ToolPath { poses, contact: Some(contact), feed: 0.01, jumps: Vec::new() };
        let end = lifted_off(&poses, contact, (0.0, row_period(&poses)));
        LoggedPass { poses, taken_over: 0.0, end }
    }

    #[test]
    fn a_pass_ends_where_the_line_begins_on_which_the_tool_rose() {
        let end = logged(20, 12, 0.1137).end.unwrap();
        assert!((end.time - 0.1137).abs() < 1e-12, "{end:?}");
        assert!(end.centre.distance(DVec3::new(0.001_137, 0.0, 0.05)) < 1e-12, "{end:?}");
    }

    #[test]
    fn a_pass_whose_log_ends_in_contact_ends_half_a_row_later() {
        for rows in [12, 13] {
            let end = logged(rows, 12, f64::INFINITY).end.unwrap();
            assert!((end.time - 0.115).abs() < 1e-12, "{end:?}");
            assert!(end.centre.distance(DVec3::new(0.001_15, 0.0, 0.05)) < 1e-12, "{end:?}");
        }
    }
}
