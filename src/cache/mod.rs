//! Baked fields by content: a folder in which each mesh, baked in a certain way, has one file that is never made twice.
//!
//! ```text
//! cache.json                    marks the folder as a cache
//! 3f…c2.nvdb, 3f…c2.json        an entry: the field, and its record
//! index.jsonl                   which mesh file became which entry
//! .3f…c2.lock, .3f…c2.part      while an entry is made
//! ```
//!
//! The name of an entry is the SHA-256 of its [`Recipe`]: the mesh's bytes and everything else that decides the field. A
//! record is written after its field, both by renaming, and holds the field's length and hash; so an entry is
//! complete or it is none, whenever the program is killed, and damage is noticed.

mod batch;
mod entry;
mod index;
mod recipe;
mod room;
mod sources;

use std::fs;
use std::path::{Path, PathBuf};

use anyhow::{Context, Result, ensure};
use files::input::quoted_near;
use serde::{Deserialize, Serialize};

use crate::wrong_use;
use files::folder::{check_writable, write_file};
use files::json_file::read_json;
use files::output::{FolderKind, Out};

pub use batch::{Batch, Entry, Outcome};
pub use entry::Record;
pub use index::INDEX_FILE;
pub use recipe::Recipe;
pub use sources::{Sources, find_meshes};

/// Name of the file that marks a cache.
pub const MARKER_FILE: &str = "cache.json";
/// The folder of a cache that is not one yet.
const CACHE: FolderKind = FolderKind { marker: MARKER_FILE, key: "format", names: &[] };
/// Value of the `format` key of the marker and of every recipe.
pub const CACHE_FORMAT: &str = "robofin-cache/1";

/// What to do with a folder that already holds something.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Occupied {
    /// Leave it alone and say so.
    Refuse,
    /// Go on with a cache: what is complete is kept.
    Resume,
    /// Empty a cache first.
    Replace,
}

/// A folder of entries.
#[derive(Clone, Debug)]
pub struct Cache {
    folder: PathBuf,
}

#[derive(Serialize, Deserialize)]
struct Marker {
    format: String,
}

impl Cache {
    /// Opens a cache, or makes one in a folder that is empty or not there.
    ///
    /// # Errors
    /// Wrong use when the folder holds something that is no cache, or a cache and `occupied` does not say what to do
    /// with it; otherwise when the folder cannot be written.
    pub fn open(out: &Out, occupied: Occupied) -> Result<Self> {
        let folder = out.place;
        let cache = Self { folder: folder.to_owned() };
        let marker = folder.join(MARKER_FILE);
        if folder.exists() && !folder.is_dir() {
            let place = folder.display();
            return Err(wrong_use(format!(
                "{place} already exists and is a file; --out expects a folder for several meshes"
            )));
        }
        if marker.is_file() {
            check_marker(&marker)?;
            check_writable(folder)?;
            cache.drop_staged_markers();
            match occupied {
                Occupied::Resume => {}
                Occupied::Replace => cache.clear()?,
                Occupied::Refuse => {
                    return Err(wrong_use(format!(
                        "{} is a cache already: give --resume to go on with it, --force to bake all of it anew, or \
                         choose another --out",
                        folder.display()
                    )));
                }
            }
            return Ok(cache);
        }
        if !is_unused(folder) {
            if occupied == Occupied::Resume {
                return Err(wrong_use(format!(
                    "{} holds no {MARKER_FILE}: it is not a cache that --resume could go on with; choose another --out",
                    folder.display()
                )));
            }
            out.check_folder(&CACHE)?;
        }
        let text = serde_json::to_string(&Marker { format: CACHE_FORMAT.to_owned() })? + "\n";
        let written = write_file(&marker, text.as_bytes());
        // Another process that was quicker may have dropped the staged file; then the marker is there.
        check_marker(&marker).or(written)?;
        cache.drop_staged_markers();
        Ok(cache)
    }

    /// Removes what processes left behind that were killed while they marked the folder.
    fn drop_staged_markers(&self) {
        for file in fs::read_dir(&self.folder).into_iter().flatten().flatten().filter(is_staged_marker) {
            let _ = fs::remove_file(file.path());
        }
    }

    /// The folder.
    pub fn folder(&self) -> &Path {
        &self.folder
    }

    /// Removes entries and index; other files are not the cache's to remove.
    fn clear(&self) -> Result<()> {
        for file in fs::read_dir(&self.folder).with_context(|| self.folder.display().to_string())? {
            let path = file?.path();
            let name = path.file_name().unwrap_or_default().to_string_lossy();
            if name == INDEX_FILE || entry::is_of_an_entry(&name) {
                fs::remove_file(&path).with_context(|| format!("{}: cannot be removed", path.display()))?;
            }
        }
        Ok(())
    }
}

/// Whether a folder is absent, or holds at most what a run that was killed at its start leaves behind.
fn is_unused(folder: &Path) -> bool {
    match fs::read_dir(folder) {
        Ok(mut files) => files.all(|file| file.is_ok_and(|file| is_staged_marker(&file))),
        Err(_) => folder.symlink_metadata().is_err(),
    }
}

fn is_staged_marker(file: &fs::DirEntry) -> bool {
    file.file_name().to_string_lossy().starts_with(&format!(".{MARKER_FILE}.part-"))
}

fn check_marker(marker: &Path) -> Result<()> {
    let found: Marker = read_json(marker, &format!("the mark of a cache of format {CACHE_FORMAT}"))?;
    ensure!(
        found.format == CACHE_FORMAT,
        "{}: format is {}, {CACHE_FORMAT:?} is expected: choose another --out",
        marker.display(),
        quoted_near(&found.format, [CACHE_FORMAT])
    );
    Ok(())
}
