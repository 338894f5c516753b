//! The page on which a weld is made: dials, a picture of the part with the weld, and the asset made in the background.
//!
//! 1. `parts` lists the meshes of the folder; `flags` are the dials as flags of `robofin weld`.
//! 2. A part that is looked at has an [`OpenPart`]: a thread that owns its mesh and its fields (`easel`).
//! 3. `figures` are the numbers beside the picture.
//! 4. `maker` runs `robofin weld` with the same flags, so the asset is the one that the page showed.

mod easel;
mod figures;
mod flags;
mod maker;
mod open_part;
mod parts;

use std::path::{Path, PathBuf};
use std::sync::{Arc, Mutex, PoisonError};

use files::folder::write_file;

pub(crate) use easel::Easel;
pub(crate) use flags::{DialRow, Flags, dials};
pub(crate) use maker::{Maker, Order, Outcome};
pub(crate) use open_part::OpenPart;
pub(crate) use parts::{PartFile, parts};

use crate::error::Refusal;

/// Greatest number of parts that stay open; each holds its mesh and its fields in memory.
const MOST_OPEN: usize = 3;
/// The bundled part, and the name of its file in the folder for results.
const BUNDLED: (&str, &[u8]) = ("bracket.obj", include_bytes!("../../../data/bracket.obj"));

/// The parts of a folder, those that are open, and the run that makes an asset.
pub(crate) struct Welder {
    folder: PathBuf,
    out: PathBuf,
    open: Mutex<Vec<Arc<OpenPart>>>,
    /// The run in the background.
    pub(crate) maker: Maker,
}

impl Welder {
    /// Makes a welder of the served folder and the folder for results.
    pub(crate) fn new(folder: &Path, out: &Path) -> Self {
        Self { folder: folder.to_owned(), out: out.to_owned(), open: Mutex::default(), maker: Maker::default() }
    }

    /// Lists the bundled part and the meshes of the folder; the second value is true if the list is incomplete.
    pub(crate) fn parts(&self) -> (Vec<PartFile>, bool) {
        let (mut found, is_cut) = parts(&self.folder);
        found.insert(0, PartFile::bundled(&self.out.join(BUNDLED.0)));
        (found, is_cut)
    }

    /// Finds a part by its id; the bundled one is written to the folder for results, so that command lines can name it.
    ///
    /// # Errors
    /// If it no longer exists, or the bundled one cannot be written.
    pub(crate) fn part(&self, id: &str) -> Result<PartFile, Refusal> {
        let found = self.parts().0.into_iter().find(|part| part.id == id);
        let part =
            found.ok_or_else(|| Refusal::missing("the folder no longer holds this part; load the page again"))?;
        if part.is_bundled && !part.path.is_file() {
            let unwritable = |error: String| Refusal::wrong(format!("{}: {error}", self.out.display()));
            std::fs::create_dir_all(&self.out).map_err(|error| unwritable(error.to_string()))?;
            write_file(&part.path, BUNDLED.1).map_err(|error| unwritable(error.to_string()))?;
        }
        Ok(part)
    }

    /// Opens a part, or returns the open one if its file has not changed since.
    ///
    /// # Errors
    /// If it no longer exists, or the system cannot start a thread.
    pub(crate) fn open(&self, id: &str) -> Result<Arc<OpenPart>, Refusal> {
        let part = self.part(id)?;
        let mut open = self.open.lock().unwrap_or_else(PoisonError::into_inner);
        let found = open.iter().position(|own| own.is_of(&part));
        let own = match found {
            Some(at) => open.remove(at),
            None => Arc::new(OpenPart::open(part)?),
        };
        open.insert(0, own.clone());
        open.truncate(MOST_OPEN);
        Ok(own)
    }
}
