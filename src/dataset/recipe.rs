//! Recipe of a data set's items, and the seed of each.

use anyhow::{Result, ensure};
use serde::{Deserialize, Serialize};
use serde_json::Value;

use super::{ASSETS_FOLDER, MARKER_FILE};
use crate::asset::Manifest;
use crate::store::{FAILURES_FOLDER, Marker, number_from};
use crate::workpiece::WeldingOptions;

/// Value of the `format` key.
pub const DATASET_FORMAT: &str = "robofin-dataset/1";

/// Marker of a data set: all inputs that define its items, and its command line.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Recipe {
    /// [`DATASET_FORMAT`].
    pub format: String,
    /// Version of the program.
    pub version: String,
    /// Seed of the set; see [`Recipe::seed_of`].
    pub seed: u64,
    /// Requested unit.
    pub unit: Value,
    /// Options of welding without their seed, in the form of an item's manifest.
    pub options: Value,
    /// Width and height of the pictures [pixels].
    pub preview: (usize, usize),
    /// Licence of the sources.
    pub licence: String,
    /// Flags that define the items, as they were given.
    pub flags: Vec<String>,
    /// Paths of the sources, as they were given.
    pub sources: Vec<String>,
}

impl Recipe {
    /// Returns options in the form of [`Recipe::options`].
    ///
    /// # Errors
    /// Never: options are plain data.
    pub fn options_without_seed(options: &WeldingOptions) -> Result<Value> {
        let mut options = serde_json::to_value(options)?;
        if let Some(fields) = options.as_object_mut() {
            fields.remove("seed");
        }
        Ok(options)
    }

    /// Returns the seed of an item, from the set's seed and the item's name.
    pub fn seed_of(&self, id: &str) -> u64 {
        number_from(&format!("{DATASET_FORMAT} {} {id}", self.seed))
    }

    /// Checks that an item was made by this recipe.
    ///
    /// # Errors
    /// The difference, in words.
    pub fn fits(&self, id: &str, manifest: &Manifest) -> Result<()> {
        let mut options = manifest.options.clone();
        if let Some(fields) = options.as_object_mut() {
            fields.remove("seed");
        }
        let seed = self.seed_of(id);
        ensure!(manifest.seed == seed, "its seed is {}, {seed} is expected", manifest.seed);
        ensure!(manifest.version == self.version, "its version is {}, {} is expected", manifest.version, self.version);
        ensure!(options == self.options, "its options are {options}, {} is expected", self.options);
        Ok(())
    }
}

impl Marker for Recipe {
    const WHAT: &'static str = "a data set";
    const FILE: &'static str = MARKER_FILE;
    const FORMAT: &'static str = DATASET_FORMAT;
    const FOLDERS: &'static [&'static str] = &[ASSETS_FOLDER, FAILURES_FOLDER];

    fn format(&self) -> &str {
        &self.format
    }

    fn difference(&self, asked: &Self) -> Option<String> {
        let unit = |recipe: &Self| recipe.unit.to_string();
        let preview = |recipe: &Self| format!("{:?}", recipe.preview);
        let compared = [
            ("version", self.version.clone(), asked.version.clone()),
            ("seed", self.seed.to_string(), asked.seed.to_string()),
            ("unit", unit(self), unit(asked)),
            ("options", self.options.to_string(), asked.options.to_string()),
            ("preview", preview(self), preview(asked)),
            ("licence", self.licence.clone(), asked.licence.clone()),
        ];
        let (name, now, then) = compared.into_iter().find(|(_, now, then)| now != then)?;
        Some(format!("{name} is {now} there, and {then} now"))
    }
}
