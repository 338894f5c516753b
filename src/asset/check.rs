//! What is checked of an asset, and what the checks see.

use std::path::Path;

use serde::Serialize;

use super::{AssetFields, Manifest, Meshes, UsdMode, Welds};

/// One thing that was checked.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Check {
    /// File or files that were opened.
    pub file: String,
    /// What must hold.
    pub rule: String,
    /// Whether it holds.
    pub passed: bool,
    /// What was found.
    pub found: String,
}

impl Check {
    pub(crate) fn new(file: &str, rule: impl Into<String>, passed: bool, found: impl Into<String>) -> Self {
        Self { file: file.to_owned(), rule: rule.into(), passed, found: found.into() }
    }
}

/// What validation found, and what it could not look at.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub struct Validation {
    /// Everything that was checked.
    pub checks: Vec<Check>,
    /// What was not checked, and why; neither passed nor failed.
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
    /// Whether to open USD.
    pub usd: UsdMode,
}
