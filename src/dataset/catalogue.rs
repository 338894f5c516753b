//! The files that describe a data set; each follows from the marker, the items and the failures.

use std::collections::BTreeMap;

use anyhow::Result;
use files::input::{self, MOST_TEXT_BYTES};
use serde::Serialize;

use super::row::Seen;
use super::table::Table;
use super::{Dataset, Failure, Marker, card, contact, croissant, record_of, remove_stale};
use files::folder::write_file;

/// One line of JSON for each item.
pub const ROWS_FILE: &str = "manifest.jsonl";
/// The same as a table.
pub const TABLE_FILE: &str = "manifest.csv";
/// One line of JSON for each failure.
pub const FAILURES_FILE: &str = "failures.jsonl";
/// For people.
pub const CARD_FILE: &str = "README.md";
/// Pictures of some items.
pub const CONTACT_FILE: &str = "contact-sheet.png";
/// For machines that look for data sets.
pub const CROISSANT_FILE: &str = "croissant.json";

/// The files of a catalogue by name.
pub struct Catalogue {
    /// Their contents.
    pub files: BTreeMap<&'static str, Vec<u8>>,
    /// How many items it lists.
    pub items: usize,
}

impl Catalogue {
    /// Describes what is there.
    ///
    /// # Errors
    /// When an item or the record of a failure cannot be read.
    pub fn of(dataset: &Dataset) -> Result<Self> {
        let items = dataset.ids()?.iter().map(|id| Seen::read(dataset, id)).collect::<Result<Vec<Seen>>>()?;
        let failures: Vec<Failure> = dataset.failures()?;
        let table = Table::of(items.iter().map(|item| &item.row))?;
        let mut files = BTreeMap::from([
            (ROWS_FILE, lines(items.iter().map(|item| &item.row))?),
            (TABLE_FILE, table.csv()?),
            (FAILURES_FILE, lines(failures.iter())?),
            (CARD_FILE, card::write(&dataset.recipe, &items, &failures).into_bytes()),
            (CONTACT_FILE, contact::draw(dataset, &items)?),
        ]);
        let records = files.iter().map(|(&name, bytes)| (name, record_of(bytes))).collect();
        files.insert(CROISSANT_FILE, croissant::write(&dataset.recipe, &table, &records)?);
        Ok(Self { files, items: items.len() })
    }

    /// Describes what is there and writes the description, in place of an older one.
    ///
    /// # Errors
    /// As [`Catalogue::of`], and when a file cannot be written.
    pub fn update(dataset: &Dataset) -> Result<Self> {
        // Shards that end together describe the set one after the other.
        let _claim = dataset.claim_catalogue()?;
        let catalogue = Self::of(dataset)?;
        publish(dataset, &catalogue.files)?;
        Ok(catalogue)
    }
}

/// Writes files of a data set in place of older ones; for who holds the claim on its catalogue.
///
/// # Errors
/// When a file cannot be written.
pub(crate) fn publish<R: Marker>(dataset: &Dataset<R>, files: &BTreeMap<&'static str, Vec<u8>>) -> Result<()> {
    for (name, bytes) in files {
        let place = dataset.folder().join(name);
        if let (Some(folder), Some(name)) = (place.parent().filter(|folder| folder.is_dir()), place.file_name()) {
            remove_stale(folder, &name.to_string_lossy())?;
        }
        if input::read(&place, MOST_TEXT_BYTES).ok().as_ref() != Some(bytes) {
            write_file(&place, bytes)?;
        }
    }
    Ok(())
}

/// Values as JSON, one a line.
///
/// # Errors
/// Never for plain data.
pub(crate) fn lines<'a, T: Serialize + 'a>(values: impl Iterator<Item = &'a T>) -> Result<Vec<u8>> {
    let mut text = Vec::new();
    for value in values {
        serde_json::to_writer(&mut text, value)?;
        text.push(b'\n');
    }
    Ok(text)
}
