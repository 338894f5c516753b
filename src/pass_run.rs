//! Passes over one workpiece, one after the other: progress, states on disk, and what is kept if one of them fails.

use std::path::Path;
use std::time::Instant;

use anyhow::{Error, Result};
use effects::CompiledModel;
use lab::Origin;
use sim::{PassRecord, Progress};
use study::snapshot::{self, Keeping, Resume, Snapshot};
use trial_simulation::RunState;

use crate::console::Console;

/// The passes over one workpiece.
pub trait Passes {
    /// A completed pass.
    type Pass;

    /// Number of all passes.
    fn count(&self) -> usize;

    /// Model of the passes.
    fn model(&self) -> &CompiledModel;

    /// The workpiece and the tool before the first pass.
    fn start(&self) -> RunState;

    /// Runs the next pass.
    ///
    /// # Errors
    /// Names the pass; `state` then holds the last good state.
    fn run(&self, state: &mut RunState, progress: &mut dyn FnMut(Progress)) -> Result<Self::Pass>;

    /// Makes a pass of an earlier run from the states before and after it, and its record.
    ///
    /// # Errors
    /// If the state does not give it.
    fn read_back(&self, before: &RunState, after: &RunState, record: PassRecord) -> Result<Self::Pass>;

    /// Figures and log of a pass.
    fn record<'p>(&self, pass: &'p Self::Pass) -> &'p PassRecord;

    /// Describes a pass for people.
    fn describe(&self, pass: &Self::Pass) -> String;

    /// Collects all inputs that the state after `passes` passes depends on.
    fn origin(&self, passes: usize) -> Origin;
}

/// Result of a run.
pub struct PassRun<T> {
    /// The completed passes, those of an earlier run included.
    pub passes: Vec<T>,
    /// The workpiece and the tool in their last good state.
    pub state: RunState,
    /// Reason why the run ended before its last pass.
    pub stopped: Option<Error>,
    /// Computing time [s].
    pub seconds: f64,
    /// Simulated time of the passes that this run simulated [s].
    pub simulated: f64,
}

impl<T> PassRun<T> {
    /// Runs the passes, or the remaining ones after an earlier state.
    ///
    /// - `folder`: folder of the states that `keeping` requests
    ///
    /// # Errors
    /// If a state cannot be read or written, or is of another run. A failed pass is in [`PassRun::stopped`].
    pub fn new(
        passes: &impl Passes<Pass = T>,
        (keeping, folder): (&Keeping, &Path),
        console: &Console,
    ) -> Result<Self> {
        let mut run = Self { passes: Vec::new(), state: passes.start(), stopped: None, seconds: 0.0, simulated: 0.0 };
        if let Some(resume) = &keeping.resume {
            run.read_back(passes, resume)?;
            console.step("resumed", format!("after pass {} of {}", resume.passes, resume.folder.display()));
        }
        keeping.copy_earlier(folder)?;
        let started = Instant::now();
        while run.stopped.is_none() && run.passes.len() < passes.count() {
            run.next(passes, console);
            if keeping.snapshots && run.stopped.is_none() {
                run.keep(passes, folder)?;
            }
        }
        run.seconds = started.elapsed().as_secs_f64();
        Ok(run)
    }

    /// Returns the run, unless its first pass failed.
    ///
    /// # Errors
    /// The reason of that pass.
    pub fn begun(self) -> Result<Self> {
        match self {
            Self { passes, stopped: Some(error), .. } if passes.is_empty() => Err(error),
            run => Ok(run),
        }
    }

    /// Reads all passes up to a state of an earlier run.
    fn read_back(&mut self, passes: &impl Passes<Pass = T>, resume: &Resume) -> Result<()> {
        for done in 1..=resume.passes {
            let Snapshot { part, tool, trial_time, record } =
                snapshot::read(&resume.folder, done, passes.model(), &passes.origin(done))?;
            let after = RunState { part, tool, passes: done, trial_time, first_row: self.state.first_row };
            self.passes.push(passes.read_back(&self.state, &after, record)?);
            self.state = after;
        }
        Ok(())
    }

    /// Runs the next pass.
    fn next(&mut self, passes: &impl Passes<Pass = T>, console: &Console) {
        let name = format!("pass {}", self.passes.len() + 1);
        let bar = console.bar(&name, 100);
        let mut show = |at: Progress| bar.set_position((100.0 * at.time / at.duration) as u64);
        let ran = passes.run(&mut self.state, &mut show);
        bar.finish_and_clear();
        match ran {
            Ok(pass) => {
                self.simulated += passes.record(&pass).duration;
                console.step(&name, passes.describe(&pass));
                self.passes.push(pass);
            }
            Err(error) => self.stopped = Some(error),
        }
    }

    /// Writes the state after the last pass.
    fn keep(&self, passes: &impl Passes<Pass = T>, folder: &Path) -> Result<()> {
        let Some(last) = self.passes.last() else { return Ok(()) };
        let RunState { part, tool, passes: done, trial_time, .. } = self.state.clone();
        let state = Snapshot { part, tool, trial_time, record: passes.record(last).clone() };
        Ok(snapshot::write(folder, done, &state, passes.origin(done))?)
    }

    /// Returns simulated time over computing time.
    pub fn real_time_factor(&self) -> f64 {
        self.simulated / self.seconds
    }
}
