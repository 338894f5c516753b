//! Failed items, each with its reason and the command line that reproduces it.

use std::path::PathBuf;

use anyhow::Result;
use serde::{Deserialize, Serialize};

use super::{Marker, Store, names, remove, remove_stale};
use files::file_lock::LockWait;
use files::folder::write_file;
use files::json_file::read_json;

/// Folder of the failures' records in a set.
pub const FAILURES_FOLDER: &str = "failures";

/// Stage at which an item failed.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Stage {
    /// Reading and cleaning the part.
    Part,
    /// Baking, placing the weld, uniting.
    Weld,
    /// Sanding.
    Sand,
    /// Drawing and labelling an image.
    Render,
    /// Writing the result.
    Write,
    /// Time or memory beyond the limit.
    Limit,
    /// A bug in this program.
    Crash,
}

impl Stage {
    /// Returns the name in files.
    pub fn name(self) -> &'static str {
        match self {
            Self::Part => "part",
            Self::Weld => "weld",
            Self::Sand => "sand",
            Self::Render => "render",
            Self::Write => "write",
            Self::Limit => "limit",
            Self::Crash => "crash",
        }
    }
}

/// A failed item.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct Failure {
    /// Name of the item; for an unreadable source, `source-` and a hash of its path.
    pub id: String,
    /// Path of its source, as given.
    pub source: String,
    /// Index among the items of the source.
    pub index: u32,
    /// Stage at which it failed.
    pub stage: Stage,
    /// Reason with its causes.
    pub reason: String,
    /// Command line that makes this item alone.
    pub command: String,
}

/// Error in making an item, with its stage; the default stage is writing.
#[derive(Debug)]
pub struct Fault {
    /// Stage at which it failed.
    pub stage: Stage,
    /// Error with its causes.
    pub error: anyhow::Error,
}

impl Stage {
    /// Makes a fault at this stage.
    pub fn fault(self, error: anyhow::Error) -> Fault {
        Fault { stage: self, error }
    }
}

impl From<anyhow::Error> for Fault {
    fn from(error: anyhow::Error) -> Self {
        Stage::Write.fault(error)
    }
}

/// Joins words into one line that a POSIX shell splits into the same words.
pub fn command_line<'a>(words: impl Iterator<Item = &'a String>) -> String {
    words.map(|word| quoted(word)).collect::<Vec<_>>().join(" ")
}

/// Quotes a word for a POSIX shell.
fn quoted(word: &str) -> String {
    let is_plain = |letter: char| letter.is_ascii_alphanumeric() || "_-./=:,+@%".contains(letter);
    match !word.is_empty() && word.chars().all(is_plain) {
        true => word.to_owned(),
        false => format!("'{}'", word.replace('\'', "'\\''")),
    }
}

impl<M: Marker> Store<M> {
    fn failure_path(&self, id: &str) -> PathBuf {
        self.folder().join(FAILURES_FOLDER).join(format!("{id}.json"))
    }

    /// Writes the record of a failure.
    ///
    /// # Errors
    /// If it cannot be written.
    pub fn keep_failure(&self, failure: &Failure) -> Result<()> {
        let _claim = self.claim(&failure.id, LockWait::Endless)?;
        remove_stale(&self.folder().join(FAILURES_FOLDER), &failure.id)?;
        let text = serde_json::to_string_pretty(failure)? + "\n";
        Ok(write_file(&self.failure_path(&failure.id), text.as_bytes())?)
    }

    /// Removes the record of a failure that no longer exists.
    ///
    /// # Errors
    /// If the file system refuses.
    pub fn forget_failure(&self, id: &str) -> Result<()> {
        remove(&self.failure_path(id))
    }

    /// Reads all failures, by name.
    ///
    /// # Errors
    /// If a record cannot be read.
    pub fn failures(&self) -> Result<Vec<Failure>> {
        let folder = self.folder().join(FAILURES_FOLDER);
        let read = |name: &String| {
            let path = folder.join(name);
            read_json(&path, "the record of a failure")
        };
        names(&folder)?.iter().filter(|name| !name.starts_with('.')).map(|name| Ok(read(name)?)).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_shell_reads_a_line_as_its_words_were() {
        let words = ["robofin", "dataset", "my parts/it's.obj", "--seed", "7", ""].map(str::to_owned);
        assert_eq!(command_line(words.iter()), r"robofin dataset 'my parts/it'\''s.obj' --seed 7 ''");
    }
}
