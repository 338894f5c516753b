//! Files that a manifest names: they lie in its folder, unless `--allow-outside` says otherwise.
//!
//! Whoever sends a folder of measurements must not be able to have other files of the reader's opened and shown.

use std::path::{Component, Path, PathBuf};
use std::sync::atomic::{AtomicBool, Ordering};

/// True if files outside are accepted, in the whole process.
static OUTSIDE: AtomicBool = AtomicBool::new(false);

/// Why a named file is not opened.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Absent {
    /// It lies outside the folder, after all links are followed.
    Outside,
    /// There is no such file.
    Missing,
}

/// From now on manifests may name files anywhere.
pub fn allow_outside() {
    OUTSIDE.store(true, Ordering::Relaxed);
}

/// The place of a file that a manifest in `folder` names. Whether a file outside exists is not said.
pub fn place(folder: &Path, name: &Path) -> Result<PathBuf, Absent> {
    let path = folder.join(name);
    if OUTSIDE.load(Ordering::Relaxed) {
        return if path.exists() { Ok(path) } else { Err(Absent::Missing) };
    }
    if name.components().any(|part| !matches!(part, Component::Normal(_) | Component::CurDir)) {
        return Err(Absent::Outside);
    }
    match (path.canonicalize(), folder.canonicalize()) {
        (Ok(file), Ok(folder)) if file.starts_with(&folder) => Ok(path),
        (Ok(_), Ok(_)) => Err(Absent::Outside),
        _ => Err(Absent::Missing),
    }
}
