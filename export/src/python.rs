//! Python environment of the external libraries (usd-core, manifold3d, pycocotools): found, or created.
//!
//! Search order, as described in `docs/usd.md`:
//!
//! 1. `ROBOFIN_PYTHON`: exactly this interpreter, or an error.
//! 2. `VIRTUAL_ENV`, if the libraries are installed in it.
//! 3. `<project>/.venv`, where the project is the nearest folder above the current one, or else above the program, that
//!    contains RoboFin's `scripts/requirements.txt`; without a project, a per-user cache folder.
//! 4. Otherwise that last folder is filled (bootstrapped) from the pinned requirements, unless that is forbidden.
//!
//! The scripts are embedded in the program; they take file names as arguments and answer with one line of JSON. This
//! module prints nothing: a bootstrap is announced through a callback.

mod bootstrap;
mod process;

use std::ffi::OsStr;
use std::path::{Path, PathBuf};
use std::process::Command;
use std::time::Duration;

/// The pinned requirements, embedded so that an installed program needs no source tree.
pub const REQUIREMENTS: &str = include_str!("../../scripts/requirements.txt");

/// Time limit of one script; even a batch of hundreds of assets takes a few minutes.
const SCRIPT_LIMIT: Duration = Duration::from_secs(300);
const PROBE_LIMIT: Duration = Duration::from_secs(60);

/// Script that prints the versions found; it fails with the missing library.
const PROBE: &str = "
import sys
if not (3, 11) <= sys.version_info[:2] <= (3, 14):
    sys.exit('Python %d.%d found, 3.11 to 3.14 needed' % sys.version_info[:2])
import numpy, manifold3d, pycocotools.mask
from pxr import Usd, UsdValidation
print('Python %d.%d.%d' % sys.version_info[:3] + ', USD %d.%d.%d' % Usd.GetVersion() + ', numpy ' + numpy.__version__)
";

/// A script of `scripts/`.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Script {
    /// Writes `welded.usdc` into asset folders.
    ExportUsd,
    /// Checks USD files.
    CheckUsd,
    /// Computes the volume that beads add to a part, with manifold3d.
    CheckBeadVolume,
    /// Checks the COCO files of a set of images, with pycocotools.
    CheckCoco,
}

impl Script {
    /// Returns the file name under `scripts/`.
    pub fn file_name(self) -> &'static str {
        match self {
            Script::ExportUsd => "export_usd.py",
            Script::CheckUsd => "check_usd.py",
            Script::CheckBeadVolume => "check_bead_volume.py",
            Script::CheckCoco => "check_coco.py",
        }
    }
}

/// File names and texts of the scripts and of the modules that they import.
const FILES: [(&str, &str); 5] = [
    ("glb.py", include_str!("../../scripts/glb.py")),
    ("export_usd.py", include_str!("../../scripts/export_usd.py")),
    ("check_usd.py", include_str!("../../scripts/check_usd.py")),
    ("check_bead_volume.py", include_str!("../../scripts/check_bead_volume.py")),
    ("check_coco.py", include_str!("../../scripts/check_coco.py")),
];

/// Reason why Python cannot be found, created or used.
#[derive(Debug, thiserror::Error)]
pub enum PythonError {
    /// `ROBOFIN_PYTHON` names an interpreter that cannot be used.
    #[error("ROBOFIN_PYTHON is {}, which cannot be used: {cause}; unset it, or name a Python 3.11 to 3.14 with \
             scripts/requirements.txt installed", .path.display())]
    Chosen {
        /// Path of the interpreter.
        path: PathBuf,
        /// Error message of the interpreter.
        cause: String,
    },
    /// The project has a virtual environment that RoboFin did not create and that lacks the libraries.
    #[error("{} lacks what scripts/requirements.txt lists ({cause}); install that there, or delete the folder and \
             run again", .venv.display())]
    Incomplete {
        /// Folder of the environment.
        venv: PathBuf,
        /// Missing library.
        cause: String,
    },
    /// No environment is found, and creating one is forbidden.
    #[error("no Python environment with usd-core at {}, and making one is not allowed here; unset \
             ROBOFIN_NO_BOOTSTRAP, or set ROBOFIN_PYTHON to one that has scripts/requirements.txt", .venv.display())]
    Forbidden {
        /// Folder in which one would be created.
        venv: PathBuf,
    },
    /// No folder for an environment is known.
    #[error("no folder to keep a Python environment in: set HOME or XDG_CACHE_HOME, or set ROBOFIN_PYTHON")]
    NoPlace,
    /// There is no interpreter to create an environment with.
    #[error("no Python 3.11 to 3.14 on PATH ({found}): apt-get install -y python3 python3-venv, or install uv")]
    NoInterpreter {
        /// Unsuitable interpreter that was found instead.
        found: String,
    },
    /// The module `venv` is missing; Debian packages it separately.
    #[error("python3-venv is missing: apt-get install -y python3-venv")]
    NoVenvModule,
    /// The environment cannot be created or filled.
    #[error("could not make the Python environment {}: {step}: {cause}", .venv.display())]
    Bootstrap {
        /// Folder of the environment.
        venv: PathBuf,
        /// Step that failed.
        step: &'static str,
        /// Last error message of the step.
        cause: String,
    },
    /// A temporary file or a process cannot be created.
    #[error("{what}: {source}")]
    Io {
        /// Action that failed.
        what: String,
        /// Error of the operating system.
        source: std::io::Error,
    },
    /// A script failed.
    #[error("{script} failed ({status}): {stderr}")]
    Script {
        /// File name of the script.
        script: &'static str,
        /// Exit status.
        status: String,
        /// Last lines of standard error.
        stderr: String,
    },
    /// A script, or a step of the bootstrap, exceeded its time limit.
    #[error("{what} did not finish within {seconds} s and was stopped")]
    TimedOut {
        /// Name of the script or step.
        what: String,
        /// Time limit [s].
        seconds: u64,
    },
    /// A script succeeded, but its last line is not the expected JSON.
    #[error("{script} answered {answer:?} instead of the JSON expected ({cause})")]
    Answer {
        /// File name of the script.
        script: &'static str,
        /// Last line of its standard output.
        answer: String,
        /// Error message of the parser.
        cause: String,
    },
}

/// An interpreter with the libraries installed.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Python {
    executable: PathBuf,
    versions: String,
}

/// Places to search for Python; [`Places::from_environment`] fills them in the order of the module's documentation.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Places {
    /// `ROBOFIN_PYTHON`: exactly this interpreter.
    pub chosen: Option<PathBuf>,
    /// `VIRTUAL_ENV`.
    pub active: Option<PathBuf>,
    /// Environment that the program may create: `<project>/.venv` or one in the cache folder.
    pub own: Option<PathBuf>,
    /// True if `ROBOFIN_NO_BOOTSTRAP` is not set.
    pub bootstrap_allowed: bool,
}

impl Places {
    /// Reads the environment variables, the current folder and the program's own path.
    pub fn from_environment() -> Places {
        let path = |name: &str| std::env::var_os(name).filter(|value| !value.is_empty()).map(PathBuf::from);
        let starts = [std::env::current_dir().ok(), std::env::current_exe().ok()];
        let project = starts.iter().flatten().find_map(|start| project_above(start));
        let cache = || path("XDG_CACHE_HOME").or_else(|| Some(path("HOME")?.join(".cache")));
        Places {
            chosen: path("ROBOFIN_PYTHON"),
            active: path("VIRTUAL_ENV"),
            own: project.map(|folder| folder.join(".venv")).or_else(|| Some(cache()?.join("robofin").join("venv"))),
            bootstrap_allowed: path("ROBOFIN_NO_BOOTSTRAP").is_none_or(|value| value.as_os_str() == "0"),
        }
    }

    /// Finds an interpreter, or creates an environment if `announce` is given and bootstrapping is allowed.
    ///
    /// `announce` is called with one line for people before each slow step.
    pub fn find(&self, announce: Option<&mut dyn FnMut(&str)>) -> Result<Python, PythonError> {
        if let Some(path) = &self.chosen {
            return Python::probe(path).map_err(|cause| PythonError::Chosen { path: path.clone(), cause });
        }
        if let Some(python) = self.active.as_ref().and_then(|venv| Python::probe(&interpreter_in(venv)).ok()) {
            return Ok(python);
        }
        let venv = self.own.as_ref().ok_or(PythonError::NoPlace)?;
        if let Some(python) = bootstrap::present(venv)? {
            return Ok(python);
        }
        match announce {
            Some(announce) if self.bootstrap_allowed => bootstrap::make(venv, announce),
            _ => Err(PythonError::Forbidden { venv: venv.clone() }),
        }
    }
}

/// Finds Python as [`Places::from_environment`] and [`Places::find`] describe.
pub fn find(announce: Option<&mut dyn FnMut(&str)>) -> Result<Python, PythonError> {
    Places::from_environment().find(announce)
}

impl Python {
    /// Returns the path of the interpreter.
    pub fn executable(&self) -> &Path {
        &self.executable
    }

    /// Returns the versions of Python, USD and numpy, for people and for records.
    pub fn versions(&self) -> &str {
        &self.versions
    }

    /// Runs a script on `arguments` and returns the last line of its standard output as JSON.
    pub fn run_script<A: AsRef<OsStr>>(
        &self,
        script: Script,
        arguments: impl IntoIterator<Item = A>,
    ) -> Result<serde_json::Value, PythonError> {
        let name = script.file_name();
        let folder = unpack_scripts()?;
        let mut command = self.command();
        command.arg("-B").arg(folder.path().join(name)).args(arguments);
        let done = process::run(command, name, SCRIPT_LIMIT)?;
        if !done.status.success() {
            return Err(PythonError::Script {
                script: name,
                status: done.status.to_string(),
                stderr: done.last_lines(5),
            });
        }
        let answer = done.stdout.lines().rev().find(|line| !line.trim().is_empty()).unwrap_or_default();
        serde_json::from_str(answer).map_err(|error| PythonError::Answer {
            script: name,
            answer: answer.chars().take(200).collect(),
            cause: error.to_string(),
        })
    }

    /// Checks that an interpreter has the libraries; the error is its last line of standard error.
    fn probe(executable: &Path) -> Result<Python, String> {
        let mut python = Python { executable: executable.to_owned(), versions: String::new() };
        let mut command = python.command();
        command.args(["-c", PROBE]);
        let done =
            process::run(command, "the check of the Python environment", PROBE_LIMIT).map_err(|e| e.to_string())?;
        if !done.status.success() {
            return Err(done.last_lines(1));
        }
        python.versions = done.stdout.trim().to_owned();
        Ok(python)
    }

    /// Makes a command for the interpreter, without the variables that would mix another installation into it.
    fn command(&self) -> Command {
        let mut command = Command::new(&self.executable);
        command.env_remove("PYTHONPATH").env_remove("PYTHONHOME").env("PYTHONHASHSEED", "0");
        command
    }
}

fn unpack_scripts() -> Result<tempfile::TempDir, PythonError> {
    let io = |source| PythonError::Io { what: "unpacking the Python scripts".to_owned(), source };
    let folder = tempfile::Builder::new().prefix("robofin-scripts-").tempdir().map_err(io)?;
    for (name, text) in FILES {
        std::fs::write(folder.path().join(name), text).map_err(io)?;
    }
    Ok(folder)
}

/// Returns the interpreter of a virtual environment.
fn interpreter_in(venv: &Path) -> PathBuf {
    if cfg!(windows) { venv.join("Scripts").join("python.exe") } else { venv.join("bin").join("python") }
}

/// Finds the nearest folder with RoboFin's requirements; a requirements file of another project does not count.
fn project_above(start: &Path) -> Option<PathBuf> {
    let ours = |folder: &&Path| {
        let text = std::fs::read_to_string(folder.join("scripts").join("requirements.txt"));
        text.is_ok_and(|text| text.lines().eq(REQUIREMENTS.lines()))
    };
    start.ancestors().find(ours).map(Path::to_owned)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_project_is_known_by_our_requirements_and_not_by_the_file_name() {
        let folder = tempfile::tempdir().expect("a temporary folder");
        let inner = folder.path().join("theirs").join("scripts");
        std::fs::create_dir_all(&inner).expect("folders can be made");
        std::fs::write(inner.join("requirements.txt"), "flask\n").expect("it can be written");
        assert_eq!(project_above(&inner), None);
        let outer = folder.path().join("scripts");
        std::fs::create_dir_all(&outer).expect("folders can be made");
        std::fs::write(outer.join("requirements.txt"), REQUIREMENTS).expect("it can be written");
        assert_eq!(project_above(&inner), Some(folder.path().to_owned()));
    }

    #[test]
    fn in_the_source_tree_the_environment_is_the_projects_own() {
        let own = Places::from_environment().own;
        let project = Path::new(env!("CARGO_MANIFEST_DIR")).parent().expect("the project");
        assert_eq!(own, Some(project.join(".venv")));
    }
}
