//! The command line: one verb per file. A verb parses, calls the libraries and reports.

mod backend_flags;
mod backends;
mod bake;
mod bead_flags;
mod bench;
mod calibrate;
mod compare;
mod compare_pair;
mod completions;
mod convert;
mod dataset;
mod dataset_image;
mod dataset_images;
mod dataset_item;
mod demo;
mod diagnose;
mod effects;
mod faults;
mod flags;
mod item_flags;
mod ledger;
mod man;
mod model_flags;
mod path;
mod press;
mod render;
mod sensor_flags;
mod simulate;
mod study;
mod trial;
mod trial_files;
mod try_effect;
mod validate;
mod validate_images;
mod validate_set;
mod values;
mod weld;
mod workbench;

use std::ffi::OsString;

use anyhow::Result;
use clap::{ArgMatches, CommandFactory, FromArgMatches, Parser, Subcommand};

use lab::LabError;
use serde::Serialize;
use trials::trial::{Finding, TrialError};

use crate::console::Console;
use crate::{in_full, interrupt, is_wrong_use};
use files::named_file;

/// Accepted numbers of threads.
const THREADS: [u64; 2] = [1, 1024];

/// Make welded workpieces, bake them into signed distance fields, grind them in simulation.
#[derive(Debug, Parser)]
#[command(name = "robofin", version, max_term_width = 110)]
struct Cli {
    /// Print the result as one JSON object on standard output; text for people goes to standard error anyway.
    #[arg(long, global = true)]
    json: bool,
    /// Worker threads; the results do not depend on it [default: all cores].
    #[arg(
        long,
        global = true,
        value_name = "N",
        allow_negative_numbers = true,
        value_parser = values::whole::<usize>(THREADS)
    )]
    threads: Option<usize>,
    /// Let the manifest of a trial or table name files outside its own folder.
    #[arg(long, global = true)]
    allow_outside: bool,
    #[command(subcommand)]
    verb: Verb,
}

#[derive(Debug, Subcommand)]
enum Verb {
    /// The whole chain on the bundled part: weld, bake, grind, draw, report.
    Demo(demo::DemoArgs),
    /// Weld a part: place a curve, sweep a bead, bake, write an asset folder.
    Weld(weld::WeldArgs),
    /// Bake meshes, or folders of them, into NanoVDB signed distance fields.
    Bake(bake::BakeArgs),
    /// Simulate a trial as it was run, or grind the weld of an asset.
    Simulate(simulate::SimulateArgs),
    /// Plan a tool path along a weld or over a patch of an asset.
    Path(path::PathArgs),
    /// Write a scan or a robot's program in another format, or report what is in it.
    Convert(convert::ConvertArgs),
    /// Begin a trial from its files and check it; make synthetic trials in which effects are hidden.
    Trial(trial::TrialArgs),
    /// Press a tool into a part and print the force, the patch and the pressures.
    Press(press::PressArgs),
    /// Draw an asset or a field from its distance field.
    Render(render::RenderArgs),
    /// Weld folders of parts into a data set of thousands of assets; or `images`, labelled pictures of coated ones.
    Dataset(Box<dataset::DatasetArgs>),
    /// Make one item of a data set.
    #[command(hide = true)]
    DatasetItem(dataset_item::DatasetItemArgs),
    /// Make one image of a set, or what it needs.
    #[command(hide = true)]
    DatasetImage(dataset_image::DatasetImageArgs),
    /// Open every file of an asset, or of a data set, and compare it with the others.
    Validate(validate::ValidateArgs),
    /// Fit a model to a campaign, step by step from the base law to its last effect.
    Calibrate(calibrate::CalibrateArgs),
    /// Report where a model fails on a campaign, without fitting it.
    Compare(compare::CompareArgs),
    /// Find out which effect a model lacks, from the scans of a campaign.
    Diagnose(diagnose::DiagnoseArgs),
    /// Try one hypothesis, a formula or an effect, beside the current model of a campaign, and keep a ledger of it.
    Try(Box<try_effect::TryArgs>),
    /// Show what was tried on a campaign, or return to an earlier model.
    Ledger(ledger::LedgerArgs),
    /// Compare, calibrate, diagnose, add what is missing and calibrate again, until nothing more can be found.
    Study(study::StudyArgs),
    /// Look where a model fails and try causes, on a page of this machine.
    Workbench(workbench::WorkbenchArgs),
    /// Count how often a diagnosis is right, on synthetic campaigns with known answers.
    Bench(bench::BenchArgs),
    /// List, show and check laws and effects; add them to a model or remove them.
    Effects(effects::EffectsArgs),
    /// List the devices that can compute, and check them against the CPU.
    Backends(backends::BackendsArgs),
    /// Print a script that completes verbs and flags in a shell.
    Completions(completions::CompletionsArgs),
    /// Print the manual page of the program or of a verb.
    Man(man::ManArgs),
}

/// Parses a command line and runs the verb. Returns the exit code: 0 success, 1 failure, 2 wrong use.
pub fn run(words: Vec<OsString>) -> u8 {
    let parsed = Cli::command().try_get_matches_from(&words);
    let matches = parsed.unwrap_or_else(|error| faults::refuse(&Cli::command(), &words, error));
    let cli = Cli::from_arg_matches(&matches).unwrap_or_else(|error| error.exit());
    let console = Console::new(cli.json);
    interrupt::listen();
    let ended = start(cli, &matches, &console);
    interrupt::wait_if_ending();
    match ended {
        Ok(()) => 0,
        Err(error) => {
            eprintln!("error: {}", in_full(&error));
            answer_refusal(&error, &console);
            if is_wrong_use(&error) { 2 } else { 1 }
        }
    }
}

/// JSON answer for a trial whose files contradict each other or cannot be used.
#[derive(Serialize)]
struct Refusal {
    refused: Finding,
}

/// Prints the JSON answer if the error is a refusal of a trial's files and JSON was requested.
fn answer_refusal(error: &anyhow::Error, console: &Console) {
    let trial = |cause: &(dyn std::error::Error + 'static)| match cause.downcast_ref::<LabError>() {
        Some(LabError::Trial(error)) => Finding::of(error),
        _ => Finding::of(cause.downcast_ref::<TrialError>()?),
    };
    let refused = error.chain().find_map(trial);
    if let Some(refused) = refused {
        // The error was reported already; a closed output is ignored.
        let _ = console.answer(&Refusal { refused });
    }
}

fn start(cli: Cli, matches: &ArgMatches, console: &Console) -> Result<()> {
    if let Some(threads) = cli.threads {
        rayon::ThreadPoolBuilder::new().num_threads(threads).build_global()?;
    }
    if cli.allow_outside {
        named_file::allow_outside();
    }
    match cli.verb {
        Verb::Demo(args) => demo::run(&args, console),
        Verb::Weld(args) => weld::run(&args, console),
        Verb::Bake(args) => bake::run(&args, console),
        Verb::Simulate(args) => simulate::run(&args, console),
        Verb::Path(args) => path::run(&args, console),
        Verb::Convert(args) => convert::run(&args, console),
        Verb::Trial(args) => trial::run(&args, console),
        Verb::Press(args) => press::run(&args, console),
        Verb::Render(args) => render::run(&args, console),
        Verb::Dataset(args) => dataset::run(&args, matches.subcommand().map_or(matches, |(_, given)| given), console),
        Verb::DatasetItem(args) => dataset_item::run(&args),
        Verb::DatasetImage(args) => dataset_image::run(&args),
        Verb::Validate(args) => validate::run(&args, console),
        Verb::Calibrate(args) => calibrate::run(&args, console),
        Verb::Bench(args) => bench::run(&args, console),
        Verb::Compare(args) => compare::run(&args, console),
        Verb::Diagnose(args) => diagnose::run(&args, console),
        Verb::Study(args) => study::run(&args, console),
        Verb::Try(args) => try_effect::run(&args, console),
        Verb::Ledger(args) => ledger::run(&args, console),
        Verb::Workbench(args) => workbench::run(&args, console),
        Verb::Effects(args) => effects::run(&args, console),
        Verb::Backends(args) => backends::run(&args, console),
        Verb::Completions(args) => completions::run(&args, Cli::command(), console),
        Verb::Man(args) => man::run(&args, Cli::command(), console),
    }
}
