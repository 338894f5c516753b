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
//! The road: [`plan`] names the items of a list of parts, [`run`] makes them, each in a process of its own that calls
//! [`item`]; `catalogue` describes what is there, and [`check`] holds all of it against itself. What sets have in common,
//! processes, resuming, failures, is in [`crate::store`]. An item's name and seed follow from its source's content and its
//! index, and its bytes from those and the [`Recipe`]; so neither order, jobs, shards nor interruptions change them.

mod card;
mod catalogue;
pub mod check;
mod contact;
mod croissant;
mod difficulty;
pub mod item;
pub mod plan;
mod recipe;
mod row;
pub mod run;
mod table;

use std::fs;
use std::path::PathBuf;

use anyhow::Result;

use crate::asset::{FileRecord, MANIFEST_FILE, Manifest};
use crate::store::{Store, names};

pub use plan::{Item, Plan};
pub use recipe::{DATASET_FORMAT, Recipe};

/// Name of the file that marks a data set.
pub const MARKER_FILE: &str = "dataset.json";
/// Folder of the items.
pub const ASSETS_FOLDER: &str = "assets";

/// The folder of a data set of assets.
pub type Dataset = Store<Recipe>;

impl Dataset {
    /// Where an item lies, or would.
    pub fn asset_folder(&self, id: &str) -> PathBuf {
        self.folder().join(ASSETS_FOLDER).join(id)
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
        let ids = names(&self.folder().join(ASSETS_FOLDER))?;
        Ok(ids.into_iter().filter(|name| !name.starts_with('.')).collect())
    }
}

/// Name of an item's manifest below the data set's folder.
fn manifest_path(id: &str) -> String {
    format!("{ASSETS_FOLDER}/{id}/{MANIFEST_FILE}")
}
