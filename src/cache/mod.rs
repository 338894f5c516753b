//! Cache of baked fields by content: a folder with one file for each mesh and each set of options, made only once.
//!
//! ```text
//! cache.json                    marks the folder as a cache
//! 3f…c2.nvdb, 3f…c2.json        an entry: the field, and its record
//! index.jsonl                   mesh files and their entries
//! .3f…c2.…                      an entry under construction
//! ```
//!
//! The name of an entry is the SHA-256 of its [`Recipe`]: the mesh's bytes and all options that affect the field. A
//! record is written after its field, both by renaming, and holds the field's length and hash. So an entry is complete
//! or does not exist, whenever the program is killed, and damage is detected.

mod batch;
mod entry;
mod index;
mod recipe;
mod sources;

use std::path::Path;

use anyhow::Result;
use serde::{Deserialize, Serialize};

use crate::store::{Marker, Occupied, Store, names, remove};

pub use batch::{Batch, Entry, Outcome};
pub use entry::Record;
pub use index::INDEX_FILE;
pub use recipe::Recipe;
pub use sources::{Sources, find_meshes};

/// Name of the file that marks a cache.
pub const MARKER_FILE: &str = "cache.json";
/// Value of the `format` key of the marker and of every recipe.
pub const CACHE_FORMAT: &str = "robofin-cache/1";

/// Folder of cached fields.
pub type Cache = Store<CacheMarker>;

/// Marker of a cache; each entry has a recipe of its own.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub struct CacheMarker {
    format: String,
}

impl Marker for CacheMarker {
    const WHAT: &'static str = "a cache";
    const FILE: &'static str = MARKER_FILE;
    const FORMAT: &'static str = CACHE_FORMAT;
    const FOLDERS: &'static [&'static str] = &[""];
    const CONTINUED: &'static str = "--resume to continue it, --force to bake all of it again";

    fn format(&self) -> &str {
        &self.format
    }

    fn difference(&self, _: &Self) -> Option<String> {
        None
    }

    fn text(&self) -> Result<String> {
        Ok(serde_json::to_string(self)? + "\n")
    }
}

impl Cache {
    /// Makes a cache in an empty or new folder, or opens one; replacing a cache removes its entries.
    ///
    /// # Errors
    /// Those of [`Store::start`].
    pub fn prepare(folder: &Path, occupied: Occupied) -> Result<Self> {
        let cache = Self::start(folder, CacheMarker { format: CACHE_FORMAT.to_owned() }, occupied)?;
        if occupied == Occupied::Replace {
            // Files that do not belong to the cache stay.
            for name in names(folder)?.iter().filter(|name| *name == INDEX_FILE || entry::is_of_an_entry(name)) {
                remove(&folder.join(name))?;
            }
        }
        Ok(cache)
    }
}
