//! Row of the catalogue for one item, read from its folder.

use std::collections::BTreeMap;

use anyhow::{Context, Result};
use serde::{Deserialize, Serialize};
use serde_json::{Value, json};
use weldgen::Difficulty;

use super::plan::{index_of, key_of};
use super::{ASSETS_FOLDER, Dataset};
use crate::asset::{CurveTruth, FileRecord, MANIFEST_FILE, Manifest, WeldTruth, Welds};
use crate::store::number_from;

/// Tenths of the parts for training; one tenth each is for validation and for tests.
const TRAINING: u64 = 8;

/// A row of the catalogue.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Row {
    /// Name of the item.
    pub id: String,
    /// `train`, `validation` or `test`: all items of a part have the same.
    pub split: String,
    /// Difficulty of its hardest weld, from measurements.
    pub difficulty: Difficulty,
    /// File name of the source.
    pub source: String,
    /// SHA-256 of the source.
    pub source_sha256: String,
    /// Index among the items of the part.
    pub index: u32,
    /// Licence of the source.
    pub licence: String,
    /// Seed of the item.
    pub seed: u64,
    /// Folder of the item, relative to the data set's.
    pub folder: String,
    /// Options as in the item's manifest (SI); `null` values were chosen for the part.
    pub requested: Value,
    /// Measured properties: voxel, checks, and each weld's figures.
    pub measured: Value,
    /// Files of the folder by name.
    pub files: BTreeMap<String, FileRecord>,
}

/// A row with further figures for the README and the contact sheet.
pub(super) struct RowFigures {
    pub(super) row: Row,
    /// Least exposure of its welds.
    pub(super) exposure: f64,
    /// Greatest turn of its welds over one bead width [rad].
    pub(super) turn: f64,
    /// Total length of its welds [mm].
    pub(super) length_mm: f64,
}

/// Returns the split of all items of a part, which follows from the part's key.
pub(super) fn split_of(key: &str) -> &'static str {
    match number_from(&format!("split {key}")) % 10 {
        0..TRAINING => "train",
        TRAINING => "validation",
        _ => "test",
    }
}

/// Returns the greatest turn of a weld over one bead width, |κ_g|·w [rad].
fn turn_of(weld: &WeldTruth) -> f64 {
    weld.geodesic_curvature_max_per_m * 1e-3 * weld.width_mm
}

impl RowFigures {
    /// Reads an item from its folder.
    ///
    /// # Errors
    /// If its folder is incomplete.
    pub(super) fn read(dataset: &Dataset, id: &str) -> Result<Self> {
        let folder = dataset.asset_folder(id);
        let index = index_of(id).with_context(|| format!("{}: not the name of an item", folder.display()))?;
        let (manifest, welds) = (Manifest::read(&folder)?, Welds::read(&folder)?.welds);
        let fold = |start: f64, pick: fn(f64, f64) -> f64, figure: fn(&WeldTruth) -> f64| {
            welds.iter().map(figure).fold(start, pick)
        };
        let (exposure, turn) = (fold(1.0, f64::min, |weld| weld.exposure_min), fold(0.0, f64::max, turn_of));
        let hardest = welds.iter().map(|weld| Difficulty::measured(weld.exposure_min, turn_of(weld))).max();
        let length_mm = welds.iter().map(|weld| weld.length_mm).sum();
        let mut files = manifest.files.clone();
        files.insert(MANIFEST_FILE.to_owned(), FileRecord::of(&folder.join(MANIFEST_FILE))?);
        let row = Row {
            id: id.to_owned(),
            split: split_of(key_of(id)).to_owned(),
            difficulty: hardest.unwrap_or(Difficulty::Easy),
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

/// Returns the figures of an item, without the points of its curves.
fn measured(manifest: &Manifest, welds: Vec<WeldTruth>) -> Result<Value> {
    let figures = |weld: WeldTruth| {
        let mut figures = serde_json::to_value(WeldTruth { curve: CurveTruth::default(), ..weld })?;
        figures.as_object_mut().map(|fields| fields.remove("curve"));
        Ok(figures)
    };
    Ok(json!({
        "unit": manifest.source.unit,
        "unit_doubts": manifest.source.unit_doubts,
        "voxel_mm": 1e3 * manifest.baking.voxel_m,
        "bricks": manifest.baking.bricks,
        "checks": manifest.checks,
        "welds": welds.into_iter().map(figures).collect::<Result<Vec<Value>>>()?,
    }))
}
