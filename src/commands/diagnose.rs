//! `robofin diagnose`: finds the effects that a model lacks, from the scans of a campaign.

use std::path::PathBuf;
use std::time::Instant;

use anyhow::{Context, Result};
use clap::Args;

use super::flags::{OutFlags, SEEDS};
use super::model_flags::ModelFlags;
use super::values::whole;
use crate::console::Console;
use files::folder::StagedFolder;
use files::output::FolderKind;
use lab::{Diagnosis, DiagnosisSummary, Order};
use report::study::page;
use study::{MODEL_WITH_PROPOSAL, Measurements, NEXT_TRIAL_NAMES as NEXT, ReportInput};
use study::{proposal, report, summary, write_next_trial, write_proposal};

/// File that marks a result folder.
const DIAGNOSIS_FILE: &str = "diagnosis.json";
/// Kind of the result folder.
const DIAGNOSIS: FolderKind = FolderKind {
    marker: DIAGNOSIS_FILE,
    key: "verdict",
    names: &[
        ("", &["model.toml", "report.html", MODEL_WITH_PROPOSAL]),
        ("effects/", &["*.toml"]),
        NEXT[0],
        NEXT[1],
        NEXT[2],
    ],
};

#[derive(Debug, Args)]
#[command(after_help = "Example:\n  robofin diagnose trials --out out/diagnosis\n  \
                  robofin diagnose trials --model model.toml --effects my-effects --out out/diagnosis --json")]
pub(super) struct DiagnoseArgs {
    /// Folder of trial folders, one trial folder, or a folder with a table.toml.
    campaign: PathBuf,
    #[command(flatten)]
    out: OutFlags,
    #[command(flatten)]
    model: ModelFlags,
    /// Seed of the permutations in significance tests.
    #[arg(long, value_name = "N", default_value_t = 1, allow_negative_numbers = true, value_parser = whole::<u64>(SEEDS))]
    seed: u64,
}

/// Runs the verb.
pub(super) fn run(args: &DiagnoseArgs, console: &Console) -> Result<()> {
    let folder = StagedFolder::new(&args.out.beside(&args.model.inputs(&args.campaign)), &DIAGNOSIS)?;
    let (library, started) = (args.model.own.library()?, Instant::now());
    let measurements = Measurements::read(&args.campaign)?;
    let mut data = measurements.data()?;
    let library = data.library(library)?;
    console.step("read", data.describe());
    data.notes().iter().for_each(|note| console.step("note", note));
    let model = data.fitting(args.model.model(data.evidence().process(), &library)?, &library)?;
    let start = data.start(&model, &library)?;
    let calibration = data.calibrated((&model, &start), &library, (Order::Joint, &|_| {}))?;
    let (model, fit) = (&calibration.model, calibration.last().fit.clone());
    console.step("calibrated", format!("{} simulations, {:.0} s", fit.runs, started.elapsed().as_secs_f64()));
    let progress = console.progress("effects");
    let on_progress = |what: &str, done: usize, all: usize| progress.report(what, done, all);
    let diagnosis = Diagnosis::new(data.evidence(), (model, fit), &library, (args.seed, &on_progress))?;
    drop(progress);
    let proposal = proposal(&data, &diagnosis, &library, args.seed)?;
    let summary = DiagnosisSummary { proposal, ..summary(&mut data, &diagnosis, &library)? };
    if let Some(proposal) = &summary.proposal {
        write_proposal(proposal, folder.path())?.into_iter().for_each(|(what, text)| console.step(what, text));
    }
    if let Some(next) = &summary.next_trial {
        write_next_trial(next, folder.path())?.into_iter().for_each(|(what, text)| console.step(what, text));
    }
    describe(&summary, console);
    data.free_nuisances();
    let input = ReportInput {
        scans: data.scans(),
        rows: data.rows(),
        folder: data.folder(),
        diagnosis: &diagnosis,
        summary: &summary,
        seed: args.seed,
        notes: data.notes(),
        findings: data.findings(),
    };
    let report = report(&input)?;
    write(&folder, DIAGNOSIS_FILE, &serde_json::to_string_pretty(&report.diagnosis)?)?;
    write(&folder, "model.toml", &diagnosis.model.to_text(&library))?;
    write(&folder, "report.html", &page(&report))?;
    let place = folder.commit()?;
    console.step("written", format!("{} after {:.0} s", place.display(), started.elapsed().as_secs_f64()));
    console.answer(&report.diagnosis)
}

fn write(folder: &StagedFolder, name: &str, text: &str) -> Result<()> {
    std::fs::write(folder.path().join(name), text).with_context(|| format!("{name}: cannot be written"))
}

fn describe(summary: &DiagnosisSummary, console: &Console) {
    let unit = summary.error_unit;
    console.step("verdict", &summary.sentence);
    summary.waterfall.iter().for_each(|step| console.step("error", step.shown(unit)));
    console.step("floor", unit.shown(summary.noise_floor));
    summary.suspects.iter().for_each(|suspect| console.step("suspect", suspect.shown()));
    summary.unfitted.iter().for_each(|one| console.step("", format!("{}: {}", one.name, one.reason)));
}
