//! Content of the served folder, and the benches opened on it.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use std::sync::{Arc, Mutex, PoisonError};

use crate::bench::Bench;
use crate::error::Refusal;
use crate::part::Studio;
use crate::place::{Kind, Place, places};
use crate::sets::ImageSets;
use crate::weld::Welder;

/// The served folder and its open benches.
pub(crate) struct Home {
    folder: PathBuf,
    out: PathBuf,
    benches: Mutex<BTreeMap<String, Arc<Bench>>>,
    /// Parts, and the assets made of them.
    pub(crate) welder: Welder,
    /// Sets of images that were read last.
    pub(crate) images: ImageSets,
    /// Device for photographs; `None` for the CPU.
    pub(crate) studio: Option<Arc<Studio>>,
}

impl Home {
    /// Makes a home of the served folder and the folder for results.
    pub(crate) fn new(folder: PathBuf, out: PathBuf, studio: Option<Studio>) -> Self {
        let welder = Welder::new(&folder, &out);
        Self {
            folder,
            out,
            benches: Mutex::default(),
            welder,
            images: ImageSets::default(),
            studio: studio.map(Arc::new),
        }
    }

    /// Returns the name of the folder.
    pub(crate) fn title(&self) -> String {
        self.folder.display().to_string()
    }

    /// Returns the path of the folder for results.
    pub(crate) fn out(&self) -> String {
        self.out.display().to_string()
    }

    /// Returns the path of the served folder.
    pub(crate) fn folder(&self) -> &Path {
        &self.folder
    }

    /// Lists the current content of the folder; the second value is true if the list is incomplete.
    pub(crate) fn places(&self) -> (Vec<Place>, bool) {
        places(&self.folder)
    }

    /// Returns the address of the page of a campaign that holds a trial; the list if there is none.
    pub(crate) fn address_of(&self, trial: &Path) -> String {
        let holds = |place: &&Place| place.kind == Kind::Campaign && trial.parent() == Some(&place.path);
        self.places().0.iter().find(holds).map_or("/".to_owned(), |place| format!("/bench/{}", place.id))
    }

    /// Returns the address of an asset's picture; `None` if there is no asset in this folder.
    pub(crate) fn address_of_asset(&self, folder: &Path) -> Option<String> {
        let is_own = |place: &&Place| place.kind == Kind::Asset && place.path == folder;
        self.places().0.iter().find(is_own).map(|place| format!("/place/{}", place.id))
    }

    /// Finds a place by its id in addresses.
    ///
    /// # Errors
    /// If it no longer exists.
    pub(crate) fn place(&self, id: &str) -> Result<Place, Refusal> {
        let found = self.places().0.into_iter().find(|place| place.id == id);
        found.ok_or_else(|| Refusal::missing("the folder no longer holds this; go back to the list"))
    }

    /// Returns the bench of a campaign or table; opens it if necessary.
    ///
    /// # Errors
    /// If there is no such campaign, or the system cannot start a thread.
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

    /// Drops a bench with unusable measurements, so that it opens again once they are corrected.
    pub(crate) fn forget(&self, id: &str) {
        self.benches.lock().unwrap_or_else(PoisonError::into_inner).remove(id);
    }

    /// Returns the file that shows a place: the page of a result, or the picture of an asset.
    pub(crate) fn shown_file(place: &Place) -> PathBuf {
        let name = match place.kind {
            Kind::Asset => "preview.png",
            _ => "report.html",
        };
        place.path.join(name)
    }
}
