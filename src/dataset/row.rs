//! What the catalogue says of one item, read from its folder.

use std::collections::BTreeMap;

use anyhow::{Context, Result};
use serde::{Deserialize, Serialize};
use serde_json::{Value, json};

use super::difficulty::{Difficulty, turn};
use super::plan::{index_of, key_of};
use super::{ASSETS_FOLDER, Dataset};
use crate::asset::{CurveTruth, FileRecord, MANIFEST_FILE, Manifest, WeldTruth, Welds};
use crate::store::number_from;

/// Tenths of the parts for training; one of the others is for validation and one for tests.
const TRAINING: u64 = 8;

/// A line of the catalogue.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Row {
    /// Name of the item.
    pub id: String,
    /// `train`, `validation` or `test`: all items of a part have the same.
    pub split: String,
    /// Class by what was measured.
    pub difficulty: Difficulty,
    /// File name of the source.
    pub source: String,
    /// SHA-256 of the source.
    pub source_sha256: String,
    /// Number among the items of the part.
    pub index: u32,
    /// What is known of the source's licence.
    pub licence: String,
    /// Seed of the item.
    pub seed: u64,
    /// Its folder, from the data set's.
    pub folder: String,
    /// Options as in the item's manifest (SI); `null` was chosen for the part.
    pub requested: Value,
    /// What the item has: voxel, checks, and each weld's figures.
    pub measured: Value,
    /// Files of the folder by name.
    pub files: BTreeMap<String, FileRecord>,
}

/// A row with what only the card and the contact sheet look at.
pub(super) struct Seen {
    pub(super) row: Row,
    /// The least exposure of its welds.
    pub(super) exposure: f64,
    /// The largest turn of its welds over one bead width [rad].
    pub(super) turn: f64,
    /// Length of all its welds [mm].
    pub(super) length_mm: f64,
}

/// Which split all items of a part belong to; the part's name decides.
pub(super) fn split_of(key: &str) -> &'static str {
    match number_from(&format!("split {key}")) % 10 {
        0..TRAINING => "train",
        TRAINING => "validation",
        _ => "test",
    }
}

impl Seen {
    /// Reads an item.
    ///
    /// # Errors
    /// When its folder is not whole.
    pub(super) fn read(dataset: &Dataset, id: &str) -> Result<Self> {
        let folder = dataset.asset_folder(id);
        let index = index_of(id).with_context(|| format!("{}: not the name of an item", folder.display()))?;
        let (manifest, welds) = (Manifest::read(&folder)?, Welds::read(&folder)?.welds);
        let fold = |start: f64, pick: fn(f64, f64) -> f64, figure: fn(&WeldTruth) -> f64| {
            welds.iter().map(figure).fold(start, pick)
        };
        let (exposure, turn) = (fold(1.0, f64::min, |weld| weld.exposure_min), fold(0.0, f64::max, turn));
        let length_mm = welds.iter().map(|weld| weld.length_mm).sum();
        let mut files = manifest.files.clone();
        files.insert(MANIFEST_FILE.to_owned(), FileRecord::of(&folder.join(MANIFEST_FILE))?);
        let row = Row {
            id: id.to_owned(),
            split: split_of(key_of(id)).to_owned(),
            difficulty: Difficulty::of(&welds),
            index,
            licence: dataset.recipe.licence.clone(),
            seed: manifest.seed,
            folder: format!("{ASSETS_FOLDER}/{id}"),
            requested: dataset.recipe.options.clone(),
            measured: measured(&manifest, welds)?,
            source: manifest.source.file,
            source_sha256: manifest.source.sha256,
            files,
        };
        Ok(Self { row, exposure, turn, length_mm })
    }
}

/// Figures of an item, without the points of its curves.
fn measured(manifest: &Manifest, welds: Vec<WeldTruth>) -> Result<Value> {
    let figures = |weld: WeldTruth| {
        let mut figures = serde_json::to_value(WeldTruth { curve: CurveTruth::default(), ..weld })?;
        figures.as_object_mut().map(|fields| fields.remove("curve"));
        Ok(figures)
    };
    Ok(json!({
        "unit": manifest.source.unit,
        "voxel_mm": 1e3 * manifest.baking.voxel_m,
        "bricks": manifest.baking.bricks,
        "checks": manifest.checks,
        "welds": welds.into_iter().map(figures).collect::<Result<Vec<Value>>>()?,
    }))
}
