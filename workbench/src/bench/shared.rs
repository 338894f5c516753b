//! State of a bench, written by its thread and read by every request.

use std::sync::atomic::Ordering;
use std::sync::{Arc, Mutex, PoisonError};
use std::time::Instant;

use effects::{Library, NamedState, OneLine, Process};
use serde::Serialize;
use serde_json::{Value, json};
use tokio::sync::watch;
use trial_simulation::Stop;

use super::stage::{Record, Stage};
use super::suspects::Suspects;
use super::task::Task;
use super::trail::Trail;
use crate::error::Refusal;
use crate::part::Surfaces;

/// State with a version number that grows with each change.
pub(crate) struct Shared {
    state: Mutex<State>,
    version: watch::Sender<u64>,
    /// Flag that stops running simulations.
    pub(super) stop: Stop,
}

/// Phase of a bench.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "kebab-case")]
pub(crate) enum Phase {
    /// Measurements are being read.
    Reading,
    /// Tasks are accepted.
    Open,
    /// The measurements cannot be used.
    Closed,
}

/// Task in progress.
pub(super) struct Job {
    pub(super) what: String,
    pub(super) done: usize,
    pub(super) all: usize,
    pub(super) since: Instant,
}

/// A parameter fixed by its slider, and the response of the other parameters.
#[derive(Clone, Debug, Serialize)]
pub(super) struct FixedParameter {
    pub(super) parameter: String,
    pub(super) value: f64,
    /// Robust sum of squared residuals with the parameter fixed, and of the free fit.
    pub(super) chi2: [f64; 2],
    /// Names of the other parameters and their values with units.
    pub(super) others: Vec<(String, String)>,
    /// Root mean square error of the calibration passes; `None` until the fine lattice is computed.
    pub(super) rms: Option<f64>,
    /// Computing time [s].
    pub(super) seconds: f64,
}

/// Context in which typed formulas are parsed.
pub(crate) struct Reader {
    /// Process of the measurements.
    pub(super) process: Process,
    /// States that a formula may read.
    pub(super) states: Vec<NamedState>,
    /// Known effects.
    pub(super) library: Library,
}

/// Complete state of a bench.
pub(crate) struct State {
    pub(super) phase: Phase,
    pub(super) about: String,
    pub(super) notes: Vec<String>,
    /// Reason why the last task failed, or why the bench is closed.
    pub(super) fault: Option<String>,
    pub(super) job: Option<Job>,
    pub(super) waiting: usize,
    pub(super) stages: Vec<Arc<Stage>>,
    pub(super) trail: Trail,
    pub(super) suspects: Option<Suspects>,
    pub(super) held: Option<FixedParameter>,
    pub(super) reader: Option<Arc<Reader>>,
    pub(super) surfaces: Option<Arc<Surfaces>>,
}

impl Default for Shared {
    fn default() -> Self {
        let state = State {
            phase: Phase::Reading,
            about: String::new(),
            notes: Vec::new(),
            fault: None,
            job: None,
            waiting: 0,
            stages: Vec::new(),
            trail: Trail::default(),
            suspects: None,
            held: None,
            reader: None,
            surfaces: None,
        };
        Self { state: Mutex::new(state), version: watch::Sender::new(1), stop: Stop::default() }
    }
}

impl Shared {
    /// Reads the state.
    pub(crate) fn read<R>(&self, look: impl FnOnce(&State) -> R) -> R {
        look(&self.state.lock().unwrap_or_else(PoisonError::into_inner))
    }

    /// Changes the state, and wakes the requests that wait for a change.
    pub(crate) fn change<R>(&self, change: impl FnOnce(&mut State) -> R) -> R {
        let changed = change(&mut self.state.lock().unwrap_or_else(PoisonError::into_inner));
        self.version.send_modify(|version| *version += 1);
        changed
    }

    /// Stops the running task.
    pub(crate) fn cancel(&self) {
        self.stop.store(true, Ordering::Relaxed);
    }

    /// Waits for a version later than the known one; returns the latest version number.
    pub(crate) async fn later_than(&self, known: u64) -> u64 {
        let mut versions = self.version.subscribe();
        match versions.wait_for(|version| *version > known).await {
            Ok(version) => *version,
            Err(_) => known,
        }
    }

    /// Returns the latest version number.
    pub(crate) fn version(&self) -> u64 {
        *self.version.borrow()
    }
}

impl State {
    /// Returns the model of a number.
    pub(crate) fn stage(&self, number: usize) -> Option<Arc<Stage>> {
        self.stages.iter().find(|stage| stage.record.number == number).cloned()
    }

    /// Returns the current model.
    pub(crate) fn current(&self) -> Option<Arc<Stage>> {
        self.trail.current().and_then(|number| self.stage(number))
    }

    /// Returns the scanned surfaces; `None` for a table, and until the scans are read.
    pub(crate) fn surfaces(&self) -> Option<Arc<Surfaces>> {
        self.surfaces.clone()
    }

    /// Returns the context for typed formulas; `None` until the measurements are read.
    pub(crate) fn reader(&self) -> Option<Arc<Reader>> {
        self.reader.clone()
    }

    /// Returns true if the measurements cannot be used.
    pub(crate) fn is_closed(&self) -> bool {
        self.phase == Phase::Closed
    }

    /// Returns the command lines that make all models without the page.
    pub(crate) fn replay(&self) -> String {
        let of_stage = |stage: &Arc<Stage>| {
            let Record { number, label, commands, .. } = &stage.record;
            // A label may hold a formula; control characters are removed because a comment of the shell ends at a line
            // break.
            let label: String = label.chars().filter(|c| !c.is_control()).collect();
            format!("\n# {number}: {label}\n{}\n", commands.join("\n"))
        };
        let stages: String = self.stages.iter().map(of_stage).collect();
        format!("#!/bin/sh\n# Makes what the workbench made, in the folder replay.\nset -eu\nmkdir -p replay\n{stages}")
    }

    /// Makes another existing model the current one.
    pub(super) fn travel(&mut self, task: &Task) -> Result<(), Refusal> {
        let is_done = match task {
            Task::Undo => self.trail.undo(),
            Task::Redo => self.trail.redo(),
            Task::GoTo { number } if self.stage(*number).is_some() => {
                self.trail.go(*number);
                true
            }
            _ => false,
        };
        self.held = None;
        if is_done { Ok(()) } else { Err(Refusal::wrong("there is no such model to go to")) }
    }

    /// Returns the state as JSON for the page.
    pub(crate) fn to_json(&self, version: u64) -> Value {
        let current = self.current();
        let is_live = current.as_ref().is_some_and(|stage| stage.live().is_some());
        json!({
            "version": version,
            "phase": self.phase,
            "about": self.about,
            "notes": self.notes,
            "fault": self.fault,
            "job": self.job.as_ref().map(|job| json!({
                "what": job.what, "done": job.done, "all": job.all, "seconds": job.since.elapsed().as_secs_f64(),
            })),
            "waiting": self.waiting,
            "current": self.trail.current(),
            "drawable": self.stages.iter().filter(|stage| stage.live().is_some()).map(|stage| stage.record.number)
                .collect::<Vec<_>>(),
            "canUndo": self.trail.can_undo(),
            "canRedo": self.trail.can_redo(),
            "stages": self.stages.iter().map(|stage| stage.record.to_json()).collect::<Vec<_>>(),
            "sliders": current.as_ref().map(|stage| json!(stage.record.sliders)),
            "isLive": is_live,
            "suspects": self.suspects,
            "held": self.held,
            "library": self.reader.as_ref().map(|reader| reader.effects()),
            "trials": self.surfaces.as_ref().map(|surfaces| surfaces.to_json()),
        })
    }
}

impl Reader {
    /// Returns names and titles of the effects that act in the process.
    fn effects(&self) -> Vec<[&str; 2]> {
        let acting = self.library.effects().iter().filter(|effect| effect.acts_in(self.process));
        acting.map(|effect| [effect.name.as_str(), effect.title.as_str()]).collect()
    }

    /// Returns the unknown names of a formula with their SI units, or the error in the formula.
    pub(crate) fn check(&self, line: &str) -> Result<Vec<(String, String)>, String> {
        let read =
            OneLine::parse(line, self.process, &self.states, &self.library).map_err(|error| error.to_string())?;
        Ok(read.unknowns.into_iter().map(|unknown| (unknown.name, unknown.dimension.to_string())).collect())
    }
}
