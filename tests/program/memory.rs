//! Absurdly fine voxels are refused before anything is allocated.

use std::process::Command;

use crate::program::{bracket, names, run};

/// Address space that suffices for a refusal [KiB].
const MEMORY: &str = "3000000";

/// Returns the program in a shell that limits its memory.
fn limited(verb: &str, flags: &[&str]) -> Command {
    let mut command = Command::new("sh");
    command.args(["-c", &format!("ulimit -v {MEMORY}; exec \"$@\""), "sh", env!("CARGO_BIN_EXE_robofin"), verb]);
    command.arg(bracket()).args(flags);
    command
}

#[test]
fn a_grid_that_would_not_fit_in_memory_is_refused_before_it_is_made() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    for verb in ["bake", "weld"] {
        for flags in [
            &["--voxel-mm", "0.001"][..],
            &["--voxel-mm", "1e-9"],
            &["--resolution", "4096"],
            &["--band", "64", "--resolution", "4096"],
            &["--band", "64", "--resolution", "2048"],
        ] {
            let outcome = run(limited(verb, flags).arg("--out").arg(folder.path().join("out")));
            outcome.is_refused(1, &["bricks", "--voxel-mm", "--resolution", "--band"]);
        }
    }
    assert_eq!(names(folder.path()), Vec::<String>::new());
}
