//! OpenUSD export and checks, by the scripts that use usd-core.
//!
//! One Python process serves a whole batch, because starting it takes longer than writing a stage. For the layout of a
//! stage see `docs/usd.md`.

use std::collections::BTreeMap;
use std::io::Write;
use std::path::{Path, PathBuf};

use serde::Deserialize;
use serde_json::{Value, json};

use super::glb::GENERATOR;
use crate::python::{Python, PythonError, Script};

/// Report of usd-core on one file.
#[derive(Clone, Debug, PartialEq, Deserialize)]
pub struct UsdReport {
    /// The `.usdc` file.
    pub path: PathBuf,
    /// Number of prims.
    pub prims: usize,
    /// Lowest and highest corner [m], z up, of the geometry drawn by default; `None` if there is none.
    pub bbox: Option<[[f64; 3]; 2]>,
    /// Defects of the file, or the reason why it was not written; empty if there are none.
    pub errors: Vec<String>,
}

#[derive(Deserialize)]
struct Reports {
    files: Vec<UsdReport>,
}

/// Writes `welded.usdc` into each asset folder from its `welded.glb` and `welds.json`, and checks it.
///
/// The reports are in the order of `assets`; a folder that fails has errors in its report and does not stop the others.
/// `origin` is written to the custom data of the layers: texts by name.
pub fn export(
    assets: &[PathBuf],
    origin: &BTreeMap<&str, String>,
    python: &Python,
) -> Result<Vec<UsdReport>, PythonError> {
    let io = |source| PythonError::Io { what: "writing the job for the USD export".to_owned(), source };
    let mut job = tempfile::Builder::new().prefix("robofin-usd-").suffix(".json").tempfile().map_err(io)?;
    let assets: Vec<PathBuf> = assets.iter().map(|path| absolute(path)).collect();
    let text = json!({ "generator": GENERATOR, "origin": origin, "assets": assets });
    job.write_all(text.to_string().as_bytes()).map_err(io)?;
    reports(Script::ExportUsd, python.run_script(Script::ExportUsd, [job.path()])?)
}

/// Checks USD files with all of usd-core's validators, and with checks that these lack.
pub fn check(files: &[PathBuf], python: &Python) -> Result<Vec<UsdReport>, PythonError> {
    reports(Script::CheckUsd, python.run_script(Script::CheckUsd, files)?)
}

/// Returns an absolute path, so that messages are valid in any current folder.
fn absolute(path: &Path) -> PathBuf {
    std::path::absolute(path).unwrap_or_else(|_| path.to_owned())
}

fn reports(script: Script, answer: Value) -> Result<Vec<UsdReport>, PythonError> {
    let text: String = answer.to_string().chars().take(200).collect();
    let reports: Reports = serde_json::from_value(answer).map_err(|error| PythonError::Answer {
        script: script.file_name(),
        answer: text,
        cause: error.to_string(),
    })?;
    Ok(reports.files)
}
