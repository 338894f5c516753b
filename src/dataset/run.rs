//! Making the items of a plan, several at once.

use std::path::PathBuf;
use std::time::Instant;

use anyhow::Result;

use super::failure::source_id;
use super::item::Ending;
use super::limits::{Limits, Usage};
use super::plan::{Item, Plan};
use super::process::{Answer, make_apart};
use super::{Dataset, Failure};
use files::file_lock::Patience;
use files::job_queue::take_turns;

/// Items to make.
pub struct Run<'a> {
    /// Where to.
    pub dataset: &'a Dataset,
    /// Which.
    pub plan: &'a Plan,
    /// The flags that decide an item, with limits.
    pub flags: &'a [String],
    /// What each item may use.
    pub limits: Limits,
    /// Items at once.
    pub jobs: usize,
}

/// What became of an item.
#[derive(Clone, Debug)]
pub struct Outcome {
    /// Its name.
    pub id: String,
    /// The mesh file.
    pub source: PathBuf,
    /// How it ended; never [`Ending::Busy`].
    pub ending: Ending,
    /// What making it took.
    pub usage: Usage,
    /// The same by the clock [s].
    pub seconds: f64,
}

impl Run<'_> {
    /// Makes what is not there yet and calls `done` for each item as it ends, sources without items first.
    ///
    /// # Errors
    /// When the data set cannot be written, or `done` fails; an item that fails is an outcome.
    pub fn run(&self, mut done: impl FnMut(&Outcome) -> Result<()>) -> Result<()> {
        for source in &self.plan.readable {
            self.dataset.forget_failure(&source_id(source))?;
        }
        for unreadable in &self.plan.unreadable {
            let failure = Failure::of_source(unreadable, self.flags);
            self.dataset.keep_failure(&failure)?;
            let ending = Ending::Failed { stage: failure.stage, reason: failure.reason };
            let (source, usage) = (unreadable.source.clone(), Usage::default());
            done(&Outcome { id: failure.id, source, ending, usage, seconds: 0.0 })?;
        }
        let work = |turn: usize, patience| self.outcome(&self.plan.items[turn], patience).transpose();
        take_turns(self.plan.items.len(), self.jobs, work, |_, outcome| done(&outcome?))?;
        self.dataset.sweep()
    }

    /// Finds or makes one item; `None` when someone else is making it and there is no patience.
    fn outcome(&self, item: &Item, patience: Patience) -> Result<Option<Outcome>> {
        let started = Instant::now();
        if patience == Patience::Endless {
            // Whoever makes it is done when the claim is free.
            drop(self.dataset.claim(&item.id, Patience::Endless)?);
        }
        let Answer { ending, usage } = match self.dataset.holds(&item.id) {
            true => Answer { ending: Ending::There, usage: Usage::default() },
            false => make_apart(self.dataset, item, self.flags, self.limits)?,
        };
        match &ending {
            Ending::Busy => return Ok(None),
            Ending::Failed { stage, reason } => {
                self.dataset.keep_failure(&Failure::of(item, *stage, reason.clone(), self.flags))?;
            }
            Ending::Made | Ending::There => self.dataset.forget_failure(&item.id)?,
        }
        let seconds = started.elapsed().as_secs_f64();
        Ok(Some(Outcome { id: item.id.clone(), source: item.source.clone(), ending, usage, seconds }))
    }
}
