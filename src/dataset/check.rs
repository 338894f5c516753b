//! Check of a data set: every item is hashed and validated again, the catalogue is made again and compared.

use std::collections::BTreeSet;
use std::fs;
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::path::PathBuf;

use anyhow::{Context, Result};
use files::input::{self, MOST_TEXT_BYTES};
use sdf_bake::read::UnitChoice;

use super::catalogue::ROWS_FILE;
use super::plan::{index_of, key_of, source_key};
use super::row::Row;
use super::{ASSETS_FOLDER, Dataset, Item, Plan, manifest_path};
use crate::asset::{MANIFEST_FILE, Manifest, UsdMode};
use crate::cache::find_meshes;
use crate::in_full;
use crate::store::check::{Broken, SetValidation};
use crate::store::{self, remove};
use crate::validate::validate;
use files::file_lock::LockWait;

/// Checks all items with `jobs` threads, then the catalogue; calls `done` with each item's faults as they arrive.
///
/// # Errors
/// If a folder cannot be read, or `done` fails.
pub fn check(dataset: &Dataset, jobs: usize, done: impl FnMut(&str, &[String]) -> Result<()>) -> Result<SetValidation> {
    let ids: BTreeSet<String> = listed(dataset).into_iter().chain(dataset.ids()?).collect();
    let items: Vec<(String, ())> = ids.into_iter().map(|id| (id, ())).collect();
    store::check::check(dataset, jobs, &items, |id, ()| check_item(dataset, id), done)
}

/// Returns the names of the items in the catalogue, as far as it can be read.
fn listed(dataset: &Dataset) -> BTreeSet<String> {
    let text = input::read(&dataset.folder().join(ROWS_FILE), MOST_TEXT_BYTES).unwrap_or_default();
    let rows = text.split(|&byte| byte == b'\n').filter_map(|line| serde_json::from_slice::<Row>(line).ok());
    rows.map(|row| row.id).filter(|id| index_of(id).is_some()).collect()
}

/// Checks an item; returns the number of checks, and the faults found.
fn check_item(dataset: &Dataset, id: &str) -> (usize, Vec<String>) {
    let folder = dataset.asset_folder(id);
    if !folder.is_dir() {
        return (1, vec![format!("{ROWS_FILE} lists it and there is no such folder")]);
    }
    let checked = || -> Result<(usize, Vec<String>)> {
        let manifest = Manifest::read(&folder)?;
        dataset.recipe.fits(id, &manifest).with_context(|| manifest_path(id))?;
        let checks = validate(&folder, UsdMode::Off)?.checks;
        let failed = checks.iter().filter(|check| !check.passed);
        let faults = failed.map(|check| format!("{}: {}: {}", check.file, check.rule, check.found)).collect();
        Ok((checks.len() + 1, faults))
    };
    // A panic on a hostile file is a fault of that item.
    match catch_unwind(AssertUnwindSafe(checked)) {
        Ok(Ok(found)) => found,
        Ok(Err(error)) => (1, vec![in_full(&error)]),
        Err(_) => (1, vec!["its files cannot be opened: a bug in this program".to_owned()]),
    }
}

/// Removes broken items and plans them again from the sources below `places`.
///
/// # Errors
/// If a source is missing; the error names its item, and nothing is removed.
pub fn plan_repair(dataset: &Dataset, broken: &[Broken], places: &[PathBuf], unit: UnitChoice) -> Result<Plan> {
    let keys: Vec<(String, PathBuf)> = find_meshes(places)?
        .into_keys()
        .filter_map(|source| source_key(&source, unit).ok().map(|key| (key, source)))
        .collect();
    let item = |Broken { id, .. }: &Broken| -> Result<Item> {
        let index =
            index_of(id).with_context(|| format!("{ASSETS_FOLDER}/{id}: not the name of an item; remove it"))?;
        let source = keys.iter().find(|(key, _)| key == key_of(id)).map(|(_, source)| source.clone());
        let source = source.with_context(|| {
            let file = Manifest::read(&dataset.asset_folder(id)).map_or(String::new(), |found| found.source.file);
            format!("{id}: its source {file} is not below the folders searched; name its folder with --from")
        })?;
        Ok(Item { source, id: id.clone(), index })
    };
    let items = broken.iter().map(item).collect::<Result<Vec<Item>>>()?;
    for Item { id, .. } in &items {
        let _claim = dataset.claim(id, LockWait::Endless)?;
        let folder = dataset.asset_folder(id);
        // The manifest goes first, so that an interrupted removal leaves no item that seems complete.
        let _ = fs::remove_file(folder.join(MANIFEST_FILE));
        remove(&folder)?;
    }
    Ok(Plan { parts: items.len(), items, ..Default::default() })
}
