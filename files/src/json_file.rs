//! Reading of JSON files: only regular files, and errors that do not repeat their content.

use std::fs;
use std::path::Path;

use serde::Serialize;
use serde::de::DeserializeOwned;

use crate::error::FileError;
use crate::input::{self, MOST_TEXT_BYTES, without_content};

/// Reads a JSON file with the expected content `what`, such as `the record of an image`.
///
/// # Errors
/// If the file cannot be read or holds something else. The error gives the type and length found, and what is accepted.
pub fn read_json<T: DeserializeOwned>(path: &Path, what: &str) -> Result<T, FileError> {
    parse_json(path, &input::read_text(path, MOST_TEXT_BYTES)?, what)
}

/// As [`read_json`], for a text that was read from `path`.
///
/// # Errors
/// As for [`read_json`].
pub fn parse_json<T: DeserializeOwned>(path: &Path, text: &str, what: &str) -> Result<T, FileError> {
    serde_json::from_str(text).map_err(|error| FileError::Content {
        place: path.to_owned(),
        what: what.to_owned(),
        found: without_content(&error.to_string()).to_string(),
    })
}

/// Writes a value as indented JSON.
///
/// # Errors
/// If the file cannot be written.
pub fn write_json(path: &Path, value: &impl Serialize) -> Result<(), FileError> {
    let mut text = serde_json::to_string_pretty(value).map_err(FileError::encoding(path))?;
    text.push('\n');
    fs::write(path, text).map_err(FileError::at(path, "cannot write this file"))
}
