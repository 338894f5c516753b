//! Lock file, held by one thread of one process at a time.

use std::fs::{self, File, TryLockError};
use std::path::{Path, PathBuf};

use same_file::Handle;

use crate::error::FileError;

/// A held lock. The operating system releases it when the process ends, in any way.
#[derive(Debug)]
pub struct FileLock {
    path: PathBuf,
    _locked: File,
}

/// Behaviour if the lock is held by another thread or process.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum LockWait {
    /// Returns at once.
    None,
    /// Waits without limit.
    Endless,
}

impl FileLock {
    /// Takes the lock file at `path`; `None` if the lock is held and waiting was not requested.
    ///
    /// # Errors
    /// If the file cannot be created, or the file system does not support locks.
    pub fn take(path: &Path, wait: LockWait) -> Result<Option<Self>, FileError> {
        let failed = || FileError::at(path, "cannot be locked; choose an --out on a file system with locks");
        loop {
            let file = File::options().create(true).truncate(false).write(true).open(path).map_err(failed())?;
            match (file.try_lock(), wait) {
                (Ok(()), _) => {}
                (Err(TryLockError::WouldBlock), LockWait::None) => return Ok(None),
                (Err(TryLockError::WouldBlock), LockWait::Endless) => file.lock().map_err(failed())?,
                (Err(TryLockError::Error(error)), _) => return Err(failed()(error)),
            }
            // The previous holder may have removed the file between our opening and locking it.
            if is_at(&file, path) {
                return Ok(Some(Self { path: path.to_owned(), _locked: file }));
            }
        }
    }
}

fn is_at(file: &File, path: &Path) -> bool {
    let opened = file.try_clone().and_then(Handle::from_file);
    opened.is_ok_and(|opened| Handle::from_path(path).is_ok_and(|there| there == opened))
}

impl Drop for FileLock {
    fn drop(&mut self) {
        // A leftover lock file is harmless: the next run that needs it locks it.
        let _ = fs::remove_file(&self.path);
    }
}

#[cfg(test)]
mod tests {
    use std::sync::atomic::{AtomicUsize, Ordering};

    use super::*;

    #[test]
    fn one_holder_at_a_time_and_nothing_left_behind() {
        let place = tempfile::tempdir().unwrap();
        let path = place.path().join(".lock");
        let held = FileLock::take(&path, LockWait::None).unwrap().expect("free");
        assert!(FileLock::take(&path, LockWait::None).unwrap().is_none());
        drop(held);
        let (inside, most) = (AtomicUsize::new(0), AtomicUsize::new(0));
        std::thread::scope(|scope| {
            for _ in 0..8 {
                scope.spawn(|| {
                    for _ in 0..200 {
                        let _claim = FileLock::take(&path, LockWait::Endless).unwrap().expect("endless patience");
                        most.fetch_max(inside.fetch_add(1, Ordering::SeqCst) + 1, Ordering::SeqCst);
                        inside.fetch_sub(1, Ordering::SeqCst);
                    }
                });
            }
        });
        assert_eq!(most.into_inner(), 1);
        assert!(!path.exists());
    }
}
