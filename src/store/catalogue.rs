//! Files that describe a set; all follow from the marker, the items and the failures.

use std::collections::BTreeMap;

use anyhow::Result;
use files::input::{self, MOST_TEXT_BYTES};
use serde::Serialize;

use super::{Marker, Store, remove_stale};
use files::folder::write_file;

/// Name of the file with one line of JSON for each failure.
pub const FAILURES_FILE: &str = "failures.jsonl";
/// Name of the README for people.
pub const CARD_FILE: &str = "README.md";
/// Name of the contact sheet.
pub const CONTACT_FILE: &str = "contact-sheet.png";

/// A type of set with a catalogue.
pub trait Described: Marker {
    /// Plural name of its items in messages.
    const ITEMS: &'static str;

    /// Makes the catalogue of the existing items.
    ///
    /// # Errors
    /// If an item or the record of a failure cannot be read.
    fn describe(set: &Store<Self>) -> Result<Catalogue>
    where
        Self: Sized;

    /// Finds contradictions between complete items of the set, one sentence each.
    ///
    /// # Errors
    /// Those of [`Described::describe`].
    fn contradictions(_set: &Store<Self>) -> Result<Vec<String>>
    where
        Self: Sized,
    {
        Ok(Vec::new())
    }
}

/// Files of a catalogue by name.
pub struct Catalogue {
    /// Contents of the files.
    pub files: BTreeMap<&'static str, Vec<u8>>,
    /// Number of items listed.
    pub items: usize,
}

impl Catalogue {
    /// Makes the catalogue of the existing items and writes it in place of an older one.
    ///
    /// # Errors
    /// Those of [`Described::describe`], and if a file cannot be written.
    pub fn update<M: Described>(set: &Store<M>) -> Result<Self> {
        // Shards that end together write the catalogue one after the other.
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
