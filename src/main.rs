//! The `robofin` program: see `robofin --help`.

use std::process::ExitCode;

fn main() -> ExitCode {
    ExitCode::from(robofin::commands::run(std::env::args_os().collect()))
}
