//! The shared folder: campaigns made elsewhere that are not part of the project.

use std::path::{Path, PathBuf};

/// Returns a path in the shared folder, or reports that it is missing and returns `None`; panics instead if
/// `ROBOFIN_REQUIRE_SHARED` is 1. A relative `ROBOFIN_SHARED` starts at the workspace, whatever crate the test belongs
/// to.
pub fn shared(place: impl AsRef<Path>) -> Option<PathBuf> {
    let named = std::env::var_os("ROBOFIN_SHARED").map_or_else(|| PathBuf::from("../shared"), PathBuf::from);
    let place = workspace().join(named).join(place);
    if place.is_dir() {
        return Some(place);
    }
    assert!(std::env::var_os("ROBOFIN_REQUIRE_SHARED").is_none_or(|v| v != "1"), "{} is not there", place.display());
    eprintln!("NOT TESTED: {} is not there; set ROBOFIN_SHARED", place.display());
    None
}

/// Finds the folder of the lock file, at or above the crate under test.
fn workspace() -> &'static Path {
    let own = Path::new(env!("CARGO_MANIFEST_DIR"));
    own.ancestors().find(|folder| folder.join("Cargo.lock").is_file()).unwrap_or(own)
}
