//! Making the images of a set and what they need, several things at once.

use std::path::PathBuf;
use std::time::Instant;

use anyhow::Result;

use super::ImageSet;
use super::make::Task;
use crate::dataset::item::Ending;
use crate::dataset::limits::{Limits, Usage};
use crate::dataset::process::{Answer, run_apart};
use crate::dataset::run::Outcome;
use crate::dataset::{Failure, command_line};
use files::file_lock::Patience;
use files::job_queue::take_turns;

/// Verb that does one task in the process that is started.
pub const TASK_VERB: &str = "dataset-image";

/// Tasks of a set to do.
pub struct ImageRun<'a> {
    /// Where to.
    pub set: &'a ImageSet,
    /// What each task may use.
    pub limits: Limits,
    /// Tasks at once.
    pub jobs: usize,
}

impl ImageRun<'_> {
    /// Does the tasks of one step that are not done yet and calls `done` for each as it ends.
    ///
    /// # Errors
    /// When the set cannot be written, or `done` fails; a task that fails is an outcome.
    pub fn run(&self, tasks: &[Task], mut done: impl FnMut(&Outcome) -> Result<()>) -> Result<()> {
        let work = |turn: usize, patience| self.outcome(&tasks[turn], patience).transpose();
        take_turns(tasks.len(), self.jobs, work, |_, outcome| done(&outcome?))?;
        self.set.sweep()
    }

    /// Finds or makes one thing; `None` when someone else is making it and there is no patience.
    fn outcome(&self, task: &Task, patience: Patience) -> Result<Option<Outcome>> {
        let started = Instant::now();
        if patience == Patience::Endless {
            // Whoever makes it is done when the claim is free.
            drop(self.set.claim(task.id(), Patience::Endless)?);
        }
        let Answer { ending, usage } = self.answer(task)?;
        match &ending {
            Ending::Busy => return Ok(None),
            Ending::Failed { stage, reason } => {
                let source = task.workpiece(&self.set.recipe).to_owned();
                let index = if let Task::Image(image) = task { image.placement } else { 0 };
                let (id, stage, reason) = (task.id().to_owned(), *stage, reason.clone());
                let command = self.command(task.id());
                self.set.keep_failure(&Failure { id, source, index, stage, reason, command })?;
            }
            Ending::Made | Ending::There => self.set.forget_failure(task.id())?,
        }
        let (id, source) = (task.id().to_owned(), PathBuf::from(task.workpiece(&self.set.recipe)));
        Ok(Some(Outcome { id, source, ending, usage, seconds: started.elapsed().as_secs_f64() }))
    }

    fn answer(&self, task: &Task) -> Result<Answer> {
        let at_once = |ending| Ok(Answer { ending, usage: Usage::default() });
        if task.is_done(self.set) {
            return at_once(Ending::There);
        }
        let is_done = |id: &String| Task::named(&self.set.recipe, id).is_some_and(|task| task.is_done(self.set));
        if let Some(missing) = task.needs(&self.set.recipe).iter().find(|id| !is_done(id)) {
            let reason = format!("it needs {missing}, which failed");
            return at_once(Ending::Failed { stage: task.stage(), reason });
        }
        run_apart(self.limits, |command| {
            let Limits { time, memory } = self.limits;
            command.arg(TASK_VERB).arg("--id").arg(task.id()).arg("--out").arg(self.set.folder());
            command
                .arg("--time-limit")
                .arg(time.to_string())
                .arg("--memory-limit")
                .arg((memory as f64 * 1e-9).to_string())
        })
    }

    /// The command line that does this task alone.
    fn command(&self, id: &str) -> String {
        let words = ["robofin", "dataset", "images"].map(str::to_owned);
        let more = ["--only", id, "--out", "again"].map(str::to_owned);
        command_line(words.iter().chain(&self.set.recipe.flags()).chain(&more))
    }
}
