//! Draft of a `trial.toml` for a folder with scans and logs. Values that the files reveal are filled in, each with its
//! reason; the others are listed as open.
//!
//! 1. `files` classifies every file: height map, mask, log, or other.
//! 2. `scans` orders the maps in time, by their names and by the removal between them.
//! 3. `place` registers the path with the scans: the position of the first pixel and the tool's dimensions.
//! 4. `text` writes the file.

mod files;
mod place;
mod scans;
mod text;

use std::path::Path;

use crate::trial::TrialError;
use files::Found;
use place::Placing;
use scans::Scans;

/// A draft `trial.toml`.
#[derive(Clone, Debug)]
pub struct Guess {
    /// Its text.
    pub text: String,
    /// A description of each file.
    pub seen: Vec<String>,
    /// Keys that a person must fill in.
    pub open: Vec<String>,
}

/// Drafts a `trial.toml` for a folder.
///
/// # Errors
/// [`TrialError`] if the folder cannot be read, or holds no scan or no log.
pub fn guess(folder: &Path) -> Result<Guess, TrialError> {
    let found = Found::look(folder)?;
    found.check(folder)?;
    let scans = Scans::of(&found);
    let placing = Placing::of(&found, &scans);
    let mut writer = text::Writer { found: &found, scans: &scans, placing: &placing, open: Vec::new() };
    let text = writer.text(folder);
    Ok(Guess { text, seen: found.seen(), open: writer.open })
}
