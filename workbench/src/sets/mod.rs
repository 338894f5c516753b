//! Data sets on the page: assets as a table with filters, labelled images with their labels over them.
//!
//! 1. [`SetKind`] is read from the marker of a data set.
//! 2. `lines` reads the files with one line of JSON for each item; a line that cannot be read is reported by its number.
//! 3. `assets` and `images` make the rows for the page; [`ImageSets`] keeps those of images, which are long.
//! 4. `inside` finds the files of an item among the folder's own entries.
//! 5. `overlay` colours labels.

mod assets;
mod images;
mod inside;
mod lines;
mod overlay;

use std::path::Path;

use files::json_file::read_json;
use serde::Deserialize;

pub(crate) use assets::{item, preview, table};
pub(crate) use images::{ImageSets, Layer};

use crate::error::Refusal;

/// Kind of a data set.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum SetKind {
    /// Welded workpieces.
    Assets,
    /// Labelled images.
    Images,
}

/// The part of a marker that names the kind.
#[derive(Deserialize)]
struct Marker {
    format: String,
}

impl SetKind {
    /// Reads the kind of a data set.
    ///
    /// # Errors
    /// If its marker cannot be read, or is of another kind.
    pub(crate) fn of(folder: &Path) -> Result<Self, Refusal> {
        let path = folder.join("dataset.json");
        let marker: Marker =
            read_json(&path, "the marker of a data set").map_err(|error| Refusal::wrong(error.to_string()))?;
        match marker.format.split('/').next() {
            Some("robofin-dataset") => Ok(Self::Assets),
            Some("robofin-images") => Ok(Self::Images),
            _ => Err(Refusal::wrong(format!(
                "{}: the format is {:?}; robofin-dataset and robofin-images are accepted",
                path.display(),
                marker.format
            ))),
        }
    }
}
