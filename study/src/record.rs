//! What a study keeps between its steps: `study.json`.

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

/// The file by which the folder of a study is known.
pub const STUDY_FILE: &str = "study.json";
/// Form of that file.
pub const STUDY_FORMAT: &str = "robofin-study/1";

/// A step of a study.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Action {
    /// Hold the base law against the measurements before anything is fitted.
    Compare,
    /// Fit the model.
    Calibrate,
    /// Search for the effect that it lacks.
    Diagnose,
    /// Add that effect to the model.
    Add,
}

impl Action {
    /// For people.
    pub fn word(self) -> &'static str {
        match self {
            Self::Compare => "compare",
            Self::Calibrate => "calibrate",
            Self::Diagnose => "diagnose",
            Self::Add => "add",
        }
    }

    /// What it will do, in a few words.
    pub fn intent(self) -> &'static str {
        match self {
            Self::Compare => "hold the base law against the measurements",
            Self::Calibrate => "fit the model to the calibration passes",
            Self::Diagnose => "search the library for what the model lacks",
            Self::Add => "add the effect that was found to the model",
        }
    }
}

/// A step that was done.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub struct Done {
    /// Which.
    pub action: Action,
    /// What came out.
    pub outcome: String,
}

/// A study as far as it has come.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub struct StudyRecord {
    /// [`STUDY_FORMAT`].
    pub format: String,
    /// SHA-256 over the hashes of all measurements.
    pub measurements_sha256: String,
    /// Seed of all draws.
    pub seed: u64,
    /// The verdict, once there is one.
    pub verdict: Option<Verdict>,
    /// The verdict in a sentence.
    pub sentence: Option<String>,
    /// Why the study ended; absent while it goes on.
    pub ended: Option<String>,
    /// The next step; absent where the study has ended.
    pub next: Option<Action>,
    /// What was done.
    pub done: Vec<Done>,
    /// Effects that the study added, in order.
    pub added: Vec<String>,
    /// The first model and that with each effect that was added, held against all data.
    #[serde(default)]
    pub searched: Vec<Searched>,
    /// In what the errors below are told: `um` for scans, `percent` of the removal for tables.
    pub error_unit: ErrorUnit,
    /// What noise alone would leave of the calibration passes [µm].
    pub noise_floor_um: f64,
    /// The same of the evaluation passes; absent where none is held out.
    #[serde(default)]
    pub evaluation_noise_floor_um: Option<f64>,
    /// What the reader understood of the files where it was not the plain case, one sentence each.
    #[serde(default)]
    pub notes: Vec<String>,
    /// What the checks of scans and logs against each other found, for machines.
    #[serde(default)]
    pub findings: Vec<Finding>,
    /// The first answer, before anything was fitted to the end; absent where it was not asked for.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub first_answer: Option<FirstAnswer>,
    /// How the error fell so far.
    pub waterfall: Vec<WaterfallStep>,
    /// The effect to add, while that is the next step, and the text of the model with it as the search fitted it.
    pub to_add: Option<[String; 2]>,
    /// The last diagnosis as `diagnose --json` tells it.
    pub diagnosis: Option<Value>,
    /// The numbers behind all decisions, by name, as this program has them; those of a record that is read are left out.
    #[serde(skip_deserializing)]
    pub criteria: CriterionValues,
}

impl StudyRecord {
    /// The record of a study's folder.
    ///
    /// # Errors
    /// Wrong use where it is none, or of other measurements than the campaign holds now.
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

    /// A study that begins.
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
            noise_floor_um: 0.0,
            evaluation_noise_floor_um: None,
            notes: Vec::new(),
            findings: Vec::new(),
            first_answer: None,
            waterfall: Vec::new(),
            to_add: None,
            diagnosis: None,
            criteria: CriterionValues,
        }
    }

    /// Counts a frame or clock that is off as the effect of the library that does the same. The model does without it: every
    /// fit leaves both free.
    pub(super) fn add_frame(&mut self, frame: Option<&FrameEstimate>) {
        let effect = frame.and_then(|frame| frame.cause.effect()).filter(|name| !self.added.iter().any(|a| a == name));
        self.added.extend(effect.map(str::to_owned));
    }

    /// What a search says in a sentence, given the effects that were added before it.
    pub(super) fn sentence_with(&self, verdict: Verdict, to_add: Option<&str>, of_search: &str) -> String {
        let names: Vec<&str> = self.added.iter().map(String::as_str).chain(to_add).collect();
        let names = names.join(" and ");
        match verdict {
            _ if self.added.is_empty() => of_search.to_owned(),
            Verdict::Identified => format!("The model lacked {names}."),
            Verdict::Unknown => {
                format!(
                    "The model lacked {names}, or what does the like: most of what is left no effect of the library describes."
                )
            }
            _ => format!("The model lacked {names}, and more that was not found."),
        }
    }

    /// What noise alone leaves of calibration and evaluation passes, as the report takes it.
    pub(super) fn floors(&self) -> (f64, Option<f64>) {
        (self.noise_floor_um, self.evaluation_noise_floor_um)
    }

    /// An error in its unit, with the held-out one.
    pub(super) fn shown(&self, step: &WaterfallStep) -> String {
        let unit = self.error_unit.symbol();
        let held_out = step.evaluation_rms_um.map_or(String::new(), |rms| format!(", held out {rms:.2} {unit}"));
        format!("{}: {:.2} {unit}{held_out}", step.step, step.calibration_rms_um)
    }
}
