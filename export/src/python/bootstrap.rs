//! Creates a virtual environment from the pinned requirements, once, even if several processes start together.
//!
//! The environment is built in `<venv>.tmp` under a file lock and renamed at the end, so an incomplete environment is
//! never used. A copy of the requirements inside marks an environment created by RoboFin: an outdated one is replaced;
//! one created by somebody else is left alone.

use std::fs::{self, File};
use std::path::{Path, PathBuf};
use std::process::Command;
use std::time::Duration;

use super::{Python, PythonError, REQUIREMENTS, interpreter_in, process};

const STAMP: &str = "robofin-requirements.txt";
const STEP_LIMIT: Duration = Duration::from_secs(600);

/// Returns the environment at `venv` if it can be used; `None` if it is absent, or RoboFin's own and outdated.
pub(super) fn present(venv: &Path) -> Result<Option<Python>, PythonError> {
    if !venv.exists() {
        return Ok(None);
    }
    let stamp = fs::read_to_string(venv.join(STAMP)).ok();
    if stamp.as_ref().is_some_and(|text| text != REQUIREMENTS) {
        return Ok(None);
    }
    match Python::probe(&interpreter_in(venv)) {
        Ok(python) => Ok(Some(python)),
        Err(_) if stamp.is_some() => Ok(None),
        Err(cause) => Err(PythonError::Incomplete { venv: venv.to_owned(), cause }),
    }
}

/// Creates the environment, or waits for the process that is creating it.
pub(super) fn make(venv: &Path, announce: &mut dyn FnMut(&str)) -> Result<Python, PythonError> {
    let failed = |step: &'static str| {
        move |error: std::io::Error| PythonError::Bootstrap { venv: venv.to_owned(), step, cause: error.to_string() }
    };
    if let Some(parent) = venv.parent() {
        fs::create_dir_all(parent).map_err(failed("creating its folder"))?;
    }
    let lock = File::create(beside(venv, ".lock")).map_err(failed("creating its lock"))?;
    lock.lock().map_err(failed("locking"))?;
    if let Some(python) = present(venv)? {
        return Ok(python);
    }
    announce(&format!("making a Python environment with usd-core in {} (once, about half a minute)", venv.display()));
    let fresh = beside(venv, ".tmp");
    let built = build(&fresh, venv).and_then(|()| {
        if venv.exists() {
            fs::remove_dir_all(venv).map_err(failed("removing the outdated one"))?;
        }
        fs::rename(&fresh, venv).map_err(failed("renaming"))
    });
    if built.is_err() {
        // The cause is in `built`; the next attempt removes what cannot be removed now.
        let _ = fs::remove_dir_all(&fresh);
    }
    built?;
    Python::probe(&interpreter_in(venv)).map_err(|cause| PythonError::Bootstrap {
        venv: venv.to_owned(),
        step: "checking it",
        cause,
    })
}

/// Builds the environment with uv if it is installed, otherwise (or if uv fails) with the standard library's venv and
/// pip.
fn build(fresh: &Path, venv: &Path) -> Result<(), PythonError> {
    if runs("uv") && build_with_uv(fresh, venv).is_ok() {
        return Ok(());
    }
    let base = base_interpreter()?;
    clear(fresh, venv)?;
    let mut create = clean(base);
    create.args(["-m", "venv"]).arg(fresh);
    let done = process::run(create, "python3 -m venv", STEP_LIMIT)?;
    if done.says("ensurepip") || done.says("No module named venv") {
        return Err(PythonError::NoVenvModule);
    }
    expect(done, venv, "python3 -m venv")?;
    let requirements = stamp(fresh, venv)?;
    let mut install = clean(interpreter_in(fresh));
    install.args(["-m", "pip", "install", "--disable-pip-version-check", "--quiet", "--only-binary=:all:", "-r"]);
    install.arg(requirements);
    expect(process::run(install, "pip install", STEP_LIMIT)?, venv, "pip install")
}

fn build_with_uv(fresh: &Path, venv: &Path) -> Result<(), PythonError> {
    clear(fresh, venv)?;
    let mut create = clean("uv");
    create.args(["venv", "--quiet", "--python", ">=3.11,<3.15"]).arg(fresh);
    expect(process::run(create, "uv venv", STEP_LIMIT)?, venv, "uv venv")?;
    let requirements = stamp(fresh, venv)?;
    let mut install = clean("uv");
    install.args(["pip", "install", "--quiet", "--only-binary=:all:", "--python"]).arg(interpreter_in(fresh));
    install.arg("-r").arg(requirements);
    expect(process::run(install, "uv pip install", STEP_LIMIT)?, venv, "uv pip install")
}

/// Finds the first `python3` on PATH with a version that usd-core supports.
fn base_interpreter() -> Result<&'static str, PythonError> {
    let mut found = Vec::new();
    for name in ["python3", "python3.14", "python3.13", "python3.12", "python3.11", "python"] {
        let mut command = clean(name);
        command.args(["-c", "import sys; print('%d.%d' % sys.version_info[:2])"]);
        let Ok(done) = process::run(command, name, STEP_LIMIT) else { continue };
        let version = done.stdout.trim().to_owned();
        if ["3.11", "3.12", "3.13", "3.14"].contains(&version.as_str()) {
            return Ok(name);
        }
        found.push(format!("{name} is {version}"));
    }
    let found = if found.is_empty() { "none at all".to_owned() } else { found.join(", ") };
    Err(PythonError::NoInterpreter { found })
}

fn runs(program: &str) -> bool {
    let mut command = Command::new(program);
    command.arg("--version");
    process::run(command, program, STEP_LIMIT).is_ok_and(|done| done.status.success())
}

fn clean(program: impl AsRef<std::ffi::OsStr>) -> Command {
    let mut command = Command::new(program);
    command.env_remove("PYTHONPATH").env_remove("PYTHONHOME").env_remove("VIRTUAL_ENV");
    command
}

fn expect(done: process::Finished, venv: &Path, step: &'static str) -> Result<(), PythonError> {
    if done.status.success() {
        return Ok(());
    }
    Err(PythonError::Bootstrap { venv: venv.to_owned(), step, cause: done.last_lines(2) })
}

/// Writes the requirements into the environment and returns the file's path.
fn stamp(fresh: &Path, venv: &Path) -> Result<PathBuf, PythonError> {
    let path = fresh.join(STAMP);
    fs::write(&path, REQUIREMENTS).map_err(|error| PythonError::Bootstrap {
        venv: venv.to_owned(),
        step: "writing the requirements",
        cause: error.to_string(),
    })?;
    Ok(path)
}

fn clear(fresh: &Path, venv: &Path) -> Result<(), PythonError> {
    match fs::remove_dir_all(fresh) {
        Err(error) if error.kind() != std::io::ErrorKind::NotFound => Err(PythonError::Bootstrap {
            venv: venv.to_owned(),
            step: "removing an unfinished one",
            cause: error.to_string(),
        }),
        _ => Ok(()),
    }
}

fn beside(venv: &Path, suffix: &str) -> PathBuf {
    let mut name = venv.as_os_str().to_owned();
    name.push(suffix);
    PathBuf::from(name)
}
