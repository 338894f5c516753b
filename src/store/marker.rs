//! Marker of a type of store: the content of its marker file, and the folders of its items.

use anyhow::Result;
use serde::Serialize;
use serde::de::DeserializeOwned;

/// Recipe of a store, from which all its items follow; stored in the marker file.
pub trait Marker: Serialize + DeserializeOwned + Sync {
    /// Name of the type of store in messages, with its article.
    const WHAT: &'static str;
    /// Name of the marker file.
    const FILE: &'static str;
    /// Value of the `format` key.
    const FORMAT: &'static str;
    /// Folders of the items, the folder of the claims first; `""` is the store's own.
    const FOLDERS: &'static [&'static str];
    /// Flags that continue an existing store, and their effect, for messages.
    const CONTINUED: &'static str = "--resume to continue it";

    /// Returns the value of the `format` key in the marker file.
    fn format(&self) -> &str;

    /// Describes the first difference from another marker; how the stores were started does not count.
    fn difference(&self, asked: &Self) -> Option<String>;

    /// Returns the text of the marker file.
    ///
    /// # Errors
    /// Never: a marker is plain data.
    fn text(&self) -> Result<String> {
        Ok(serde_json::to_string_pretty(self)? + "\n")
    }
}
