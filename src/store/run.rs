//! Makes the items of a set, several at once, each in a process of its own.

use std::path::PathBuf;
use std::process::Command;
use std::time::Instant;

use anyhow::Result;

use super::limits::{Limits, Usage};
use super::process::{Answer, Ending, run_apart};
use super::{Failure, Marker, Stage, Store};
use files::file_lock::LockWait;

/// An item of a set of type `M`.
pub trait SetItem<M>: Sync {
    /// Returns its name.
    fn id(&self) -> &str;

    /// Returns the path of its source, for messages.
    fn source(&self, set: &Store<M>) -> PathBuf;

    /// Returns true if it exists already.
    fn is_there(&self, set: &Store<M>) -> bool;

    /// Returns a failure without an attempt if an item that it needs has failed; `None` if it can be tried.
    fn obstacle(&self, _set: &Store<M>) -> Option<Ending> {
        None
    }

    /// Adds the arguments of the process that makes it.
    fn words<'c>(&self, command: &'c mut Command, set: &Store<M>, limits: Limits) -> &'c mut Command;

    /// Makes the record of its failure.
    fn failure(&self, set: &Store<M>, stage: Stage, reason: String) -> Failure;
}

/// A run that makes the items of a set.
pub struct Run<'a, M> {
    /// Set of the items.
    pub set: &'a Store<M>,
    /// Limits of each item's process.
    pub limits: Limits,
    /// Number of items made at once.
    pub jobs: usize,
}

/// Outcome of an item in a run.
#[derive(Clone, Debug)]
pub struct Outcome {
    /// Name of the item.
    pub id: String,
    /// Path of its source.
    pub source: PathBuf,
    /// Outcome of making it; never [`Ending::Busy`].
    pub ending: Ending,
    /// Processor time and memory used.
    pub usage: Usage,
    /// Wall time [s].
    pub seconds: f64,
}

impl<M: Marker> Run<'_, M> {
    /// Makes the missing items and calls `done` for each item as it ends.
    ///
    /// # Errors
    /// If the set cannot be written, or `done` fails; an item that fails is an outcome.
    pub fn run<I: SetItem<M>>(&self, items: &[I], mut done: impl FnMut(&Outcome) -> Result<()>) -> Result<()> {
        let work = |item: &I, wait| self.outcome(item, wait).transpose();
        self.set.work_through(items, self.jobs, work, |_, outcome| done(&outcome?))
    }

    /// Finds or makes one item; `None` if another process is making it and `wait` does not allow waiting.
    fn outcome(&self, item: &impl SetItem<M>, wait: LockWait) -> Result<Option<Outcome>> {
        let started = Instant::now();
        if wait == LockWait::Endless {
            // The claim is free when the other process is done.
            drop(self.set.claim(item.id(), LockWait::Endless)?);
        }
        let Answer { ending, usage } = self.answer(item)?;
        match &ending {
            Ending::Busy => return Ok(None),
            Ending::Failed { stage, reason } => {
                self.set.keep_failure(&item.failure(self.set, *stage, reason.clone()))?;
            }
            Ending::Made | Ending::There => self.set.forget_failure(item.id())?,
        }
        let (id, source) = (item.id().to_owned(), item.source(self.set));
        Ok(Some(Outcome { id, source, ending, usage, seconds: started.elapsed().as_secs_f64() }))
    }

    fn answer(&self, item: &impl SetItem<M>) -> Result<Answer> {
        let known = if item.is_there(self.set) { Some(Ending::There) } else { item.obstacle(self.set) };
        match known {
            Some(ending) => Ok(Answer { ending, usage: Usage::default() }),
            None => run_apart(self.limits, |command| item.words(command, self.set, self.limits)),
        }
    }
}
