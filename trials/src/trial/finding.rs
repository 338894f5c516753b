//! Findings of a trial's checks, both for messages and machine-readable.

use serde::{Deserialize, Serialize};

use super::error::TrialError;

/// Consequence of a finding.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Severity {
    /// The campaign was not used.
    Refused,
    /// The files were used as they are.
    Noted,
}

/// One finding of a check.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct Finding {
    /// Name of the check, as listed in `docs/sanity.md`.
    pub check: String,
    /// Consequence for the trial.
    pub severity: Severity,
    /// Name of the trial; absent for a refused one.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub trial: Option<String>,
    /// The file; absent if several are meant.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub file: Option<String>,
    /// Line in the file, from 1.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub line: Option<u64>,
    /// Column of that line, from 1.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub column: Option<u64>,
    /// The problem found, with the gap.
    pub found: String,
    /// Accepted values.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub expected: Option<String>,
    /// Possible cause.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub guess: Option<String>,
}

/// A check with its findings; empty if it passes.
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
pub struct Checked {
    /// Name of the check, as listed in `docs/sanity.md`.
    pub check: &'static str,
    /// Refusals and notes.
    pub findings: Vec<Finding>,
}

impl Finding {
    /// The refusal behind an error; `None` if a file could not be read.
    pub fn of(error: &TrialError) -> Option<Self> {
        let TrialError::Bad { check, place, found, accepted } = error else { return None };
        let (expected, guess) = parted(accepted);
        Some(Self {
            check: (*check).to_owned(),
            severity: Severity::Refused,
            trial: None,
            file: Some(place.file.display().to_string()),
            line: place.line,
            column: place.column,
            found: found.clone(),
            expected,
            guess,
        })
    }

    /// A note of a check; the text may begin with the name of its file.
    pub(super) fn noted(check: &str, trial: &str, note: &str) -> Self {
        let named = note.split_once(": ").filter(|(file, _)| file.contains('.') && !file.contains(' '));
        let (file, found) = named.map_or((None, note), |(file, found)| (Some(file.to_owned()), found));
        Self {
            check: check.to_owned(),
            severity: Severity::Noted,
            trial: Some(trial.to_owned()),
            file,
            line: None,
            column: None,
            found: found.to_owned(),
            expected: None,
            guess: None,
        }
    }
}

/// Splits a text into the accepted values and the guess after the colon.
fn parted(accepted: &str) -> (Option<String>, Option<String>) {
    let owned = |text: &str| Some(text.to_owned());
    match accepted.split_once(": ") {
        Some((expected, guess)) => (owned(expected), owned(guess)),
        None if accepted.ends_with('?') => (None, owned(accepted)),
        None => (owned(accepted), None),
    }
}
