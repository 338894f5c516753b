//! A study compared with the answer that a seal has kept from it.

use std::path::Path;

use effects::Library;
use files::FileError;
use files::json_file::read_json;
use lab::Verdict;
use serde::Serialize;
use serde_json::Value;
use study::{StudyRecord, StudyState};
use thiserror::Error;
use virtual_lab::write::{SEAL_FILE, WriteError, unseal};

/// Error of a seal that cannot be compared with a study.
#[derive(Debug, Error)]
pub enum SealError {
    /// The study has not ended.
    #[error("the study has not come to a verdict")]
    Unfinished,
    /// The key does not open the seal.
    #[error(transparent)]
    Unseal(#[from] WriteError),
    /// The seal cannot be read.
    #[error(transparent)]
    Seal(#[from] FileError),
}

/// An opened seal, compared with the result of a study.
#[derive(Clone, Debug, Serialize)]
pub struct OpenedSeal {
    /// SHA-256 of the answer, as published in the seal.
    pub sha256: String,
    /// Names of the hidden effects that the library contains, in alphabetical order.
    pub hidden: Vec<String>,
    /// True if an unlisted effect was hidden.
    pub hidden_is_foreign: bool,
    /// Names of the effects that the study found, in alphabetical order.
    pub found: Vec<String>,
    /// Verdict of the study.
    pub verdict: Verdict,
    /// True if the study was right: the hidden effects, `unknown` for an unlisted one, or nothing missing.
    pub is_right: bool,
    /// True if the measurements are those of the seal.
    pub measurements_unchanged: bool,
    /// The hidden effects, each with its parameters that differ from their null values, in words.
    #[serde(skip)]
    pub hidden_lines: Vec<String>,
    /// The effects that the study found, each with its parameters, or that nothing is missing, in words.
    #[serde(skip)]
    pub found_lines: Vec<String>,
}

impl OpenedSeal {
    /// Opens the seal of a campaign and compares it with a finished study.
    ///
    /// # Errors
    /// If the key does not open the seal, or the study has no verdict yet.
    pub fn open(folder: &Path, key: &Path, study: &StudyState) -> Result<Self, SealError> {
        let verdict = study.record.verdict.ok_or(SealError::Unfinished)?;
        let unsealed = unseal(folder, key)?;
        let seal: Value = read_json(&folder.join(SEAL_FILE), "a sealed answer")?;
        let sha256 = seal["sha256"].as_str().unwrap_or_default().to_owned();
        let effects = unsealed.answer["effects"].as_array().cloned().unwrap_or_default();
        let (known, foreign): (Vec<&Value>, Vec<&Value>) =
            effects.iter().partition(|effect| effect["in_library"].as_bool().unwrap_or(false));
        let mut hidden: Vec<String> = known.iter().filter_map(|e| e["name"].as_str()).map(str::to_owned).collect();
        let mut found = study.record.added.clone();
        hidden.sort();
        found.sort();
        let is_right = match (hidden.is_empty(), foreign.is_empty()) {
            (true, true) => verdict == Verdict::NothingMissing,
            (true, false) => verdict == Verdict::Unknown,
            (false, true) => verdict == Verdict::Identified && found == hidden,
            (false, false) => verdict == Verdict::Partly && found == hidden,
        };
        let or_else = |lines: Vec<String>, none: &str| if lines.is_empty() { vec![none.to_owned()] } else { lines };
        Ok(Self {
            sha256,
            hidden_lines: or_else(effects.iter().flat_map(hidden_lines).collect(), "nothing"),
            found_lines: or_else(found_lines(study), &nothing_found(&study.record)),
            hidden,
            hidden_is_foreign: !foreign.is_empty(),
            found,
            verdict,
            is_right,
            measurements_unchanged: unsealed.measurements_unchanged,
        })
    }
}

/// Lists the name of a hidden effect, and its parameters that differ from their null values.
fn hidden_lines(effect: &Value) -> Vec<String> {
    let name = effect["name"].as_str().unwrap_or_default();
    let known = Library::builtin().find(name);
    let parameter = |(parameter, quantity): (&String, &Value)| {
        let values: Vec<&str> = quantity["values"].as_array().into_iter().flatten().filter_map(Value::as_str).collect();
        let null = known.and_then(|effect| effect.parameter(parameter)?.null);
        let is_null = |value: &&str| null.is_some_and(|null| value.parse() == Ok(null));
        let unit = quantity["unit"].as_str().filter(|unit| *unit != "1").unwrap_or_default();
        (!values.iter().all(is_null))
            .then(|| format!("{parameter} = {} {unit}", values.join(" ")).trim_end().to_owned())
    };
    let parameters = effect["parameters"].as_object().into_iter().flatten().filter_map(parameter);
    [name.to_owned()].into_iter().chain(parameters).collect()
}

/// Lists names and fitted parameters of the effects that a study added.
fn found_lines(study: &StudyState) -> Vec<String> {
    let parameters = study.parameters();
    let own = |name: &String| {
        let prefix = format!("{name}.");
        let parameters = parameters.iter().filter(|parameter| parameter.name.starts_with(&prefix));
        let lines = parameters.flat_map(|parameter| {
            let shown = parameter.shown().replacen(&prefix, "", 1);
            let (value, rest) = shown.split_once(", ").map_or((shown.as_str(), ""), |(value, rest)| (value, rest));
            let lines = [value, rest].into_iter().filter(|line| !line.is_empty());
            lines.map(str::to_owned).collect::<Vec<_>>()
        });
        [name.clone()].into_iter().chain(lines).collect::<Vec<String>>()
    };
    study.record.added.iter().flat_map(own).collect()
}

fn nothing_found(record: &StudyRecord) -> String {
    match record.verdict {
        Some(Verdict::NothingMissing) => "nothing is missing".to_owned(),
        _ => record.sentence.clone().unwrap_or_default(),
    }
}
