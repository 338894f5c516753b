//! Making one item; runs in a process of its own.

use std::fs;
use std::path::Path;

use anyhow::{Context, Result, ensure};
use sdf_bake::read::UnitChoice;
use serde::{Deserialize, Serialize};

use super::plan::{key_of, source_key};
use super::{ASSETS_FOLDER, Dataset, Stage, remove_stale};
use crate::asset::{self, Extras, UsdMode};
use crate::console::Console;
use crate::in_full;
use crate::part::Part;
use crate::workpiece::{WeldingOptions, weld_part};
use files::file_lock::Patience;
use files::folder::StagedFolder;

/// Samples along each side of a picture's pixel: four times as many would take most of an item's time.
const SAMPLES_PER_SIDE: usize = 1;

/// How an item ended.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Ending {
    /// It was made.
    Made,
    /// It was there already.
    There,
    /// Another process is making it.
    Busy,
    /// It cannot be made.
    Failed {
        /// Where it failed.
        stage: Stage,
        /// Why.
        reason: String,
    },
}

/// What is the same for all items of a set.
#[derive(Clone, Debug)]
pub struct ItemWishes {
    /// Unit of the files' coordinates.
    pub unit: UnitChoice,
    /// Options of welding; the seed is the set's.
    pub options: WeldingOptions,
}

/// Makes the item `id` of a source, or says why there is none; the folder is complete or it is not there.
pub fn make(dataset: &Dataset, source: &Path, id: &str, wishes: &ItemWishes) -> Ending {
    // The name of the folder in the making holds the number of this process, and reasons are the same in every run.
    let staging = format!(".{id}.part-{}", std::process::id());
    let failed = |stage, error: anyhow::Error| {
        let reason = in_full(&error).replace(&staging, id);
        Ending::Failed { stage, reason }
    };
    let _claim = match dataset.claim(id, Patience::None) {
        Ok(Some(claim)) => claim,
        Ok(None) => return Ending::Busy,
        Err(error) => return failed(Stage::Write, error),
    };
    if dataset.holds(id) {
        return Ending::There;
    }
    let folder = match place(dataset, id) {
        Ok(folder) => folder,
        Err(error) => return failed(Stage::Write, error),
    };
    let part = match load(source, id, wishes.unit) {
        Ok(part) => part,
        Err(error) => return failed(Stage::Part, error),
    };
    let options = WeldingOptions { seed: dataset.recipe.seed_of(id), ..wishes.options.clone() };
    let console = Console::silent();
    let workpiece = match weld_part(part, &options, &console) {
        Ok(workpiece) => workpiece,
        Err(error) => return failed(Stage::Weld, error),
    };
    let preview = dataset.recipe.preview;
    let extras = Extras { usd: UsdMode::Off, preview, samples_per_side: SAMPLES_PER_SIDE };
    match asset::write(&workpiece, &options, folder, extras, &console) {
        Ok(_) => Ending::Made,
        Err(error) => failed(Stage::Write, error),
    }
}

/// An empty place for the item; what is there and not complete goes, and so does what killed runs left.
fn place(dataset: &Dataset, id: &str) -> Result<StagedFolder> {
    let folder = dataset.asset_folder(id);
    remove_stale(&dataset.folder().join(ASSETS_FOLDER), id)?;
    if folder.exists() {
        fs::remove_dir_all(&folder).with_context(|| format!("{}: cannot be removed", folder.display()))?;
    }
    Ok(StagedFolder::fresh(&folder)?)
}

fn load(source: &Path, id: &str, unit: UnitChoice) -> Result<Part> {
    let key = source_key(source, unit)?;
    ensure!(key == key_of(id), "the file changed while its items were made: its name is {key} now");
    Part::load(source, unit)
}
