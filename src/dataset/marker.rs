//! What a kind of data set has in its marker file, and where its items lie.

use serde::Serialize;
use serde::de::DeserializeOwned;

use super::{ASSETS_FOLDER, DATASET_FORMAT, FAILURES_FOLDER, Recipe};

/// What decides every item of a data set, as its marker holds it.
pub trait Marker: Serialize + DeserializeOwned {
    /// Value of the `format` key.
    const FORMAT: &'static str;
    /// Folders of the items, the one in which they are claimed first, and that of the failures.
    const FOLDERS: &'static [&'static str];

    /// What was found under the `format` key.
    fn format(&self) -> &str;

    /// The first thing in which two differ, in words; how the sets were started does not count.
    fn difference(&self, asked: &Self) -> Option<String>;
}

impl Marker for Recipe {
    const FORMAT: &'static str = DATASET_FORMAT;
    const FOLDERS: &'static [&'static str] = &[ASSETS_FOLDER, FAILURES_FOLDER];

    fn format(&self) -> &str {
        &self.format
    }

    fn difference(&self, asked: &Self) -> Option<String> {
        Recipe::difference(self, asked)
    }
}
