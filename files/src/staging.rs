//! Temporary paths beside an output, where it is written first. Each output has one run at a time, and the path is
//! removed whenever the run ends, in any way.
//!
//! A temporary path is named `.NAME.part-PID` and locked by its process. The lock ends with the process, so an unlocked
//! path belongs to a run that was killed; the next run for the same output removes it.

use std::fs::{self, File, TryLockError};
use std::io;
use std::path::{Path, PathBuf};
use std::sync::{Mutex, MutexGuard, PoisonError};
use std::thread::sleep;
use std::time::Duration;

use crate::error::FileError;

/// Number of attempts to remove a path that other threads still write to, and the time between them.
const ATTEMPTS: (usize, Duration) = (20, Duration::from_millis(10));
/// Suffix under which a replaced output is kept until the new one is in place.
const OLD: &str = ".old";
const MAKE: &str = "cannot make this folder";
const BUSY: &str = "another run is writing this; wait for its end, or choose another --out";

/// All paths that this process has staged.
static STAGED: Mutex<Vec<PathBuf>> = Mutex::new(Vec::new());

fn staged() -> MutexGuard<'static, Vec<PathBuf>> {
    STAGED.lock().unwrap_or_else(PoisonError::into_inner)
}

/// Removes all paths that this process has staged. While the returned guard lives, nothing is staged, renamed or
/// removed.
pub fn remove_all() -> impl Sized {
    let staged = staged();
    // An inner path is removed with the outer one.
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
            // Another thread may have written to it in the meantime.
            Err(_) => sleep(ATTEMPTS.1),
        }
    }
}

/// A folder or file in progress; removed when dropped.
pub(crate) struct Staging {
    path: PathBuf,
    target: PathBuf,
    _lock: Option<File>,
}

impl Staging {
    /// An empty folder that will become `target`.
    ///
    /// # Errors
    /// If another run is writing `target`, or the parent folder cannot be written.
    pub(crate) fn folder(target: &Path) -> Result<Self, FileError> {
        Self::new(target, |path| fs::create_dir(path).map_err(FileError::at(path, MAKE)))
    }

    /// An empty file that will become `target`.
    ///
    /// # Errors
    /// As for [`Staging::folder`].
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
        let _turn = FolderLock::take(parent);
        sweep(target)?;
        let mut staged = staged();
        let mut hidden = std::ffi::OsString::from(".");
        hidden.push(&name);
        hidden.push(format!(".part-{}", std::process::id()));
        let path = parent.join(hidden);
        make(&path)?;
        // Without file locks in the file system, runs do not see each other, and nothing is removed for them.
        let lock = File::open(&path).ok().filter(|file| file.try_lock().is_ok());
        staged.push(path.clone());
        Ok(Self { path, target: target.to_owned(), _lock: lock })
    }

    /// Temporary path.
    pub(crate) fn path(&self) -> &Path {
        &self.path
    }

    /// Final path.
    pub(crate) fn target(&self) -> &Path {
        &self.target
    }

    /// Moves it to its final path. With `replace`, an existing output is moved aside, and removed once the new one is
    /// in place.
    ///
    /// # Errors
    /// If the file system refuses a rename; the existing output is kept then.
    pub(crate) fn commit(self, replace: bool) -> Result<(), FileError> {
        let failed = || FileError::at(&self.target, "cannot put the finished result here");
        let mut old = self.path.clone().into_os_string();
        old.push(OLD);
        let old = PathBuf::from(old);
        let _turn = self.target.parent().map(FolderLock::take);
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
            // Errors cannot be reported here; the name of a leftover says what it is.
            remove(&self.path);
        }
    }
}

/// Exclusive access to the paths in a folder, held briefly to inspect them and to create one.
struct FolderLock {
    _lock: Option<File>,
}

impl FolderLock {
    /// Waits for access; without file locks in the file system there is no waiting. A folder that this process has
    /// staged is its own and already locked: no other process competes for it.
    fn take(folder: &Path) -> Self {
        if staged().iter().any(|own| folder.starts_with(own)) {
            return Self { _lock: None };
        }
        Self { _lock: File::open(folder).ok().filter(|folder| folder.lock().is_ok()) }
    }
}

/// Removes the leftovers of killed runs for an output, and restores an output that one had moved aside. Requires
/// exclusive access.
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
                .map_err(FileError::at(&place, "cannot restore what a killed run had moved away"))?,
        }
    }
    Ok(())
}

/// Temporary paths of an output, with true for those that hold a replaced output.
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
