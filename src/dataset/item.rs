//! Makes one item; runs in a process of its own.

use std::path::Path;

use anyhow::{Result, ensure};
use sdf_bake::read::UnitChoice;

use super::Dataset;
use super::plan::{key_of, source_key};
use crate::asset::{self, Extras, UsdMode};
use crate::console::Console;
use crate::part::Part;
use crate::store::process::Ending;
use crate::store::{Fault, Stage, remove};
use crate::workpiece::{WeldingOptions, weld_part};
use files::file_lock::LockWait;
use files::folder::StagedFolder;

/// Samples along each side of a picture's pixel; more would take most of an item's time.
const SAMPLES_PER_SIDE: usize = 1;

/// Settings shared by all items of a set.
#[derive(Clone, Debug)]
pub struct ItemSettings {
    /// Unit of the files' coordinates.
    pub unit: UnitChoice,
    /// Options of welding; their seed is that of the set.
    pub options: WeldingOptions,
}

/// Makes the item `id` of a source, or returns the reason of the failure; the folder is complete or does not exist.
pub fn make(dataset: &Dataset, source: &Path, id: &str, settings: &ItemSettings) -> Ending {
    let there = || dataset.holds(id).then_some(());
    Ending::of(id, dataset.fill(id, LockWait::None, there, || make_again(dataset, source, id, settings)))
}

fn make_again(dataset: &Dataset, source: &Path, id: &str, settings: &ItemSettings) -> Result<(), Fault> {
    let folder = place(dataset, id)?;
    let part = load(source, id, settings.unit).map_err(|error| Stage::Part.fault(error))?;
    let options = WeldingOptions { seed: dataset.recipe.seed_of(id), ..settings.options.clone() };
    let console = Console::silent();
    let workpiece = weld_part(part, &options, &console).map_err(|error| Stage::Weld.fault(error))?;
    let (preview, full) = (dataset.recipe.preview, Extras::full(UsdMode::Off));
    let extras = Extras { density: None, preview, samples_per_side: SAMPLES_PER_SIDE, ..full };
    asset::write(&workpiece, &options, folder, extras, &console)?;
    Ok(())
}

/// Returns an empty staged folder for the item; an incomplete folder in its place is removed.
fn place(dataset: &Dataset, id: &str) -> Result<StagedFolder> {
    let folder = dataset.asset_folder(id);
    remove(&folder)?;
    Ok(StagedFolder::fresh(&folder)?)
}

fn load(source: &Path, id: &str, unit: UnitChoice) -> Result<Part> {
    let key = source_key(source, unit)?;
    ensure!(key == key_of(id), "the file changed while its items were made: its name is {key} now");
    Part::load(source, unit)
}
