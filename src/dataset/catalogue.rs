//! Files that describe a data set; all follow from the marker, the items and the failures.

use std::collections::BTreeMap;

use anyhow::Result;

use super::row::RowFigures;
use super::table::Table;
use super::{Dataset, Recipe, card, contact_sheet, croissant};
use crate::asset::FileRecord;
use crate::store::Failure;
use crate::store::catalogue::{CARD_FILE, CONTACT_FILE, Catalogue, Described, FAILURES_FILE, lines};

/// Name of the catalogue with one line of JSON for each item.
pub const ROWS_FILE: &str = "manifest.jsonl";
/// Name of the same catalogue as a table.
pub const TABLE_FILE: &str = "manifest.csv";
/// Name of the metadata for search engines of data sets.
pub const CROISSANT_FILE: &str = "croissant.json";

impl Described for Recipe {
    const ITEMS: &'static str = "items";

    fn describe(dataset: &Dataset) -> Result<Catalogue> {
        let items =
            dataset.ids()?.iter().map(|id| RowFigures::read(dataset, id)).collect::<Result<Vec<RowFigures>>>()?;
        let failures: Vec<Failure> = dataset.failures()?;
        let table = Table::of(items.iter().map(|item| &item.row))?;
        let mut files = BTreeMap::from([
            (ROWS_FILE, lines(items.iter().map(|item| &item.row))?),
            (TABLE_FILE, table.csv()?),
            (FAILURES_FILE, lines(failures.iter())?),
            (CARD_FILE, card::write(&dataset.recipe, &items, &failures).into_bytes()),
            (CONTACT_FILE, contact_sheet::draw(dataset, &items)?),
        ]);
        let records = files.iter().map(|(&name, bytes)| (name, FileRecord::of_bytes(bytes))).collect();
        files.insert(CROISSANT_FILE, croissant::write(&dataset.recipe, &table, &records)?);
        Ok(Catalogue { files, items: items.len() })
    }
}
