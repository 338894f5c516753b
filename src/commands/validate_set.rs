//! `robofin validate` of a data set, and its repair.

use std::path::{Path, PathBuf};

use anyhow::{Result, bail, ensure};
use serde::Serialize;

use super::dataset::make;
use super::item_flags::ItemFlags;
use crate::console::Console;
use crate::dataset::check::{check, plan_repair};
use crate::dataset::run::Run;
use crate::dataset::{Dataset, MARKER_FILE};
use crate::store::Marker;
use crate::store::catalogue::Catalogue;
use crate::store::check::SetValidation;

/// The answer of `validate --json` for a data set.
#[derive(Serialize)]
struct SetAnswer<'a> {
    dataset: &'a Path,
    valid: bool,
    #[serde(flatten)]
    validation: &'a SetValidation,
}

/// Validates a data set, and repairs it on request. A repair searches the folders `from` for sources.
pub(super) fn run(folder: &Path, repair: bool, from: Option<&[PathBuf]>, jobs: usize, console: &Console) -> Result<()> {
    let dataset = Dataset::open(folder)?;
    let mut found = look(&dataset, jobs, console)?;
    if repair && !found.holds() {
        repair_items(&dataset, &found, from, jobs, console)?;
        found = look(&dataset, jobs, console)?;
    }
    conclude(folder, repair, &found, console)
}

/// Reports the final result.
pub(super) fn conclude(folder: &Path, repair: bool, found: &SetValidation, console: &Console) -> Result<()> {
    console.answer(&SetAnswer { dataset: folder, valid: found.holds(), validation: found })?;
    let SetValidation { items, checks, broken, catalogue } = found;
    if !found.holds() {
        let counts = format!("{} of {items} items broken, {} faults in the catalogue", broken.len(), catalogue.len());
        bail!("{}: {counts}{}", folder.display(), if repair { "" } else { "; --repair makes only these again" });
    }
    console.step("valid", format!("{items} items, {checks} checks, and the catalogue says what they say"));
    Ok(())
}

fn look(dataset: &Dataset, jobs: usize, console: &Console) -> Result<SetValidation> {
    report_items(dataset.ids()?.len(), console, |done| check(dataset, jobs, done))
}

/// Reports each item in which `check` finds faults.
pub(super) fn report_items(
    items: usize,
    console: &Console,
    check: impl FnOnce(&mut dyn FnMut(&str, &[String]) -> Result<()>) -> Result<SetValidation>,
) -> Result<SetValidation> {
    let bar = console.bar("validate", items as u64);
    let found = check(&mut |id, faults| {
        bar.inc(1);
        bar.suspend(|| faults.iter().for_each(|fault| console.step("BROKEN", format!("{id}: {fault}"))));
        Ok(())
    })?;
    bar.finish_and_clear();
    found.catalogue.iter().for_each(|fault| console.step("BROKEN", fault));
    Ok(found)
}

/// Makes broken items again, then the catalogue.
fn repair_items(
    dataset: &Dataset,
    found: &SetValidation,
    from: Option<&[PathBuf]>,
    jobs: usize,
    console: &Console,
) -> Result<()> {
    let recipe = &dataset.recipe;
    let kept = ItemFlags::read(&recipe.flags)?;
    let same = kept.recipe(&kept.wishes(), &recipe.flags, recipe.sources.clone())?;
    let difference = recipe.difference(&same);
    ensure!(
        difference.is_none(),
        "{}: its flags do not lead to what it says ({}), so nothing can be made like it",
        dataset.folder().join(MARKER_FILE).display(),
        difference.unwrap_or_default()
    );
    if !found.broken.is_empty() {
        let places = from.map_or_else(|| recipe.sources.iter().map(PathBuf::from).collect(), <[PathBuf]>::to_vec);
        let plan = plan_repair(dataset, &found.broken, &places, kept.unit())?;
        let flags = &recipe.flags;
        make(&Run { dataset, plan: &plan, flags, limits: kept.limits(), jobs }, console)?;
    }
    Catalogue::update(dataset)?;
    Ok(())
}
