//! Check of a set: every item is checked, the catalogue is made again and compared.

use std::collections::{BTreeMap, BTreeSet};

use anyhow::Result;
use files::input::{self, MOST_TEXT_BYTES};
use serde::Serialize;

use super::catalogue::Described;
use super::{Marker, Store, names};
use crate::in_full;
use files::job_queue::take_turns;

/// An item with faults.
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
pub struct Broken {
    /// Name of the item.
    pub id: String,
    /// Faults of the item, one sentence each.
    pub faults: Vec<String>,
}

/// Result of the check of a set.
#[derive(Clone, Debug, Default, PartialEq, Eq, Serialize)]
pub struct SetValidation {
    /// Number of items checked.
    pub items: usize,
    /// Number of checks made.
    pub checks: usize,
    /// Items with faults, by name.
    pub broken: Vec<Broken>,
    /// Faults of the set's own files, one sentence each.
    pub catalogue: Vec<String>,
}

impl SetValidation {
    /// True if no fault was found.
    pub fn holds(&self) -> bool {
        self.broken.is_empty() && self.catalogue.is_empty()
    }
}

/// Checks items with `jobs` threads, then the catalogue; calls `done` with each item's faults as they arrive.
///
/// - `items`: names, and the inputs of `look`
/// - `look`: returns the number of checks made of an item, and the faults found
///
/// # Errors
/// If a folder cannot be read, or `done` fails.
pub fn check<M: Described, I: Sync>(
    set: &Store<M>,
    jobs: usize,
    items: &[(String, I)],
    look: impl Fn(&str, &I) -> (usize, Vec<String>) + Sync,
    mut done: impl FnMut(&str, &[String]) -> Result<()>,
) -> Result<SetValidation> {
    let mut found = SetValidation { items: items.len(), ..Default::default() };
    take_turns(
        items.len(),
        jobs,
        |turn, _| Some(look(&items[turn].0, &items[turn].1)),
        |turn, (checks, faults)| {
            let id = &items[turn].0;
            done(id, &faults)?;
            found.checks += checks;
            if !faults.is_empty() {
                found.broken.push(Broken { id: id.clone(), faults });
            }
            anyhow::Ok(())
        },
    )?;
    found.broken.sort_by(|a, b| a.id.cmp(&b.id));
    found.catalogue = check_catalogue(set, found.broken.is_empty())?;
    Ok(found)
}

/// Returns the faults of the set's own files, one sentence each; these are compared only if no item has faults.
fn check_catalogue<M: Described>(set: &Store<M>, items_hold: bool) -> Result<Vec<String>> {
    if !items_hold {
        return Ok(vec![format!("not compared with the {}, some of which are broken", M::ITEMS)]);
    }
    match M::describe(set) {
        Err(error) => Ok(vec![in_full(&error)]),
        Ok(catalogue) => Ok([compare_files(set, &catalogue.files)?, M::contradictions(set)?].concat()),
    }
}

/// Finds catalogue files with unexpected content, and names that do not belong to the set.
fn compare_files<M: Marker>(set: &Store<M>, files: &BTreeMap<&'static str, Vec<u8>>) -> Result<Vec<String>> {
    let found = |name: &str| input::read(&set.folder().join(name), MOST_TEXT_BYTES).ok();
    let mut faults: Vec<String> =
        files.iter().filter_map(|(name, expected)| compare(name, found(name), expected)).collect();
    let own = M::FOLDERS.iter().chain(files.keys()).map(|name| name.split('/').next().unwrap_or(name));
    let known: BTreeSet<&str> = own.chain([M::FILE]).collect();
    let strange = names(set.folder())?.into_iter().filter(|name| !known.contains(name.as_str()));
    let strange = strange.filter(|name| !name.starts_with('.'));
    faults.extend(strange.map(|name| format!("{name}: not part of a data set")));
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
