//! The `robofin` program: see `robofin --help`.

use std::process::ExitCode;

fn main() -> ExitCode {
    robofin::commands::main()
}
