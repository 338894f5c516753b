//! The command line of the program, run in the interpreter's process.

use std::ffi::OsString;
use std::path::PathBuf;

use files::program::Program;
use pyo3::prelude::*;

/// Runs a command line, whose first word is the program's name. Returns the exit code.
///
/// - `module`: file of this module, which identifies the build
/// - `start`: command that starts the program again, for the processes of items
#[pyfunction]
pub fn run(py: Python<'_>, words: Vec<OsString>, module: PathBuf, start: Vec<OsString>) -> u8 {
    Program { file: module, start }.host();
    py.detach(|| robofin::commands::run(words))
}
