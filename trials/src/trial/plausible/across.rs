//! Consistency of the trials of a campaign: scans or logs that occur in two trials, or were swapped.

use sdf_bake::HeightMap;

use super::super::error::{Place, TrialError};
use super::super::manifest::TRIAL_FILE;
use super::super::{ExposureMask, PassScan, Trial};
use super::profile::{Contact, contacts, odds_of_another};
use super::{Surfaces, ground, odds};

/// Refuses campaigns whose trials share scans or logs, or whose logs follow each other's surfaces.
pub(in crate::trial) fn check(trials: &[Trial]) -> Result<(), TrialError> {
    for (k, trial) in trials.iter().enumerate() {
        for other in &trials[..k] {
            if let Some((mine, theirs)) = shared(trial, other) {
                return Err(Place::file(&trial.folder.join(TRIAL_FILE)).bad(
                    format!("{mine} is the same as {theirs} of {}", other.folder.display()),
                    "measurements of its own are expected for each trial: is one a copy of the other?",
                ));
            }
        }
    }
    if trials.len() > 1 { check_places(trials) } else { Ok(()) }
}

/// The first scan or log that two trials share. The last scan of a trial may be the first of another, if the workpiece
/// continues in it.
fn shared(trial: &Trial, other: &Trial) -> Option<(String, String)> {
    let (mine, theirs) = (maps(trial), maps(other));
    let goes_on = |mine: &str, theirs: &str| {
        !mine.contains("pass") && theirs == format!("scan of [[pass]] {}", other.passes.len())
    };
    for (name, map) in &mine {
        let same = |(their, map_of): &&(String, &HeightMap)| is_same(map, map_of) && !goes_on(name, their);
        if let Some((their, _)) = theirs.iter().find(same) {
            return Some((name.clone(), their.clone()));
        }
    }
    for (k, pass) in trial.passes.iter().enumerate() {
        let named = |number: usize, what: &str| format!("{what} of [[pass]] {}", number + 1);
        let log = other.passes.iter().position(|theirs| theirs.log.rows == pass.log.rows);
        let mask = mask(&pass.scan).and_then(|mine| {
            other
                .passes
                .iter()
                .position(|theirs| mask(&theirs.scan).is_some_and(|theirs| theirs.exposed == mine.exposed))
        });
        if let Some(found) = log.map(|at| (named(k, "log"), named(at, "log"))) {
            return Some(found);
        }
        if let Some(found) = mask.map(|at| (named(k, "scan"), named(at, "scan"))) {
            return Some(found);
        }
    }
    None
}

/// The height maps of a trial with their names.
fn maps(trial: &Trial) -> Vec<(String, &HeightMap)> {
    let scanned = (!trial.scans.is_nominal).then_some(&trial.scans.before);
    let before = scanned.map(|map| ("[scan] before".to_owned(), map)).into_iter();
    let repeats = trial.scans.repeats.iter().map(|map| ("[scan] repeat".to_owned(), map));
    let after = trial.passes.iter().enumerate();
    let after = after.filter_map(|(k, pass)| Some((format!("scan of [[pass]] {}", k + 1), ground(pass)?)));
    before.chain(repeats).chain(after).collect()
}

/// The mask after a pass, if it shows both coating and substrate.
fn mask(scan: &PassScan) -> Option<&ExposureMask> {
    let shows = |mask: &ExposureMask, kind: bool| mask.exposed.contains(&Some(kind));
    scan.mask().filter(|mask| shows(mask, true) && shows(mask, false))
}

/// True if two maps have bit-identical heights that are not all equal.
fn is_same(a: &HeightMap, b: &HeightMap) -> bool {
    let same = |(a, b): (&f64, &f64)| a.to_bits() == b.to_bits() || (a.is_nan() && b.is_nan());
    let known = || a.heights.iter().filter(|height| height.is_finite());
    a.heights.len() == b.heights.len()
        && a.heights.iter().zip(&b.heights).all(same)
        && known().zip(known().skip(1)).any(|(now, next)| now != next)
}

/// Expectation in the messages of these checks.
const ONE_PLACE: &str = "logs and scans of one workpiece are expected: were files of the two trials swapped?";

/// Refuses a trial whose logs follow the surface of another trial instead of its own, and two trials that were swapped.
fn check_places(trials: &[Trial]) -> Result<(), TrialError> {
    let surfaces: Vec<Surfaces> = trials.iter().map(Surfaces::of).collect();
    let places = Places { trials, contacts: surfaces.iter().map(contacts).collect() };
    for k in 0..trials.len() {
        for other in (0..trials.len()).filter(|&other| other != k && trials[other].tool == trials[k].tool) {
            let found = places.one(k, other).or_else(|| (k < other).then(|| places.both(k, other)).flatten());
            if let Some(found) = found {
                return Err(Place::file(&trials[k].folder.join(TRIAL_FILE)).bad(found, ONE_PLACE));
            }
        }
    }
    Ok(())
}

/// All trials with their poses in contact.
struct Places<'a> {
    trials: &'a [Trial],
    contacts: Vec<Vec<Contact<'a>>>,
}

impl Places<'_> {
    /// Logarithm of the odds that the log of a pass belongs to a scan of another trial.
    fn gain(&self, (trial, pass): (usize, usize), (other, there): (usize, usize)) -> f64 {
        odds_of_another(&self.trials[trial].tool, &self.contacts[trial][pass], &self.contacts[other][there].map)
    }

    /// Message for one trial whose log follows a scan of another.
    fn one(&self, trial: usize, other: usize) -> Option<String> {
        let passes: usize = self.contacts.iter().map(Vec::len).sum();
        let theirs = 0..self.contacts[other].len();
        let pairs = (0..self.contacts[trial].len()).flat_map(|pass| theirs.clone().map(move |there| (pass, there)));
        let all = pairs.map(|(pass, there)| (pass, there, self.gain((trial, pass), (other, there))));
        let (pass, there, gain) = all.max_by(|a, b| a.2.total_cmp(&b.2))?;
        (gain > odds::refusing(passes * passes)).then(|| {
            format!(
                "z_mm of the log of [[pass]] {} follows the scan of [[pass]] {} of {} exp({gain:.0}) times better than its own",
                pass + 1,
                there + 1,
                self.trials[other].folder.display()
            )
        })
    }

    /// Message for two trials whose scans or logs were swapped.
    fn both(&self, trial: usize, other: usize) -> Option<String> {
        let passes = self.contacts[trial].len();
        if self.contacts[other].len() != passes {
            return None;
        }
        let gain: f64 = (0..passes)
            .map(|pass| self.gain((trial, pass), (other, pass)) + self.gain((other, pass), (trial, pass)))
            .sum();
        (gain > odds::refusing(self.trials.len().pow(2))).then(|| {
            format!(
                "z_mm of its logs follows the scans of {}, and the logs there follow its own, exp({gain:.0}) times better than the \
                 other way round",
                self.trials[other].folder.display()
            )
        })
    }
}
