//! What a folder holds, and the benches that were opened on it.

use std::collections::BTreeMap;
use std::path::PathBuf;
use std::sync::{Arc, Mutex, PoisonError};

use crate::bench::Bench;
use crate::error::Refusal;
use crate::place::{Kind, Place, places};

/// The folder that a workbench is of.
pub(crate) struct Home {
    folder: PathBuf,
    out: PathBuf,
    benches: Mutex<BTreeMap<String, Arc<Bench>>>,
}

impl Home {
    /// A folder, and the one that keeps what is tried.
    pub(crate) fn new(folder: PathBuf, out: PathBuf) -> Self {
        Self { folder, out, benches: Mutex::default() }
    }

    /// Name of the folder.
    pub(crate) fn title(&self) -> String {
        self.folder.display().to_string()
    }

    /// Where what is tried is kept.
    pub(crate) fn out(&self) -> String {
        self.out.display().to_string()
    }

    /// What the folder holds now, and whether some of it was left out.
    pub(crate) fn places(&self) -> (Vec<Place>, bool) {
        places(&self.folder)
    }

    /// A place by its name in addresses.
    ///
    /// # Errors
    /// Where it is not there any more.
    pub(crate) fn place(&self, id: &str) -> Result<Place, Refusal> {
        let found = self.places().0.into_iter().find(|place| place.id == id);
        found.ok_or_else(|| Refusal::missing("the folder holds no such thing any more; go back to the list"))
    }

    /// The bench of a campaign, opened if it is not.
    ///
    /// # Errors
    /// Where there is none, or the system gives no thread.
    pub(crate) fn bench(&self, id: &str) -> Result<Arc<Bench>, Refusal> {
        let mut benches = self.benches.lock().unwrap_or_else(PoisonError::into_inner);
        if let Some(bench) = benches.get(id) {
            return Ok(bench.clone());
        }
        let place = self.place(id)?;
        if !place.kind.has_bench() {
            return Err(Refusal::wrong("effects can be tried on campaigns and tables"));
        }
        let out = self.out.join(place.slug());
        let bench = Bench::open(place, out, self.folder.clone());
        let bench = Arc::new(bench.map_err(|error| Refusal::wrong(format!("no thread for it: {error}")))?);
        benches.insert(id.to_owned(), bench.clone());
        Ok(bench)
    }

    /// Forgets a bench whose measurements could not be used, so that it is opened again when they are mended.
    pub(crate) fn forget(&self, id: &str) {
        self.benches.lock().unwrap_or_else(PoisonError::into_inner).remove(id);
    }

    /// File of a place that is shown as it is: the page of a result, or the picture of an asset.
    pub(crate) fn shown_file(place: &Place) -> PathBuf {
        let name = match place.kind {
            Kind::Asset => "preview.png",
            _ => "report.html",
        };
        place.path.join(name)
    }
}
