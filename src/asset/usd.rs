//! Whether an asset gets a USD file, which needs Python.

use std::path::{Path, PathBuf};

use anyhow::{Context, Result, bail};
use clap::ValueEnum;

use super::USD_FILE;
use crate::console::Console;
use export::python;
use export::usd::export;

/// What to do about USD.
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

/// Writes the USD file of the asset in `folder`, as far as the mode and the machine allow.
pub(super) fn write(folder: &Path, mode: UsdMode, console: &Console) -> Result<()> {
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
    for report in export(&[PathBuf::from(folder)], &python)? {
        if !report.errors.is_empty() {
            bail!("{USD_FILE} is not clean under usd-core's validators: {}", report.errors.join("; "));
        }
        console.step("usd", format!("{} prims, clean under usd-core's validators", report.prims));
    }
    Ok(())
}
