//! `welded.usdc`: written if Python is available, and checked with usd-core.

use std::path::{Path, PathBuf};

use anyhow::{Context, Result, bail};
use clap::ValueEnum;

use super::check::{Check, Opened, Validation};
use super::exporter::{Content, Exporter};
use super::{Meshes, USD_FILE};
use export::python;
use export::usd::{self, UsdReport};

/// Greatest difference between the boxes of glTF and USD file [m]; both hold the same single-precision numbers.
const BOX_TOLERANCE: f64 = 1e-6;

/// Mode of the USD file.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, ValueEnum)]
pub enum UsdMode {
    /// Make it if Python can be had; otherwise say what was left out.
    #[default]
    Auto,
    /// Fail without it.
    Require,
    /// Leave it out.
    Off,
}

/// Exporter of the USD file, made from `welded.glb` and `welds.json`.
pub(super) struct Usd;

impl Exporter for Usd {
    const FILE: &'static str = USD_FILE;
    const MEDIA_TYPE: &'static str = "model/vnd.usd";
    const ALWAYS: bool = false;

    fn write(content: &Content<'_>, place: &Path) -> Result<()> {
        let (mode, console) = (content.extras.usd, content.console);
        if mode == UsdMode::Off {
            return Ok(());
        }
        let python = match python::find(Some(&mut |line: &str| console.step("python", line))) {
            Ok(python) => python,
            Err(error) if mode == UsdMode::Auto => {
                console.step("usd", format!("{USD_FILE} was left out: {error}"));
                return Ok(());
            }
            Err(error) => return Err(error).context(format!("{USD_FILE} is required")),
        };
        let folder = place.parent().map(PathBuf::from).unwrap_or_default();
        for report in usd::export(&[folder], &content.origin, &python)? {
            if !report.errors.is_empty() {
                bail!("{USD_FILE} is not clean under usd-core's validators: {}", report.errors.join("; "));
            }
            console.step("usd", format!("{} prims, clean under usd-core's validators", report.prims));
        }
        Ok(())
    }

    fn check(opened: &Opened<'_>, found: &mut Validation) -> Result<()> {
        let Opened { folder, manifest, usd: mode, .. } = opened;
        let mut unseen = |why: &str| found.not_checked.push(format!("{USD_FILE}: only its hash was checked: {why}"));
        let listed = manifest.files.contains_key(USD_FILE);
        match (listed, mode) {
            (false, UsdMode::Require) => {
                let absent = "the asset was made without USD";
                found.checks.push(Check::new(USD_FILE, "is part of the asset", false, absent));
            }
            (false, _) => {}
            (true, UsdMode::Off) => unseen("--usd off"),
            (true, _) => match python::find(None) {
                Ok(python) => {
                    let reports = usd::check(&[folder.join(USD_FILE)], &python)?;
                    let checks = reports.iter().flat_map(|report| check_report(report, opened.meshes.as_ref()));
                    found.checks.extend(checks);
                }
                Err(error) if *mode == UsdMode::Require => return Err(error.into()),
                Err(error) => unseen(&error.to_string()),
            },
        }
        Ok(())
    }
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
