//! External programs: Python with usd-core and manifold3d, node with gltf-validator; reports of skipped tests.

use std::fs::{self, File};
use std::io::Write;
use std::path::{Path, PathBuf};
use std::process::Command;

use export::python::{Python, find};
use serde_json::Value;

/// Reports a skipped test, bypassing the test harness's capture; fails if outside programs are required.
pub(crate) fn untested(what: &str, cause: &str) {
    let promised = std::env::var_os("ROBOFIN_REQUIRE_OUTSIDE").is_some_and(|value| value == "1");
    assert!(!promised, "ROBOFIN_REQUIRE_OUTSIDE=1, but {what} cannot be tested: {cause}");
    writeln!(std::io::stderr(), "NOT TESTED: {what}: {cause}").expect("standard error is open");
}

/// Returns Python with the pinned libraries, found or created; `None` after reporting a skipped test.
pub(crate) fn python(what: &str) -> Option<Python> {
    let mut announce = |line: &str| writeln!(std::io::stderr(), "{line}").expect("standard error is open");
    match find(Some(&mut announce)) {
        Ok(python) => Some(python),
        Err(error) => {
            untested(what, &error.to_string());
            None
        }
    }
}

/// Returns the report of gltf-validator on each file; `None` after reporting a skipped test.
pub(crate) fn gltf_validator(what: &str, files: &[PathBuf]) -> Option<Vec<Value>> {
    let modules = match validator_modules() {
        Ok(modules) => modules,
        Err(cause) => {
            untested(what, &cause);
            return None;
        }
    };
    let script = Path::new(env!("CARGO_MANIFEST_DIR")).join("scripts/check_gltf.mjs");
    let done =
        Command::new("node").arg(script).args(files).env("NODE_PATH", modules).output().expect("node ran before");
    let text = String::from_utf8(done.stdout).expect("the answer is text");
    let reports: Vec<Value> = text.lines().map(|line| serde_json::from_str(line).expect("a line of JSON")).collect();
    assert_eq!(reports.len(), files.len(), "{}", String::from_utf8_lossy(&done.stderr));
    let clean = reports.iter().all(|report| report["errors"] == 0 && report["warnings"] == 0);
    assert_eq!(done.status.code(), Some(i32::from(!clean)), "the exit code says what the reports say");
    Some(reports)
}

/// Returns a folder with gltf-validator: that of `NODE_PATH`, or one that npm fills once per build folder.
fn validator_modules() -> Result<PathBuf, String> {
    let probe = Command::new("node").arg("--version").output().map_err(|error| format!("node: {error}"))?;
    if !probe.status.success() {
        return Err("node --version fails".to_owned());
    }
    let installed = |modules: &Path| modules.join("gltf-validator").join("package.json").is_file();
    if let Some(modules) = std::env::var_os("NODE_PATH").map(PathBuf::from).filter(|path| installed(path)) {
        return Ok(modules);
    }
    let folder = Path::new(env!("CARGO_TARGET_TMPDIR")).join("gltf-validator");
    fs::create_dir_all(&folder).map_err(|error| error.to_string())?;
    let lock = File::create(folder.join("lock")).map_err(|error| error.to_string())?;
    lock.lock().map_err(|error| error.to_string())?;
    let modules = folder.join("node_modules");
    if !installed(&modules) {
        let mut npm = Command::new("npm");
        npm.args(["install", "--no-audit", "--no-fund", "gltf-validator@2.0.0-dev.3.10", "--prefix"]).arg(&folder);
        let done = npm.output().map_err(|error| format!("npm: {error}"))?;
        if !installed(&modules) {
            return Err(format!("npm install: {}", String::from_utf8_lossy(&done.stderr).trim()));
        }
    }
    Ok(modules)
}
