//! Holding a data set against itself: every item rehashed and rechecked, the catalogue made again and compared.

use std::collections::{BTreeMap, BTreeSet};
use std::fs;
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::path::PathBuf;

use anyhow::{Context, Result};
use files::input::{self, MOST_TEXT_BYTES};
use sdf_bake::read::UnitChoice;
use serde::Serialize;

use super::catalogue::ROWS_FILE;
use super::plan::{index_of, key_of, source_key};
use super::row::Row;
use super::{ASSETS_FOLDER, Catalogue, Dataset, Item, MARKER_FILE, Marker, Plan, manifest_path, names};
use crate::asset::{MANIFEST_FILE, Manifest, UsdMode};
use crate::cache::find_meshes;
use crate::in_full;
use crate::validate::validate;
use files::file_lock::Patience;
use files::job_queue::take_turns;

/// An item that does not hold.
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
pub struct Broken {
    /// Its name.
    pub id: String,
    /// What is wrong, one sentence each.
    pub faults: Vec<String>,
}

/// What was found in a data set.
#[derive(Clone, Debug, Default, PartialEq, Eq, Serialize)]
pub struct SetValidation {
    /// Items that were checked.
    pub items: usize,
    /// Checks that were made in them.
    pub checks: usize,
    /// Items that do not hold, by name.
    pub broken: Vec<Broken>,
    /// What is wrong with the set's own files.
    pub catalogue: Vec<String>,
}

impl SetValidation {
    /// Whether everything holds.
    pub fn holds(&self) -> bool {
        self.broken.is_empty() && self.catalogue.is_empty()
    }
}

/// Checks all items with `jobs` threads, then the catalogue; calls `done` with each item's faults as they come in.
///
/// # Errors
/// When a folder cannot be read, or `done` fails.
pub fn check(
    dataset: &Dataset,
    jobs: usize,
    mut done: impl FnMut(&str, &[String]) -> Result<()>,
) -> Result<SetValidation> {
    let ids: Vec<String> =
        listed(dataset).into_iter().chain(dataset.ids()?).collect::<BTreeSet<_>>().into_iter().collect();
    let mut found = SetValidation { items: ids.len(), ..Default::default() };
    take_turns(
        ids.len(),
        jobs,
        |turn, _| Some(check_item(dataset, &ids[turn])),
        |turn, (checks, faults)| {
            done(&ids[turn], &faults)?;
            found.checks += checks;
            if !faults.is_empty() {
                found.broken.push(Broken { id: ids[turn].clone(), faults });
            }
            anyhow::Ok(())
        },
    )?;
    found.broken.sort_by(|a, b| a.id.cmp(&b.id));
    found.catalogue = check_catalogue(dataset, found.broken.is_empty())?;
    Ok(found)
}

/// Names of the items that the manifest lists, as far as it can be read.
fn listed(dataset: &Dataset) -> BTreeSet<String> {
    let text = input::read(&dataset.folder().join(ROWS_FILE), MOST_TEXT_BYTES).unwrap_or_default();
    let rows = text.split(|&byte| byte == b'\n').filter_map(|line| serde_json::from_slice::<Row>(line).ok());
    rows.map(|row| row.id).filter(|id| index_of(id).is_some()).collect()
}

/// How many checks were made of an item, and what they found.
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
    // A file made to bring down the one who opens it is a fault of that item.
    match catch_unwind(AssertUnwindSafe(checked)) {
        Ok(Ok(found)) => found,
        Ok(Err(error)) => (1, vec![in_full(&error)]),
        Err(_) => (1, vec!["its files cannot be opened: a bug in this program".to_owned()]),
    }
}

/// What is wrong with the files of the set itself; those that follow from the items need whole items.
fn check_catalogue(dataset: &Dataset, items_hold: bool) -> Result<Vec<String>> {
    if !items_hold {
        return Ok(vec!["not compared with the items, some of which are broken".to_owned()]);
    }
    match Catalogue::of(dataset) {
        Err(error) => Ok(vec![in_full(&error)]),
        Ok(catalogue) => compare_files(dataset, &catalogue.files),
    }
}

/// What differs between the files of a data set's catalogue and what they should hold, and what is no part of the set.
///
/// # Errors
/// When the set's folder cannot be read.
pub(crate) fn compare_files<R: Marker>(
    dataset: &Dataset<R>,
    files: &BTreeMap<&'static str, Vec<u8>>,
) -> Result<Vec<String>> {
    let found = |name: &str| input::read(&dataset.folder().join(name), MOST_TEXT_BYTES).ok();
    let mut faults: Vec<String> =
        files.iter().filter_map(|(name, expected)| compare(name, found(name), expected)).collect();
    let own = R::FOLDERS.iter().chain(files.keys()).map(|name| name.split('/').next().unwrap_or(name));
    let known: BTreeSet<&str> = own.chain([MARKER_FILE]).collect();
    let strange = names(dataset.folder())?.into_iter().filter(|name| !known.contains(name.as_str()));
    let strange = strange.filter(|name| !name.starts_with('.'));
    faults.extend(strange.map(|name| format!("{name}: no part of a data set")));
    Ok(faults)
}

fn compare(name: &str, found: Option<Vec<u8>>, expected: &[u8]) -> Option<String> {
    let Some(found) = found else { return Some(format!("{name}: missing")) };
    let same = found.iter().zip(expected).take_while(|(a, b)| a == b).count();
    if same == expected.len() && found.len() == expected.len() {
        return None;
    }
    let line = 1 + expected[..same].iter().filter(|&&byte| byte == b'\n').count();
    Some(format!("{name}: differs in line {line} from what the items and failures say"))
}

/// Removes broken items and plans them anew from the sources below `places`.
///
/// # Errors
/// When a source is no longer there, named by its item; nothing is removed then.
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
        let _claim = dataset.claim(id, Patience::Endless)?;
        let folder = dataset.asset_folder(id);
        // Without its manifest an item is not taken for whole, should this be interrupted.
        let _ = fs::remove_file(folder.join(MANIFEST_FILE));
        if folder.exists() {
            fs::remove_dir_all(&folder).with_context(|| format!("{}: cannot be removed", folder.display()))?;
        }
    }
    Ok(Plan { parts: items.len(), items, ..Default::default() })
}
