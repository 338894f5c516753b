//! What a kind of store has in its marker file, and where its pieces lie.

use anyhow::Result;
use serde::Serialize;
use serde::de::DeserializeOwned;

/// What decides every piece of a store, as its marker file holds it.
pub trait Marker: Serialize + DeserializeOwned + Sync {
    /// What the store is, with its article, in messages.
    const WHAT: &'static str;
    /// Name of the marker file.
    const FILE: &'static str;
    /// Value of the `format` key.
    const FORMAT: &'static str;
    /// Folders of the pieces, the one in which they are claimed first; `""` is the store's own.
    const FOLDERS: &'static [&'static str];
    /// The flags that go on with a store that is there, and what they do.
    const CONTINUED: &'static str = "--resume to go on with it";

    /// What was found under the `format` key.
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
