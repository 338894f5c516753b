//! Results of an asset's checks, and the opened files that the checks read.

use std::path::Path;

use serde::Serialize;

use super::{AssetFields, Manifest, Meshes, UsdMode, Welds};

/// Result of one check.
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

/// Results of a validation.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub struct Validation {
    /// Results of all checks made.
    pub checks: Vec<Check>,
    /// Checks that could not be made, each with the reason; they neither passed nor failed.
    pub not_checked: Vec<String>,
}

/// Opened files of an asset; `None` for those that cannot be opened.
pub struct Opened<'a> {
    /// Folder of the asset.
    pub folder: &'a Path,
    /// Manifest.
    pub manifest: &'a Manifest,
    /// Meshes of the glTF files.
    pub meshes: Option<Meshes>,
    /// Fields of the NanoVDB files.
    pub fields: Option<AssetFields>,
    /// Ground truth of the welds.
    pub truth: Option<Welds>,
    /// Mode of the USD check; `Off` leaves it out.
    pub usd: UsdMode,
}
