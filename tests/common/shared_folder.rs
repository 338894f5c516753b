//! The shared folder: campaigns that were made elsewhere and are no part of the project.

use std::path::{Path, PathBuf};

/// A place in it, or `None` and a word where it is not there; it must be where `ROBOFIN_REQUIRE_SHARED` is 1. A relative
/// `ROBOFIN_SHARED` begins at the workspace, whatever crate the test belongs to.
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

/// The folder of the lock file, at or above the crate under test.
fn workspace() -> &'static Path {
    let own = Path::new(env!("CARGO_MANIFEST_DIR"));
    own.ancestors().find(|folder| folder.join("Cargo.lock").is_file()).unwrap_or(own)
}
