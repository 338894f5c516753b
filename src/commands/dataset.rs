//! `robofin dataset`: makes thousands of assets from folders of meshes.

use std::path::{Path, PathBuf};
use std::time::Instant;

use anyhow::{Result, bail};
use clap::{ArgMatches, Args, Subcommand};
use serde::Serialize;

use super::dataset_images::{self, ImagesArgs};
use super::flags::{JOBS, LIMITS, RUNS};
use super::item_flags::{ITEMS, ItemFlags};
use super::values::whole;
use crate::cache::find_meshes;
use crate::console::Console;
use crate::dataset::plan::Shard;
use crate::dataset::run::Run;
use crate::dataset::{Dataset, Plan};
use crate::store::Occupied;
use crate::store::catalogue::Catalogue;
use crate::store::limits::Usage;
use crate::store::process::Ending;
use crate::store::progress::{Progress, Summary};
use crate::store::run::Outcome;

/// Greatest number of items of one part; their names have four digits.
const MOST_PER_PART: u64 = 10_000;

/// Other kinds of sets.
#[derive(Debug, Subcommand)]
enum Kind {
    /// Labelled images of coated workpieces in the course of sanding.
    Images(ImagesArgs),
}

const HELP: &str = "Every item is an asset as `robofin weld` makes it, without USD, made in a process of its own. Its bytes follow from the
content of its part, its number and the flags of the items; never from --jobs, --shard, --limit or interruptions.

Examples:
  robofin dataset parts --out out/set --per-part 10 --seed 7
  robofin dataset parts --out out/set --per-part 10 --seed 7 --resume --jobs 8
  robofin dataset parts more/plate.stl --out out/set --per-part 4 --limit 100 --shard 1/3 --time-limit 60
  robofin dataset images --out out/images";

#[derive(Debug, Args)]
#[command(args_conflicts_with_subcommands = true, subcommand_negates_reqs = true, after_help = HELP)]
pub(super) struct DatasetArgs {
    #[command(subcommand)]
    kind: Option<Kind>,
    /// Folders with mesh files (OBJ, STL, PLY, GLB or glTF) anywhere below, and mesh files.
    #[arg(required = true, value_name = "FOLDER|MESH")]
    sources: Vec<PathBuf>,
    /// Folder of the data set.
    #[arg(long, required = true, value_name = "DIR")]
    out: Option<PathBuf>,
    /// Items of each part.
    #[arg(
        long,
        value_name = "N",
        default_value_t = 1,
        allow_negative_numbers = true,
        value_parser = whole::<u32>([1, MOST_PER_PART]),
        help_heading = ITEMS
    )]
    per_part: u32,
    /// Only the item with this number of each part, from 0.
    #[arg(
        long,
        value_name = "K",
        conflicts_with = "per_part",
        allow_negative_numbers = true,
        value_parser = whole::<u32>([0, MOST_PER_PART - 1]),
        help_heading = ITEMS
    )]
    item: Option<u32>,
    /// At most this many items, every part once before any twice; shards share them.
    #[arg(
        long,
        value_name = "K",
        allow_negative_numbers = true,
        value_parser = whole::<usize>(LIMITS),
        help_heading = RUNS
    )]
    limit: Option<usize>,
    /// The i-th of n shares, for several machines.
    #[arg(long, value_name = "i/n", allow_hyphen_values = true, value_parser = shard, help_heading = RUNS)]
    shard: Option<Shard>,
    /// Items at once [default: all cores].
    #[arg(
        long,
        value_name = "J",
        allow_negative_numbers = true,
        value_parser = whole::<usize>(JOBS),
        help_heading = RUNS
    )]
    jobs: Option<usize>,
    /// Continue the data set of an earlier run: what is complete there is not made again, what failed is tried again.
    #[arg(long, help_heading = RUNS)]
    resume: bool,
    /// Print what would be made, and make nothing.
    #[arg(long, help_heading = RUNS)]
    dry_run: bool,
    #[command(flatten)]
    items: ItemFlags,
}

/// A line of `dataset --json`, for one item.
#[derive(Serialize)]
struct ItemAnswer<'a> {
    item: &'a str,
    source: &'a str,
    ending: &'a Ending,
    #[serde(flatten)]
    usage: Usage,
    seconds: f64,
}

pub(super) fn run(args: &DatasetArgs, matches: &ArgMatches, console: &Console) -> Result<()> {
    if let Some(Kind::Images(images)) = &args.kind {
        return dataset_images::run(images, console);
    }
    // clap requires `--out` unless a subcommand follows.
    let out = args.out.as_deref().unwrap_or(Path::new(""));
    let jobs = jobs(args.jobs);
    let (wishes, limits) = (args.items.wishes(), args.items.limits());
    let flags = ItemFlags::given(matches);
    let sources = args.sources.iter().map(|place| place.to_string_lossy().into_owned()).collect();
    let recipe = args.items.recipe(&wishes, &flags, sources)?;
    let plan = plan(args)?;
    console.step("plan", describe(&plan));
    if args.dry_run {
        return report_plan(out, &plan, console);
    }
    let dataset = Dataset::start(out, recipe, Occupied::resumed(args.resume))?;
    let run = Run { dataset: &dataset, plan: &plan, flags: &flags, limits, jobs };
    let summary = make(&run, console)?;
    let catalogue = Catalogue::update(&dataset)?;
    console.step("dataset", format!("{} items listed in {}", catalogue.items, out.display()));
    console.step("done", summary.describe(jobs));
    if let Some(outlook) = summary.outlook() {
        console.step("", outlook);
    }
    console.answer_line(&summary)?;
    match summary.failed {
        0 => Ok(()),
        failed => bail!(
            "{failed} of {} items failed; failures.jsonl in {} has reasons and command lines, --resume tries them again",
            summary.items,
            out.display()
        ),
    }
}

/// Makes the items of a run and reports each.
pub(super) fn make(run: &Run, console: &Console) -> Result<Summary> {
    report_items(run.plan.items.len() + run.plan.unreadable.len(), console, |done| run.run(done))
}

/// Reports each item that `work` finishes.
pub(super) fn report_items(
    items: usize,
    console: &Console,
    work: impl FnOnce(&mut dyn FnMut(&Outcome) -> Result<()>) -> Result<()>,
) -> Result<Summary> {
    let bar = console.bar("items", items as u64);
    let mut progress = Progress::new(items, Instant::now());
    work(&mut |outcome| {
        let line = progress.count(outcome);
        bar.inc(1);
        // With a progress bar, only failures have a text.
        if let (about, Some(text)) = (line.about, line.text(bar.is_hidden())) {
            bar.suspend(|| console.step(about, text));
        }
        bar.suspend(|| answer(outcome, console))
    })?;
    bar.finish_and_clear();
    Ok(progress.summary())
}

fn answer(outcome: &Outcome, console: &Console) -> Result<()> {
    let Outcome { id, source, ending, usage, seconds } = outcome;
    let source = &*source.to_string_lossy();
    console.answer_line(&ItemAnswer { item: id, source, ending, usage: *usage, seconds: *seconds })
}

/// Returns the number of items made at once.
pub(super) fn jobs(asked: Option<usize>) -> usize {
    let cores = || std::thread::available_parallelism().map_or(1, |cores| cores.get().min(JOBS[1] as usize));
    asked.unwrap_or_else(cores)
}

fn shard(text: &str) -> Result<Shard, String> {
    Shard::parse(text).ok_or_else(|| "i/n is accepted, with i from 1 to n, for example 2/3".to_owned())
}

fn plan(args: &DatasetArgs) -> Result<Plan> {
    let indices = args.item.map_or(0..args.per_part, |item| item..item + 1);
    let sources = find_meshes(&args.sources)?;
    Ok(Plan::new(
        sources,
        args.items.unit(),
        indices,
        args.limit.unwrap_or(usize::MAX),
        args.shard.unwrap_or(Shard::WHOLE),
    ))
}

fn describe(plan: &Plan) -> String {
    let mut text = format!("{} items of {} parts", plan.items.len(), plan.parts);
    if plan.copies > 0 {
        text += &format!("\n{} files are copies of others and count once", plan.copies);
    }
    if !plan.unreadable.is_empty() {
        text += &format!("\n{} files cannot be read", plan.unreadable.len());
    }
    text
}

/// A line of `dataset --dry-run --json`.
#[derive(Serialize)]
struct PlanAnswer<'a> {
    item: &'a str,
    source: &'a str,
    index: u32,
    is_there: bool,
}

fn report_plan(out: &Path, plan: &Plan, console: &Console) -> Result<()> {
    let dataset = Dataset::open(out).ok();
    let mut there = 0;
    for item in &plan.items {
        let is_there = dataset.as_ref().is_some_and(|dataset| dataset.holds(&item.id));
        there += usize::from(is_there);
        let source = &*item.source.to_string_lossy();
        console.answer_line(&PlanAnswer { item: &item.id, source, index: item.index, is_there })?;
    }
    for unreadable in &plan.unreadable {
        console.step("unread", format!("{}: {}", unreadable.source.display(), unreadable.reason));
    }
    console.step("dry run", format!("{} items would be made, {there} are there", plan.items.len() - there));
    Ok(())
}
