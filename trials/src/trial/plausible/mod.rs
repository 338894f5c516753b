//! Physical plausibility of a trial: the files must be able to describe one workpiece and one tool.
//!
//! All checks run when a trial is read, before any simulation. Each check refuses with file, column or key, the gap
//! found and a guess of the cause, or leaves a note:
//!
//! - [`logs`]: direction of the path, copied or swapped logs, disconnected sensors;
//! - [`pairs`]: scans that share their noise, and scans of another surface;
//! - [`profile`]: the logged heights follow the scans best in the frame as read;
//! - [`exposure`]: exposed area lies where the pad was, and no coating returns;
//! - [`material`]: the bead lies where the labels say;
//! - [`across`]: trials that share files, or were swapped;
//! - [`readings`]: force, feed and spindle speed of a log against the values of its pass;
//! - [`copies`]: two scans with the same heights are one scan;
//! - [`orientation`]: a scan that is mirrored relative to the others, or has another sign or unit;
//! - [`contact`]: the tool lies on the surface that it ground, neither above it nor deep inside;
//! - [`follow`]: scans that are swapped or displaced, and removal beside the tool's path;
//! - [`repeat`]: the repeated scan differs from the first one only by noise.

mod across;
mod coarse;
mod contact;
mod copies;
mod exposure;
mod follow;
mod logs;
mod material;
mod odds;
mod orientation;
mod pairs;
mod profile;
mod readings;
mod repeat;

pub(super) use across::check as check_across;
pub use contact::least_gap;

use std::ops::Range;
use std::path::Path;

use rayon::prelude::*;
use sdf_bake::HeightMap;

use super::error::{Place, TrialError};
use super::manifest::{Manifest, PassTable};
use super::poses::{ToolPath, ToolPose};
use super::{Checked, Finding, Pass, PassScan, Trial};
use crate::measure::{CLEARANCE, despiked, untouched};

/// Minimum number of pixels for a decision: the standard error of a mean is then a tenth of the spread.
const LEAST_PIXELS: usize = 100;
/// Time between two passes for a note [s].
const LONG_PAUSE: f64 = 3600.0;

/// Names of a trial's files, as given in `trial.toml`.
pub(super) struct Names<'a> {
    before: &'a Path,
    repeats: Vec<&'a Path>,
    logs: Vec<&'a Path>,
    /// One for each pass; empty for a pass that was not scanned.
    scans: Vec<&'a Path>,
}

impl<'a> Names<'a> {
    pub(super) fn of(manifest: &'a Manifest) -> Self {
        Self {
            before: manifest.scan.first_name(),
            repeats: manifest.scan.repeat.iter().map(|name| name.get_ref().as_path()).collect(),
            logs: manifest.pass.iter().map(|table| table.log.get_ref().as_path()).collect(),
            scans: manifest.pass.iter().map(scan_name).collect(),
        }
    }
}

/// Name of the scan after a pass; empty if there was none.
fn scan_name(table: &PassTable) -> &Path {
    table.scan.as_ref().map_or(Path::new(""), |name| name.get_ref())
}

/// A trial's scans without spikes, and its paths.
struct Surfaces {
    before: HeightMap,
    repeats: Vec<HeightMap>,
    /// Surface after each pass; `None` for sanding, and for a pass that was not scanned.
    after: Vec<Option<HeightMap>>,
    /// Path of each pass.
    paths: Vec<ToolPath>,
    /// For each pass and pixel, true if no tool came close to it in this pass.
    free: Vec<Vec<bool>>,
}

impl Surfaces {
    fn of(trial: &Trial) -> Self {
        let clean = |map: &HeightMap| despiked(map).0;
        let before = &trial.scans.before;
        let after: Vec<Option<&HeightMap>> = trial.passes.iter().map(ground).collect();
        let paths: Vec<ToolPath> = trial.passes.iter().map(|pass| pass.tool_path(&trial.tool)).collect();
        Self {
            before: clean(before),
            repeats: trial.scans.repeats.iter().map(clean).collect(),
            after: after.into_par_iter().map(|map| map.map(clean)).collect(),
            free: paths.iter().map(|path| untouched(before, path, &trial.tool, CLEARANCE)).collect(),
            paths,
        }
    }

    /// True if the scan after a pass shows removal or exposure since the previous one.
    fn shows_work(&self, trial: &Trial, pass: usize) -> bool {
        let scan = |number: usize| trial.passes.get(number).map(|pass| &pass.scan);
        match (scan(pass), pass.checked_sub(1).and_then(scan)) {
            (Some(PassScan::Exposure(now)), Some(PassScan::Exposure(earlier))) => {
                let pixels = now.exposed.iter().zip(&earlier.exposed);
                pixels.filter(|(now, earlier)| **now == Some(true) && **earlier == Some(false)).count() >= LEAST_PIXELS
            }
            (Some(PassScan::Exposure(now)), _) => {
                now.exposed.iter().filter(|exposed| **exposed == Some(true)).count() >= LEAST_PIXELS
            }
            _ => follow::shows_removal(self, pass),
        }
    }

    /// The last surface that was scanned before a pass, and the passes since then, this one included.
    fn earlier(&self, pass: usize) -> (&HeightMap, Range<usize>) {
        let scanned = (0..pass).rev().find_map(|earlier| Some((earlier, self.after[earlier].as_ref()?)));
        scanned.map_or((&self.before, 0..pass + 1), |(earlier, map)| (map, earlier + 1..pass + 1))
    }

    /// Pixels that no pass of a range came close to.
    fn free_in(&self, passes: Range<usize>) -> Vec<bool> {
        (0..self.before.heights.len()).map(|at| self.free[passes.clone()].iter().all(|free| free[at])).collect()
    }

    /// Pixels that no pass up to this one came close to; all pixels if those are too few.
    fn free_until(&self, pass: usize) -> Vec<bool> {
        let free = self.free_in(0..pass + 1);
        let enough = free.iter().filter(|free| **free).count() >= LEAST_PIXELS;
        if enough { free } else { vec![true; free.len()] }
    }
}

/// The ground surface after a pass; `None` for sanding, and for a pass that was not scanned.
fn ground(pass: &Pass) -> Option<&HeightMap> {
    pass.scan.heights().filter(|_| !pass.scan.is_missing())
}

/// Result of a check: notes, or the reason for refusal.
type Outcome = Result<Vec<String>, TrialError>;

/// Refuses a trial whose files contradict each other, and adds notes on oddities.
pub(super) fn check(trial: &mut Trial, names: &Names) -> Result<(), TrialError> {
    let mut noted = NoteCollector::of(trial);
    run(trial, names, &mut |check, found| noted.add(check, found))?;
    trial.notes.extend(noted.notes);
    trial.findings = noted.findings;
    Ok(())
}

/// Runs all checks and returns all findings; a refusal does not stop the later checks.
pub(super) fn check_all(trial: &mut Trial, names: &Names) -> Vec<Checked> {
    let mut noted = NoteCollector::of(trial);
    let mut all: Vec<Checked> = Vec::new();
    let each = &mut |check, found: Outcome| {
        let before = noted.findings.len();
        if let Err(error) = noted.add(check, found) {
            noted.findings.extend(Finding::of(&error));
        }
        let new = noted.findings[before..].to_vec();
        match all.iter_mut().find(|known| known.check == check) {
            Some(known) => known.findings.extend(new),
            None => all.push(Checked { check, findings: new }),
        }
        Ok(())
    };
    run(trial, names, each).expect("no check ends the others");
    trial.notes.extend(noted.notes);
    trial.findings = noted.findings;
    all
}

/// Passes the outcome of every check to `each`, until that returns an error.
fn run(
    trial: &Trial,
    names: &Names,
    each: &mut dyn FnMut(&'static str, Outcome) -> Result<(), TrialError>,
) -> Result<(), TrialError> {
    let trial = &*coarse::coarse(trial);
    for (pass, name) in trial.passes.iter().zip(&names.logs) {
        let found = readings::check(pass, trial, &trial.folder.join(name));
        let named = |notes: Vec<String>| notes.into_iter().map(|note| format!("{}: {note}", name.display())).collect();
        each("readings", found.map(named))?;
    }
    let surfaces = Surfaces::of(trial);
    for (path, name) in surfaces.paths.iter().zip(&names.logs) {
        let place = Place::file(&trial.folder.join(name));
        each("place", contact::check_place(&touching(path), &trial.scans.before, &place).map(|()| Vec::new()))?;
    }
    each("orientation", orientation::check(trial, &surfaces, names).map(|()| Vec::new()))?;
    each("contact", contact::check(trial, &surfaces, names))?;
    each("logs", logs::check(trial, &surfaces, names))?;
    for pass in &trial.passes {
        each("rim speed", readings::check_rim(pass, trial).map(Vec::from_iter))?;
    }
    each("copies", copies::check(trial, names).map(|()| Vec::new()))?;
    each("removal", follow::check(trial, &surfaces, names))?;
    each("repeat", repeat::check(trial, &surfaces, names))?;
    each("noise", pairs::check(trial, &surfaces, names).map(Vec::from_iter))?;
    each("profile", profile::check(trial, &surfaces, names).map(Vec::from_iter))?;
    each("exposure", exposure::check(trial, &surfaces, names))?;
    each("material", material::check(trial, &surfaces).map(Vec::from_iter))?;
    each("pause", Ok(pauses(trial, names)))
}

/// Notes collected so far.
struct NoteCollector {
    /// Name of the trial.
    trial: String,
    notes: Vec<String>,
    findings: Vec<Finding>,
}

impl NoteCollector {
    fn of(trial: &Trial) -> Self {
        Self { trial: trial.name.clone(), notes: Vec::new(), findings: Vec::new() }
    }

    /// Adds the notes of a check, each once.
    fn add(&mut self, check: &'static str, found: Outcome) -> Result<(), TrialError> {
        for note in found.map_err(|error| error.by(check))? {
            if !self.notes.contains(&note) {
                self.findings.push(Finding::noted(check, &self.trial, &note));
                self.notes.push(note);
            }
        }
        Ok(())
    }
}

/// Notes on the times between passes.
fn pauses(trial: &Trial, names: &Names) -> Vec<String> {
    let pairs = trial.passes.windows(2).zip(&names.logs[1..]);
    pairs.filter_map(|(pair, name)| Some(format!("{}: {}", name.display(), pause(&pair[0], &pair[1])?))).collect()
}

/// Poses of a path in contact; none if the force never exceeded its noise.
fn touching(path: &ToolPath) -> Vec<&ToolPose> {
    let Some(contact) = path.contact else { return Vec::new() };
    path.poses.iter().filter(|pose| (contact.start..=contact.end).contains(&pose.time)).collect()
}

/// Note on the time between two passes.
fn pause(before: &Pass, after: &Pass) -> Option<String> {
    let (first, last) = (before.log.rows.first()?.time, before.log.rows.last()?.time);
    let start = after.log.rows.first()?.time;
    if start - last > LONG_PAUSE {
        return Some(format!("begins {:.1} h after the pass before ends: taken as a pause", (start - last) / 3600.0));
    }
    (first < start && start < last).then(|| "begins before the pass before ends: its clock is its own".to_owned())
}
