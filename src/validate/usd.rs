//! The USD file, opened by usd-core.

use std::path::Path;

use anyhow::Result;

use super::meshes::Meshes;
use super::{Check, Validation};
use crate::asset::{Manifest, USD_FILE, UsdMode};
use export::python;
use export::usd::{self, UsdReport};

/// Boxes of the glTF and the USD file hold the same single-precision numbers.
const BOX_TOLERANCE: f64 = 1e-6;

/// Adds the checks of the USD file, or why its content was not looked at.
pub(super) fn check(
    folder: &Path,
    manifest: &Manifest,
    meshes: Option<&Meshes>,
    mode: UsdMode,
    validation: &mut Validation,
) -> Result<()> {
    let mut unseen = |why: &str| validation.not_checked.push(format!("{USD_FILE}: only its hash was checked: {why}"));
    let listed = manifest.files.contains_key(USD_FILE);
    match (listed, mode) {
        (false, UsdMode::Require) => {
            let absent = "the asset was made without USD";
            validation.checks.push(Check::new(USD_FILE, "is part of the asset", false, absent));
        }
        (false, _) => {}
        (true, UsdMode::Off) => unseen("--usd off"),
        (true, _) => match python::find(None) {
            Ok(python) => {
                let reports = usd::check(&[folder.join(USD_FILE)], &python)?;
                validation.checks.extend(reports.iter().flat_map(|report| check_report(report, meshes)));
            }
            Err(error) if mode == UsdMode::Require => return Err(error.into()),
            Err(error) => unseen(&error.to_string()),
        },
    }
    Ok(())
}

fn check_report(report: &UsdReport, meshes: Option<&Meshes>) -> Vec<Check> {
    let found = match report.errors.is_empty() {
        true => format!("{} prims", report.prims),
        false => report.errors.join("; "),
    };
    let mut checks =
        vec![Check::new(USD_FILE, "is clean under usd-core's validators", report.errors.is_empty(), found)];
    if let (Some([low, high]), Some(bounds)) = (report.bbox, meshes.and_then(Meshes::welded_bounds)) {
        let apart = (bounds.0 - glam::DVec3::from(low)).abs().max((bounds.1 - glam::DVec3::from(high)).abs());
        let relative = apart.max_element() / (bounds.1 - bounds.0).length();
        let found = format!("{relative:.1e} of the diagonal apart");
        checks.push(Check::new(USD_FILE, "has the box of welded.glb", relative <= BOX_TOLERANCE, found));
    }
    checks
}
