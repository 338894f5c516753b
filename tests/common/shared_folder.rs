//! The shared folder: campaigns that were made elsewhere and are no part of the project.

use std::path::{Path, PathBuf};

/// A place in it, or `None` and a word where it is not there; it must be where `ROBOFIN_REQUIRE_SHARED` is 1.
pub fn shared(place: impl AsRef<Path>) -> Option<PathBuf> {
    let beside = || PathBuf::from("../shared");
    let place = std::env::var_os("ROBOFIN_SHARED").map_or_else(beside, PathBuf::from).join(place);
    if place.is_dir() {
        return Some(place);
    }
    assert!(std::env::var_os("ROBOFIN_REQUIRE_SHARED").is_none_or(|v| v != "1"), "{} is not there", place.display());
    eprintln!("NOT TESTED: {} is not there; set ROBOFIN_SHARED", place.display());
    None
}
