//! A campaign: all trials of a folder.

use std::fs;
use std::path::{Path, PathBuf};

use super::error::{Place, TrialError};
use super::manifest::TRIAL_FILE;
use super::{Finding, HeldTool, Trial, plausible};

/// All trials of a folder, in the order of their folders' names.
#[derive(Clone, Debug, PartialEq)]
pub struct Campaign {
    /// The folder.
    pub folder: PathBuf,
    /// The trials; a tool that is not fresh keeps its wear from the previous trial.
    pub trials: Vec<Trial>,
}

impl Campaign {
    /// Reads a folder of trial folders, or one trial folder.
    ///
    /// # Errors
    /// [`TrialError`] if there is no trial, or one cannot be read.
    pub fn read(folder: &Path) -> Result<Self, TrialError> {
        let places = Self::places(folder)?;
        if places == [folder] {
            return Ok(Self { folder: folder.to_owned(), trials: vec![Trial::read(folder)?] });
        }
        let trials: Vec<Trial> = places.iter().map(|place| Trial::read(place)).collect::<Result<_, _>>()?;
        plausible::check_across(&trials).map_err(|error| error.by("across trials"))?;
        Self { folder: folder.to_owned(), trials }.checked()
    }

    /// Trial folders in a folder, by name, or the folder itself if it is one.
    ///
    /// # Errors
    /// [`TrialError`] if there is no trial.
    pub fn places(folder: &Path) -> Result<Vec<PathBuf>, TrialError> {
        let unreadable = |source| TrialError::Unreadable { file: folder.to_owned(), source };
        if folder.join(TRIAL_FILE).is_file() {
            return Ok(vec![folder.to_owned()]);
        }
        let mut places = Vec::new();
        for entry in fs::read_dir(folder).map_err(unreadable)? {
            let place = entry.map_err(unreadable)?.path();
            if place.join(TRIAL_FILE).is_file() {
                places.push(place);
            }
        }
        places.sort();
        if places.is_empty() {
            return Err(Place::file(folder).bad(
                format!("no {TRIAL_FILE} here or in a folder below"),
                "a trial or a folder of trials is expected: `robofin trial init FOLDER` writes the file for scans and logs",
            ));
        }
        Ok(places)
    }

    /// Notes of all trials, one sentence each; with several trials, each begins with its trial's name.
    pub fn notes(&self) -> Vec<String> {
        let several = self.trials.len() > 1;
        let named =
            |trial: &Trial, note: &String| if several { format!("{}: {note}", trial.name) } else { note.clone() };
        self.trials.iter().flat_map(|trial| trial.notes.iter().map(move |note| named(trial, note))).collect()
    }

    /// Findings of the checks of all trials, machine-readable.
    pub fn findings(&self) -> Vec<Finding> {
        self.trials.iter().flat_map(|trial| trial.findings.iter().cloned()).collect()
    }

    /// Checks that a tool that is not fresh is the tool of the previous trial.
    fn checked(mut self) -> Result<Self, TrialError> {
        let tools: Vec<HeldTool> = self.trials.iter().map(|trial| trial.tool.clone()).collect();
        for (k, trial) in self.trials.iter_mut().enumerate().filter(|(_, trial)| !trial.fresh) {
            if k == 0 {
                trial.notes.push("the tool is not fresh and no trial comes before: its past is unknown".to_owned());
            } else if tools[k - 1] != tools[k] {
                return Err(Place::file(&trial.folder.join(TRIAL_FILE)).bad(
                    "the tool is not fresh and differs from that of the trial before",
                    "fresh = true, or the same tool as before, is expected",
                ));
            }
        }
        Ok(self)
    }
}
