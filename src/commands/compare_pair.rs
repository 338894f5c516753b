//! `robofin compare` with two models: compares both, unfitted, with the same data, block by block.

use std::path::PathBuf;

use anyhow::{Context, Result};
use effects::CompiledModel;
use serde::Serialize;

use super::compare::CompareArgs;
use super::model_flags::ModelFlags;
use crate::console::Console;
use crate::wrong_use;
use files::folder::StagedFolder;
use files::output::FolderKind;
use lab::{Better, ErrorUnit, Paired};
use report::study::page;
use study::{Conclusion, Data, Measurements, StudyReport, pair_in_words, pair_report};

/// File that marks a result folder.
const PAIR_FILE: &str = "pair.json";
/// Kind of the result folder.
const PAIR: FolderKind = FolderKind { marker: PAIR_FILE, key: "better", names: &[("", &["report.html"])] };

/// The answer of `compare --json` with two models, and `pair.json`.
#[derive(Serialize)]
struct PairAnswer<'a> {
    models: [&'a PathBuf; 2],
    /// The better model, by the held-out data if there are any.
    better: Better,
    sentence: String,
    error_unit: ErrorUnit,
    #[serde(flatten)]
    paired: Paired,
}

/// Compares two model files with a campaign.
pub(super) fn run(args: &CompareArgs, files: [&PathBuf; 2], console: &Console) -> Result<()> {
    if !args.sections.is_empty() {
        return Err(wrong_use("--section: two models are compared in whole scans; leave it out".to_owned()));
    }
    let folder = StagedFolder::new(&args.out.beside(&args.inputs()), &PAIR)?;
    let measurements = Measurements::read(&args.campaign)?;
    let mut data = measurements.data()?;
    let library = data.library(args.own.library()?)?;
    console.step("read", data.describe());
    data.notes().iter().for_each(|note| console.step("note", note));
    let read = |file: &PathBuf| -> Result<_> {
        let flags = ModelFlags { model: Some(file.clone()), own: args.own.clone() };
        let model = data.fitting(flags.model(data.evidence().process(), &library)?, &library)?;
        let compiled = CompiledModel::new(&model, &library, data.evidence().rows())?;
        Ok((model, compiled))
    };
    let (first, second) = (read(files[0])?, read(files[1])?);
    if let Data::Scans(_, evidence) = &mut data {
        evidence.measure_simulation_errors(&first.1)?;
    }
    let models = [&first.1, &second.1];
    let paired = Paired::new(data.evidence(), models)?;
    let (better, error_unit) = (paired.deciding().better(), data.evidence().unit());
    let shown = files.map(|file| file.display().to_string());
    let sentence = pair_in_words(&shown, &paired, error_unit);
    let report = pair_report(&data, &second.0, (models, ["first model", "second model"]), &paired)?;
    let answer = PairAnswer { models: files, better, sentence, error_unit, paired };
    let conclusion = if better == Better::Second { Conclusion::Better } else { Conclusion::NotBetter };
    let report = StudyReport {
        conclusion,
        sentence: answer.sentence.clone(),
        diagnosis: serde_json::to_value(&answer)?,
        ..report
    };
    let write = |name: &str, text: String| {
        std::fs::write(folder.path().join(name), text).with_context(|| format!("{name}: cannot be written"))
    };
    write(PAIR_FILE, serde_json::to_string_pretty(&answer)?)?;
    write("report.html", page(&report))?;
    console.step("verdict", &answer.sentence);
    let place = folder.commit()?;
    console.step("written", place.display().to_string());
    console.answer(&answer)
}
