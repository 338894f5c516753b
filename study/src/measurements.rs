//! What a folder holds for a study, trials with scans or a table of rows, and the same as data for fits.

use std::path::{Path, PathBuf};

use effects::{CompiledModel, Library, Model};
use lab::{LabError, Reaches, Result, Tried};

use lab::{Calibration, Order, RowEvidence, ScanEvidence, Totals, uncalibrated};
use trials::table::{TABLE_FILE, Table};
use trials::trial::{Campaign, Finding, FrameOffset};

/// Measurements as they were read.
pub enum Measurements {
    /// Trials with scans.
    Scans(Campaign),
    /// Rows.
    Rows(PathBuf, Box<Table>),
}

/// Measurements as data.
pub enum Data<'a> {
    /// Scans, and the campaign that they are of.
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

    /// Makes data of them.
    ///
    /// # Errors
    /// When there is nothing that a fit could use.
    pub fn data(&self) -> Result<Data<'_>> {
        Ok(match self {
            Self::Scans(campaign) => Data::Scans(campaign, Box::new(ScanEvidence::new(&campaign.trials, None)?)),
            Self::Rows(folder, table) => Data::Rows(folder, Box::new(RowEvidence::new(table)?)),
        })
    }
}

/// A campaign with its logs moved to where its scans show the tool, where they are far from there; a note says so.
///
/// # Errors
/// When the base law of its process cannot be simulated.
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
    /// For fits.
    pub fn evidence(&self) -> &dyn Totals {
        match self {
            Self::Scans(_, evidence) => evidence.as_ref(),
            Self::Rows(_, evidence) => evidence.as_ref(),
        }
    }

    /// For an effect that is tried.
    pub fn tried(&mut self) -> &mut dyn Tried {
        match self {
            Self::Scans(_, evidence) => evidence.as_mut(),
            Self::Rows(_, evidence) => evidence.as_mut(),
        }
    }

    /// For how large what a formula reads becomes.
    pub fn reaches(&self) -> &dyn Reaches {
        match self {
            Self::Scans(_, evidence) => evidence.as_ref(),
            Self::Rows(_, evidence) => evidence.as_ref(),
        }
    }

    /// The scans, where there are scans.
    pub fn scans(&self) -> Option<(&'a Campaign, &ScanEvidence<'a>)> {
        match self {
            Self::Scans(campaign, evidence) => Some((campaign, evidence)),
            Self::Rows(..) => None,
        }
    }

    /// The rows, where there is a table.
    pub fn rows(&self) -> Option<&RowEvidence<'a>> {
        match self {
            Self::Scans(..) => None,
            Self::Rows(_, evidence) => Some(evidence),
        }
    }

    /// Where they were read.
    pub fn folder(&self) -> &'a Path {
        match self {
            Self::Scans(campaign, _) => &campaign.folder,
            Self::Rows(folder, _) => folder,
        }
    }

    /// What there is, in one line.
    pub fn describe(&self) -> String {
        match self {
            Self::Scans(campaign, evidence) => {
                format!("{} trials, {} scans", campaign.trials.len(), evidence.views.len())
            }
            Self::Rows(_, evidence) => format!("{} rows", evidence.table.rows.len()),
        }
    }

    /// What the reader understood of the files where it was not the plain case, and what was assumed; one sentence each.
    pub fn notes(&self) -> Vec<String> {
        match self {
            Self::Scans(campaign, evidence) => campaign.notes().into_iter().chain(evidence.noise_notes()).collect(),
            Self::Rows(_, evidence) => evidence.table.notes.iter().chain(&evidence.notes).cloned().collect(),
        }
    }

    /// A library with the effects that only these data can show.
    ///
    /// # Errors
    /// An effect that cannot be evaluated on the rows of a table.
    pub fn library(&self, library: Library) -> Result<Library> {
        match self {
            Self::Scans(..) => Ok(library),
            Self::Rows(_, evidence) => evidence.library(&library).map_err(LabError::Refused),
        }
    }

    /// What the checks of scans and logs against each other found, for machines; nothing of a table.
    pub fn findings(&self) -> Vec<Finding> {
        match self {
            Self::Scans(campaign, _) => campaign.findings(),
            Self::Rows(..) => Vec::new(),
        }
    }

    /// A model ready for these data: that of a table gets the rate constant and the reference values that its rows need.
    ///
    /// # Errors
    /// A model that the library does not know.
    pub fn fitting(&self, model: Model, library: &Library) -> Result<Model> {
        match self {
            Self::Scans(..) => Ok(model),
            Self::Rows(_, evidence) => evidence.scaled(model, library).map_err(LabError::Refused),
        }
    }

    /// The base law of a model before any fit.
    ///
    /// # Errors
    /// A model that the library does not know.
    pub fn start(&self, model: &Model, library: &Library) -> Result<Model> {
        self.fitting(uncalibrated(model, library, self.evidence())?, library)
    }

    /// Calibrates a model and those that it grew from.
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

    /// A calibration to which a search has added an effect, taken further with errors of the simulation as they are there.
    ///
    /// # Errors
    /// When the model cannot be simulated.
    pub fn renewed(&mut self, calibration: Calibration) -> Result<Calibration> {
        match self {
            Self::Scans(_, evidence) => evidence.renewed(calibration),
            Self::Rows(..) => Ok(calibration),
        }
    }

    /// Keeps the observation that a model finds, so that maps of several models are seen alike.
    ///
    /// # Errors
    /// When the model cannot be simulated.
    pub fn fix_observation(&mut self, model: &CompiledModel) -> Result<()> {
        let Self::Scans(_, evidence) = self else { return Ok(()) };
        Ok(evidence.fix_observation(model)?)
    }

    /// Lets every model find its own observation again, as fits do.
    pub fn free_observation(&mut self) {
        if let Self::Scans(_, evidence) = self {
            evidence.observation = None;
        }
    }
}
