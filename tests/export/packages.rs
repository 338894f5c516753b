//! Python environments with packages that the program itself does not need.

use std::fs::{self, File};
use std::path::{Path, PathBuf};
use std::process::Command;

use crate::outside::untested;

/// Returns a Python with `packages`, installed once per build folder under `name` and probed by a script; `None` after
/// reporting a skipped test. These are packages that the program does not need.
pub(crate) fn packages(name: &str, packages: &[&str], probe: &str, what: &str) -> Option<PathBuf> {
    installed(name, packages, probe).map_err(|cause| untested(what, &cause)).ok()
}

fn installed(name: &str, packages: &[&str], probe: &str) -> Result<PathBuf, String> {
    let folder = Path::new(env!("CARGO_TARGET_TMPDIR")).join(name);
    fs::create_dir_all(&folder).map_err(|error| error.to_string())?;
    let lock = File::create(folder.join("lock")).map_err(|error| error.to_string())?;
    lock.lock().map_err(|error| error.to_string())?;
    let python = folder.join("venv/bin/python");
    let works = || Command::new(&python).args(["-c", probe]).output().is_ok_and(|done| done.status.success());
    if !works() {
        let steps = [
            ("python3", vec!["-m", "venv", "--clear", "venv"]),
            ("venv/bin/python", [&["-m", "pip", "install", "--quiet", "--only-binary=:all:"], packages].concat()),
        ];
        for (program, words) in steps {
            let program = if program == "python3" { PathBuf::from(program) } else { folder.join(program) };
            let done = Command::new(&program).args(&words).current_dir(&folder).output();
            let done = done.map_err(|error| format!("{}: {error}", program.display()))?;
            if !done.status.success() {
                return Err(format!("{}: {}", program.display(), String::from_utf8_lossy(&done.stderr).trim()));
            }
        }
    }
    if works() { Ok(python) } else { Err(format!("{packages:?} were installed and cannot be loaded")) }
}
