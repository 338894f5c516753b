//! A part on the page: a thread that owns its mesh and does one order after the other.

use std::sync::mpsc;
use std::thread;
use std::time::SystemTime;

use sdf_bake::clean::clean;
use sdf_bake::query::MeshQuery;
use sdf_bake::read::{MeshBytes, UnitChoice};
use tokio::sync::oneshot;
use weldgen::Surface;

use super::easel::{Easel, ReadPart};
use super::parts::PartFile;
use crate::error::Refusal;

/// Work on a part; the text is the reason why its file cannot be read.
type Work = Box<dyn FnOnce(Result<&mut Easel<'_>, &str>) + Send>;

/// A part that is looked at. Its thread ends when this is dropped.
pub(crate) struct OpenPart {
    part: PartFile,
    changed: Option<SystemTime>,
    orders: mpsc::Sender<Work>,
}

impl OpenPart {
    /// Starts the thread of a part, which reads the file.
    ///
    /// # Errors
    /// If the system cannot start a thread.
    pub(super) fn open(part: PartFile) -> Result<Self, Refusal> {
        let (orders, work) = mpsc::channel();
        let (changed, own) = (changed(&part), part.clone());
        let started = thread::Builder::new().name("part".into()).spawn(move || serve(&own, &work));
        started.map_err(|error| Refusal::wrong(format!("no thread for the part: {error}")))?;
        Ok(Self { part, changed, orders })
    }

    /// Returns true if this is the part, and its file has not changed since it was opened.
    pub(super) fn is_of(&self, part: &PartFile) -> bool {
        self.part == *part && self.changed == changed(part)
    }

    /// Does work on the part, after what was ordered before.
    ///
    /// # Errors
    /// Those of the work, and if the file cannot be read.
    pub(crate) async fn ask<R: Send + 'static>(
        &self,
        work: impl FnOnce(&mut Easel<'_>) -> Result<R, Refusal> + Send + 'static,
    ) -> Result<R, Refusal> {
        let (reply, answer) = oneshot::channel();
        let order = move |easel: Result<&mut Easel<'_>, &str>| {
            let done = easel.map_err(Refusal::wrong).and_then(work);
            // A page that was closed does not wait for its answer.
            let _gone = reply.send(done);
        };
        let lost =
            || Refusal::wrong("the work on this part ended by a fault of the program; the terminal has its words");
        self.orders.send(Box::new(order)).map_err(|_| lost())?;
        answer.await.map_err(|_| lost())?
    }

    /// Returns the file.
    pub(crate) fn file(&self) -> &PartFile {
        &self.part
    }
}

fn changed(part: &PartFile) -> Option<SystemTime> {
    part.path.metadata().and_then(|file| file.modified()).ok()
}

fn serve(part: &PartFile, orders: &mpsc::Receiver<Work>) {
    match read(part) {
        Err(words) => orders.iter().for_each(|order| order(Err(&words))),
        Ok(part) => {
            let query = MeshQuery::new(&part.mesh);
            let mut easel = Easel::new(&part, Surface::new(&part.mesh, &query));
            orders.iter().for_each(|order| order(Ok(&mut easel)));
        }
    }
}

/// Reads and cleans a mesh file, as `robofin weld` does.
fn read(part: &PartFile) -> Result<ReadPart, String> {
    let failed = |words: String| format!("{}: {words}", part.name);
    let bytes = MeshBytes::load(&part.path).map_err(|error| failed(error.to_string()))?;
    let file = bytes.parse(UnitChoice::Auto).map_err(|error| failed(error.to_string()))?;
    let (mesh, cleaning) = clean(file.mesh).map_err(|error| failed(error.to_string()))?;
    let notes = [vec![file.unit_reason], file.notes, cleaning.notes()].concat();
    Ok(ReadPart { mesh, notes })
}
