//! Items that could not be made, each with its reason and the line that shows it again.

use std::fs;
use std::path::{Path, PathBuf};

use anyhow::{Context, Result};
use serde::{Deserialize, Serialize};

use super::plan::{Item, Unreadable};
use super::{Dataset, FAILURES_FOLDER, Marker, names, remove_stale};
use files::file_lock::Patience;
use files::folder::write_file;
use files::json_file::read_json;
use files::sha256;

/// Where on the road an item failed.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Stage {
    /// Reading and cleaning the part.
    Part,
    /// Baking, placing the weld, uniting.
    Weld,
    /// Sanding the coating off.
    Sand,
    /// Drawing and labelling an image.
    Render,
    /// Writing what was made.
    Write,
    /// Time or memory beyond the limit.
    Limit,
    /// A bug in this program.
    Crash,
}

impl Stage {
    /// Its name in files.
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

/// An item that could not be made.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct Failure {
    /// Name of the item; of a source that cannot be read, `source-` and a hash of its path.
    pub id: String,
    /// The mesh file, as it was given.
    pub source: String,
    /// Number among the items of the part.
    pub index: u32,
    /// Where it failed.
    pub stage: Stage,
    /// Why.
    pub reason: String,
    /// The command line that makes this item alone.
    pub command: String,
}

impl Failure {
    /// The failure of an item; `flags` are those that decide it.
    pub fn of(item: &Item, stage: Stage, reason: String, flags: &[String]) -> Self {
        Self {
            id: item.id.clone(),
            source: item.source.to_string_lossy().into_owned(),
            index: item.index,
            stage,
            reason,
            command: command(&item.source, item.index, flags),
        }
    }

    /// The failure of a source without items.
    pub fn of_source(Unreadable { source, reason }: &Unreadable, flags: &[String]) -> Self {
        Self {
            id: source_id(source),
            source: source.to_string_lossy().into_owned(),
            index: 0,
            stage: Stage::Part,
            reason: reason.clone(),
            command: command(source, 0, flags),
        }
    }
}

/// Name under which the failure of a source without items is kept.
pub(super) fn source_id(source: &Path) -> String {
    format!("source-{}", &sha256(source.to_string_lossy().as_bytes())[..16])
}

fn command(source: &Path, index: u32, flags: &[String]) -> String {
    let words = ["robofin".to_owned(), "dataset".to_owned(), source.to_string_lossy().into_owned()];
    let more = ["--item".to_owned(), index.to_string(), "--out".to_owned(), "again".to_owned()];
    command_line(words.iter().chain(flags).chain(&more))
}

/// Words as one line that a POSIX shell takes apart into them.
pub fn command_line<'a>(words: impl Iterator<Item = &'a String>) -> String {
    words.map(|word| quoted(word)).collect::<Vec<_>>().join(" ")
}

/// A word as a POSIX shell takes it.
fn quoted(word: &str) -> String {
    let is_plain = |letter: char| letter.is_ascii_alphanumeric() || "_-./=:,+@%".contains(letter);
    match !word.is_empty() && word.chars().all(is_plain) {
        true => word.to_owned(),
        false => format!("'{}'", word.replace('\'', "'\\''")),
    }
}

impl<R: Marker> Dataset<R> {
    fn failure_path(&self, id: &str) -> PathBuf {
        self.folder().join(FAILURES_FOLDER).join(format!("{id}.json"))
    }

    /// Keeps the record of a failure.
    ///
    /// # Errors
    /// When it cannot be written.
    pub(crate) fn keep_failure(&self, failure: &Failure) -> Result<()> {
        let _claim = self.claim(&failure.id, Patience::Endless)?;
        remove_stale(&self.folder().join(FAILURES_FOLDER), &failure.id)?;
        let text = serde_json::to_string_pretty(failure)? + "\n";
        Ok(write_file(&self.failure_path(&failure.id), text.as_bytes())?)
    }

    /// Forgets the failure of an item or source that is well now.
    ///
    /// # Errors
    /// When the file system refuses.
    pub(crate) fn forget_failure(&self, id: &str) -> Result<()> {
        let path = self.failure_path(id);
        match fs::remove_file(&path) {
            Err(error) if error.kind() != std::io::ErrorKind::NotFound => {
                Err(error).with_context(|| format!("{}: cannot be removed", path.display()))
            }
            _ => Ok(()),
        }
    }

    /// All failures, by name.
    ///
    /// # Errors
    /// When a record cannot be read.
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
    fn a_shell_reads_the_command_as_it_was_given() {
        let item = Item { source: "my parts/it's.obj".into(), id: "0-0003".into(), index: 3 };
        let failure = Failure::of(&item, Stage::Weld, String::new(), &["--seed".into(), "7".into()]);
        let line = r"robofin dataset 'my parts/it'\''s.obj' --seed 7 --item 3 --out again";
        assert_eq!(failure.command, line);
    }
}
