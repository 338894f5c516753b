//! `robofin diagnose`: what a model lacks, from the scans of a campaign.

use std::path::PathBuf;
use std::time::Instant;

use anyhow::{Context, Result};
use clap::Args;
use sim::effect::{Library, Model};

use super::flags::OutFlags;
use super::model_flags::ModelFlags;
use crate::console::Console;
use crate::folder::StagedFolder;
use crate::laboratory::{
    Diagnosis, DiagnosisSummary, Evidence, Finding, Fit, NextTrial, RowEvidence, ScanEvidence, Verdict, calibrate,
    next_row, next_trial, suggest, with_values,
};
use crate::study::{ReportInput, report};
use crate::study_report::page;
use crate::table::{TABLE_FILE, Table};
use crate::trial::Campaign;

/// The file by which a result folder is known.
const DIAGNOSIS_FILE: &str = "diagnosis.json";

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
    /// Seed of the draws that tell chance from effect.
    #[arg(long, value_name = "N", default_value_t = 1)]
    seed: u64,
}

/// Runs the verb.
pub(super) fn run(args: &DiagnoseArgs, console: &Console) -> Result<()> {
    let folder = StagedFolder::new(&args.out.out, DIAGNOSIS_FILE, args.out.force)?;
    let library = args.model.own.library()?;
    let started = Instant::now();
    let write = |name: &str, text: String| {
        std::fs::write(folder.path().join(name), text).with_context(|| format!("{name}: cannot be written"))
    };
    let search = |evidence: &dyn Evidence, model: &Model, fit: Fit| -> Result<(DiagnosisSummary, Diagnosis)> {
        console.step("calibrated", format!("{} simulations, {:.0} s", fit.runs, started.elapsed().as_secs_f64()));
        let bar = console.bar("effects", 100);
        let told = |_: &str, done: usize, all: usize| bar.set_position((100 * done / all.max(1)) as u64);
        let diagnosis = Diagnosis::new(evidence, (model, fit), &library, (args.seed, &told))?;
        bar.finish_and_clear();
        let title = |name: &str| library.find(name).map_or(String::new(), |effect| effect.title.clone());
        let mut summary = DiagnosisSummary::new(evidence, &diagnosis, &title)?;
        if matches!(summary.verdict, Verdict::Unknown | Verdict::Partly) {
            let suggestion = suggest(evidence, (&diagnosis.model, &diagnosis.fit), &library, args.seed)?;
            if let Some(suggestion) = suggestion {
                let file = format!("{}.toml", suggestion.name);
                write(&file, suggestion.text)?;
                console.step("suggested", format!("{}: {file}", suggestion.summary));
                summary.suggested_effect_file = Some(args.out.out.join(file).display().to_string());
            }
        }
        Ok((summary, diagnosis))
    };
    let (seed, place) = (args.seed, args.campaign.as_path());
    let (summary, diagnosis, report) = if args.campaign.join(TABLE_FILE).is_file() {
        let table = Table::read(&args.campaign)?;
        let evidence = RowEvidence::new(&table)?;
        table.notes.iter().chain(&evidence.notes).for_each(|note| console.step("note", note));
        let model = args.model.model(evidence.process(), &library)?;
        let model = evidence.scaled(model, &library).map_err(anyhow::Error::msg)?;
        let fit = calibrate(&evidence, &model, &library)?;
        let (mut summary, diagnosis) = search(&evidence, &model, fit)?;
        summary.next_trial = separating_row(&evidence, &diagnosis)?;
        let notes = table.notes.iter().chain(&evidence.notes).cloned().collect();
        let input = ReportInput {
            scans: None,
            rows: Some(&evidence),
            folder: place,
            diagnosis: &diagnosis,
            summary: &summary,
            seed,
            notes,
        };
        let report = report(&input)?;
        (summary, diagnosis, report)
    } else {
        let campaign = Campaign::read(&args.campaign)?;
        let mut evidence = ScanEvidence::new(&campaign.trials, None)?;
        console.step("read", format!("{} trials, {} scans", campaign.trials.len(), evidence.views.len()));
        let model = args.model.model(evidence.process(), &library)?;
        let fit = first_fit(&mut evidence, &model, &library)?;
        let (mut summary, diagnosis) = search(&evidence, &model, fit)?;
        summary.next_trial = separating_trial(&evidence, &diagnosis)?;
        let scans = Some((&campaign, &evidence));
        let input = ReportInput {
            scans,
            rows: None,
            folder: place,
            diagnosis: &diagnosis,
            summary: &summary,
            seed,
            notes: Vec::new(),
        };
        let report = report(&input)?;
        (summary, diagnosis, report)
    };
    write(DIAGNOSIS_FILE, serde_json::to_string_pretty(&summary)?)?;
    write("model.toml", diagnosis.model.to_text(&library))?;
    write("report.html", page(&report))?;
    describe(&summary, console);
    let place = folder.commit()?;
    console.step("written", format!("{} after {:.0} s", place.display(), started.elapsed().as_secs_f64()));
    console.answer(&summary)
}

/// The row that would tell the two most probable effects apart, where the data do not.
fn separating_row(evidence: &RowEvidence, diagnosis: &Diagnosis) -> Result<Option<NextTrial>> {
    let Some([first, second, ..]) = diagnosis.rounds.first().map(|round| round.findings.as_slice()) else {
        return Ok(None);
    };
    if !first.is_sound || diagnosis.verdict == Verdict::Identified {
        return Ok(None);
    }
    let rival = |finding: &'_ Finding| (finding.suspect.name().to_owned(), finding.suspect.fit.clone());
    let ((first, one), (second, other)) = (rival(first), rival(second));
    Ok(next_row(evidence, ((&first, &one), (&second, &other)))?)
}

/// The trial that would tell the two most probable effects apart, where the data do not.
fn separating_trial(evidence: &ScanEvidence, diagnosis: &Diagnosis) -> Result<Option<NextTrial>> {
    if diagnosis.verdict != Verdict::Ambiguous {
        return Ok(None);
    }
    let Some([first, second, ..]) = diagnosis.rounds.last().map(|round| round.findings.as_slice()) else {
        return Ok(None);
    };
    let rival = |finding: &'_ Finding| (finding.suspect.name().to_owned(), finding.suspect.fit.clone());
    let ((first, one), (second, other)) = (rival(first), rival(second));
    Ok(next_trial(evidence, ((&first, &one), (&second, &other)))?)
}

/// Fits the model, with the instrument's blur found in between.
fn first_fit(evidence: &mut ScanEvidence, model: &Model, library: &Library) -> Result<Fit> {
    let first = calibrate(evidence, model, library)?;
    evidence.find_blur(&first.model)?;
    let second = calibrate(evidence, &with_values(model, &first), library)?;
    Ok(second)
}

fn describe(summary: &DiagnosisSummary, console: &Console) {
    console.step("verdict", &summary.sentence);
    for step in &summary.waterfall {
        let held_out = step
            .evaluation_rms_um
            .map_or(String::new(), |rms| format!(", {rms:.2} {} held out", summary.error_unit.symbol()));
        console.step(
            "error",
            format!("{}: {:.2} {}{held_out}", step.step, step.calibration_rms_um, summary.error_unit.symbol()),
        );
    }
    console.step("floor", format!("{:.2} {}", summary.noise_floor_um, summary.error_unit.symbol()));
    for effect in &summary.suspects {
        let values: Vec<String> =
            effect.parameters.iter().map(|(name, p)| format!("{name} = {:.4} {}", p.value, p.unit)).collect();
        console.step(
            "suspect",
            format!(
                "{}: {:.3}, gain {:.1}, chance {:.3}; {}",
                effect.name,
                effect.probability,
                effect.gain,
                effect.chance,
                values.join(", ")
            ),
        );
    }
}
