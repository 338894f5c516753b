//! Opens every file of an asset and holds it against the others.

mod dials;
mod fields;
mod files;
mod meshes;
mod surface;
mod usd;
mod welds;

use std::path::Path;

use anyhow::Result;
use serde::Serialize;

use crate::asset::{AssetFields, Manifest, UsdMode, WELDS_FILE, Welds};

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
    fn new(file: &str, rule: impl Into<String>, passed: bool, found: impl Into<String>) -> Self {
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

/// Checks an asset folder: hashes, then everything that the files say of each other.
///
/// A file that cannot be opened is a failed check, not an error, so that one run names all that is wrong.
///
/// # Errors
/// When the folder has no readable manifest.
pub fn validate(folder: &Path, usd: UsdMode) -> Result<Validation> {
    let manifest = Manifest::read(folder)?;
    let mut checks = files::check(folder, &manifest);
    let meshes = opened(meshes::Meshes::open(folder), "workpiece.glb, welded.glb, surface.glb", &mut checks);
    let fields = opened(AssetFields::open(folder), "phi.nvdb, weld.nvdb", &mut checks);
    let truth = opened(Welds::read(folder), WELDS_FILE, &mut checks);
    if let Some(meshes) = &meshes {
        checks.extend(meshes::check(meshes));
    }
    if let (Some(fields), Some(meshes)) = (&fields, &meshes) {
        checks.extend(fields::check(fields, meshes, truth.as_ref()));
        checks.extend(surface::check(&meshes.surface, fields, truth.as_ref()));
    }
    if let (Some(truth), Some(meshes), Some(fields)) = (&truth, &meshes, &fields) {
        checks.extend(welds::check(truth, meshes, fields));
        checks.push(welds::check_ids(truth, meshes, fields));
        checks.extend(dials::check(truth, &meshes.part.mesh));
    }
    if let Some(truth) = &truth {
        checks.extend(welds::check_manifest(truth, &manifest));
    }
    let mut validation = Validation { checks, not_checked: Vec::new() };
    usd::check(folder, &manifest, meshes.as_ref(), usd, &mut validation)?;
    Ok(validation)
}

fn opened<T>(result: Result<T>, file: &str, checks: &mut Vec<Check>) -> Option<T> {
    match result {
        Ok(value) => {
            checks.push(Check::new(file, "can be opened", true, "opened"));
            Some(value)
        }
        Err(error) => {
            checks.push(Check::new(file, "can be opened", false, format!("{error:#}")));
            None
        }
    }
}
