//! Whether the files of a trial can belong together: a wrong unit is found here and named.

use std::path::Path;

use glam::{DVec2, DVec3};
use sdf_bake::{HeightMap, PixelGrid};

use super::error::{Place, TrialError};
use super::manifest::TRIAL_FILE;
use super::poses::{Motion, ToolPath, ToolPose};
use super::{Pass, Tool, Trial};
use crate::measure::centre_and_sigma;

/// How far a factor may be from a thousand and still be a wrong unit.
const THOUSAND: std::ops::Range<f64> = 500.0..2000.0;
/// Gap between tool and map that a wrong unit may explain [m].
const LEAST_GAP: f64 = 0.5e-3;
/// Spread that the right unit may add to the gap [m]: noise of the scan.
const SPREAD: f64 = 50e-6;
/// Ratio of logged force and setpoint beyond which a word is said.
const FORCE_RATIO: std::ops::Range<f64> = 0.2..5.0;
/// Ratio of logged speed and feed beyond which a word is said.
const SPEED_RATIO: std::ops::Range<f64> = 0.8..1.25;
/// Time between two passes that is worth a word [s].
const LONG_PAUSE: f64 = 3600.0;
/// Contact rows on the map that a judgement needs.
const LEAST_ROWS: usize = 10;

/// Refuses a trial whose files contradict each other as only a wrong unit or a wrong frame can; notes what is odd.
///
/// - `logs`: name of each pass's log
pub(super) fn check(trial: &mut Trial, logs: &[&Path]) -> Result<(), TrialError> {
    let mut notes = Vec::new();
    for (pass, name) in trial.passes.iter().zip(logs) {
        let place = || Place::file(&trial.folder.join(name));
        check_speed(pass, &trial.scans.before, &place)?;
        let path = pass.tool_path(&trial.tool);
        let Some(contact) = path.contact else {
            notes.push(format!("{}: the force never rises above its noise: no contact", name.display()));
            continue;
        };
        let touching: Vec<&ToolPose> =
            path.poses.iter().filter(|pose| (contact.start..=contact.end).contains(&pose.time)).collect();
        check_place(&touching, &trial.scans.before, &place)?;
        check_heights(&touching, trial)?;
        notes.extend(describe(&path, pass, &touching).map(|note| format!("{}: {note}", name.display())));
    }
    let pauses = trial.passes.windows(2).zip(&logs[1..]);
    notes.extend(pauses.filter_map(|(pair, name)| Some(format!("{}: {}", name.display(), pause(&pair[0], &pair[1])?))));
    trial.notes.extend(notes);
    Ok(())
}

/// What is odd about the time between two passes.
fn pause(before: &Pass, after: &Pass) -> Option<String> {
    let (first, last) = (before.log.rows.first()?.time, before.log.rows.last()?.time);
    let start = after.log.rows.first()?.time;
    if start - last > LONG_PAUSE {
        return Some(format!("begins {:.1} h after the pass before ends: taken as a pause", (start - last) / 3600.0));
    }
    (first < start && start < last).then(|| "begins before the pass before ends: its clock is its own".to_owned())
}

/// The speed of the log against the feed of the pass.
fn check_speed(pass: &Pass, map: &HeightMap, place: &dyn Fn() -> Place) -> Result<(), TrialError> {
    let speed = Motion::of(&pass.log).feed;
    let shown = format!("the tool moves at {:.3e} mm/s where the feed is {:.3} mm/s", speed * 1e3, pass.feed * 1e3);
    if THOUSAND.contains(&(speed / pass.feed)) {
        return Err(place().bad(shown, "positions in mm are expected: these look like µm"));
    }
    if !THOUSAND.contains(&(pass.feed / speed)) {
        return Ok(());
    }
    let reach = pass.log.rows.iter().map(|row| (row.position - pass.log.rows[0].position).length()).fold(0.0, f64::max);
    let map_length = map.pixels.pitch * map.pixels.nx.max(map.pixels.ny) as f64;
    let accepted = if reach < 0.02 * map_length {
        "positions in mm are expected: these look like m"
    } else {
        "times in s are expected: these look like ms"
    };
    Err(place().bad(shown, accepted))
}

/// Some of the contact must lie on the map.
fn check_place(touching: &[&ToolPose], map: &HeightMap, place: &dyn Fn() -> Place) -> Result<(), TrialError> {
    let PixelGrid { origin, nx, ny, .. } = map.pixels;
    if touching.iter().any(|pose| map.pixels.nearest(pose.centre.truncate()).is_some()) {
        return Ok(());
    }
    let (low, high) = touching.iter().fold((DVec2::INFINITY, DVec2::NEG_INFINITY), |(low, high), pose| {
        (low.min(pose.centre.truncate()), high.max(pose.centre.truncate()))
    });
    let shown = |low: DVec2, high: DVec2| {
        format!("x {:.2} to {:.2} mm, y {:.2} to {:.2} mm", low.x * 1e3, high.x * 1e3, low.y * 1e3, high.y * 1e3)
    };
    Err(place().bad(
        format!("all contact is at {}", shown(low, high)),
        format!("a path over the map at {} is expected", shown(origin, map.pixels.position(nx - 1, ny - 1))),
    ))
}

/// The tool's lowest point in contact against the map, also with the map in metres; a map in µm is refused for its
/// slopes when it is read.
fn check_heights(touching: &[&ToolPose], trial: &Trial) -> Result<(), TrialError> {
    let map = &trial.scans.before;
    let pairs: Vec<(f64, f64)> = touching
        .iter()
        .filter_map(|pose| {
            let lowest = lowest(&trial.tool, pose);
            let height = map.heights[map.pixels.nearest(lowest.truncate())?];
            height.is_finite().then_some((lowest.z, height))
        })
        .collect();
    if pairs.len() < LEAST_ROWS {
        return Ok(());
    }
    let (gap, spread) = gap_and_spread(&pairs, 1.0);
    let (scaled_gap, scaled_spread) = gap_and_spread(&pairs, 1e3);
    if gap > LEAST_GAP && scaled_gap < 0.1 * gap && scaled_spread < spread + SPREAD {
        let (gap, scaled_gap) = (gap * 1e3, scaled_gap * 1e3);
        return Err(Place::file(&trial.folder.join(TRIAL_FILE)).bad(
            format!(
                "the tool touches {gap:.2} mm off the surface of the scan `before`, and {scaled_gap:.2} mm off if its \
                 heights are in m"
            ),
            "heights in mm are expected: these look like m",
        ));
    }
    Ok(())
}

/// Magnitude of the median of z - scale · h, and the spread around it [m].
fn gap_and_spread(pairs: &[(f64, f64)], scale: f64) -> (f64, f64) {
    let gaps: Vec<f64> = pairs.iter().map(|(z, height)| z - scale * height).collect();
    let (centre, spread) = centre_and_sigma(&gaps).unwrap_or_default();
    (centre.abs(), spread)
}

/// The point of the tool that reaches furthest against the approach axis [m].
fn lowest(tool: &Tool, pose: &ToolPose) -> DVec3 {
    match *tool {
        Tool::Wheel { radius, .. } => {
            pose.centre - pose.approach.reject_from_normalized(pose.axis).normalize() * radius
        }
        Tool::Pad { .. } => pose.centre,
    }
}

/// What is odd about a pass, without being wrong for sure.
fn describe(path: &ToolPath, pass: &Pass, touching: &[&ToolPose]) -> impl Iterator<Item = String> {
    let jump = path.jumps.first().map(|jump| {
        format!("{} jumps of the clock, the first of {:.3} s before {:.3} s", path.jumps.len(), jump.gap, jump.time)
    });
    let mean = touching.iter().map(|pose| pose.force).sum::<f64>() / touching.len() as f64;
    let force = (!FORCE_RATIO.contains(&(mean / pass.force_setpoint)))
        .then(|| format!("the mean force in contact is {mean:.2} N where the setpoint is {} N", pass.force_setpoint));
    let speed = (!SPEED_RATIO.contains(&(path.feed / pass.feed))).then(|| {
        let (logged, feed) = (path.feed * 1e3, pass.feed * 1e3);
        format!("the tool moves at {logged:.2} mm/s where the feed is {feed} mm/s: is the clock right?")
    });
    jump.into_iter().chain(force).chain(speed)
}
