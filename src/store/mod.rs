//! Folders filled item by item, which can be resumed: caches, data sets, sets of images.
//!
//! A store has a [`Marker`] that defines every item in it. An item is made under a lock of the operating system and
//! published by renaming, so it is complete or does not exist, whenever a run is killed. [`Store::fill`] finds or makes
//! an item, and [`Store::work_through`] does so for many, even with other runs at the same time. Order, jobs and
//! interruptions do not change a byte.
//!
//! A set is a store whose items are made by processes of their own: [`run`] starts them ([`process`], [`limits`]) and
//! counts ([`progress`]), `failure` records failed items, [`catalogue`] lists items, [`check`] compares them.

pub mod catalogue;
pub mod check;
mod failure;
pub mod limits;
mod marker;
pub mod process;
pub mod progress;
pub mod run;

use std::fs;
use std::io::ErrorKind;
use std::path::{Path, PathBuf};

use anyhow::{Context, Result, ensure};
use sha2::{Digest, Sha256};

use crate::wrong_use;
use files::file_lock::{FileLock, LockWait};
use files::folder::{check_writable, write_file};
use files::input::quoted_near;
use files::job_queue::take_turns;
use files::json_file::read_json;

pub use failure::{FAILURES_FOLDER, Failure, Fault, Stage, command_line};
pub use marker::Marker;

/// Treatment of a folder that already is a store of the same type.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Occupied {
    /// Refuse with an error.
    Refuse,
    /// Continue; complete items are kept.
    Resume,
    /// The caller empties it first.
    Replace,
}

impl Occupied {
    /// Returns the treatment for the flag `--resume` of verbs that replace nothing.
    pub fn resumed(resume: bool) -> Self {
        if resume { Self::Resume } else { Self::Refuse }
    }
}

/// A folder of items.
#[derive(Clone, Debug)]
pub struct Store<M> {
    folder: PathBuf,
    /// Recipe of its items.
    pub recipe: M,
}

/// An item of a store, found or made.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum StoredItem<T> {
    /// It existed already.
    There(T),
    /// It was made now.
    Made(T),
}

impl<M: Marker> Store<M> {
    /// Starts a store in an empty or new folder, or opens one with the same recipe.
    ///
    /// # Errors
    /// Wrong use if the folder holds something that `occupied` does not allow; otherwise if it cannot be written.
    pub fn start(folder: &Path, recipe: M, occupied: Occupied) -> Result<Self> {
        let (place, marker) = (folder.display(), folder.join(M::FILE));
        if folder.exists() && !folder.is_dir() {
            return Err(wrong_use(format!("{place} already exists and is a file; --out expects a folder")));
        }
        if is_unused::<M>(folder) {
            return Self::begin(folder, recipe);
        }
        if !marker.is_file() {
            return Err(wrong_use(format!(
                "{place} already exists and holds no {}: it is not {}; choose another --out",
                M::FILE,
                M::WHAT
            )));
        }
        if occupied == Occupied::Refuse {
            return Err(wrong_use(format!(
                "{place} is {} already: give {}, or choose another --out",
                M::WHAT,
                M::CONTINUED
            )));
        }
        let store = Self::open(folder)?;
        check_writable(folder)?;
        let store = store.check_recipe(&recipe)?;
        // A copy through an object store lacks empty folders.
        make_folders::<M>(folder)?;
        Ok(store)
    }

    /// Marks an empty or new folder.
    fn begin(folder: &Path, recipe: M) -> Result<Self> {
        make_folders::<M>(folder)?;
        let store = Self { folder: folder.to_owned(), recipe };
        let _claim = store.claim_catalogue()?;
        remove_stale(folder, M::FILE)?;
        // Another process may have marked it first, with another recipe.
        if folder.join(M::FILE).exists() {
            return Self::open(folder)?.check_recipe(&store.recipe);
        }
        write_file(&folder.join(M::FILE), store.recipe.text()?.as_bytes())?;
        Ok(store)
    }

    /// Opens a store.
    ///
    /// # Errors
    /// If its marker is missing, damaged or of another format.
    pub fn open(folder: &Path) -> Result<Self> {
        let marker = folder.join(M::FILE);
        let recipe: M = read_json(&marker, &format!("the mark of {} of format {}", M::WHAT, M::FORMAT))?;
        ensure!(
            recipe.format() == M::FORMAT,
            "{}: format is {}, {:?} is expected",
            marker.display(),
            quoted_near(recipe.format(), [M::FORMAT]),
            M::FORMAT
        );
        Ok(Self { folder: folder.to_owned(), recipe })
    }

    fn check_recipe(self, recipe: &M) -> Result<Self> {
        match self.recipe.difference(recipe) {
            None => Ok(self),
            Some(difference) => Err(wrong_use(format!(
                "{} was started with other flags: {difference}; give the same flags, or choose another --out",
                self.folder.display()
            ))),
        }
    }

    /// Returns the folder.
    pub fn folder(&self) -> &Path {
        &self.folder
    }

    /// Claims the right to write an item; `None` if another process has it and `wait` does not allow waiting.
    ///
    /// # Errors
    /// If the file system refuses.
    pub fn claim(&self, id: &str, wait: LockWait) -> Result<Option<FileLock>> {
        Ok(FileLock::take(&self.folder.join(M::FOLDERS[0]).join(format!(".{id}.lock")), wait)?)
    }

    /// Claims the right to write the store's own files; waits for another run that has it.
    ///
    /// # Errors
    /// If the file system refuses.
    pub fn claim_catalogue(&self) -> Result<Option<FileLock>> {
        Ok(FileLock::take(&self.folder.join(format!(".{}.lock", stem::<M>())), LockWait::Endless)?)
    }

    /// Finds an item, or makes it under its claim; `None` if another process is making it and `wait` does not allow
    /// waiting.
    ///
    /// # Errors
    /// Those of `make`, and if the file system refuses.
    pub fn fill<T, E: From<anyhow::Error>>(
        &self,
        id: &str,
        wait: LockWait,
        find: impl Fn() -> Option<T>,
        make: impl FnOnce() -> Result<T, E>,
    ) -> Result<Option<StoredItem<T>>, E> {
        if let Some(there) = find() {
            return Ok(Some(StoredItem::There(there)));
        }
        let Some(_claim) = self.claim(id, wait)? else { return Ok(None) };
        // The previous holder of the claim may have finished it.
        if let Some(there) = find() {
            return Ok(Some(StoredItem::There(there)));
        }
        for folder in M::FOLDERS {
            remove_stale(&self.folder.join(folder), id)?;
        }
        Ok(Some(StoredItem::Made(make()?)))
    }

    /// Does `work` for each of `items` with `jobs` threads, then removes leftovers of killed runs; `done` gets index
    /// and result of each item as it arrives. If `work` returns `None`, it is called again at the end and may wait.
    ///
    /// # Errors
    /// Those of `done`, and if the folder cannot be written.
    pub fn work_through<I: Sync, T: Send>(
        &self,
        items: &[I],
        jobs: usize,
        work: impl Fn(&I, LockWait) -> Option<T> + Sync,
        done: impl FnMut(usize, T) -> Result<()>,
    ) -> Result<()> {
        take_turns(items.len(), jobs, |turn, wait| work(&items[turn], wait), done)?;
        self.sweep()
    }

    /// Removes leftovers of killed runs for items that no process is writing.
    fn sweep(&self) -> Result<()> {
        // The store's own files may be staged in a folder of items.
        let _claim = self.claim_catalogue()?;
        remove_stale(&self.folder, stem::<M>())?;
        for folder in M::FOLDERS {
            let place = self.folder.join(folder);
            for name in names(&place)?.iter().filter(|name| name.starts_with('.')) {
                let id = name[1..].split('.').next().unwrap_or_default();
                // Taking and releasing the claim also removes the lock file.
                if let Some(_claim) = self.claim(id, LockWait::None)? {
                    remove_stale(&place, id)?;
                }
            }
        }
        Ok(())
    }
}

/// Returns the name of the marker file without its extension; the store's own hidden files begin with it.
fn stem<M: Marker>() -> &'static str {
    M::FILE.split('.').next().unwrap_or_default()
}

/// Returns true if a folder does not exist, or holds at most the leftovers of a run killed at its start.
fn is_unused<M: Marker>(folder: &Path) -> bool {
    let Ok(entries) = fs::read_dir(folder) else { return folder.symlink_metadata().is_err() };
    entries.flatten().all(|entry| {
        let name = entry.file_name().to_string_lossy().into_owned();
        let is_empty = || fs::read_dir(entry.path()).is_ok_and(|mut entries| entries.next().is_none());
        name.starts_with(&format!(".{}.", stem::<M>())) || (M::FOLDERS.contains(&name.as_str()) && is_empty())
    })
}

/// Makes the folders of the items.
fn make_folders<M: Marker>(folder: &Path) -> Result<()> {
    for name in M::FOLDERS {
        let place = folder.join(name);
        fs::create_dir_all(&place).with_context(|| format!("{}: cannot make this folder", place.display()))?;
    }
    Ok(())
}

/// Returns the names in a folder, sorted; none if the folder is missing, as empty ones are in an object store.
///
/// # Errors
/// If it cannot be read.
pub fn names(folder: &Path) -> Result<Vec<String>> {
    let context = || format!("{}: cannot be read", folder.display());
    let mut names = Vec::new();
    let entries = match fs::read_dir(folder) {
        Err(error) if error.kind() == ErrorKind::NotFound => return Ok(names),
        entries => entries.with_context(context)?,
    };
    for entry in entries {
        names.push(entry.with_context(context)?.file_name().to_string_lossy().into_owned());
    }
    names.sort();
    Ok(names)
}

/// Removes staged files of `stem` in `folder` that were never renamed; the caller must hold the claim.
///
/// # Errors
/// If the file system refuses.
pub fn remove_stale(folder: &Path, stem: &str) -> Result<()> {
    let prefix = format!(".{stem}.");
    for name in names(folder)? {
        let is_staging = name.strip_prefix(&prefix).is_some_and(|rest| rest.contains("part-"));
        if is_staging {
            remove(&folder.join(&name))?;
        }
    }
    Ok(())
}

/// Removes a file or folder, if it exists.
///
/// # Errors
/// If the file system refuses.
pub fn remove(path: &Path) -> Result<()> {
    let removed = if path.is_dir() { fs::remove_dir_all(path) } else { fs::remove_file(path) };
    match removed {
        Err(error) if error.kind() == ErrorKind::NotFound => Ok(()),
        removed => removed.with_context(|| format!("{}: cannot be removed", path.display())),
    }
}

/// Returns the first eight bytes of a text's SHA-256 as a number, from which seeds, splits and shards follow.
pub fn number_from(text: &str) -> u64 {
    Sha256::digest(text.as_bytes()).iter().take(8).fold(0, |number, &byte| number << 8 | u64::from(byte))
}

#[cfg(test)]
mod tests {
    use serde::Deserialize;

    use super::*;

    #[derive(serde::Serialize, Deserialize)]
    struct Words {
        format: String,
        language: String,
    }

    impl Marker for Words {
        const WHAT: &'static str = "a word list";
        const FILE: &'static str = "words.json";
        const FORMAT: &'static str = "words/1";
        const FOLDERS: &'static [&'static str] = &["", "failures"];

        fn format(&self) -> &str {
            &self.format
        }

        fn difference(&self, asked: &Self) -> Option<String> {
            (self.language != asked.language).then(|| format!("{}, {} asked", self.language, asked.language))
        }
    }

    fn start(folder: &Path, language: &str, occupied: Occupied) -> Result<Store<Words>> {
        Store::start(folder, Words { format: "words/1".to_owned(), language: language.to_owned() }, occupied)
    }

    #[test]
    fn a_store_continues_only_on_request_and_with_the_same_flags() {
        let place = tempfile::tempdir().unwrap();
        let folder = &place.path().join("words");
        let refused = |language: &str, occupied| start(folder, language, occupied).err().unwrap().to_string();
        start(folder, "English", Occupied::Refuse).unwrap();
        assert!(refused("English", Occupied::Refuse).contains("is a word list already: give --resume"));
        assert!(refused("German", Occupied::Resume).contains("started with other flags: English, German asked"));
        start(folder, "English", Occupied::Resume).unwrap();
        fs::write(folder.join("words.json"), "{\"format\": \"words/2\", \"language\": \"English\"}").unwrap();
        assert!(refused("English", Occupied::Resume).contains("format is \"words/2\", \"words/1\" is expected"));
        fs::remove_file(folder.join("words.json")).unwrap();
        fs::write(folder.join("thesis.txt"), "years of work").unwrap();
        assert!(refused("English", Occupied::Replace).contains("holds no words.json: it is not a word list"));
    }

    #[test]
    fn a_store_without_its_empty_folders_is_continued() {
        let place = tempfile::tempdir().unwrap();
        start(place.path(), "English", Occupied::Refuse).unwrap();
        let failures = place.path().join("failures");
        fs::remove_dir(&failures).unwrap();
        assert!(names(&failures).unwrap().is_empty());
        start(place.path(), "English", Occupied::Resume).unwrap();
        assert!(failures.is_dir());
    }

    #[test]
    fn an_item_is_made_once_and_what_killed_runs_left_of_it_goes() {
        let place = tempfile::tempdir().unwrap();
        let store = start(place.path(), "English", Occupied::Refuse).unwrap();
        let at = |name: &str| place.path().join(name);
        let left = [".a.txt.part-1", ".b.txt.part-1", ".list.part-1"];
        left.iter().for_each(|name| fs::write(at(name), "half").unwrap());
        let find = |id: &str| at(id).is_file().then_some(());
        let fill = |id: &str| {
            store.fill(id, LockWait::None, || find(id), || -> Result<()> { Ok(fs::write(at(id), "whole")?) })
        };
        assert_eq!(fill("a").unwrap(), Some(StoredItem::Made(())));
        assert!(!at(left[0]).exists());
        assert_eq!(fill("a").unwrap(), Some(StoredItem::There(())));
        let held = store.claim("b", LockWait::None).unwrap().expect("nobody else wants it");
        assert_eq!(fill("b").unwrap(), None, "someone else makes it");
        store.work_through(&[()], 1, |(), _| Some(()), |_, ()| Ok(())).unwrap();
        assert!(at(left[1]).exists() && !at(left[2]).exists(), "what is being made is left alone");
        drop(held);
        assert_eq!(fill("b").unwrap(), Some(StoredItem::Made(())));
        assert!(!at(left[1]).exists());
        assert_eq!(names(place.path()).unwrap(), ["a", "b", "failures", "words.json"]);
    }
}
