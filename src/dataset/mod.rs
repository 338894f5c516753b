//! Data sets: thousands of welded workpieces from a folder of parts, each item on its own account.
//!
//! ```text
//! dataset.json                        what decides every item: seed, options, version
//! assets/3f4ac0ffee012345-0002/       an item: an asset folder (see `crate::asset`)
//! failures/3f4ac0ffee012345-0003.json an item that could not be made, and why
//! manifest.jsonl, manifest.csv        the catalogue, made anew from the folders above
//! failures.jsonl, README.md, contact-sheet.png, croissant.json
//! ```
//!
//! The road: [`plan`] names the items of a list of parts, [`run`] makes them, each in a process of its own
//! ([`process`], [`limits`]) that calls [`item`]; [`Catalogue`] describes what is there, and [`check`] holds all of it
//! against itself. An item's name and seed follow from its source's content and its index, and its bytes from those and
//! the [`Recipe`]; so neither order, jobs, shards nor interruptions change them. An item's folder appears by one
//! renaming and only under a lock of the operating system, so it is complete or it is not there.

mod card;
pub(crate) mod catalogue;
pub mod check;
pub(crate) mod contact;
mod croissant;
mod difficulty;
mod failure;
pub mod item;
pub mod limits;
mod marker;
pub mod plan;
pub mod process;
pub mod progress;
mod recipe;
mod row;
pub mod run;
mod table;

use std::fs;
use std::path::{Path, PathBuf};

use anyhow::{Context, Result, ensure};

use crate::asset::{FileRecord, MANIFEST_FILE, Manifest};
use crate::wrong_use;
use files::file_lock::{FileLock, Patience};
use files::folder::write_file;
use files::input::quoted_near;
use files::json_file::read_json;
use files::sha256;

pub use catalogue::Catalogue;
pub use failure::{Failure, Stage, command_line};
pub use marker::Marker;
pub use plan::{Item, Plan};
pub use recipe::{DATASET_FORMAT, Recipe};

/// Name of the file that marks a data set.
pub const MARKER_FILE: &str = "dataset.json";
/// Folder of the items.
pub const ASSETS_FOLDER: &str = "assets";
/// Folder of the records of failed items.
pub const FAILURES_FOLDER: &str = "failures";
/// What the data set's own files are claimed by.
const CLAIM_FILE: &str = ".dataset.lock";

/// The folder of a data set, of assets unless its marker says otherwise.
#[derive(Clone, Debug)]
pub struct Dataset<R = Recipe> {
    folder: PathBuf,
    /// What decides its items.
    pub recipe: R,
}

impl<R: Marker> Dataset<R> {
    /// Starts a data set in a folder that is empty or not there, or with `resume` goes on with one of the same recipe.
    ///
    /// # Errors
    /// Wrong use when the folder holds something else, or a data set of another recipe; otherwise when the folder cannot
    /// be written.
    pub fn start(folder: &Path, recipe: R, resume: bool) -> Result<Self> {
        if is_unused(folder, R::FOLDERS) {
            for name in R::FOLDERS {
                let place = folder.join(name);
                fs::create_dir_all(&place).with_context(|| format!("{}: cannot make this folder", place.display()))?;
            }
            let dataset = Self { folder: folder.to_owned(), recipe };
            let _claim = dataset.claim_catalogue()?;
            remove_stale(folder, MARKER_FILE)?;
            // Another process may have come first, with a recipe of its own.
            if !folder.join(MARKER_FILE).exists() {
                let text = serde_json::to_string_pretty(&dataset.recipe)? + "\n";
                write_file(&folder.join(MARKER_FILE), text.as_bytes())?;
                return Ok(dataset);
            }
            return Self::open(folder)?.held_against(dataset.recipe);
        }
        if !folder.join(MARKER_FILE).is_file() {
            return Err(wrong_use(format!(
                "{} holds something and no {MARKER_FILE}: it is not a data set; choose another --out",
                folder.display()
            )));
        }
        if !resume {
            return Err(wrong_use(format!(
                "{} is a data set already: give --resume to go on with it, or choose another --out",
                folder.display()
            )));
        }
        Self::open(folder)?.held_against(recipe)
    }

    /// Opens a data set.
    ///
    /// # Errors
    /// When its marker is missing, damaged or of another format.
    pub fn open(folder: &Path) -> Result<Self> {
        let marker = folder.join(MARKER_FILE);
        let recipe: R = read_json(&marker, &format!("the mark of a data set of format {}", R::FORMAT))?;
        ensure!(
            recipe.format() == R::FORMAT,
            "{}: format is {}, {:?} is expected",
            marker.display(),
            quoted_near(recipe.format(), [R::FORMAT]),
            R::FORMAT
        );
        Ok(Self { folder: folder.to_owned(), recipe })
    }

    fn held_against(self, recipe: R) -> Result<Self> {
        match self.recipe.difference(&recipe) {
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
        Ok(FileLock::take(&self.folder.join(R::FOLDERS[0]).join(format!(".{id}.lock")), patience)?)
    }

    pub(crate) fn claim_catalogue(&self) -> Result<Option<FileLock>> {
        Ok(FileLock::take(&self.folder.join(CLAIM_FILE), Patience::Endless)?)
    }

    /// Removes what killed runs left of items that no one is writing.
    ///
    /// # Errors
    /// When the file system refuses.
    pub fn sweep(&self) -> Result<()> {
        for folder in R::FOLDERS {
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

impl Dataset {
    /// Where an item lies, or would.
    pub fn asset_folder(&self, id: &str) -> PathBuf {
        self.folder.join(ASSETS_FOLDER).join(id)
    }

    /// Whether an item is there: its manifest says that it was made by this recipe, and its files have their lengths.
    ///
    /// Their hashes are the business of [`check`].
    pub fn holds(&self, id: &str) -> bool {
        let folder = self.asset_folder(id);
        let has_length = |(name, record): (&String, &FileRecord)| {
            fs::metadata(folder.join(name)).is_ok_and(|file| file.len() == record.bytes)
        };
        Manifest::read(&folder)
            .is_ok_and(|manifest| self.recipe.fits(id, &manifest).is_ok() && manifest.files.iter().all(has_length))
    }

    /// Names of the items that have a folder, sorted.
    ///
    /// # Errors
    /// When the folder cannot be read.
    pub fn ids(&self) -> Result<Vec<String>> {
        let ids = names(&self.folder.join(ASSETS_FOLDER))?;
        Ok(ids.into_iter().filter(|name| !name.starts_with('.')).collect())
    }
}

/// Names in a folder, sorted.
pub(crate) fn names(folder: &Path) -> Result<Vec<String>> {
    let context = || format!("{}: cannot be read", folder.display());
    let mut names = Vec::new();
    for entry in fs::read_dir(folder).with_context(context)? {
        names.push(entry.with_context(context)?.file_name().to_string_lossy().into_owned());
    }
    names.sort();
    Ok(names)
}

/// Removes what was staged in `folder` for `stem` and never renamed; only for who holds the claim on it.
pub(crate) fn remove_stale(folder: &Path, stem: &str) -> Result<()> {
    let prefix = format!(".{stem}.");
    for name in names(folder)? {
        let is_staging = name.strip_prefix(&prefix).is_some_and(|rest| rest.contains("part-"));
        let path = folder.join(&name);
        let removed = match (is_staging, path.is_dir()) {
            (false, _) => continue,
            (true, true) => fs::remove_dir_all(&path),
            (true, false) => fs::remove_file(&path),
        };
        removed.with_context(|| format!("{}: cannot be removed", path.display()))?;
    }
    Ok(())
}

/// Whether a folder is absent, or holds at most what a run that was killed at its start leaves behind.
fn is_unused(folder: &Path, folders: &[&str]) -> bool {
    let Ok(entries) = fs::read_dir(folder) else { return folder.symlink_metadata().is_err() };
    entries.flatten().all(|entry| {
        let name = entry.file_name().to_string_lossy().into_owned();
        let is_empty = || fs::read_dir(entry.path()).is_ok_and(|mut entries| entries.next().is_none());
        name.starts_with(".dataset.") || (folders.contains(&name.as_str()) && is_empty())
    })
}

/// Identity of bytes that are a file's content.
pub(crate) fn record_of(bytes: &[u8]) -> FileRecord {
    FileRecord { sha256: sha256(bytes), bytes: bytes.len() as u64 }
}

/// Name of an item's manifest below the data set's folder.
fn manifest_path(id: &str) -> String {
    format!("{ASSETS_FOLDER}/{id}/{MANIFEST_FILE}")
}
