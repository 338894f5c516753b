//! The files that describe a set; each follows from the marker, the items and the failures.

use std::collections::BTreeMap;

use anyhow::Result;
use files::input::{self, MOST_TEXT_BYTES};
use serde::Serialize;

use super::{Marker, Store, remove_stale};
use files::folder::write_file;

/// One line of JSON for each failure.
pub const FAILURES_FILE: &str = "failures.jsonl";
/// For people.
pub const CARD_FILE: &str = "README.md";
/// Pictures of some items.
pub const CONTACT_FILE: &str = "contact-sheet.png";

/// A kind of set that is described by files of its own.
pub trait Described: Marker {
    /// Name of its items in messages, in the plural.
    const ITEMS: &'static str;

    /// Describes what is there.
    ///
    /// # Errors
    /// When an item or the record of a failure cannot be read.
    fn describe(set: &Store<Self>) -> Result<Catalogue>
    where
        Self: Sized;

    /// Contradictions between whole items of the set, one sentence each.
    ///
    /// # Errors
    /// As [`Described::describe`].
    fn contradictions(_set: &Store<Self>) -> Result<Vec<String>>
    where
        Self: Sized,
    {
        Ok(Vec::new())
    }
}

/// The files of a catalogue by name.
pub struct Catalogue {
    /// Their contents.
    pub files: BTreeMap<&'static str, Vec<u8>>,
    /// Number of items that it lists.
    pub items: usize,
}

impl Catalogue {
    /// Describes what is there and writes the description, in place of an older one.
    ///
    /// # Errors
    /// As [`Described::describe`], and when a file cannot be written.
    pub fn update<M: Described>(set: &Store<M>) -> Result<Self> {
        // Shards that end together describe the set one after the other.
        let _claim = set.claim_catalogue()?;
        let catalogue = M::describe(set)?;
        for (name, bytes) in &catalogue.files {
            let place = set.folder().join(name);
            if let (Some(folder), Some(name)) = (place.parent().filter(|folder| folder.is_dir()), place.file_name()) {
                remove_stale(folder, &name.to_string_lossy())?;
            }
            if input::read(&place, MOST_TEXT_BYTES).ok().as_ref() != Some(bytes) {
                write_file(&place, bytes)?;
            }
        }
        Ok(catalogue)
    }
}

/// Values as JSON, one a line.
///
/// # Errors
/// Never for plain data.
pub fn lines<'a, T: Serialize + 'a>(values: impl Iterator<Item = &'a T>) -> Result<Vec<u8>> {
    let mut text = Vec::new();
    for value in values {
        serde_json::to_writer(&mut text, value)?;
        text.push(b'\n');
    }
    Ok(text)
}
