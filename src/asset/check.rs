//! Results of an asset's checks, and the opened files that the checks read.

use std::path::Path;

use serde::Serialize;

use super::{AssetFields, Manifest, Meshes, UsdMode, Welds};

/// One thing that was checked.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Check {
    /// File or files that were opened.
    pub file: String,
    /// Condition that the file must meet, in words.
    pub rule: String,
    /// True if the file meets the condition.
    pub passed: bool,
    /// Values found, in words.
    pub found: String,
}

impl Check {
    pub(crate) fn new(file: &str, rule: impl Into<String>, passed: bool, found: impl Into<String>) -> Self {
        Self { file: file.to_owned(), rule: rule.into(), passed, found: found.into() }
    }
}

/// Results of a validation: checks that were made, and those that could not be made.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub struct Validation {
    /// Everything that was checked.
    pub checks: Vec<Check>,
    /// Checks that were not made, each with the reason; neither passed nor failed.
    pub not_checked: Vec<String>,
}

/// The files of an asset, opened; `None` for those that cannot be.
pub struct Opened<'a> {
    /// The asset.
    pub folder: &'a Path,
    /// Its manifest.
    pub manifest: &'a Manifest,
    /// Its glTF files.
    pub meshes: Option<Meshes>,
    /// Its NanoVDB files.
    pub fields: Option<AssetFields>,
    /// Its truth.
    pub truth: Option<Welds>,
    /// Mode of the check of USD: `Off` leaves it out.
    pub usd: UsdMode,
}
