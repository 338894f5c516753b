//! Rows of a set of labelled images, from the metadata of its splits, and the pictures of one image.

use std::collections::BTreeSet;
use std::fs;
use std::path::{Path, PathBuf};
use std::sync::{Arc, Mutex, PoisonError};
use std::time::SystemTime;

use files::input;
use serde::de::Error as _;
use serde::{Deserialize, Deserializer};
use serde_json::{Map, Value, json};

use super::inside::{MOST_PICTURE_BYTES, inside};
use super::lines::{self, Lines};
use super::overlay::{Colouring, legend, overlay};
use crate::error::Refusal;

/// Splits of a set.
const SPLITS: [&str; 3] = ["train", "validation", "test"];
/// Number of sets that are kept in memory.
const MOST_SETS: usize = 2;
/// Looks that stand under another name in the metadata.
const RENAMED: [(&str, &str); 5] = [
    ("part", "texture"),
    ("table", "texture"),
    ("panels", "studio"),
    ("jpeg_quality", "compression"),
    ("table_pattern", "table"),
];

/// A picture of an image.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub(crate) enum Layer {
    /// The photograph.
    Photograph,
    /// Classes by appearance.
    Appearance,
    /// Classes by dose.
    Dose,
    /// Base metal and welds.
    Instances,
    /// Depth along the camera's axis.
    Depth,
    /// The whole workpiece, as if nothing hid it.
    Amodal,
}

/// The part of a line of `metadata.jsonl` that the page shows.
#[derive(Deserialize)]
struct Line {
    file_name: String,
    id: String,
    workpiece: String,
    treatment: Value,
    exposed_share: f64,
    agreement: Option<f64>,
    appearance_pixels: [u64; 4],
    dose_pixels: [u64; 4],
    appearance: String,
    dose: String,
    instances: String,
    depth: String,
    amodal: String,
    #[serde(deserialize_with = "scene_of_text")]
    scene: Scene,
}

/// The drawn scene; the file holds it as a text in JSON.
fn scene_of_text<'de, D: Deserializer<'de>>(from: D) -> Result<Scene, D::Error> {
    serde_json::from_str(&String::deserialize(from)?).map_err(D::Error::custom)
}

#[derive(Deserialize)]
struct Scene {
    #[serde(default)]
    looks: Map<String, Value>,
    #[serde(default)]
    obstacles: Vec<Value>,
    #[serde(default)]
    spatter: Vec<Value>,
    #[serde(default)]
    tool: Value,
}

/// Images of a set, with the split of each.
pub(crate) struct ImageSet {
    folder: PathBuf,
    lines: Vec<(&'static str, Line)>,
    faults: Vec<String>,
    changed: Vec<Option<SystemTime>>,
}

/// Sets that were read last.
#[derive(Default)]
pub(crate) struct ImageSets(Mutex<Vec<Arc<ImageSet>>>);

impl ImageSets {
    /// Returns the set in a folder; reads it if it is not kept or has changed.
    pub(crate) fn set(&self, folder: &Path) -> Arc<ImageSet> {
        let mut kept = self.0.lock().unwrap_or_else(PoisonError::into_inner);
        let changed = changed(folder);
        let found = kept.iter().position(|set| set.folder == folder && set.changed == changed);
        let set = match found {
            Some(at) => kept.remove(at),
            None => Arc::new(ImageSet::read(folder, changed)),
        };
        kept.retain(|other| other.folder != folder);
        kept.insert(0, set.clone());
        kept.truncate(MOST_SETS);
        set
    }
}

fn metadata(split: &str) -> String {
    format!("{split}/metadata.jsonl")
}

fn changed(folder: &Path) -> Vec<Option<SystemTime>> {
    let of = |split: &str| fs::metadata(folder.join(metadata(split))).and_then(|file| file.modified()).ok();
    SPLITS.map(of).to_vec()
}

impl ImageSet {
    fn read(folder: &Path, changed: Vec<Option<SystemTime>>) -> Self {
        let mut set = Self { folder: folder.to_owned(), lines: Vec::new(), faults: Vec::new(), changed };
        // A split without images has no file.
        for (split, _) in SPLITS.into_iter().zip(&set.changed).filter(|(_, changed)| changed.is_some()) {
            let Lines { items, faults } = lines::read::<Line>(folder, &metadata(split));
            set.lines.extend(items.into_iter().map(|line| (split, line)));
            set.faults.extend(faults);
        }
        if set.changed.iter().all(Option::is_none) {
            set.faults
                .push("there is no metadata.jsonl in train, validation or test: no image was finished".to_owned());
        }
        set
    }

    /// Returns the rows for the page.
    pub(crate) fn table(&self) -> Value {
        let failures: Lines<Value> = lines::read(&self.folder, "failures.jsonl");
        let faults = [self.faults.clone(), failures.faults].concat();
        json!({
            "rows": self.lines.iter().map(|(split, line)| line.row(split)).collect::<Vec<_>>(),
            "legends": legends(),
            "failures": failures.items,
            "faults": faults,
        })
    }

    /// Returns a picture of an image as PNG; labels are coloured.
    ///
    /// # Errors
    /// If there is no such image, or its file is missing or no picture.
    pub(crate) fn picture(&self, id: &str, layer: Layer) -> Result<Vec<u8>, Refusal> {
        let found = self.lines.iter().find(|(_, line)| line.id == id);
        let (split, line) = found.ok_or_else(|| Refusal::missing(format!("there is no image {id:?}")))?;
        let (relative, colouring) = match layer {
            Layer::Photograph => (format!("{split}/{}", line.file_name), None),
            Layer::Appearance => (line.appearance.clone(), Some(Colouring::Classes)),
            Layer::Dose => (line.dose.clone(), Some(Colouring::Classes)),
            Layer::Instances => (line.instances.clone(), Some(Colouring::Instances)),
            Layer::Depth => (line.depth.clone(), Some(Colouring::Depth)),
            Layer::Amodal => (line.amodal.clone(), Some(Colouring::Instances)),
        };
        let file = inside(&self.folder, &relative)?;
        let bytes = input::read(&file, MOST_PICTURE_BYTES).map_err(|error| Refusal::missing(error.to_string()))?;
        let Some(colouring) = colouring else { return Ok(bytes) };
        overlay(&bytes, colouring).map_err(|words| Refusal::wrong(format!("{relative}: {words}")))
    }
}

/// Colours of the labels with their words, by the name of the layer.
fn legends() -> Value {
    let of = |colouring| json!(legend(colouring));
    let workpiece = json!([of(Colouring::Instances)[0][0], "workpiece"]);
    json!({
        "appearance": of(Colouring::Classes),
        "dose": of(Colouring::Classes),
        "instances": of(Colouring::Instances),
        "depth": of(Colouring::Depth),
        "amodal": [workpiece],
    })
}

impl Line {
    fn row(&self, split: &str) -> Value {
        json!({
            "id": self.id,
            "split": split,
            "workpiece": self.workpiece,
            "treatment": words(&self.treatment),
            "exposed": self.exposed_share,
            "agreement": self.agreement,
            "appearance": self.appearance_pixels,
            "dose": self.dose_pixels,
            "looks": self.looks(),
        })
    }

    /// Names of the looks that were drawn for this image, sorted.
    fn looks(&self) -> Vec<String> {
        let is_there = |value: &Value| !value.is_null() && *value != json!([]);
        let name = |key: &String| {
            let renamed = RENAMED.iter().find(|(own, _)| own == key).map(|(_, name)| (*name).to_owned());
            renamed.unwrap_or_else(|| key.replace('_', "-"))
        };
        let drawn = self.scene.looks.iter().filter(|(_, value)| is_there(value)).map(|(key, _)| name(key));
        let Scene { obstacles, spatter, tool, .. } = &self.scene;
        let bodies = [("clutter", !obstacles.is_empty()), ("spatter", !spatter.is_empty()), ("tool", !tool.is_null())];
        let bodies = bodies.into_iter().filter(|(_, is_there)| *is_there).map(|(name, _)| name.to_owned());
        let sorted: BTreeSet<String> = drawn.chain(bodies).collect();
        sorted.into_iter().collect()
    }
}

/// State of the coating in words.
fn words(treatment: &Value) -> String {
    let text = |key: &str| treatment[key].as_str().unwrap_or_default();
    match treatment["stage"].as_u64() {
        Some(stage) => format!("{}, stage {stage}", text("pattern")),
        None => text("kind").to_owned(),
    }
}
