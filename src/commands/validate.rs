//! `robofin validate`: is this asset whole and consistent?

use std::path::{Path, PathBuf};

use anyhow::{Result, bail};
use clap::Args;
use serde::Serialize;

use crate::asset::UsdMode;
use crate::console::Console;
use crate::validate::{Validation, validate};

#[derive(Debug, Args)]
#[command(
    after_help = "Example:\n  robofin weld data/bracket.obj --out out/bracket --seed 7\n  robofin validate out/bracket"
)]
pub(super) struct ValidateArgs {
    /// Asset folder made by `robofin weld`.
    asset: PathBuf,
    /// USD file: auto opens it if Python can be had, require fails without it, off leaves it alone.
    #[arg(long, value_enum, default_value_t)]
    usd: UsdMode,
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
    let validation = validate(&args.asset, args.usd)?;
    let checks = &validation.checks;
    for check in checks {
        let verdict = if check.passed { "ok" } else { "FAILED" };
        console.step(verdict, format!("{}: {} ({})", check.file, check.rule, check.found));
    }
    for left_out in &validation.not_checked {
        console.step("not seen", left_out);
    }
    let failed = checks.iter().filter(|check| !check.passed).count();
    console.answer(&ValidateAnswer { asset: &args.asset, valid: failed == 0, validation: &validation })?;
    if failed > 0 {
        bail!("{}: {failed} of {} checks failed", args.asset.display(), checks.len());
    }
    console.step("valid", format!("all {} checks hold", checks.len()));
    Ok(())
}
