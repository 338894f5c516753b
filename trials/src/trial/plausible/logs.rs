//! Consistency of a trial's logs with their passes and with each other: direction of the path, copied or swapped logs,
//! disconnected sensors.

use glam::DVec2;
use robot::LogRow;
use sdf_bake::HeightMap;

use super::super::error::{Place, TrialError};
use super::super::log::Log;
use super::super::manifest::TRIAL_FILE;
use super::super::poses::ToolPose;
use super::super::strokes::strokes;
use super::super::{HeldTool, Pass, Trial};
use super::profile::{Contact, contacts, touch_level};
use super::{Names, Surfaces, touching};
use crate::measure::{CLEARANCE, median};

/// Distance between the ends of a straight pass over the length of its path: a path with a turn of 90° has √½ at most.
const STRAIGHT: f64 = 0.9;
/// Cosine of the angle between path and `direction` below which they differ: 60°. It is midway between the axis across
/// the path (90°) and an error of 30° from a skewed fixture.
const SAME_WAY: f64 = 0.5;
/// Plausible sampling periods of robot logs [s]: 0.1 MHz, and one at which no force control would work.
const PERIODS: (f64, f64) = (1e-5, 1.0);
/// Relative difference between the force in the middle of a contact and the setpoint for a note: the range of the gain
/// of force sensors (`force-bias`). Force control holds 2.5 % in all campaigns made to test this.
const FORCE_LEVEL: f64 = 0.1;
/// Share of a contact at each end that its middle leaves out: entry and exit.
const ENDS: f64 = 0.2;
/// Depth of a pass above which the heights of two logs show their order [m]: twice the error of scan and pose.
const LEAST_DEPTH: f64 = CLEARANCE;
/// Share of the contact outside the map for a note: errors of clock and path cause a few hundredths.
const BESIDE: f64 = 0.1;

/// Refuses logs of another pass and columns that cannot be measurements; returns notes.
pub(super) fn check(trial: &Trial, surfaces: &Surfaces, names: &Names) -> Result<Vec<String>, TrialError> {
    check_copies(trial, names)?;
    let mut notes = Vec::new();
    for (number, (pass, name)) in trial.passes.iter().zip(&names.logs).enumerate() {
        let place = Place::file(&trial.folder.join(name));
        check_period(&pass.log, &place)?;
        check_way(trial, number, names)?;
        let poses = touching(&surfaces.paths[number]);
        if poses.is_empty() {
            check_contact(trial, number, (surfaces, place))?;
        }
        let found = [
            constant(pass),
            several_strokes(pass),
            force_level(pass, &poses),
            beside(&poses, &trial.scans.before),
            along(&trial.tool, pass),
        ];
        notes.extend(found.into_iter().flatten().map(|note| format!("{}: {note}", name.display())));
    }
    check_order(trial, surfaces, names)?;
    Ok(notes)
}

/// Refuses a log with the rows of another one: noise never repeats. Logs without noise may be alike, but their times
/// differ.
fn check_copies(trial: &Trial, names: &Names) -> Result<(), TrialError> {
    for (k, pass) in trial.passes.iter().enumerate() {
        if let Some(first) = trial.passes[..k].iter().position(|first| first.log.rows == pass.log.rows) {
            return Err(Place::file(&trial.folder.join(names.logs[k])).bad(
                format!("it holds the same rows as {}", names.logs[first].display()),
                "a log of its own is expected for each pass: is one a copy of the other?",
            ));
        }
    }
    Ok(())
}

/// Refuses sampling periods that no robot log has.
fn check_period(log: &Log, place: &Place) -> Result<(), TrialError> {
    let period = median(log.rows.windows(2).map(|pair| pair[1].time - pair[0].time).collect()).unwrap_or(0.0);
    if period > PERIODS.1 {
        return Err(place.clone().bad(
            format!("t_s: the time between two rows is {period:.3} s"),
            format!("at most {} s are expected, for no force is held at a slower pace: is t_s in ms?", PERIODS.1),
        ));
    }
    if period < PERIODS.0 {
        return Err(place.clone().bad(
            format!("t_s: the time between two rows is {period:.1e} s"),
            format!("at least {:e} s are expected: is t_s in minutes or hours?", PERIODS.0),
        ));
    }
    Ok(())
}

/// Direction of a straight pass, unit, in the plane of the scan.
fn way(log: &Log) -> Option<DVec2> {
    let places = || log.rows.iter().map(|row: &LogRow| row.position.truncate());
    let net = places().next_back()? - places().next()?;
    // Steps longer than the jitter of the logged position: every twentieth of the path.
    let stride = (log.rows.len() / 20).max(1);
    let kept: Vec<DVec2> = places().step_by(stride).chain(places().next_back()).collect();
    let length: f64 = kept.windows(2).map(|pair| pair[0].distance(pair[1])).sum();
    (length > 0.0 && net.length() > STRAIGHT * length).then(|| net.normalize())
}

/// Refuses a straight path that differs from the pass's direction; guesses the log of another pass.
fn check_way(trial: &Trial, number: usize, names: &Names) -> Result<(), TrialError> {
    let Some(found) = way(&trial.passes[number].log) else { return Ok(()) };
    let stated = trial.passes[number].direction.truncate();
    let is_same = |way: DVec2| way.dot(stated) >= SAME_WAY * stated.length();
    if is_same(found) || stated.length() < SAME_WAY {
        return Ok(());
    }
    let fits = |&other: &usize| other != number && way(&trial.passes[other].log).is_some_and(is_same);
    let guess = match (0..trial.passes.len()).find(fits) {
        Some(other) => format!("is {} the log of this pass?", names.logs[other].display()),
        None if found.dot(stated) < -SAME_WAY => {
            "is direction that of another pass, or are x_mm and y_mm mirrored?".to_owned()
        }
        None => "is direction that of another pass, or are x_mm and y_mm swapped?".to_owned(),
    };
    Err(Place::file(&trial.folder.join(names.logs[number])).bad(
        format!(
            "the tool goes along ({:.2}, {:.2}) where direction of {TRIAL_FILE} is ({:.2}, {:.2})",
            found.x, found.y, stated.x, stated.y
        ),
        format!("one direction in both is expected: {guess}"),
    ))
}

/// Refuses a force without contact if the scans show removal.
fn check_contact(trial: &Trial, number: usize, (surfaces, place): (&Surfaces, Place)) -> Result<(), TrialError> {
    if !surfaces.shows_work(trial, number) {
        return Ok(());
    }
    let most = trial.passes[number].log.rows.iter().map(|row| row.force.abs()).fold(0.0, f64::max);
    Err(place.bad(
        format!("force_n reaches {most:.2} N and shows no contact, while the scan after the pass shows its work"),
        format!(
            "a force near force_setpoint_n = {} N is expected: was the sensor connected?",
            trial.passes[number].force_setpoint
        ),
    ))
}

/// Note on a pass in which the tool leaves the part and returns, while the simulation presses it on throughout.
fn several_strokes(pass: &Pass) -> Option<String> {
    let rows: Vec<(f64, f64)> = pass.log.rows.iter().map(|row| (row.time, row.force)).collect();
    let strokes = strokes(&rows, pass.force_setpoint);
    (strokes.len() > 1).then(|| {
        let time = |at: usize| rows[at.min(rows.len() - 1)].0;
        let parts: Vec<String> =
            strokes.iter().map(|part| format!("[{:.3}, {:.3}]", time(part.start), time(part.end))).collect();
        format!(
            "the force falls to zero between {} strokes, and the pass is simulated as one: is a [[pass]] meant for each, \
             with time_s = {}?",
            strokes.len(),
            parts.join(", ")
        )
    })
}

/// Note on a column of measured values that never changes.
fn constant(pass: &Pass) -> Option<String> {
    let never = |of: &dyn Fn(&LogRow) -> f64| {
        let first = pass.log.rows.first().map(of)?;
        pass.log.rows.iter().all(|row| of(row) == first).then_some(first)
    };
    let force = never(&|row| row.force).filter(|force| *force != 0.0);
    let force = force.map(|force| format!("force_n is {force} N in all rows: was the sensor connected?"));
    force.or_else(|| {
        let z = never(&|row| row.position.z)?;
        Some(format!("z_mm is {:.3} mm in all rows, in the air and in contact: is it measured?", 1e3 * z))
    })
}

/// Note on the force in the middle of the contact relative to the setpoint.
fn force_level(pass: &Pass, poses: &[&ToolPose]) -> Option<String> {
    let cut = (ENDS * poses.len() as f64) as usize;
    let middle = &poses[cut..poses.len() - cut];
    let mean = middle.iter().map(|pose| pose.force).sum::<f64>() / middle.len().max(1) as f64;
    let excess = mean / pass.force_setpoint - 1.0;
    (excess.abs() >= FORCE_LEVEL && !middle.is_empty()).then(|| {
        format!(
            "in the middle of the contact the force is {mean:.2} N, {:+.0} % off force_setpoint_n = {} N: is the sensor \
             calibrated, or the setpoint that of another pass?",
            100.0 * excess,
            pass.force_setpoint
        )
    })
}

/// Note on a wheel whose axis lies along its path, so that its rim moves across it.
fn along(tool: &HeldTool, pass: &Pass) -> Option<String> {
    let axis = tool.axis?;
    let way = way(&pass.log)?;
    (way.dot(axis.truncate()).abs() > SAME_WAY.acos().sin()).then(|| {
        format!(
            "the tool goes along ({:.2}, {:.2}), and axis of {TRIAL_FILE} lies along it: is the axis across?",
            way.x, way.y
        )
    })
}

/// Note on the share of the contact outside the map.
fn beside(poses: &[&ToolPose], map: &HeightMap) -> Option<String> {
    let outside = poses.iter().filter(|pose| map.pixels.nearest(pose.centre.truncate()).is_none()).count();
    let share = outside as f64 / poses.len().max(1) as f64;
    (share > BESIDE).then(|| {
        format!(
            "{:.0} % of the contact lies beside the scans: is pitch_mm or origin_mm of {TRIAL_FILE} off?",
            100.0 * share
        )
    })
}

/// Refuses swapped logs of two successive passes. In the right order the gaps of both to the surface that each left are
/// alike. If swapped, they differ by twice the depth of the second pass, and by once if the logged heights carry no
/// information.
fn check_order(trial: &Trial, surfaces: &Surfaces, names: &Names) -> Result<(), TrialError> {
    let contacts = contacts(surfaces);
    for (k, pair) in contacts.windows(2).enumerate() {
        let level = |contact: &Contact, map: &HeightMap| touch_level(&trial.tool, contact, map);
        let levels = || {
            let own = [level(&pair[0], &pair[0].map)?, level(&pair[1], &pair[1].map)?];
            Some((own, level(&pair[0], &pair[1].map)? - own[0]))
        };
        let Some(([first, second], depth)) = levels() else { continue };
        if surfaces.after.iter().all(Option::is_none) || depth < LEAST_DEPTH || second - first < 1.5 * depth {
            continue;
        }
        let place = Place::file(&trial.folder.join(names.logs[k + 1]));
        return Err(place.bad(
            format!(
                "z_mm: the tool lies {:.3} mm higher above {} than that of {} above {}, about twice the {depth:.3} mm that the pass \
                 removed",
                1e3 * (second - first),
                names.scans[k + 1].display(),
                names.logs[k].display(),
                names.scans[k].display(),
                depth = 1e3 * depth
            ),
            "logs in the order of the passes are expected: the two look swapped",
        ));
    }
    Ok(())
}
