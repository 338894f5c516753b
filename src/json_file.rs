//! JSON files that the program reads: regular files alone, and errors that repeat nothing of what they hold.

use std::path::Path;

use anyhow::{Result, anyhow};
use sdf_bake::input::{self, MOST_TEXT_BYTES, without_content};
use serde::de::DeserializeOwned;

/// Reads a JSON file that should be `what`, such as `the record of an image`.
///
/// # Errors
/// When the file cannot be read or holds something else: what was found by its type and length, and what is accepted.
pub fn read_json<T: DeserializeOwned>(path: &Path, what: &str) -> Result<T> {
    parse_json(path, &input::read_text(path, MOST_TEXT_BYTES)?, what)
}

/// As [`read_json`], for a text that was read from `path`.
///
/// # Errors
/// As there.
pub fn parse_json<T: DeserializeOwned>(path: &Path, text: &str, what: &str) -> Result<T> {
    serde_json::from_str(text)
        .map_err(|error| anyhow!("{}: not {what}: {}", path.display(), without_content(&error.to_string())))
}
