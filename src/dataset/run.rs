//! Makes the items of a plan, several at once.

use std::path::{Path, PathBuf};
use std::process::Command;

use anyhow::Result;

use super::plan::{Item, Plan, Unreadable};
use super::{Dataset, Recipe};
use crate::store::limits::{Limits, Usage};
use crate::store::process::Ending;
use crate::store::run::{self, Outcome, SetItem};
use crate::store::{Failure, Stage, command_line};
use files::sha256;

/// Verb of the process that makes one item.
pub const ITEM_VERB: &str = "dataset-item";

/// Items to make.
pub struct Run<'a> {
    /// Data set of the items.
    pub dataset: &'a Dataset,
    /// Items to make.
    pub plan: &'a Plan,
    /// Flags that define an item, limits included.
    pub flags: &'a [String],
    /// Limits of each item's process.
    pub limits: Limits,
    /// Number of items made at once.
    pub jobs: usize,
}

impl Run<'_> {
    /// Makes the missing items and calls `done` for each item as it ends, sources without items first.
    ///
    /// # Errors
    /// If the data set cannot be written, or `done` fails; an item that fails is an outcome.
    pub fn run(&self, mut done: impl FnMut(&Outcome) -> Result<()>) -> Result<()> {
        for source in &self.plan.readable {
            self.dataset.forget_failure(&source_id(source))?;
        }
        for unreadable in &self.plan.unreadable {
            let failure = failure_of_source(unreadable, self.flags);
            self.dataset.keep_failure(&failure)?;
            let ending = Ending::Failed { stage: failure.stage, reason: failure.reason };
            let (source, usage) = (unreadable.source.clone(), Usage::default());
            done(&Outcome { id: failure.id, source, ending, usage, seconds: 0.0 })?;
        }
        let items: Vec<FlaggedItem<'_>> =
            self.plan.items.iter().map(|item| FlaggedItem { item, flags: self.flags }).collect();
        run::Run { set: self.dataset, limits: self.limits, jobs: self.jobs }.run(&items, done)
    }
}

/// An item with the flags that define it, limits included.
struct FlaggedItem<'a> {
    item: &'a Item,
    flags: &'a [String],
}

impl SetItem<Recipe> for FlaggedItem<'_> {
    fn id(&self) -> &str {
        &self.item.id
    }

    fn source(&self, _: &Dataset) -> PathBuf {
        self.item.source.clone()
    }

    fn is_there(&self, dataset: &Dataset) -> bool {
        dataset.holds(&self.item.id)
    }

    fn words<'c>(&self, command: &'c mut Command, dataset: &Dataset, _: Limits) -> &'c mut Command {
        command.arg(ITEM_VERB).args(self.flags);
        command.arg("--id").arg(self.id()).arg("--out").arg(dataset.folder()).arg("--").arg(&self.item.source)
    }

    fn failure(&self, _: &Dataset, stage: Stage, reason: String) -> Failure {
        let Item { id, source, index } = self.item;
        Failure {
            id: id.clone(),
            source: source.to_string_lossy().into_owned(),
            index: *index,
            stage,
            reason,
            command: command(source, *index, self.flags),
        }
    }
}

/// Returns the failure of a source without items.
fn failure_of_source(Unreadable { source, reason }: &Unreadable, flags: &[String]) -> Failure {
    Failure {
        id: source_id(source),
        source: source.to_string_lossy().into_owned(),
        index: 0,
        stage: Stage::Part,
        reason: reason.clone(),
        command: command(source, 0, flags),
    }
}

/// Returns the name for the failure of a source without items.
fn source_id(source: &Path) -> String {
    format!("source-{}", &sha256(source.to_string_lossy().as_bytes())[..16])
}

fn command(source: &Path, index: u32, flags: &[String]) -> String {
    let words = ["robofin".to_owned(), "dataset".to_owned(), source.to_string_lossy().into_owned()];
    let more = ["--item".to_owned(), index.to_string(), "--out".to_owned(), "again".to_owned()];
    command_line(words.iter().chain(flags).chain(&more))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_command_of_a_failure_makes_that_item_alone() {
        let line = command(Path::new("my parts/it's.obj"), 3, &["--seed".into(), "7".into()]);
        assert_eq!(line, r"robofin dataset 'my parts/it'\''s.obj' --seed 7 --item 3 --out again");
    }
}
