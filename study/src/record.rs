//! Record of a study between its steps: `study.json`.

use std::path::Path;

use files::input::quoted_near;
use files::json_file::read_json;
use files::{FileError, WrongUse};
use serde::{Deserialize, Serialize};
use serde_json::Value;
use trials::trial::Finding;

use super::first_look::FirstAnswer;
use super::provenance::inputs_sha256;
use lab::criteria::CriterionValues;
use lab::{ErrorUnit, FrameEstimate, LabError, Result, Searched, Verdict, WaterfallStep};

/// File that marks the folder of a study.
pub const STUDY_FILE: &str = "study.json";
/// Format of that file.
pub const STUDY_FORMAT: &str = "robofin-study/2";

/// A step of a study.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Action {
    /// Compare the base law with the measurements before any fit.
    Compare,
    /// Fit the model.
    Calibrate,
    /// Search for a missing effect.
    Diagnose,
    /// Add that effect to the model.
    Add,
}

impl Action {
    /// Word for display.
    pub fn word(self) -> &'static str {
        match self {
            Self::Compare => "compare",
            Self::Calibrate => "calibrate",
            Self::Diagnose => "diagnose",
            Self::Add => "add",
        }
    }

    /// Intent in a few words.
    pub fn intent(self) -> &'static str {
        match self {
            Self::Compare => "compare the base law with the measurements",
            Self::Calibrate => "fit the model to the calibration passes",
            Self::Diagnose => "search the library for what the model lacks",
            Self::Add => "add the effect that was found to the model",
        }
    }
}

/// A step that was done.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub struct Done {
    /// The step.
    pub action: Action,
    /// Its result.
    pub outcome: String,
}

/// State of a study.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub struct StudyRecord {
    /// [`STUDY_FORMAT`].
    pub format: String,
    /// SHA-256 over the hashes of all measurements.
    pub measurements_sha256: String,
    /// Seed of all draws.
    pub seed: u64,
    /// The verdict, if there is one.
    pub verdict: Option<Verdict>,
    /// The verdict in a sentence.
    pub sentence: Option<String>,
    /// Reason for which the study ended; absent before that.
    pub ended: Option<String>,
    /// The next step; absent if the study has ended.
    pub next: Option<Action>,
    /// Steps that were done.
    pub done: Vec<Done>,
    /// Effects that the study added, in order.
    pub added: Vec<String>,
    /// The first model and that with each added effect, compared with all data.
    #[serde(default)]
    pub searched: Vec<Searched>,
    /// Unit of the errors below: metres for scans, shares of the removal for tables.
    pub error_unit: ErrorUnit,
    /// Noise floor of the calibration passes.
    pub noise_floor: f64,
    /// Noise floor of the evaluation passes; absent where none is held out.
    #[serde(default)]
    pub evaluation_noise_floor: Option<f64>,
    /// Notes on ambiguous input files and how they were interpreted, one sentence each.
    #[serde(default)]
    pub notes: Vec<String>,
    /// Findings of the consistency checks between scans and logs.
    #[serde(default)]
    pub findings: Vec<Finding>,
    /// The first answer, before any complete fit; absent if it was not requested.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub first_answer: Option<FirstAnswer>,
    /// Error after each step so far.
    pub waterfall: Vec<WaterfallStep>,
    /// The effect to add, while that is the next step, and the text of the fitted model with it.
    pub to_add: Option<[String; 2]>,
    /// The last diagnosis in the form of `diagnose --json`.
    pub diagnosis: Option<Value>,
    /// Values of all decision criteria of this program, by name; those of a record that is read are ignored.
    #[serde(skip_deserializing)]
    pub criteria: CriterionValues,
}

impl StudyRecord {
    /// Reads the record in a study's folder.
    ///
    /// # Errors
    /// Wrong use if it is no record, or of other measurements than the campaign holds now.
    pub fn read(folder: &Path, campaign: &Path) -> Result<Self> {
        let file = folder.join(STUDY_FILE);
        let record: Self = read_json(&file, "the record of a study")?;
        let refused = |words: String| Err(LabError::File(FileError::from(WrongUse(words))));
        if record.format != STUDY_FORMAT {
            let found = quoted_near(&record.format, [STUDY_FORMAT]);
            return refused(format!("{}: format {found}, and {STUDY_FORMAT} is accepted", file.display()));
        }
        if record.measurements_sha256 != inputs_sha256(campaign)? {
            return refused(format!(
                "{}: its study was begun with other measurements than {} holds now; begin again with --force",
                folder.display(),
                campaign.display()
            ));
        }
        Ok(record)
    }

    /// A study before its first step.
    pub fn new(measurements_sha256: String, seed: u64) -> Self {
        Self {
            format: STUDY_FORMAT.to_owned(),
            measurements_sha256,
            seed,
            verdict: None,
            sentence: None,
            ended: None,
            next: Some(Action::Compare),
            done: Vec::new(),
            added: Vec::new(),
            searched: Vec::new(),
            error_unit: ErrorUnit::default(),
            noise_floor: 0.0,
            evaluation_noise_floor: None,
            notes: Vec::new(),
            findings: Vec::new(),
            first_answer: None,
            waterfall: Vec::new(),
            to_add: None,
            diagnosis: None,
            criteria: CriterionValues,
        }
    }

    /// Records a wrong frame or clock as the equivalent effect of the library. The model does not contain it: every fit
    /// leaves both free.
    pub(super) fn add_frame(&mut self, frame: Option<&FrameEstimate>) {
        let effect = frame.and_then(|frame| frame.cause.effect()).filter(|name| !self.added.iter().any(|a| a == name));
        self.added.extend(effect.map(str::to_owned));
    }

    /// Sentence on a search, given the effects that were added before it.
    pub(super) fn sentence_with(&self, verdict: Verdict, to_add: Option<&str>, of_search: &str) -> String {
        let names: Vec<&str> = self.added.iter().map(String::as_str).chain(to_add).collect();
        let names = names.join(" and ");
        match verdict {
            _ if self.added.is_empty() => of_search.to_owned(),
            Verdict::Identified => format!("The model lacked {names}."),
            Verdict::Unknown => {
                format!(
                    "The model lacked {names} or a similar effect: no effect of the library describes most of what is \
                     left."
                )
            }
            _ => format!("The model lacked {names}, and more that was not found."),
        }
    }

    /// Noise floors of calibration and evaluation passes.
    pub(super) fn floors(&self) -> (f64, Option<f64>) {
        (self.noise_floor, self.evaluation_noise_floor)
    }
}
