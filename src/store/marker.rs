//! Marker of a kind of store: the contents of its marker file, and the folders of its items.

use anyhow::Result;
use serde::Serialize;
use serde::de::DeserializeOwned;

/// Recipe from which every item of a store follows, as the marker file holds it.
pub trait Marker: Serialize + DeserializeOwned + Sync {
    /// Name of the kind of store in messages, with its article.
    const WHAT: &'static str;
    /// Name of the marker file.
    const FILE: &'static str;
    /// Value of the `format` key.
    const FORMAT: &'static str;
    /// Folders of the items, the one in which they are claimed first; `""` is the store's own.
    const FOLDERS: &'static [&'static str];
    /// The flags that go on with a store that is there, and what they do.
    const CONTINUED: &'static str = "--resume to go on with it";

    /// Value of the `format` key in the marker file.
    fn format(&self) -> &str;

    /// The first thing in which two differ, in words; how the stores were started does not count.
    fn difference(&self, asked: &Self) -> Option<String>;

    /// Text of the marker file.
    ///
    /// # Errors
    /// Never: a marker is plain data.
    fn text(&self) -> Result<String> {
        Ok(serde_json::to_string_pretty(self)? + "\n")
    }
}
