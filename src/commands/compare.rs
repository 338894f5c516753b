//! `robofin compare`: shows where a model fails, without fitting its physics.

use std::path::{Path, PathBuf};

use anyhow::{Context, Result};
use clap::Args;
use effects::CompiledModel;
use sdf_bake::PixelGrid;

use super::compare_pair;
use super::flags::{OutFlags, SEEDS};
use super::model_flags::{ModelFlags, OwnFlags};
use super::values::whole;
use crate::console::Console;
use crate::wrong_use;
use files::folder::StagedFolder;
use files::output::FolderKind;
use lab::{Evidence, RowEvidence, ScanEvidence};
use report::study::page;
use study::{Asked, Comparison, aligned, compare_rows, compare_scans};
use study::{Direction, StudyReport};
use trials::table::{TABLE_FILE, Table};
use trials::trial::Campaign;

/// File that marks a result folder.
const COMPARISON_FILE: &str = "comparison.json";
/// Kind of the result folder.
const COMPARISON: FolderKind = FolderKind { marker: COMPARISON_FILE, key: "agrees", names: &[("", &["report.html"])] };
/// Number of covariates shown on the console.
const SHOWN_COVARIATES: usize = 5;

#[derive(Debug, Args)]
#[command(after_help = "Example:\n  robofin compare trials --model model.toml --out out/comparison\n  \
                  robofin compare trials --model one.toml --model other.toml --out out/pair\n  \
                  robofin compare trials --model model.toml --section x=20mm --section x=70mm --section x=120mm --out out/comparison --json")]
pub(super) struct CompareArgs {
    /// Folder of trial folders, one trial folder, or a folder with a table.toml.
    pub(super) campaign: PathBuf,
    #[command(flatten)]
    pub(super) out: OutFlags,
    /// Model file: base law, effects and their parameters [default: the base law of the process]. Two compare both with
    /// the same data, block by block.
    #[arg(long = "model", value_name = "FILE")]
    models: Vec<PathBuf>,
    #[command(flatten)]
    pub(super) own: OwnFlags,
    /// Section through all scans: across the bead at an x, such as x=20mm, or along it at a y; may be repeated.
    #[arg(long = "section", value_name = "x=MM", value_parser = parse_section)]
    pub(super) sections: Vec<Direction>,
    /// Seed of the permutations in tests for structure.
    #[arg(
        long,
        value_name = "N",
        default_value_t = 1,
        allow_negative_numbers = true,
        value_parser = whole::<u64>(SEEDS)
    )]
    seed: u64,
}

impl CompareArgs {
    /// Returns the flags of the only model, with the folder of the user's own effects.
    fn model(&self) -> ModelFlags {
        ModelFlags { model: self.models.first().cloned(), own: self.own.clone() }
    }

    /// Returns all input paths.
    pub(super) fn inputs(&self) -> Vec<&Path> {
        let own = self.own.effects.iter().chain(&self.models).map(PathBuf::as_path);
        std::iter::once(self.campaign.as_path()).chain(own).collect()
    }
}

/// Runs the verb.
pub(super) fn run(args: &CompareArgs, console: &Console) -> Result<()> {
    match &args.models[..] {
        [] | [_] => run_one(args, console),
        [first, second] => compare_pair::run(args, [first, second], console),
        _ => Err(wrong_use(format!("--model: {} are given, and one or two are accepted", args.models.len()))),
    }
}

fn run_one(args: &CompareArgs, console: &Console) -> Result<()> {
    let folder = StagedFolder::new(&args.out.beside(&args.inputs()), &COMPARISON)?;
    let asked = Asked { folder: &args.campaign, lines: &args.sections, seed: args.seed };
    let is_table = args.campaign.join(TABLE_FILE).is_file();
    let (comparison, report) =
        if is_table { of_rows(args, &asked, console)? } else { of_scans(args, &asked, console)? };
    let write = |name: &str, text: String| {
        std::fs::write(folder.path().join(name), text).with_context(|| format!("{name}: cannot be written"))
    };
    write(COMPARISON_FILE, serde_json::to_string_pretty(&comparison)?)?;
    write("report.html", page(&report))?;
    describe(&comparison, console);
    let place = folder.commit()?;
    console.step("written", place.display().to_string());
    console.answer(&comparison)
}

fn of_scans(args: &CompareArgs, asked: &Asked, console: &Console) -> Result<(Comparison, StudyReport)> {
    let library = args.own.library()?;
    let campaign = aligned(Campaign::read(&args.campaign)?)?;
    let maps = campaign.trials.iter().map(|trial| &trial.scans.before.pixels);
    for pixels in maps {
        args.sections.iter().try_for_each(|section| check(*section, pixels))?;
    }
    let mut evidence = ScanEvidence::new(&campaign.trials, None)?;
    console.step("read", format!("{} trials, {} scans", campaign.trials.len(), evidence.views.len()));
    campaign.notes().iter().chain(&evidence.noise_notes()).for_each(|note| console.step("note", note));
    let model = args.model().model(evidence.process(), &library)?;
    let model = CompiledModel::new(&model, &library, evidence.rows())?;
    evidence.measure_simulation_errors(&model)?;
    Ok(compare_scans((&campaign, &evidence), &model, asked)?)
}

fn of_rows(args: &CompareArgs, asked: &Asked, console: &Console) -> Result<(Comparison, StudyReport)> {
    if !args.sections.is_empty() {
        return Err(wrong_use("--section: a table has no sections".to_owned()));
    }
    let table = Table::read(&args.campaign)?;
    let evidence = RowEvidence::new(&table)?;
    let library = evidence.library(&args.own.library()?).map_err(anyhow::Error::msg)?;
    table.notes.iter().chain(&evidence.notes).for_each(|note| console.step("note", note));
    let model = args.model().model(evidence.process(), &library)?;
    let model = evidence.scaled(model, &library).map_err(anyhow::Error::msg)?;
    Ok(compare_rows(&evidence, &CompiledModel::new(&model, &library, evidence.rows())?, asked)?)
}

/// Parses `x=20mm` or `y=-3mm`.
fn parse_section(text: &str) -> Result<Direction, String> {
    let bad = || "x=20mm or y=-3mm is expected".to_owned();
    let (axis, place) = text.split_once('=').ok_or_else(bad)?;
    let number = place.trim().trim_end_matches("mm").trim();
    let place = number.parse::<f64>().ok().filter(|place| place.is_finite()).ok_or_else(bad)? * 1e-3;
    match axis.trim() {
        "x" => Ok(Direction::Across(place)),
        "y" => Ok(Direction::Along(place)),
        _ => Err(bad()),
    }
}

/// Refuses a section outside the map.
fn check(section: Direction, pixels: &PixelGrid) -> Result<()> {
    let last = pixels.position(pixels.nx - 1, pixels.ny - 1);
    let (axis, place, low, high) = match section {
        Direction::Across(x) => ("x", x, pixels.origin.x, last.x),
        Direction::Along(y) => ("y", y, pixels.origin.y, last.y),
        Direction::AlongCrest => return Ok(()),
    };
    if (low - 0.5 * pixels.pitch..=high + 0.5 * pixels.pitch).contains(&place) {
        return Ok(());
    }
    let (place, low, high) = (place * 1e3, low * 1e3, high * 1e3);
    Err(wrong_use(format!("--section {axis}={place:.2}mm: the scans reach from {axis} = {low:.2} mm to {high:.2} mm")))
}

fn describe(comparison: &Comparison, console: &Console) {
    console.step(if comparison.agrees { "agrees" } else { "differs" }, &comparison.sentence);
    for test in &comparison.failures.tests {
        let word = if test.rejects { "structure" } else { "none found" };
        console.step("test", format!("{}: {:.2}, p {:.3}, {word}", test.name, test.statistic, test.p_value));
    }
    comparison.noise.iter().for_each(|noise| console.step("noise", noise.shown()));
    for scan in &comparison.scans {
        let volume = scan.volume_mm3.map_or(String::new(), |[measured, sigma, simulated]| {
            format!(", removed {measured:.2} ± {sigma:.2} mm³, simulated {simulated:.2} mm³")
        });
        let overlap = scan
            .intersection_over_union
            .map_or(String::new(), |overlap| format!(", exposed area overlaps by {:.1} %", 100.0 * overlap));
        let errors = format!("{:.2} µm, noise alone {:.2} µm", scan.rms_um, scan.noise_floor_um);
        console.step("scan", format!("{}: {errors}{volume}{overlap}", scan.pass));
    }
    for covariate in comparison.failures.covariates.iter().take(SHOWN_COVARIATES) {
        let (share, drop) = (100.0 * covariate.share, 100.0 * covariate.drop);
        let p = covariate.p_value_of_all;
        console.step(
            "covariate",
            format!("{}: explains {share:.0} %, {drop:.0} % alone beside the others, p {p:.3}", covariate.name),
        );
    }
}
