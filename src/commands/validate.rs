//! `robofin validate`: checks that an asset, or a data set, is complete and consistent.

use std::path::{Path, PathBuf};

use anyhow::{Result, bail};
use clap::Args;
use serde::Serialize;
use serde_json::Value;

use super::dataset::jobs;
use super::flags::JOBS;
use super::values::whole;
use super::{validate_images, validate_set};
use crate::asset::{UsdMode, Validation};
use crate::console::Console;
use crate::dataset::MARKER_FILE;
use crate::images::IMAGES_FORMAT;
use crate::validate::validate;
use crate::wrong_use;
use files::json_file::read_json;

#[derive(Debug, Args)]
#[command(
    after_help = "Examples:\n  robofin weld data/bracket.obj --out out/bracket --seed 7\n  robofin validate out/bracket\n  robofin validate out/set --repair"
)]
pub(super) struct ValidateArgs {
    /// Asset folder made by `robofin weld`, or data set made by `robofin dataset`.
    folder: PathBuf,
    /// USD file: auto opens it if Python can be had, require fails without it, off leaves it alone.
    #[arg(long, value_enum, default_value_t)]
    usd: UsdMode,
    /// Make the broken items of a data set again, and its catalogue.
    #[arg(long)]
    repair: bool,
    /// Where the sources of broken items are, if not where they were [default: as the data set was made].
    #[arg(long, value_name = "FOLDER|MESH", requires = "repair")]
    from: Vec<PathBuf>,
    /// Items of a data set at once [default: all cores].
    #[arg(long, value_name = "J", allow_negative_numbers = true, value_parser = whole::<usize>(JOBS))]
    jobs: Option<usize>,
}

/// The answer of `validate --json`.
#[derive(Serialize)]
struct ValidateAnswer<'a> {
    asset: &'a Path,
    valid: bool,
    #[serde(flatten)]
    validation: &'a Validation,
}

pub(super) fn run(args: &ValidateArgs, console: &Console) -> Result<()> {
    if format_of(&args.folder).as_deref() == Some(IMAGES_FORMAT) {
        if !args.from.is_empty() {
            return Err(wrong_use("--from: images are repaired from what their set holds".to_owned()));
        }
        return validate_images::run(&args.folder, args.repair, jobs(args.jobs), console);
    }
    if args.folder.join(MARKER_FILE).exists() {
        let from = (!args.from.is_empty()).then_some(args.from.as_slice());
        return validate_set::run(&args.folder, args.repair, from, jobs(args.jobs), console);
    }
    if args.repair {
        let place = args.folder.display();
        return Err(wrong_use(format!("--repair: {place} holds no {MARKER_FILE}; only data sets can be repaired")));
    }
    validate_asset(&args.folder, args.usd, console)
}

/// Reads the format of the data set in a folder.
fn format_of(folder: &Path) -> Option<String> {
    let marker: Value = read_json(&folder.join(MARKER_FILE), "a mark").ok()?;
    Some(marker.get("format")?.as_str()?.to_owned())
}

fn validate_asset(asset: &Path, usd: UsdMode, console: &Console) -> Result<()> {
    let validation = validate(asset, usd)?;
    let checks = &validation.checks;
    for check in checks {
        let verdict = if check.passed { "ok" } else { "FAILED" };
        console.step(verdict, format!("{}: {} ({})", check.file, check.rule, check.found));
    }
    for left_out in &validation.not_checked {
        console.step("not seen", left_out);
    }
    let failed = checks.iter().filter(|check| !check.passed).count();
    console.answer(&ValidateAnswer { asset, valid: failed == 0, validation: &validation })?;
    if failed > 0 {
        bail!("{}: {failed} of {} checks failed", asset.display(), checks.len());
    }
    console.step("valid", format!("all {} checks hold", checks.len()));
    Ok(())
}
