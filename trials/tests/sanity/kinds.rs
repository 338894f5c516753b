//! Outcome of reading a damaged campaign.

use std::fs;
use std::path::{Path, PathBuf};

use tempfile::TempDir;
use trials::trial::{Campaign, Finding, Severity, TrialError};

use crate::damage::Files;

/// A kind of damage: its name, the change to the first trial with access to a second one, and the expected outcome.
pub(crate) type Kind = (&'static str, fn(&Files, &Files), Said);

/// Expected outcome for a damaged campaign.
#[derive(Clone, Copy, Debug)]
pub(crate) enum Said {
    /// It is refused; the message contains these words.
    Refused(&'static str),
    /// It is read with a note that contains these words.
    Noted(&'static str),
}

pub(crate) fn first_look() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../data/campaigns/first-look")
}

/// The first two trials of a campaign, in a writable folder of their own.
pub(crate) fn copied(campaign: &Path) -> TempDir {
    let folder = tempfile::tempdir().unwrap();
    for trial in trials(campaign).iter().take(2) {
        let to = folder.path().join(trial.file_name().unwrap());
        fs::create_dir(&to).unwrap();
        for entry in fs::read_dir(trial).unwrap() {
            let entry = entry.unwrap();
            fs::write(to.join(entry.file_name()), fs::read(entry.path()).unwrap()).unwrap();
        }
    }
    folder
}

/// Trial folders of a campaign, in order.
pub(crate) fn trials(campaign: &Path) -> Vec<PathBuf> {
    let entries = fs::read_dir(campaign).unwrap().map(|entry| entry.unwrap().path());
    let mut trials: Vec<PathBuf> = entries.filter(|place| place.join("trial.toml").is_file()).collect();
    trials.sort();
    trials
}

/// Outcome of a campaign after a kind of damage: the refusal, or the notes.
pub(crate) fn said(campaign: &Path, damage: fn(&Files, &Files)) -> Result<Vec<String>, TrialError> {
    let folder = copied(campaign);
    let places = trials(folder.path());
    damage(&Files::of(&places[0]), &Files::of(places.last().unwrap()));
    Campaign::read(folder.path()).map(|campaign| campaign.notes())
}

/// Asserts that all kinds of damage are reported as expected.
pub(crate) fn assert_reported(campaign: &Path, kinds: &[Kind]) {
    let mut silent = Vec::new();
    for (name, damage, expected) in kinds {
        let found = said(campaign, *damage);
        let is_right = match (&found, expected) {
            (Err(error), Said::Refused(words)) => {
                let finding = Finding::of(error).expect("a refusal for machines");
                assert_eq!(finding.severity, Severity::Refused);
                error.to_string().contains(words)
            }
            (Ok(notes), Said::Noted(words)) => notes.iter().any(|note| note.contains(words)),
            _ => false,
        };
        println!("{name}: {}", found.as_ref().map_or_else(ToString::to_string, |notes| notes.join("; ")));
        if !is_right {
            silent.push(format!("{name}: {expected:?} is expected, {found:?} is found"));
        }
    }
    assert!(silent.is_empty(), "{}", silent.join("\n"));
}
