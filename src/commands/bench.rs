//! `robofin bench`: how often a diagnosis is right.

use std::path::{Path, PathBuf};

use anyhow::{Context, Result};
use clap::{Args, Subcommand, ValueEnum};
use effects::Library;
use serde::Serialize;
use serde::de::DeserializeOwned;

use super::flags::SEEDS;
use super::values::whole;
use crate::console::Console;
use benchmark::{Case, Family, Outcome, Sized, Summary, cases, run as diagnosed};
use files::folder::{check_writable, write_file};
use files::json_file::read_json;
use files::output::FolderKind;
use virtual_lab::Size;

/// The folder of a benchmark: its table, and a file for each finished case.
const BENCHMARK: FolderKind =
    FolderKind { marker: "benchmark.json", key: "outcomes", names: &[("", &["benchmark.md", "*-*.json"])] };
/// Cases of each family that are accepted. One takes about a minute, so that so many of all eight take eight weeks.
const CASES: [u64; 2] = [1, 10_000];

#[derive(Debug, Args)]
#[command(after_help = "Example:\n  robofin bench diagnose --out out/bench --cases 4")]
pub(super) struct BenchArgs {
    #[command(subcommand)]
    action: Action,
}

#[derive(Debug, Subcommand)]
enum Action {
    /// Diagnose synthetic campaigns with known answers, and count how often the answer is right.
    #[command(after_help = "Examples:\n  robofin bench diagnose --out out/bench --cases 4\n  \
                            robofin bench diagnose --out out/bench --families N,S --cases 20 --json\n\n\
                            A folder that holds finished cases is gone on with.")]
    Diagnose(DiagnoseArgs),
}

#[derive(Debug, Args)]
struct DiagnoseArgs {
    /// Folder for the cases and the table; finished cases in it are kept.
    #[arg(long, value_name = "DIR")]
    out: PathBuf,
    /// Families: N nothing hidden, S one effect, A absorbed, D two, U unknown, M scanner, B sanding, P two equal passes.
    #[arg(long, value_enum, value_delimiter = ',', default_values_t = FamilyFlag::ALL)]
    families: Vec<FamilyFlag>,
    /// Cases of each family.
    #[arg(long, value_name = "N", default_value_t = 8, allow_negative_numbers = true, value_parser = whole::<usize>(CASES))]
    cases: usize,
    /// Seed of workpieces, laws, noise and paths.
    #[arg(long, value_name = "SEED", default_value_t = 1, allow_negative_numbers = true, value_parser = whole::<u64>(SEEDS))]
    seed: u64,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
#[value(rename_all = "UPPER")]
enum FamilyFlag {
    N,
    S,
    A,
    D,
    U,
    M,
    B,
    P,
}

impl FamilyFlag {
    const ALL: [Self; 8] = [Self::N, Self::S, Self::A, Self::D, Self::U, Self::M, Self::B, Self::P];
}

impl std::fmt::Display for FamilyFlag {
    fn fmt(&self, f: &mut std::fmt::Formatter) -> std::fmt::Result {
        write!(f, "{self:?}")
    }
}

/// The answer of `bench diagnose --json`.
#[derive(Serialize)]
struct Answer<'a> {
    summary: &'a Summary,
    outcomes: &'a [Outcome],
}

/// Runs the verb.
pub(super) fn run(args: &BenchArgs, console: &Console) -> Result<()> {
    let Action::Diagnose(args) = &args.action;
    let library = Library::builtin();
    let chosen: Vec<Family> = FamilyFlag::ALL
        .iter()
        .zip(Family::ALL)
        .filter(|(flag, _)| args.families.contains(flag))
        .map(|(_, family)| family)
        .collect();
    let cases = cases(&chosen, args.cases, args.seed, library);
    BENCHMARK.check_continued(&args.out)?;
    check_writable(&args.out)?;
    let mut outcomes: Vec<Outcome> = Vec::new();
    for (number, case) in cases.iter().enumerate() {
        match outcome(case, &args.out, library) {
            Ok(outcome) => {
                let word = if outcome.is_right() { "right" } else { "wrong" };
                let named = outcome.named.join(" + ");
                let hidden = case.hidden.join(" + ");
                console.step(
                    &case.id(),
                    format!(
                        "{}/{}: hidden [{hidden}], {:?} [{named}], {word}, {:.0} s",
                        number + 1,
                        cases.len(),
                        outcome.verdict,
                        outcome.seconds
                    ),
                );
                outcomes.push(outcome);
            }
            Err(error) => console.step(&case.id(), format!("not made: {error:#}")),
        }
    }
    outcomes.extend(unasked(&outcomes, &args.out, library)?);
    let summary = Summary::new(&outcomes);
    let table = summary.to_markdown(&outcomes);
    let answer = Answer { summary: &summary, outcomes: &outcomes };
    write_file(&args.out.join(BENCHMARK.marker), &serde_json::to_vec_pretty(&answer)?)?;
    write_file(&args.out.join("benchmark.md"), table.as_bytes())?;
    console.step("singles", summary.large_singles.to_string());
    console.step("alarms", summary.false_alarms.to_string());
    console.step("names", summary.false_names.to_string());
    console.step("written", args.out.join("benchmark.md").display().to_string());
    console.answer(&answer)
}

/// Campaigns without an effect from which the sizes of effects were taken, beyond those of family N.
fn unasked(outcomes: &[Outcome], folder: &Path, library: &Library) -> Result<Vec<Outcome>> {
    let mut known: Vec<String> =
        outcomes.iter().filter(|o| o.case.hidden.is_empty()).map(|o| o.case.design.id()).collect();
    let sized = outcomes.iter().filter(|outcome| matches!(outcome.case.size, Sized::Detectable(_)));
    let mut clean = Vec::new();
    for case in sized.map(|outcome| outcome.case.clean()) {
        if !known.contains(&case.design.id()) {
            known.push(case.design.id());
            clean.push(outcome(&case, folder, library)?);
        }
    }
    Ok(clean)
}

/// A case's outcome, from its file where it was finished before.
fn outcome(case: &Case, folder: &Path, library: &Library) -> Result<Outcome> {
    let name = if case.hidden.is_empty() { "clean".to_owned() } else { case.id() };
    let file = folder.join(format!("{name}-{}.json", case.design.id()));
    let known: Option<Outcome> = read(&file)?;
    let is_same = |known: &Outcome| known.case == *case || case.hidden.is_empty();
    if let Some(known) = known.filter(is_same) {
        return Ok(Outcome { case: case.clone(), ..known });
    }
    let detectable = match case.size {
        Sized::Detectable(_) => outcome(&case.clean(), folder, library)?.detectable,
        Sized::Visible => Vec::new(),
    };
    let outcome = diagnosed(case, &detectable, Size::Small, library)?;
    write_file(&file, &serde_json::to_vec_pretty(&outcome)?)?;
    Ok(outcome)
}

fn read<T: DeserializeOwned>(file: &Path) -> Result<Option<T>> {
    if file.symlink_metadata().is_err() {
        return Ok(None);
    }
    read_json(file, "a result of this benchmark").context("remove it to have the case made again").map(Some)
}
