//! Data sets: thousands of welded workpieces from a folder of parts; an item that fails does not affect the others.
//!
//! ```text
//! dataset.json                        recipe of every item: seed, options, version
//! assets/3f4ac0ffee012345-0002/       an item: an asset folder (see `crate::asset`)
//! failures/3f4ac0ffee012345-0003.json an item that could not be made, with the reason
//! manifest.jsonl, manifest.csv        catalogue, made again from the folders above
//! failures.jsonl, README.md, contact-sheet.png, croissant.json
//! ```
//!
//! [`plan`] names the items of a list of parts. [`run`] makes them, each in a process of its own that calls [`item`].
//! `catalogue` describes the items, and [`check`] compares the whole set with it. Processes, resuming and failures,
//! which other sets share, are in [`crate::store`]. An item's name and seed follow from its source's content and its
//! index, and its bytes from those and the [`Recipe`]; so order, jobs, shards and interruptions do not change them.

mod card;
mod catalogue;
pub mod check;
mod contact_sheet;
mod croissant;
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
    /// Returns the folder of an item, whether it exists or not.
    pub fn asset_folder(&self, id: &str) -> PathBuf {
        self.folder().join(ASSETS_FOLDER).join(id)
    }

    /// Returns true if an item is complete: its manifest matches the recipe, and its files have the listed lengths.
    ///
    /// Hashes are checked by [`check`].
    pub fn holds(&self, id: &str) -> bool {
        let folder = self.asset_folder(id);
        let has_length = |(name, record): (&String, &FileRecord)| {
            fs::metadata(folder.join(name)).is_ok_and(|file| file.len() == record.bytes)
        };
        Manifest::read(&folder)
            .is_ok_and(|manifest| self.recipe.fits(id, &manifest).is_ok() && manifest.files.iter().all(has_length))
    }

    /// Returns the names of the items that have a folder, sorted.
    ///
    /// # Errors
    /// If the folder cannot be read.
    pub fn ids(&self) -> Result<Vec<String>> {
        let ids = names(&self.folder().join(ASSETS_FOLDER))?;
        Ok(ids.into_iter().filter(|name| !name.starts_with('.')).collect())
    }
}

/// Returns the path of an item's manifest below the data set's folder.
fn manifest_path(id: &str) -> String {
    format!("{ASSETS_FOLDER}/{id}/{MANIFEST_FILE}")
}
