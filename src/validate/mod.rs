//! Opens every file of an asset and compares it with the others.

mod dials;
mod fields;
mod files;
mod meshes;
mod surface;
mod welds;

use std::path::Path;

use anyhow::Result;

use crate::asset::{AssetFields, Check, EXPORTS, Manifest, Meshes, Opened, UsdMode, Validation, WELDS_FILE, Welds};

/// Checks an asset folder: first the hashes, then the agreement of the files.
///
/// A file that cannot be opened is a failed check, not an error, so that one run reports all faults.
///
/// # Errors
/// If the folder has no readable manifest.
pub fn validate(folder: &Path, usd: UsdMode) -> Result<Validation> {
    let manifest = Manifest::read(folder)?;
    let mut checks = files::check(folder, &manifest);
    let opened = Opened {
        folder,
        manifest: &manifest,
        meshes: opened(Meshes::open(folder), "workpiece.glb, welded.glb, surface.glb", &mut checks),
        fields: opened(AssetFields::open(folder), "phi.nvdb, weld.nvdb", &mut checks),
        truth: opened(Welds::read(folder), WELDS_FILE, &mut checks),
        usd,
    };
    let (meshes, fields, truth) = (opened.meshes.as_ref(), opened.fields.as_ref(), opened.truth.as_ref());
    if let Some(meshes) = meshes {
        checks.extend(meshes::check(meshes));
    }
    if let (Some(fields), Some(meshes)) = (fields, meshes) {
        checks.extend(fields::check(fields, meshes, truth));
        checks.extend(surface::check(&meshes.surface, fields, truth));
    }
    if let (Some(truth), Some(meshes), Some(fields)) = (truth, meshes, fields) {
        checks.extend(welds::check(truth, meshes, fields));
        checks.push(welds::check_ids(truth, meshes, fields));
        checks.extend(dials::check(truth, &meshes.part.mesh));
    }
    if let Some(truth) = truth {
        checks.extend(welds::check_manifest(truth, &manifest));
    }
    let mut found = Validation { checks, not_checked: Vec::new() };
    EXPORTS.iter().try_for_each(|export| (export.check)(&opened, &mut found))?;
    Ok(found)
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
