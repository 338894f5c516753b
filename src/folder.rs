//! Output that is either complete or absent: written beside its place under a temporary name, then renamed.

use std::fs;
use std::path::{Path, PathBuf};

use anyhow::{Context, Result};

use crate::wrong_use;

/// An output folder in the making. Dropped without [`StagedFolder::commit`], it leaves nothing behind.
pub struct StagedFolder {
    staging: PathBuf,
    target: PathBuf,
    replace: bool,
}

impl StagedFolder {
    /// Starts a folder that will become `target`.
    ///
    /// With `force`, a folder that holds a file named `marker` is replaced; any other is not ours to remove.
    ///
    /// # Errors
    /// Wrong use when `target` already holds something that may not be replaced; otherwise when the parent
    /// folder cannot be written.
    pub fn new(target: &Path, marker: &str, force: bool) -> Result<Self> {
        let target = std::path::absolute(target).with_context(|| format!("{}: no such place", target.display()))?;
        refuse_occupied(&target, marker, force)?;
        let (parent, name) = (target.parent(), target.file_name());
        let (Some(parent), Some(name)) = (parent, name) else {
            return Err(wrong_use(format!("--out {} cannot be a new folder", target.display())));
        };
        fs::create_dir_all(parent).with_context(|| format!("{}: cannot make this folder", parent.display()))?;
        let staging = parent.join(format!(".{}.part-{}", name.to_string_lossy(), std::process::id()));
        fs::create_dir(&staging).with_context(|| format!("{}: cannot make this folder", staging.display()))?;
        Ok(Self { staging, target, replace: force })
    }

    /// Where to write for now.
    pub fn path(&self) -> &Path {
        &self.staging
    }

    /// Moves the finished folder to its place; a replaced one is removed only after that.
    ///
    /// # Errors
    /// When the file system refuses a rename; the old folder is then still there.
    pub fn commit(self) -> Result<PathBuf> {
        let place = || format!("{}: cannot put the finished folder here", self.target.display());
        let old = self.staging.with_extension("old");
        let moved_away = self.replace && self.target.exists();
        if moved_away {
            fs::rename(&self.target, &old).with_context(place)?;
        }
        if let Err(error) = fs::rename(&self.staging, &self.target) {
            if moved_away {
                fs::rename(&old, &self.target).with_context(place)?;
            }
            return Err(error).with_context(place);
        }
        if moved_away {
            remove(&old).with_context(|| format!("{}: cannot remove the replaced folder", old.display()))?;
        }
        Ok(self.target.clone())
    }
}

impl Drop for StagedFolder {
    fn drop(&mut self) {
        if self.staging.exists() {
            // Nothing can be reported from here; a leftover carries a name that says what it is.
            let _ = fs::remove_dir_all(&self.staging);
        }
    }
}

/// Fails early where an output would have to be refused at the end.
///
/// With `force`, a file may be replaced, and a folder if it holds a file named `marker`.
///
/// # Errors
/// Wrong use when `target` holds something that may not be replaced.
pub fn refuse_occupied(target: &Path, marker: &str, force: bool) -> Result<()> {
    if !is_occupied(target) {
        return Ok(());
    }
    if !force {
        return Err(occupied(target));
    }
    if target.is_dir() && marker.is_empty() {
        return Err(wrong_use(format!("{} is a folder; --out expects the name of a file", target.display())));
    }
    if target.is_dir() && !target.join(marker).is_file() {
        return Err(wrong_use(format!(
            "{} holds no {marker}: it is not a result of this command, so --force does not replace it",
            target.display()
        )));
    }
    Ok(())
}

fn is_occupied(target: &Path) -> bool {
    match fs::read_dir(target) {
        Ok(mut entries) => entries.next().is_some(),
        Err(_) => target.symlink_metadata().is_ok(),
    }
}

fn remove(path: &Path) -> std::io::Result<()> {
    if path.is_dir() { fs::remove_dir_all(path) } else { fs::remove_file(path) }
}

/// Writes a file beside its place and renames it.
///
/// # Errors
/// Wrong use when the file exists and `force` is not set; otherwise when the place cannot be written.
pub fn write_file(path: &Path, bytes: &[u8], force: bool) -> Result<()> {
    refuse_occupied(path, "", force)?;
    let context = || format!("{}: cannot write this file", path.display());
    let name = path.file_name().with_context(context)?.to_string_lossy();
    let parent = path.parent().filter(|p| !p.as_os_str().is_empty()).unwrap_or(Path::new("."));
    fs::create_dir_all(parent).with_context(context)?;
    let staging = parent.join(format!(".{name}.part-{}", std::process::id()));
    let written = fs::write(&staging, bytes).and_then(|()| fs::rename(&staging, path));
    if written.is_err() && staging.exists() {
        fs::remove_file(&staging).with_context(context)?;
    }
    written.with_context(context)
}

fn occupied(path: &Path) -> anyhow::Error {
    wrong_use(format!(
        "{} already exists and is not overwritten: choose another --out, or give --force",
        path.display()
    ))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn names(folder: &Path) -> Vec<String> {
        let mut names: Vec<String> =
            fs::read_dir(folder).unwrap().map(|e| e.unwrap().file_name().into_string().unwrap()).collect();
        names.sort();
        names
    }

    #[test]
    fn a_folder_appears_whole_or_not_at_all() {
        let place = tempfile::tempdir().unwrap();
        let target = place.path().join("asset");
        let staged = StagedFolder::new(&target, "asset.json", false).unwrap();
        fs::write(staged.path().join("asset.json"), "{}").unwrap();
        assert!(!target.exists());
        staged.commit().unwrap();
        assert_eq!(names(place.path()), ["asset"]);

        let abandoned = StagedFolder::new(&place.path().join("other"), "asset.json", false).unwrap();
        drop(abandoned);
        assert_eq!(names(place.path()), ["asset"]);
    }

    #[test]
    fn an_existing_folder_is_replaced_only_with_force_and_only_if_it_is_ours() {
        let place = tempfile::tempdir().unwrap();
        let target = place.path().join("asset");
        fs::create_dir(&target).unwrap();
        fs::write(target.join("thesis.txt"), "years of work").unwrap();
        assert!(StagedFolder::new(&target, "asset.json", false).is_err());
        let error = StagedFolder::new(&target, "asset.json", true).err().unwrap().to_string();
        assert!(error.contains("asset.json"), "{error}");

        fs::write(target.join("asset.json"), "{}").unwrap();
        let staged = StagedFolder::new(&target, "asset.json", true).unwrap();
        fs::write(staged.path().join("asset.json"), "new").unwrap();
        staged.commit().unwrap();
        assert_eq!(names(&target), ["asset.json"]);
        assert_eq!(names(place.path()), ["asset"]);
    }

    #[test]
    fn a_file_is_kept_unless_force_is_given() {
        let place = tempfile::tempdir().unwrap();
        let path = place.path().join("deep/phi.nvdb");
        write_file(&path, b"one", false).unwrap();
        assert!(write_file(&path, b"two", false).is_err());
        assert_eq!(fs::read(&path).unwrap(), b"one");
        write_file(&path, b"two", true).unwrap();
        assert_eq!(fs::read(&path).unwrap(), b"two");
        assert_eq!(names(path.parent().unwrap()), ["phi.nvdb"]);
    }
}
