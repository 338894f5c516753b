//! The bundled sealed example: a small synthetic campaign with a sealed answer. A study is compared with the seal.

use std::fs;
use std::path::Path;

use anyhow::{Context, Result};
use effects::Library;
use serde::Serialize;
use serde_json::Value;

use files::json_file::read_json;
use lab::Verdict;
use report::study::Sealed;
use study::{StudyRecord, StudyState};
use virtual_lab::write::{SEAL_FILE, unseal};

/// Name of the bundled campaign.
pub const EXAMPLE_NAME: &str = "first-look";

macro_rules! bundled {
    ($folder:literal: $($file:literal),* $(,)?) => {
        &[$(($file, include_bytes!(concat!("../data/campaigns/", $folder, "/", $file)))),*]
    };
}

/// Files of the campaign.
const FILES: &[(&str, &[u8])] = bundled!("first-look":
    "laboratory.json", "sealed.json",
    "trial-1/trial.toml", "trial-1/before.csv", "trial-1/before_repeat.csv", "trial-1/material.csv",
    "trial-1/pass1_log.csv", "trial-1/pass1_after.csv", "trial-1/pass2_log.csv", "trial-1/pass2_after.csv",
    "trial-2/trial.toml", "trial-2/before.csv", "trial-2/before_repeat.csv", "trial-2/material.csv",
    "trial-2/pass1_log.csv", "trial-2/pass1_after.csv", "trial-2/pass2_log.csv", "trial-2/pass2_after.csv",
    "trial-3/trial.toml", "trial-3/before.csv", "trial-3/before_repeat.csv", "trial-3/material.csv",
    "trial-3/pass1_log.csv", "trial-3/pass1_after.csv", "trial-3/pass2_log.csv", "trial-3/pass2_after.csv",
);
/// The key of its seal.
const KEY: &[u8] = include_bytes!("../data/campaigns/first-look.key");

/// Opened seal, compared with the result of a study.
#[derive(Clone, Debug, Serialize)]
pub struct Opened {
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
}

/// Writes the bundled campaign into a folder, and its key beside it.
///
/// # Errors
/// If a file cannot be written.
pub fn unpack(folder: &Path, key: &Path) -> Result<()> {
    for (name, bytes) in FILES {
        let file = folder.join(name);
        let context = || format!("{}: cannot write this file", file.display());
        fs::create_dir_all(file.parent().unwrap_or(folder)).with_context(context)?;
        fs::write(&file, bytes).with_context(context)?;
    }
    fs::write(key, KEY).with_context(|| format!("{}: cannot write this file", key.display()))
}

/// Opens the seal of a campaign and compares it with a finished study.
///
/// # Errors
/// If the key does not open the seal, or the study has no verdict yet.
pub fn open(folder: &Path, key: &Path, course: &StudyState) -> Result<(Opened, Sealed)> {
    let verdict = course.record.verdict.context("the study has not come to a verdict")?;
    let unsealed = unseal(folder, key)?;
    let seal: Value = read_json(&folder.join(SEAL_FILE), "a sealed answer")?;
    let sha256 = seal["sha256"].as_str().unwrap_or_default().to_owned();
    let effects = unsealed.answer["effects"].as_array().cloned().unwrap_or_default();
    let (known, foreign): (Vec<&Value>, Vec<&Value>) =
        effects.iter().partition(|effect| effect["in_library"].as_bool().unwrap_or(false));
    let mut hidden: Vec<String> = known.iter().filter_map(|e| e["name"].as_str()).map(str::to_owned).collect();
    let mut found = course.record.added.clone();
    hidden.sort();
    found.sort();
    let is_right = match (hidden.is_empty(), foreign.is_empty()) {
        (true, true) => verdict == Verdict::NothingMissing,
        (true, false) => verdict == Verdict::Unknown,
        (false, true) => verdict == Verdict::Identified && found == hidden,
        (false, false) => verdict == Verdict::Partly && found == hidden,
    };
    let lines = |lines: Vec<String>, none: &str| if lines.is_empty() { vec![none.to_owned()] } else { lines };
    let sealed = Sealed {
        sha256: sha256.clone(),
        hidden: lines(effects.iter().flat_map(hidden_lines).collect(), "nothing"),
        found: lines(found_lines(course), &nothing_found(&course.record)),
        is_right,
    };
    let measurements_unchanged = unsealed.measurements_unchanged;
    let hidden_is_foreign = !foreign.is_empty();
    Ok((Opened { sha256, hidden, hidden_is_foreign, found, verdict, is_right, measurements_unchanged }, sealed))
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
fn found_lines(course: &StudyState) -> Vec<String> {
    let parameters = course.parameters();
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
    course.record.added.iter().flat_map(own).collect()
}

fn nothing_found(record: &StudyRecord) -> String {
    match record.verdict {
        Some(Verdict::NothingMissing) => "nothing is missing".to_owned(),
        _ => record.sentence.clone().unwrap_or_default(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_file_of_the_campaign_is_bundled() {
        let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("data/campaigns").join(EXAMPLE_NAME);
        let files = walkdir::WalkDir::new(&folder).into_iter().map(Result::unwrap).filter(|e| e.file_type().is_file());
        let mut there: Vec<String> =
            files.map(|e| e.path().strip_prefix(&folder).unwrap().to_str().unwrap().replace('\\', "/")).collect();
        let mut bundled: Vec<&str> = FILES.iter().map(|(name, _)| *name).collect();
        there.sort();
        bundled.sort_unstable();
        assert_eq!(bundled, there);
    }
}
