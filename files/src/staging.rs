//! Places beside an output where it is written first: one run at a time for each output, removed when the run ends in
//! whatever way.
//!
//! A place is called `.NAME.part-PID` and locked by its process. The lock ends with the process, so a place without one
//! belongs to a run that was killed; the next run for the same output removes it.

use std::fs::{self, File, TryLockError};
use std::io;
use std::path::{Path, PathBuf};
use std::sync::{Mutex, MutexGuard, PoisonError};
use std::thread::sleep;
use std::time::Duration;

use crate::error::FileError;

/// Attempts to remove a place that other threads still write into, and the time between two of them.
const ATTEMPTS: (usize, Duration) = (20, Duration::from_millis(10));
/// Ending of the place where a replaced output waits until the new one is in its place.
const OLD: &str = ".old";
const MAKE: &str = "cannot make this folder";
const BUSY: &str = "another run is writing this; wait for its end, or choose another --out";

/// Everything that this process has staged.
static STAGED: Mutex<Vec<PathBuf>> = Mutex::new(Vec::new());

fn staged() -> MutexGuard<'static, Vec<PathBuf>> {
    STAGED.lock().unwrap_or_else(PoisonError::into_inner)
}

/// Removes everything that this process has staged. While the answer lives, nothing is staged, renamed or removed.
pub fn remove_all() -> impl Sized {
    let staged = staged();
    // An inner place goes with the outer one.
    for path in staged.iter() {
        remove(path);
    }
    staged
}

fn remove(path: &Path) {
    for _ in 0..ATTEMPTS.0 {
        let removed = if path.is_dir() { fs::remove_dir_all(path) } else { fs::remove_file(path) };
        match removed {
            Ok(()) => return,
            Err(error) if error.kind() == io::ErrorKind::NotFound => return,
            // Another thread may have written into it meanwhile.
            Err(_) => sleep(ATTEMPTS.1),
        }
    }
}

/// A folder or file in the making. Dropped, it is removed.
pub(crate) struct Staging {
    path: PathBuf,
    target: PathBuf,
    _lock: Option<File>,
}

impl Staging {
    /// An empty folder that will become `target`.
    ///
    /// # Errors
    /// When another run writes `target`, or the parent folder cannot be written.
    pub(crate) fn folder(target: &Path) -> Result<Self, FileError> {
        Self::new(target, |path| fs::create_dir(path).map_err(FileError::at(path, MAKE)))
    }

    /// An empty file that will become `target`.
    ///
    /// # Errors
    /// As [`Staging::folder`].
    pub(crate) fn file(target: &Path) -> Result<Self, FileError> {
        Self::new(target, |path| {
            let made = File::create_new(path).map(|_| ());
            made.map_err(FileError::at(path, "cannot write this file"))
        })
    }

    fn new(target: &Path, make: impl Fn(&Path) -> Result<(), FileError>) -> Result<Self, FileError> {
        let nameless = || FileError::refused(target, "cannot be an output");
        let parent = target.parent().ok_or_else(nameless)?;
        let name = target.file_name().ok_or_else(nameless)?.to_owned();
        fs::create_dir_all(parent).map_err(FileError::at(parent, MAKE))?;
        let _turn = Turn::take(parent);
        sweep(target)?;
        let mut staged = staged();
        let mut hidden = std::ffi::OsString::from(".");
        hidden.push(&name);
        hidden.push(format!(".part-{}", std::process::id()));
        let path = parent.join(hidden);
        make(&path)?;
        // A file system without locks gives none: runs then do not see each other, and nothing is removed for them.
        let lock = File::open(&path).ok().filter(|file| file.try_lock().is_ok());
        staged.push(path.clone());
        Ok(Self { path, target: target.to_owned(), _lock: lock })
    }

    /// Where to write for now.
    pub(crate) fn path(&self) -> &Path {
        &self.path
    }

    /// Where it will be.
    pub(crate) fn target(&self) -> &Path {
        &self.target
    }

    /// Moves it to its place. With `replace`, what is there gives way and is removed once the new one is there.
    ///
    /// # Errors
    /// When the file system refuses a rename; what was there is then still there.
    pub(crate) fn commit(self, replace: bool) -> Result<(), FileError> {
        let failed = || FileError::at(&self.target, "cannot put the finished result here");
        let mut old = self.path.clone().into_os_string();
        old.push(OLD);
        let old = PathBuf::from(old);
        let _turn = self.target.parent().map(Turn::take);
        let staged = staged();
        let moves_away = replace && self.target.symlink_metadata().is_ok();
        if moves_away {
            fs::rename(&self.target, &old).map_err(failed())?;
        }
        if let Err(error) = fs::rename(&self.path, &self.target) {
            if moves_away {
                fs::rename(&old, &self.target).map_err(failed())?;
            }
            return Err(failed()(error));
        }
        drop(staged);
        if moves_away {
            remove(&old);
        }
        Ok(())
    }
}

impl Drop for Staging {
    fn drop(&mut self) {
        let mut staged = staged();
        staged.retain(|path| *path != self.path);
        if self.path.symlink_metadata().is_ok() {
            // Nothing can be reported from here; a leftover carries a name that says what it is.
            remove(&self.path);
        }
    }
}

/// The right to look at the places in a folder and to make one, held for an instant.
struct Turn {
    _lock: Option<File>,
}

impl Turn {
    /// Waits for it; a file system without locks gives none. A folder that this process has staged is its own and locked
    /// already: there is nobody to wait for.
    fn take(folder: &Path) -> Self {
        if staged().iter().any(|own| folder.starts_with(own)) {
            return Self { _lock: None };
        }
        Self { _lock: File::open(folder).ok().filter(|folder| folder.lock().is_ok()) }
    }
}

/// Removes what killed runs left of an output, and puts back what one had moved away. Only for who has the turn.
fn sweep(target: &Path) -> Result<(), FileError> {
    let mut moved_away = Vec::new();
    for (place, is_old) in places(target) {
        if is_old {
            moved_away.push(place);
            continue;
        }
        match File::open(&place).map(|file| file.try_lock()) {
            Ok(Ok(())) => remove(&place),
            Ok(Err(TryLockError::WouldBlock)) => {
                return Err(FileError::refused(target, BUSY));
            }
            Ok(Err(TryLockError::Error(_))) | Err(_) => {}
        }
    }
    for place in moved_away {
        match target.symlink_metadata() {
            Ok(_) => remove(&place),
            Err(_) => fs::rename(&place, target)
                .map_err(FileError::at(&place, "cannot put back what a killed run had moved away"))?,
        }
    }
    Ok(())
}

/// Places of an output beside it, and whether each holds what was replaced.
fn places(target: &Path) -> Vec<(PathBuf, bool)> {
    let (Some(parent), Some(name)) = (target.parent(), target.file_name()) else { return Vec::new() };
    let prefix = format!(".{}.part-", name.to_string_lossy());
    let entries = fs::read_dir(parent).into_iter().flatten().flatten();
    let place = |entry: fs::DirEntry| {
        let own = entry.file_name();
        let process = own.to_str()?.strip_prefix(&prefix)?;
        let kind = entry.file_type().ok()?;
        let (process, is_old) = process.strip_suffix(OLD).map_or((process, false), |process| (process, true));
        let is_number = !process.is_empty() && process.bytes().all(|byte| byte.is_ascii_digit());
        (is_number && (kind.is_dir() || kind.is_file())).then(|| (entry.path(), is_old))
    };
    entries.filter_map(place).collect()
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
    fn a_place_within_a_staged_folder_does_not_wait_for_that_folder() {
        let folder = tempfile::tempdir().unwrap();
        let outer = Staging::folder(&folder.path().join("demo")).unwrap();
        let inner = Staging::folder(&outer.path().join("asset")).unwrap();
        inner.commit(false).unwrap();
        outer.commit(false).unwrap();
        assert_eq!(names(&folder.path().join("demo")), ["asset"]);
    }

    #[test]
    fn what_a_killed_run_left_is_removed_and_what_it_had_moved_away_is_put_back() {
        let folder = tempfile::tempdir().unwrap();
        let target = folder.path().join("asset");
        let dead = folder.path().join(".asset.part-4000001");
        fs::create_dir(&dead).unwrap();
        fs::write(dead.join("half"), "half").unwrap();
        let old = folder.path().join(".asset.part-4000002.old");
        fs::create_dir(&old).unwrap();
        fs::write(old.join("asset.json"), "kept").unwrap();
        for own in [".asset.part-of-mine", ".assets.part-1", "asset.part-2"] {
            fs::write(folder.path().join(own), "mine").unwrap();
        }
        drop(Staging::folder(&target).unwrap());
        assert_eq!(names(folder.path()), [".asset.part-of-mine", ".assets.part-1", "asset", "asset.part-2"]);
        assert_eq!(fs::read(target.join("asset.json")).unwrap(), b"kept");
    }

    #[cfg(unix)]
    #[test]
    fn one_run_at_a_time_writes_an_output() {
        let folder = tempfile::tempdir().unwrap();
        let target = folder.path().join("field.nvdb");
        let first = Staging::file(&target).unwrap();
        let refused = Staging::file(&target).err().expect("the first still writes").to_string();
        assert!(refused.contains("field.nvdb") && refused.contains("another run"), "{refused}");
        assert!(first.path().is_file(), "the first is not disturbed");
        first.commit(false).unwrap();
        assert_eq!(names(folder.path()), ["field.nvdb"]);
    }
}
