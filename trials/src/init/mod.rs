//! A first `trial.toml` for a folder with scans and logs: what can be seen in the files is filled in, each guess with its
//! reason, and what cannot be seen is named.
//!
//! 1. `files` looks at every file: a height map, a mask, a log, or neither.
//! 2. `scans` says which map was taken when, by names and by what was removed.
//! 3. `place` lays the path on the scans: where the first pixel lies, and what the tool may be.
//! 4. `text` writes it down.

mod files;
mod place;
mod scans;
mod text;

use std::path::Path;

use crate::trial::TrialError;
use files::Found;
use place::Placing;
use scans::Scans;

/// A `trial.toml` that was guessed.
#[derive(Clone, Debug)]
pub struct Guess {
    /// Its text.
    pub text: String,
    /// A description of each file.
    pub seen: Vec<String>,
    /// Keys that only a person can fill in.
    pub open: Vec<String>,
}

/// Looks at a folder.
///
/// # Errors
/// [`TrialError`] where the folder cannot be read, or holds no scan or no log.
pub fn guess(folder: &Path) -> Result<Guess, TrialError> {
    let found = Found::look(folder)?;
    found.check(folder)?;
    let scans = Scans::of(&found);
    let placing = Placing::of(&found, &scans);
    let mut writer = text::Writer { found: &found, scans: &scans, placing: &placing, open: Vec::new() };
    let text = writer.text(folder);
    Ok(Guess { text, seen: found.seen(), open: writer.open })
}
