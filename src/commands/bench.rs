//! `robofin bench`: counts how often a study is right.

use std::ffi::OsString;
use std::fs;
use std::path::{Path, PathBuf};

use anyhow::{Context, Result};
use clap::{Args, Subcommand, ValueEnum};
use effects::Library;
use serde::Serialize;
use serde::de::DeserializeOwned;

use super::flags::SEEDS;
use super::values::whole;
use crate::console::Console;
use benchmark::{Case, Family, Outcome, Summary, cases, reliability_svg, run as studied, sample};
use files::folder::{check_writable, write_file};
use files::json_file::read_json;
use files::output::{FolderKind, UNFINISHED};
use virtual_lab::Size;

/// Kind of a benchmark's folder: tables, picture, and a file for each finished case.
const BENCHMARK: FolderKind = FolderKind {
    marker: "benchmark.json",
    key: "outcomes",
    names: &[("", &["benchmark.md", "reliability.svg", "*-*.json"])],
};
/// Accepted numbers of cases in each family. One case takes a minute or two, so the greatest number takes months.
const CASES: [u64; 2] = [1, 10_000];
/// Size of the campaigns.
const SIZE: Size = Size::Small;

#[derive(Debug, Args)]
#[command(after_help = "Example:\n  robofin bench diagnose --out out/bench --cases 4")]
pub(super) struct BenchArgs {
    #[command(subcommand)]
    action: Action,
}

#[derive(Debug, Subcommand)]
enum Action {
    /// Study synthetic campaigns with known answers, and count how often the answer is right.
    #[command(after_help = "Examples:\n  robofin bench diagnose --out out/bench --cases 4\n  \
                            robofin bench diagnose --out out/bench --cases 60 --limit 100 --seed 7\n  \
                            robofin bench diagnose --out out/bench --families N,S --cases 20 --json\n  \
                            robofin bench diagnose --out out/bench --cases 60 --part 2/8\n\n\
                            Finished cases in the folder are kept, and the others are run.")]
    Diagnose(DiagnoseArgs),
}

#[derive(Debug, Args)]
struct DiagnoseArgs {
    /// Folder for the cases and the tables; finished cases in it are kept.
    #[arg(long, value_name = "DIR")]
    out: PathBuf,
    /// Families: N nothing hidden, S one effect, L one left out of the library, U outside it, H hard front ends, A
    /// absorbed, D two, P two equal passes, W a few effects for their detectable size.
    #[arg(long, value_enum, value_delimiter = ',', default_values_t = FamilyFlag::ALL)]
    families: Vec<FamilyFlag>,
    /// Cases of each family.
    #[arg(long, value_name = "N", default_value_t = 8, allow_negative_numbers = true, value_parser = whole::<usize>(CASES))]
    cases: usize,
    /// At most this many of all these cases, drawn evenly from each family.
    #[arg(long, value_name = "N", allow_negative_numbers = true, value_parser = whole::<usize>(CASES))]
    limit: Option<usize>,
    /// Only the K-th, the (K+N)-th and so on of these cases, without the tables. Machines or processes that share the
    /// folder run one part each; a run without this option then writes the tables.
    #[arg(long, value_name = "K/N", value_parser = part)]
    part: Option<Part>,
    /// Seed of workpieces, laws, noise and paths, and of the draw of --limit.
    #[arg(long, value_name = "SEED", default_value_t = 1, allow_negative_numbers = true, value_parser = whole::<u64>(SEEDS))]
    seed: u64,
}

/// One part of the cases, counted from one.
#[derive(Clone, Copy, Debug)]
struct Part {
    number: usize,
    count: usize,
}

fn part(text: &str) -> std::result::Result<Part, String> {
    let numbers = text.split_once('/').and_then(|(k, n)| Some((k.parse().ok()?, n.parse().ok()?)));
    match numbers {
        Some((number, count)) if (1..=count).contains(&number) => Ok(Part { number, count }),
        _ => Err("expected K/N with whole numbers and 1 ≤ K ≤ N, as in 2/8".into()),
    }
}

#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
#[value(rename_all = "UPPER")]
enum FamilyFlag {
    N,
    S,
    L,
    U,
    H,
    A,
    D,
    P,
    W,
}

impl FamilyFlag {
    const ALL: [Self; 9] = [Self::N, Self::S, Self::L, Self::U, Self::H, Self::A, Self::D, Self::P, Self::W];
}

impl std::fmt::Display for FamilyFlag {
    fn fmt(&self, f: &mut std::fmt::Formatter) -> std::fmt::Result {
        write!(f, "{self:?}")
    }
}

/// The answer of `bench diagnose --json`.
#[derive(Serialize)]
struct Answer<'a> {
    seed: u64,
    summary: &'a Summary,
    /// Cases that the virtual laboratory could not make, with the reasons.
    not_made: &'a [(String, String)],
    outcomes: &'a [Outcome],
}

/// Runs the verb.
pub(super) fn run(args: &BenchArgs, console: &Console) -> Result<()> {
    let Action::Diagnose(args) = &args.action;
    let library = Library::builtin();
    BENCHMARK.check_continued(&args.out)?;
    check_writable(&args.out)?;
    let cases = args.cases(library);
    let (mut outcomes, mut not_made): (Vec<Outcome>, Vec<(String, String)>) = Default::default();
    for (number, case) in cases.iter().enumerate() {
        match outcome(case, &args.out, library) {
            Ok(outcome) => {
                console.step(&case.id(), format!("{}/{}: {}", number + 1, cases.len(), line(&outcome)));
                outcomes.push(outcome);
            }
            Err(error) => {
                console.step(&case.id(), format!("not made: {error:#}"));
                not_made.push((case.id(), format!("{error:#}")));
            }
        }
    }
    if args.part.is_some() {
        console
            .step("finished", format!("{} cases of this part; without --part the tables are written", outcomes.len()));
        return console.answer(&outcomes);
    }
    let summary = Summary::new(&outcomes);
    let answer = Answer { seed: args.seed, summary: &summary, not_made: &not_made, outcomes: &outcomes };
    let write = |name: &str, text: &[u8]| write_file(&args.out.join(name), text);
    write(BENCHMARK.marker, &serde_json::to_vec_pretty(&answer)?)?;
    write("benchmark.md", summary.to_markdown(&outcomes, (library, SIZE)).as_bytes())?;
    write("reliability.svg", reliability_svg(&summary.reliability).as_bytes())?;
    let study = &summary.all.study;
    console.step("right", study.right.to_string());
    console.step("class", study.class.to_string());
    console.step("wrong", study.wrong_name.to_string());
    console.step("written", args.out.join("benchmark.md").display().to_string());
    console.answer(&answer)
}

impl DiagnoseArgs {
    /// Returns the requested cases.
    fn cases(&self, library: &Library) -> Vec<Case> {
        let flags = FamilyFlag::ALL.iter().zip(Family::ALL);
        let chosen: Vec<Family> =
            flags.filter(|(flag, _)| self.families.contains(flag)).map(|(_, family)| family).collect();
        let all = cases(&chosen, self.cases, self.seed, library);
        let cases = sample(all, self.limit.unwrap_or(usize::MAX), self.seed);
        let Part { number, count } = self.part.unwrap_or(Part { number: 1, count: 1 });
        cases.into_iter().skip(number - 1).step_by(count).collect()
    }
}

/// Describes an outcome in one line.
fn line(outcome: &Outcome) -> String {
    let (hidden, said) = (outcome.case.hidden.join(" + "), &outcome.said);
    let word = outcome.judgement.word();
    format!("hidden [{hidden}], {} [{}], {word}, {:.0} s", said.verdict_word(), said.names(), outcome.seconds)
}

/// Returns the outcome of a case, from its file if it is finished already.
fn outcome(case: &Case, folder: &Path, library: &Library) -> Result<Outcome> {
    let file = folder.join(format!("{}-{}.json", case.id(), case.design.id()));
    let known: Option<Outcome> = read(&file)?;
    if let Some(known) = known.filter(|known| known.case == *case) {
        return Ok(known);
    }
    let scratch = scratch(folder, case);
    let outcome = studied(case, SIZE, library, &scratch);
    if scratch.is_dir() {
        fs::remove_dir_all(&scratch).with_context(|| format!("{}: cannot be removed", scratch.display()))?;
    }
    let outcome = outcome?;
    write_file(&file, &serde_json::to_vec_pretty(&outcome)?)?;
    Ok(outcome)
}

/// Returns the folder of a case's trials during the study, beside the benchmark's folder.
fn scratch(folder: &Path, case: &Case) -> PathBuf {
    let mut name: OsString = folder.file_name().unwrap_or_default().to_owned();
    name.push(format!(".{}{UNFINISHED}", case.id()));
    folder.with_file_name(name)
}

fn read<T: DeserializeOwned>(file: &Path) -> Result<Option<T>> {
    if file.symlink_metadata().is_err() {
        return Ok(None);
    }
    read_json(file, "a result of this benchmark").context("remove it to run the case again").map(Some)
}
