//! Rows of a data set of assets, from its catalogue.

use std::collections::{BTreeMap, BTreeSet};
use std::fs;
use std::path::Path;

use files::input;
use serde::{Deserialize, Serialize};
use serde_json::{Value, json};

use super::inside::{MOST_PICTURE_BYTES, inside};
use super::lines::{self, Lines};
use crate::error::Refusal;

/// Catalogue, failures, folder of the items, and the picture of an item.
const CATALOGUE: &str = "manifest.jsonl";
const FAILURES: &str = "failures.jsonl";
const ITEMS: &str = "assets";
const PREVIEW: &str = "preview.png";

/// A column: its key, words and unit. Numbers are filtered by a range, words by a text.
type Column = (&'static str, &'static str, &'static str);
/// Columns of the table, first those of words.
const WORDS: [Column; 4] =
    [("id", "item", ""), ("source", "part", ""), ("split", "split", ""), ("difficulty", "difficulty", "")];
const NUMBERS: [Column; 10] = [
    ("welds", "welds", ""),
    ("length", "length", "mm"),
    ("exposure", "exposure", ""),
    ("access", "access", ""),
    ("rms", "curvature, RMS", "1/m"),
    ("sharpest", "curvature, maximum", "1/m"),
    ("width", "width", "mm"),
    ("height", "height", "mm"),
    ("volume", "weld volume", "mm³"),
    ("voxel", "voxel", "mm"),
];

/// The part of a line of the catalogue that the table shows.
#[derive(Deserialize)]
struct Row {
    id: String,
    split: String,
    difficulty: String,
    source: String,
    measured: Measured,
}

#[derive(Deserialize)]
struct Measured {
    voxel_mm: f64,
    welds: Vec<WeldFigures>,
}

#[derive(Deserialize)]
struct WeldFigures {
    length_mm: f64,
    width_mm: f64,
    height_mm: f64,
    volume_mm3: f64,
    exposure_min: f64,
    access_mean: f64,
    geodesic_curvature_rms_per_m: f64,
    geodesic_curvature_max_per_m: f64,
}

/// A failed item.
#[derive(Deserialize, Serialize)]
struct Failure {
    id: String,
    source: String,
    stage: String,
    reason: String,
    command: String,
}

/// Reads the catalogue of a set for the page.
pub(crate) fn table(folder: &Path) -> Value {
    let (rows, failures): (Lines<Row>, Lines<Failure>) =
        (lines::read(folder, CATALOGUE), lines::read(folder, FAILURES));
    let own: BTreeSet<String> = names(&folder.join(ITEMS));
    let missing = rows.items.iter().filter(|row| !own.contains(&row.id)).count();
    let lost = (missing > 0).then(|| format!("{missing} items of {CATALOGUE} have no folder below {ITEMS}"));
    let column = |kind: &'static str| move |&(key, words, unit): &Column| json!({ "key": key, "words": words, "unit": unit, "kind": kind });
    let is_drawn = |id: &str| own.contains(id) && folder.join(ITEMS).join(id).join(PREVIEW).is_file();
    let faults = [rows.faults, failures.faults, lost.into_iter().collect()].concat();
    json!({
        "columns": WORDS.iter().map(column("words")).chain(NUMBERS.iter().map(column("number"))).collect::<Vec<_>>(),
        "rows": rows.items.iter().map(|row| row.values(is_drawn(&row.id))).collect::<Vec<_>>(),
        "failures": failures.items,
        "faults": faults,
    })
}

impl Row {
    /// Values in the order of the columns, and last true if there is a picture.
    fn values(&self, is_drawn: bool) -> Value {
        let welds = &self.measured.welds;
        let over = |start: f64, pick: fn(f64, f64) -> f64, figure: fn(&WeldFigures) -> f64| {
            let value = welds.iter().map(figure).fold(start, pick);
            value.is_finite().then_some(value)
        };
        let least = |figure| over(f64::INFINITY, f64::min, figure);
        let most = |figure| over(f64::NEG_INFINITY, f64::max, figure);
        let sum = |figure| over(0.0, |a, b| a + b, figure);
        json!([
            self.id,
            self.source,
            self.split,
            self.difficulty,
            welds.len(),
            sum(|weld| weld.length_mm),
            least(|weld| weld.exposure_min),
            least(|weld| weld.access_mean),
            most(|weld| weld.geodesic_curvature_rms_per_m),
            most(|weld| weld.geodesic_curvature_max_per_m),
            most(|weld| weld.width_mm),
            most(|weld| weld.height_mm),
            sum(|weld| weld.volume_mm3),
            self.measured.voxel_mm,
            is_drawn,
        ])
    }
}

/// Returns the complete line of an item for the page.
///
/// # Errors
/// If the catalogue does not list it.
pub(crate) fn item(folder: &Path, id: &str) -> Result<Value, Refusal> {
    let rows: Lines<BTreeMap<String, Value>> = lines::read(folder, CATALOGUE);
    let own = rows.items.into_iter().find(|row| row.get("id").is_some_and(|own| own == id));
    own.map(|row| json!(row)).ok_or_else(|| Refusal::missing(format!("{CATALOGUE} does not list {id:?}")))
}

/// Reads the picture of an item.
///
/// # Errors
/// If there is no such item, or it has no picture.
pub(crate) fn preview(folder: &Path, id: &str) -> Result<Vec<u8>, Refusal> {
    let items = inside(folder, ITEMS)?;
    let own = names(&items).take(id).ok_or_else(|| Refusal::missing(format!("there is no item {id:?}")))?;
    let file = inside(&items.join(own), PREVIEW)?;
    input::read(&file, MOST_PICTURE_BYTES).map_err(|error| Refusal::missing(error.to_string()))
}

/// Names of the folders in a folder, without links; empty if it cannot be read.
fn names(folder: &Path) -> BTreeSet<String> {
    let entries = fs::read_dir(folder).into_iter().flatten().flatten();
    let own = entries.filter(|entry| entry.file_type().is_ok_and(|kind| kind.is_dir()));
    own.map(|entry| entry.file_name().to_string_lossy().into_owned()).collect()
}
