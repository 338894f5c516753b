//! Converts planned paths to robot programs, and programs to paths.

use glam::{DMat3, DQuat, DVec3};
use instruments::program::{Point, Program};
use robot::LogRow;
use trials::trial::Log;

/// Greatest distance of a row from the straight line through its neighbours at which the program omits it [m].
const STRAIGHT: f64 = 1e-6;
/// Relative change of speed above which a row becomes a program point.
const SAME_SPEED: f64 = 0.01;
/// Cosine above which two approach axes are equal.
const SAME_AXIS: f64 = 1.0 - 1e-9;

/// Values for the quantities that a program does not state.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ProgramDefaults {
    /// Speed of rapid moves, and of moves whose speed the program does not give [m/s].
    pub rapid: f64,
    /// Force setpoint of moves with a stated speed [N]; rapid moves have force 0.
    pub force: f64,
    /// Spindle speed where the program gives none [rad/s].
    pub spindle: f64,
}

/// Converts a program to the log of a plan: one row per point, reached at the speed of its move.
pub fn log_of(program: &Program, defaults: &ProgramDefaults) -> Log {
    let mut log = Log { has_approach: program.points.iter().any(|point| point.rotation.is_some()), ..Log::default() };
    let mut spindle = defaults.spindle;
    for point in &program.points {
        spindle = point.spindle.unwrap_or(spindle);
        let position = point.position;
        // The tool's z axis points into the part.
        let approach = point.rotation.map_or(DVec3::Z, |rotation| -(rotation * DVec3::Z));
        let speed = point.feed.unwrap_or(defaults.rapid);
        let time = match log.rows.last() {
            None => 0.0,
            Some(last) if last.position == position => continue,
            Some(last) => point
                .time
                .filter(|time| *time > last.time)
                .unwrap_or_else(|| last.time + last.position.distance(position) / speed),
        };
        let force = if point.feed.is_some() { defaults.force } else { 0.0 };
        log.rows.push(LogRow { time, position, force, spindle_speed: spindle, approach });
    }
    log
}

/// Selects the points of a planned log between which the tool moves straight at constant speed.
pub fn points_of(log: &Log) -> Vec<Point> {
    let rows = &log.rows;
    let speed = |k: usize| rows[k].position.distance(rows[k - 1].position) / (rows[k].time - rows[k - 1].time);
    let mut kept: Vec<usize> = Vec::new();
    for k in 0..rows.len() {
        let is_corner = k == 0 || k + 1 == rows.len() || {
            let from = rows[*kept.last().expect("the first row is kept")].position;
            let way = rows[k + 1].position - from;
            let off = (rows[k].position - from).reject_from(way.try_normalize().unwrap_or(DVec3::X)).length();
            off > STRAIGHT
                || (speed(k + 1) - speed(k)).abs() > SAME_SPEED * speed(k)
                || rows[k].approach.dot(rows[k + 1].approach) < SAME_AXIS
        };
        if is_corner {
            kept.push(k);
        }
    }
    let point = |&k: &usize| Point {
        position: rows[k].position,
        rotation: Some(rotation(rows[k].approach)),
        feed: Some(speed(k.max(1))),
        time: Some(rows[k].time),
        spindle: Some(rows[k].spindle_speed),
        line: k as u64 + 1,
    };
    kept.iter().map(point).collect()
}

/// Tool orientation for an approach axis: z into the part, x as close as possible to the frame's x.
fn rotation(approach: DVec3) -> DQuat {
    let z = -approach;
    let x = DVec3::X.reject_from_normalized(z).try_normalize().unwrap_or(DVec3::Y);
    DQuat::from_mat3(&DMat3::from_cols(x, z.cross(x), z))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn row(time: f64, x: f64, z: f64) -> LogRow {
        LogRow { time, position: DVec3::new(x, 0.0, z), force: 15.0, spindle_speed: 600.0, approach: DVec3::Z }
    }

    #[test]
    fn a_straight_line_at_one_speed_is_two_points() {
        let rows: Vec<LogRow> = (0..=10).map(|k| row(0.1 * f64::from(k), 1e-3 * f64::from(k), 0.0)).collect();
        let bent: Vec<LogRow> = rows
            .iter()
            .copied()
            .chain((1..=5).map(|k| row(1.0 + 0.1 * f64::from(k), 0.01, 1e-3 * f64::from(k))))
            .collect();
        let log = |rows: &[LogRow]| Log { rows: rows.to_vec(), ..Log::default() };
        assert_eq!(points_of(&log(&rows)).len(), 2);
        let points = points_of(&log(&bent));
        assert_eq!(points.iter().map(|point| point.position.x).collect::<Vec<_>>(), [0.0, 0.01, 0.01]);
        assert!(points.iter().all(|point| (point.feed.unwrap() - 0.01).abs() < 1e-12));
    }

    #[test]
    fn a_program_is_the_path_that_it_was_written_from() {
        let rows: Vec<LogRow> = (0..=10).map(|k| row(0.1 * f64::from(k), 1e-3 * f64::from(k), 0.0)).collect();
        let log = Log { rows, ..Log::default() };
        let program = Program { format: "test", points: points_of(&log), notes: Vec::new() };
        let back = log_of(&program, &ProgramDefaults { rapid: 0.1, force: 15.0, spindle: 0.0 });
        assert_eq!(back.rows.len(), 2);
        assert!((back.rows[1].time - 1.0).abs() < 1e-12 && back.rows[1].position.x == 0.01);
        assert!(back.rows.iter().all(|row| row.approach.distance(DVec3::Z) < 1e-12 && row.spindle_speed == 600.0));
    }
}
