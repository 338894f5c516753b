//! Measurements of a study, trials with scans or a table of rows, and their conversion to data for fits.

use std::path::{Path, PathBuf};

use effects::{CompiledModel, Library, Model};
use lab::{LabError, Reaches, Result, Tried};

use lab::{Calibration, Order, RowEvidence, ScanEvidence, Totals, uncalibrated};
use trials::table::{TABLE_FILE, Table};
use trials::trial::{Campaign, Finding, FrameOffset};

/// Measurements as read from a folder.
pub enum Measurements {
    /// Trials with scans.
    Scans(Campaign),
    /// Rows.
    Rows(PathBuf, Box<Table>),
}

/// Measurements as data.
pub enum Data<'a> {
    /// Scans, and their campaign.
    Scans(&'a Campaign, Box<ScanEvidence<'a>>),
    /// Rows, and the folder of their table.
    Rows(&'a Path, Box<RowEvidence<'a>>),
}

impl Measurements {
    /// Reads a folder of trial folders, one trial folder, or a folder with a table.
    ///
    /// # Errors
    /// The first fault, with its place in the files.
    pub fn read(folder: &Path) -> Result<Self> {
        Ok(if folder.join(TABLE_FILE).is_file() {
            Self::Rows(folder.to_owned(), Box::new(Table::read(folder)?))
        } else {
            Self::Scans(aligned(Campaign::read(folder)?)?)
        })
    }

    /// Converts the measurements to data.
    ///
    /// # Errors
    /// If no data can be used in a fit.
    pub fn data(&self) -> Result<Data<'_>> {
        Ok(match self {
            Self::Scans(campaign) => Data::Scans(campaign, Box::new(ScanEvidence::new(&campaign.trials, None)?)),
            Self::Rows(folder, table) => Data::Rows(folder, Box::new(RowEvidence::new(table)?)),
        })
    }
}

/// Returns a campaign with its logs moved to where its scans show the tool, if they are far off; a note says so.
///
/// # Errors
/// If the base law of its process cannot be simulated.
pub fn aligned(campaign: Campaign) -> Result<Campaign> {
    let model = Model::new(campaign.trials[0].process);
    let Some(mut trials) = lab::aligned(&campaign.trials, &model, Library::builtin())? else { return Ok(campaign) };
    let FrameOffset { shift, yaw, lag, .. } = trials[0].frame_offset;
    let note = format!(
        "by the scans the logs lie elsewhere: poses were moved by x {:.3} mm, y {:.3} mm, yaw {:.2} mrad, clock {lag:.3} s \
         before any fit; frame_sigma_mm, yaw_sigma_mrad and clock_sigma_s of [robot] = 0 keep them",
        1e3 * shift.x,
        1e3 * shift.y,
        1e3 * yaw
    );
    trials[0].notes.push(note);
    Ok(Campaign { trials, ..campaign })
}

impl<'a> Data<'a> {
    /// The data as evidence for fits.
    pub fn evidence(&self) -> &dyn Totals {
        match self {
            Self::Scans(_, evidence) => evidence.as_ref(),
            Self::Rows(_, evidence) => evidence.as_ref(),
        }
    }

    /// The data as evidence for attempts.
    pub fn tried(&mut self) -> &mut dyn Tried {
        match self {
            Self::Scans(_, evidence) => evidence.as_mut(),
            Self::Rows(_, evidence) => evidence.as_mut(),
        }
    }

    /// The data as source of variable ranges.
    pub fn reaches(&self) -> &dyn Reaches {
        match self {
            Self::Scans(_, evidence) => evidence.as_ref(),
            Self::Rows(_, evidence) => evidence.as_ref(),
        }
    }

    /// The scans, if there are any.
    pub fn scans(&self) -> Option<(&'a Campaign, &ScanEvidence<'a>)> {
        match self {
            Self::Scans(campaign, evidence) => Some((campaign, evidence)),
            Self::Rows(..) => None,
        }
    }

    /// The rows, if there is a table.
    pub fn rows(&self) -> Option<&RowEvidence<'a>> {
        match self {
            Self::Scans(..) => None,
            Self::Rows(_, evidence) => Some(evidence),
        }
    }

    /// Folder of the measurements.
    pub fn folder(&self) -> &'a Path {
        match self {
            Self::Scans(campaign, _) => &campaign.folder,
            Self::Rows(folder, _) => folder,
        }
    }

    /// Description in one line.
    pub fn describe(&self) -> String {
        match self {
            Self::Scans(campaign, evidence) => {
                format!("{} trials, {} scans", campaign.trials.len(), evidence.views.len())
            }
            Self::Rows(_, evidence) => format!("{} rows", evidence.table.rows.len()),
        }
    }

    /// Notes on ambiguous input files and how they were interpreted, and assumptions; one sentence each.
    pub fn notes(&self) -> Vec<String> {
        match self {
            Self::Scans(campaign, evidence) => campaign.notes().into_iter().chain(evidence.noise_notes()).collect(),
            Self::Rows(_, evidence) => evidence.table.notes.iter().chain(&evidence.notes).cloned().collect(),
        }
    }

    /// Returns a library with the effects that only these data can show.
    ///
    /// # Errors
    /// If an effect cannot be evaluated on the rows of a table.
    pub fn library(&self, library: Library) -> Result<Library> {
        match self {
            Self::Scans(..) => Ok(library),
            Self::Rows(_, evidence) => evidence.library(&library).map_err(LabError::Refused),
        }
    }

    /// Findings of the consistency checks between scans and logs; empty for a table.
    pub fn findings(&self) -> Vec<Finding> {
        match self {
            Self::Scans(campaign, _) => campaign.findings(),
            Self::Rows(..) => Vec::new(),
        }
    }

    /// Returns a model adapted to these data: that of a table gets the rate constant and the reference values of its
    /// rows.
    ///
    /// # Errors
    /// If the library does not know the model.
    pub fn fitting(&self, model: Model, library: &Library) -> Result<Model> {
        match self {
            Self::Scans(..) => Ok(model),
            Self::Rows(_, evidence) => evidence.scaled(model, library).map_err(LabError::Refused),
        }
    }

    /// The base law of a model before any fit.
    ///
    /// # Errors
    /// If the library does not know the model.
    pub fn start(&self, model: &Model, library: &Library) -> Result<Model> {
        self.fitting(uncalibrated(model, library, self.evidence())?, library)
    }

    /// Calibrates a model and the smaller models on the way to it.
    ///
    /// - `models`: the model, and its base law before any fit
    /// - `done`: called after each fit with its name
    ///
    /// # Errors
    /// As [`Calibration::new`].
    pub fn calibrated(
        &mut self,
        models: (&Model, &Model),
        library: &Library,
        (order, done): (Order, &dyn Fn(&str)),
    ) -> Result<Calibration> {
        match self {
            Self::Scans(_, evidence) => evidence.calibrated(models, library, (order, done)),
            Self::Rows(_, evidence) => Calibration::new(evidence.as_ref(), models, library, (order, done)),
        }
    }

    /// Continues a calibration to which a search has added an effect, with the simulation errors measured there.
    ///
    /// # Errors
    /// If the model cannot be simulated.
    pub fn renewed(&mut self, calibration: Calibration) -> Result<Calibration> {
        match self {
            Self::Scans(_, evidence) => evidence.renewed(calibration),
            Self::Rows(..) => Ok(calibration),
        }
    }

    /// Fixes the observation at that of a model, so that maps of several models are seen alike.
    ///
    /// # Errors
    /// If the model cannot be simulated.
    pub fn fix_nuisances(&mut self, model: &CompiledModel) -> Result<()> {
        let Self::Scans(_, evidence) = self else { return Ok(()) };
        Ok(evidence.fix_nuisances(model)?)
    }

    /// Lets every model determine its own observation again, as fits do.
    pub fn free_nuisances(&mut self) {
        if let Self::Scans(_, evidence) = self {
            evidence.nuisances = None;
        }
    }
}
