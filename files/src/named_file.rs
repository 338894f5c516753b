//! Files that a manifest names: they must lie in its folder, unless `--allow-outside` is given.
//!
//! The sender of a folder of measurements must not be able to have other files of the reader opened and shown.

use std::path::{Component, Path, PathBuf};
use std::sync::atomic::{AtomicBool, Ordering};

/// True if files outside are accepted, for the whole process.
static OUTSIDE: AtomicBool = AtomicBool::new(false);

/// Reason why a named file is not opened.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum NamedFileError {
    /// It lies outside the folder, after resolving all links.
    Outside,
    /// There is no such file.
    Missing,
}

/// Allows manifests to name files anywhere from now on.
pub fn allow_outside() {
    OUTSIDE.store(true, Ordering::Relaxed);
}

/// The path of a file that a manifest in `folder` names. The error does not reveal if a file outside exists.
pub fn place(folder: &Path, name: &Path) -> Result<PathBuf, NamedFileError> {
    let path = folder.join(name);
    if OUTSIDE.load(Ordering::Relaxed) {
        return if path.exists() { Ok(path) } else { Err(NamedFileError::Missing) };
    }
    if name.components().any(|part| !matches!(part, Component::Normal(_) | Component::CurDir)) {
        return Err(NamedFileError::Outside);
    }
    match (path.canonicalize(), folder.canonicalize()) {
        (Ok(file), Ok(folder)) if file.starts_with(&folder) => Ok(path),
        (Ok(_), Ok(_)) => Err(NamedFileError::Outside),
        _ => Err(NamedFileError::Missing),
    }
}
