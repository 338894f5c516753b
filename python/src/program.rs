//! The program: its whole command line in the process of the interpreter.

use std::ffi::OsString;
use std::path::PathBuf;

use files::program::Program;
use pyo3::prelude::*;

/// Runs a command line, the program's name first. Returns the exit code.
///
/// - `module`: the file of this module, by which the build is known
/// - `start`: what starts the program again, for the processes of items
#[pyfunction]
pub fn run(py: Python<'_>, words: Vec<OsString>, module: PathBuf, start: Vec<OsString>) -> u8 {
    Program { file: module, start }.host();
    py.detach(|| robofin::commands::run(words))
}
