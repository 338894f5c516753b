//! Folders that are filled item by item and may be gone on with: caches, data sets, sets of images.
//!
//! A store has a [`Marker`] that decides every item in it. An item is made under a lock of the operating system and
//! appears by renaming, so it is whole or it is not there, whenever a run is killed; [`Store::fill`] finds it or makes it,
//! and [`Store::work_through`] does so for many, beside other runs that do the same. Neither order nor jobs nor
//! interruptions change a byte.
//!
//! A set is a store whose items are made by processes of their own: [`run`] starts them ([`process`], [`limits`]) and
//! counts ([`progress`]), `failure` keeps what could not be made, [`catalogue`] describes what is there, and [`check`]
//! compares it with what it should be.

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
use files::file_lock::{FileLock, Patience};
use files::folder::{check_writable, write_file};
use files::input::quoted_near;
use files::job_queue::take_turns;
use files::json_file::read_json;

pub use failure::{FAILURES_FOLDER, Failure, Fault, Stage, command_line};
pub use marker::Marker;

/// Treatment of a folder that is a store of the same kind already.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Occupied {
    /// Leave it alone and say so.
    Refuse,
    /// Go on: what is complete is kept.
    Resume,
    /// The caller empties it first.
    Replace,
}

impl Occupied {
    /// Treatment that follows from the flag `--resume`, where nothing is replaced.
    pub fn resumed(resume: bool) -> Self {
        if resume { Self::Resume } else { Self::Refuse }
    }
}

/// A folder of items.
#[derive(Clone, Debug)]
pub struct Store<M> {
    folder: PathBuf,
    /// Recipe from which its items follow.
    pub recipe: M,
}

/// An item of a store.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Filled<T> {
    /// It was there.
    There(T),
    /// It was made.
    Made(T),
}

impl<M: Marker> Store<M> {
    /// Starts a store in a folder that is empty or not there, or opens one of the same recipe.
    ///
    /// # Errors
    /// Wrong use when the folder holds something else, or a store and `occupied` does not say what to do with it;
    /// otherwise when the folder cannot be written.
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
        store.begun_alike(&recipe)
    }

    /// Marks a folder that is empty or not there.
    fn begin(folder: &Path, recipe: M) -> Result<Self> {
        for name in M::FOLDERS {
            let place = folder.join(name);
            fs::create_dir_all(&place).with_context(|| format!("{}: cannot make this folder", place.display()))?;
        }
        let store = Self { folder: folder.to_owned(), recipe };
        let _claim = store.claim_catalogue()?;
        remove_stale(folder, M::FILE)?;
        // Another process may have come first, with a recipe of its own.
        if folder.join(M::FILE).exists() {
            return Self::open(folder)?.begun_alike(&store.recipe);
        }
        write_file(&folder.join(M::FILE), store.recipe.text()?.as_bytes())?;
        Ok(store)
    }

    /// Opens a store.
    ///
    /// # Errors
    /// When its marker is missing, damaged or of another format.
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

    fn begun_alike(self, recipe: &M) -> Result<Self> {
        match self.recipe.difference(recipe) {
            None => Ok(self),
            Some(difference) => Err(wrong_use(format!(
                "{} was started otherwise: {difference}; give the same flags, or choose another --out",
                self.folder.display()
            ))),
        }
    }

    /// The folder.
    pub fn folder(&self) -> &Path {
        &self.folder
    }

    /// The right to write an item; `None` when another process has it and there is no patience.
    ///
    /// # Errors
    /// When the file system refuses.
    pub fn claim(&self, id: &str, patience: Patience) -> Result<Option<FileLock>> {
        Ok(FileLock::take(&self.folder.join(M::FOLDERS[0]).join(format!(".{id}.lock")), patience)?)
    }

    /// The right to write the store's own files; another run that has it is waited for.
    ///
    /// # Errors
    /// When the file system refuses.
    pub fn claim_catalogue(&self) -> Result<Option<FileLock>> {
        Ok(FileLock::take(&self.folder.join(format!(".{}.lock", stem::<M>())), Patience::Endless)?)
    }

    /// Finds an item, or makes it under its claim; `None` when someone else is making it and there is no patience.
    ///
    /// # Errors
    /// Those of `make`, and when the file system refuses.
    pub fn fill<T, E: From<anyhow::Error>>(
        &self,
        id: &str,
        patience: Patience,
        find: impl Fn() -> Option<T>,
        make: impl FnOnce() -> Result<T, E>,
    ) -> Result<Option<Filled<T>>, E> {
        if let Some(there) = find() {
            return Ok(Some(Filled::There(there)));
        }
        let Some(_claim) = self.claim(id, patience)? else { return Ok(None) };
        // Whoever held the claim before may have finished it.
        if let Some(there) = find() {
            return Ok(Some(Filled::There(there)));
        }
        for folder in M::FOLDERS {
            remove_stale(&self.folder.join(folder), id)?;
        }
        Ok(Some(Filled::Made(make()?)))
    }

    /// Does `work` for each of `items` with `jobs` threads, then removes what killed runs left; `done` gets the position
    /// and what came of it, as it comes in. Where `work` gives `None`, it is asked again at the end, with patience.
    ///
    /// # Errors
    /// Those of `done`, and when the folder cannot be written.
    pub fn work_through<I: Sync, T: Send>(
        &self,
        items: &[I],
        jobs: usize,
        work: impl Fn(&I, Patience) -> Option<T> + Sync,
        done: impl FnMut(usize, T) -> Result<()>,
    ) -> Result<()> {
        take_turns(items.len(), jobs, |turn, patience| work(&items[turn], patience), done)?;
        self.sweep()
    }

    /// Removes what killed runs left of items that no one is writing.
    fn sweep(&self) -> Result<()> {
        // The writer of the store's own files may stage them in a folder of items.
        let _claim = self.claim_catalogue()?;
        remove_stale(&self.folder, stem::<M>())?;
        for folder in M::FOLDERS {
            let place = self.folder.join(folder);
            for name in names(&place)?.iter().filter(|name| name.starts_with('.')) {
                let id = name[1..].split('.').next().unwrap_or_default();
                // Taking and releasing the claim removes the lock file as well.
                if let Some(_claim) = self.claim(id, Patience::None)? {
                    remove_stale(&place, id)?;
                }
            }
        }
        Ok(())
    }
}

/// Name of the marker file without its ending; hidden files of the store's own begin with it.
fn stem<M: Marker>() -> &'static str {
    M::FILE.split('.').next().unwrap_or_default()
}

/// True if a folder is absent, or holds at most what a run that was killed at its start leaves behind.
fn is_unused<M: Marker>(folder: &Path) -> bool {
    let Ok(entries) = fs::read_dir(folder) else { return folder.symlink_metadata().is_err() };
    entries.flatten().all(|entry| {
        let name = entry.file_name().to_string_lossy().into_owned();
        let is_empty = || fs::read_dir(entry.path()).is_ok_and(|mut entries| entries.next().is_none());
        name.starts_with(&format!(".{}.", stem::<M>())) || (M::FOLDERS.contains(&name.as_str()) && is_empty())
    })
}

/// Names in a folder, sorted.
///
/// # Errors
/// When it cannot be read.
pub fn names(folder: &Path) -> Result<Vec<String>> {
    let context = || format!("{}: cannot be read", folder.display());
    let mut names = Vec::new();
    for entry in fs::read_dir(folder).with_context(context)? {
        names.push(entry.with_context(context)?.file_name().to_string_lossy().into_owned());
    }
    names.sort();
    Ok(names)
}

/// Removes what was staged in `folder` for `stem` and never renamed; only for who holds the claim on it.
///
/// # Errors
/// When the file system refuses.
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

/// Removes a file or folder, if it is there.
///
/// # Errors
/// When the file system refuses.
pub fn remove(path: &Path) -> Result<()> {
    let removed = if path.is_dir() { fs::remove_dir_all(path) } else { fs::remove_file(path) };
    match removed {
        Err(error) if error.kind() == ErrorKind::NotFound => Ok(()),
        removed => removed.with_context(|| format!("{}: cannot be removed", path.display())),
    }
}

/// The first eight bytes of a text's SHA-256, as a number: seeds, splits and shares follow from names by it.
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
    fn a_store_is_gone_on_with_only_if_that_is_asked_and_it_is_the_same() {
        let place = tempfile::tempdir().unwrap();
        let folder = &place.path().join("words");
        let refused = |language: &str, occupied| start(folder, language, occupied).err().unwrap().to_string();
        start(folder, "English", Occupied::Refuse).unwrap();
        assert!(refused("English", Occupied::Refuse).contains("is a word list already: give --resume"));
        assert!(refused("German", Occupied::Resume).contains("started otherwise: English, German asked"));
        start(folder, "English", Occupied::Resume).unwrap();
        fs::write(folder.join("words.json"), "{\"format\": \"words/2\", \"language\": \"English\"}").unwrap();
        assert!(refused("English", Occupied::Resume).contains("format is \"words/2\", \"words/1\" is expected"));
        fs::remove_file(folder.join("words.json")).unwrap();
        fs::write(folder.join("thesis.txt"), "years of work").unwrap();
        assert!(refused("English", Occupied::Replace).contains("holds no words.json: it is not a word list"));
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
            store.fill(id, Patience::None, || find(id), || -> Result<()> { Ok(fs::write(at(id), "whole")?) })
        };
        assert_eq!(fill("a").unwrap(), Some(Filled::Made(())));
        assert!(!at(left[0]).exists());
        assert_eq!(fill("a").unwrap(), Some(Filled::There(())));
        let held = store.claim("b", Patience::None).unwrap().expect("nobody else wants it");
        assert_eq!(fill("b").unwrap(), None, "someone else makes it");
        store.work_through(&[()], 1, |(), _| Some(()), |_, ()| Ok(())).unwrap();
        assert!(at(left[1]).exists() && !at(left[2]).exists(), "what is being made is left alone");
        drop(held);
        assert_eq!(fill("b").unwrap(), Some(Filled::Made(())));
        assert!(!at(left[1]).exists());
        assert_eq!(names(place.path()).unwrap(), ["a", "b", "failures", "words.json"]);
    }
}
