//! An opened campaign or table: a thread that owns its measurements, and the results so far.

mod engine;
mod fields;
mod journal;
mod live;
mod plan;
mod replay;
mod shared;
mod slider;
mod stage;
mod suspects;
mod task;
mod trail;
mod worker;

use std::path::PathBuf;
use std::sync::mpsc::{Sender, channel};
use std::sync::{Arc, Mutex, PoisonError};

pub(crate) use journal::PAGE_FILE;
pub(crate) use live::{Live, Residuals, ScanMap, interpolated};
pub(crate) use shared::Shared;
pub(crate) use stage::Stage;
pub(crate) use task::Task;

use crate::error::Refusal;
use crate::place::Place;
use worker::Setup;

/// An opened campaign or table.
pub(crate) struct Bench {
    /// Folder of the measurements.
    pub(crate) place: Place,
    /// State shared with the requests.
    pub(crate) shared: Arc<Shared>,
    /// Folder in which the bench is saved.
    pub(crate) out: PathBuf,
    tasks: Mutex<Sender<Task>>,
}

impl Bench {
    /// Starts a thread that reads the measurements and then waits for tasks.
    ///
    /// - `out`: folder in which the bench is saved
    /// - `root`: folder that may hold studies of the same measurements
    ///
    /// # Errors
    /// If the system cannot start a thread.
    pub(crate) fn open(place: Place, out: PathBuf, root: PathBuf) -> std::io::Result<Self> {
        let shared = Arc::new(Shared::default());
        let (tasks, waiting) = channel();
        let setup = Setup { place: place.clone(), out: out.clone(), root };
        let of_worker = shared.clone();
        std::thread::Builder::new().name("bench".into()).spawn(move || worker::run(setup, &of_worker, &waiting))?;
        Ok(Self { place, shared, out, tasks: Mutex::new(tasks) })
    }

    /// Sends a task to the thread, or does it at once if it needs no simulation.
    pub(crate) fn take(&self, task: Task) -> Result<(), Refusal> {
        match task {
            Task::Cancel => self.shared.cancel(),
            Task::Undo | Task::Redo | Task::GoTo { .. } => {
                self.shared.change(|state| state.travel(&task))?;
                self.send(Task::Renew)?;
            }
            task => self.send(task)?,
        }
        Ok(())
    }

    fn send(&self, task: Task) -> Result<(), Refusal> {
        let tasks = self.tasks.lock().unwrap_or_else(PoisonError::into_inner);
        tasks
            .send(task)
            .map_err(|_| Refusal::early("the measurements could not be read; correct them and open them again"))
    }
}
