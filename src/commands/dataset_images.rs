//! `robofin dataset images`: labelled images of coated workpieces during sanding.

use std::collections::BTreeSet;
use std::path::{Path, PathBuf};

use anyhow::{Result, bail};
use clap::Args;
use paths::Pattern;
use perception::Look;
use serde::Serialize;

use super::dataset::{jobs, report_items};
use super::flags::{JOBS, LIMITS, RUNS, SEEDS};
use super::item_flags::{GIGABYTES, SECONDS};
use super::render::parse_size;
use super::values::{number, one_of, whole};
use crate::console::Console;
use crate::images::make::{STEPS, Task};
use crate::images::plan::{Split, SplitBy};
use crate::images::scene_files::{ClutterFolder, EnvironmentFile};
use crate::images::workpiece::Coated;
use crate::images::{IMAGES_FORMAT, ImageRecipe, ImageSet};
use crate::store::Occupied;
use crate::store::catalogue::Catalogue;
use crate::store::limits::Limits;
use crate::store::progress::Summary;
use crate::store::run::{Run, SetItem};
use crate::wrong_use;

/// Accepted numbers of placements or stages; names of placements have two digits.
const COUNTS: [u64; 2] = [1, 99];

/// Folder, size and number of images of `--quick`.
const QUICK_OUT: &str = "out/images-quick";
const QUICK_SIZE: (usize, usize) = (320, 240);
const QUICK_IMAGES: usize = 24;

/// Heading of the help for flags that define the images.
const CONTENTS: &str = "Contents";

#[derive(Debug, Args)]
#[command(
    after_help = "A set has WORKPIECES x PLACEMENTS x (PATTERNS x STAGES + 2) images, by default 6 x 4 x (6 x 5 + 2) = 768. Their bytes follow
from the flags above --limit; never from --jobs, --threads, --limit or interruptions.

Examples:
  robofin dataset images --quick
  robofin dataset images --out out/images
  robofin dataset images --out out/images --resume --jobs 8
  robofin dataset images --out out/few --placements 3 --patterns spiral,spots --size 320x240 --workpieces panel,out/bracket"
)]
pub(super) struct ImagesArgs {
    /// Folder of the set [with --quick: out/images-quick].
    #[arg(long, value_name = "DIR", required_unless_present = "quick")]
    out: Option<PathBuf>,
    /// A sample that shows every state of the coating: 24 images of 320x240.
    #[arg(long, conflicts_with_all = ["limit", "only", "size"], help_heading = CONTENTS)]
    quick: bool,
    /// Seed of the set: placement, camera, light, material, noise, the bracket's weld.
    #[arg(
        long,
        default_value_t = 1,
        allow_negative_numbers = true,
        value_parser = whole::<u64>(SEEDS),
        help_heading = CONTENTS
    )]
    seed: u64,
    /// Coated workpieces: bracket, panel, tee, lap, channel, hood, and asset folders made by `robofin weld`.
    #[arg(
        long,
        value_name = "NAME|DIR,...",
        value_delimiter = ',',
        default_value = "bracket,panel,tee,lap,channel,hood",
        help_heading = CONTENTS
    )]
    workpieces: Vec<String>,
    /// Views of each workpiece.
    #[arg(
        long,
        value_name = "N",
        default_value_t = 4,
        allow_negative_numbers = true,
        value_parser = whole::<u32>(COUNTS),
        help_heading = CONTENTS
    )]
    placements: u32,
    /// Paths of the sanding pad [default: all].
    #[arg(
        long,
        value_name = "NAME,...",
        value_delimiter = ',',
        value_parser = one_of(&Pattern::ALL, |pattern| [pattern.name(), pattern.about()]),
        help_heading = CONTENTS
    )]
    patterns: Vec<Pattern>,
    /// Equal parts of each path, with an image after each.
    #[arg(
        long,
        value_name = "N",
        default_value_t = 5,
        allow_negative_numbers = true,
        value_parser = whole::<u32>(COUNTS),
        help_heading = CONTENTS
    )]
    stages: u32,
    /// Width and height of the images [pixels].
    #[arg(long, default_value = "640x480", value_parser = parse_size, help_heading = CONTENTS)]
    size: (usize, usize),
    /// Distance between voxels of bracket and panel [mm]; assets have their own.
    #[arg(
        long,
        value_name = "MM",
        default_value_t = 0.6,
        allow_negative_numbers = true,
        value_parser = number([0.1, 5.0]),
        help_heading = CONTENTS
    )]
    voxel_mm: f64,
    /// Unit by which the images are split: no two splits share a workpiece, or a placement as in the paper.
    #[arg(
        long,
        value_name = "WHAT",
        default_value = SplitBy::Workpiece.name(),
        value_parser = one_of(&SplitBy::ALL, |split| [split.name(), split.about()]),
        help_heading = CONTENTS
    )]
    split_by: SplitBy,
    #[arg(long, value_name = "NAME,...", value_delimiter = ',', help_heading = CONTENTS, help = looks_help())]
    looks: Vec<String>,
    /// Equirectangular picture in the Radiance format (.hdr) that lights all images, in place of drawn ambient light and
    /// the panels of `studio`.
    #[arg(long, value_name = "FILE", help_heading = CONTENTS)]
    environment: Option<PathBuf>,
    /// Folder of closed meshes that stand among the clutter of every placement, in drawn sizes.
    #[arg(long, value_name = "DIR", help_heading = CONTENTS)]
    clutter: Option<PathBuf>,
    /// At most this many images, with every state of the coating, workpiece, placement and split in its share of the
    /// set; a larger limit with --resume adds to those that are there.
    #[arg(
        long,
        value_name = "K",
        allow_negative_numbers = true,
        value_parser = whole::<usize>(LIMITS),
        help_heading = RUNS
    )]
    limit: Option<usize>,
    /// Only the workpiece, simulation or image of this name; what the command lines of failures use.
    #[arg(long, value_name = "ID", conflicts_with = "limit", help_heading = RUNS)]
    only: Option<String>,
    /// Images at once, each in a process of one thread [default: all cores].
    #[arg(
        long,
        value_name = "J",
        allow_negative_numbers = true,
        value_parser = whole::<usize>(JOBS),
        help_heading = RUNS
    )]
    jobs: Option<usize>,
    /// Continue the set of an earlier run: what is complete there is not made again, what failed is tried again.
    #[arg(long, help_heading = RUNS)]
    resume: bool,
    /// Print what would be made, and make nothing.
    #[arg(long, help_heading = RUNS)]
    dry_run: bool,
    #[command(flatten)]
    limits: LimitFlags,
}

/// Default limits of time [s] and memory [GB].
const USUAL_LIMITS: (f64, f64) = (600.0, 4.0);

/// Limits of the process of one image.
#[derive(Clone, Debug, Args)]
pub(super) struct LimitFlags {
    /// Time by the clock that an image or simulation may take [s].
    #[arg(
        long,
        value_name = "s",
        default_value_t = USUAL_LIMITS.0,
        allow_negative_numbers = true,
        value_parser = number(SECONDS),
        help_heading = RUNS
    )]
    time_limit: f64,
    /// Memory that the process of one may ask for [GB].
    #[arg(
        long,
        value_name = "GB",
        default_value_t = USUAL_LIMITS.1,
        allow_negative_numbers = true,
        value_parser = number(GIGABYTES),
        help_heading = RUNS
    )]
    memory_limit: f64,
}

impl LimitFlags {
    /// Returns the default limits.
    pub(super) fn usual() -> Self {
        Self { time_limit: USUAL_LIMITS.0, memory_limit: USUAL_LIMITS.1 }
    }

    pub(super) fn limits(&self) -> Limits {
        Limits { time: self.time_limit, memory: (self.memory_limit * 1e9) as u64 }
    }
}

/// The last line of the answer of `dataset images --json`.
#[derive(Serialize)]
struct ImagesAnswer<'a> {
    out: &'a Path,
    workpieces: Summary,
    sandings: Summary,
    views: Summary,
    images: Summary,
}

/// A line of `dataset images --dry-run --json`.
#[derive(Serialize)]
struct PlanAnswer<'a> {
    task: &'a str,
    needs: Vec<String>,
    is_there: bool,
}

pub(super) fn run(args: &ImagesArgs, console: &Console) -> Result<()> {
    let out = args.out.as_deref().unwrap_or(Path::new(QUICK_OUT));
    let (jobs, limits, recipe) = (jobs(args.jobs), args.limits.limits(), args.recipe()?);
    let steps = args.steps(&recipe)?;
    let left_out = recipe.clutter.iter().flat_map(|clutter| &clutter.left_out);
    left_out.for_each(|why| console.step("left out", why));
    let [workpieces, sandings, _, images] = steps.each_ref().map(Vec::len);
    console.step("plan", format!("{images} images from {sandings} simulations on {workpieces} workpieces"));
    if recipe.splits().iter().all(|split| *split == Split::Train) {
        let held = recipe.split_by.name();
        console.step("split", format!("fewer than three {held}s: all images are for training, none for tests"));
    }
    if args.dry_run {
        return report_plan(&recipe, &steps, ImageSet::open(out).ok().as_ref(), console);
    }
    let set = ImageSet::start(out, recipe, Occupied::resumed(args.resume))?;
    let summaries = make(&Run { set: &set, limits, jobs }, &steps, console)?;
    let catalogue = Catalogue::update(&set)?;
    console.step("dataset", format!("{} images listed in {}", catalogue.items, out.display()));
    console.step("done", summaries[STEPS - 1].describe(jobs));
    let failed: usize = summaries.iter().map(|summary| summary.failed).sum();
    let [workpieces, sandings, views, images] = summaries;
    console.answer_line(&ImagesAnswer { out, workpieces, sandings, views, images })?;
    match failed {
        0 => Ok(()),
        failed => bail!(
            "{failed} tasks failed; failures.jsonl in {} has reasons and command lines, --resume tries them again",
            out.display()
        ),
    }
}

/// Does the tasks of all steps and reports each.
pub(super) fn make(
    run: &Run<'_, ImageRecipe>,
    steps: &[Vec<Task>; STEPS],
    console: &Console,
) -> Result<[Summary; STEPS]> {
    let mut summaries = [(); STEPS].map(|()| Summary::default());
    for (tasks, summary) in steps.iter().zip(&mut summaries) {
        *summary = report_items(tasks.len(), console, |done| run.run(tasks, done))?;
    }
    Ok(summaries)
}

impl ImagesArgs {
    fn recipe(&self) -> Result<ImageRecipe> {
        let coated = self.workpieces.iter().map(|word| Coated::named(word, self.voxel_mm));
        let workpieces: Vec<Coated> = coated.collect::<Result<_>>()?;
        let twice = |name: &str| workpieces.iter().filter(|coated| coated.name == name).count() > 1;
        if let Some(coated) = workpieces.iter().find(|coated| twice(&coated.name)) {
            return Err(wrong_use(format!("--workpieces: {} is named twice", coated.name)));
        }
        let mut patterns = if self.patterns.is_empty() { Pattern::ALL.to_vec() } else { self.patterns.clone() };
        patterns.sort_unstable();
        patterns.dedup();
        Ok(ImageRecipe {
            format: IMAGES_FORMAT.to_owned(),
            version: env!("CARGO_PKG_VERSION").to_owned(),
            seed: self.seed,
            workpieces,
            placements: self.placements,
            patterns,
            stages: self.stages,
            size: if self.quick { QUICK_SIZE } else { self.size },
            voxel_mm: self.voxel_mm,
            split_by: self.split_by,
            looks: chosen_looks(&self.looks)?,
            environment: self.environment.as_deref().map(EnvironmentFile::of).transpose()?,
            clutter: self.clutter.as_deref().map(ClutterFolder::of).transpose()?,
        })
    }

    /// Returns the tasks to do.
    fn steps(&self, recipe: &ImageRecipe) -> Result<[Vec<Task>; STEPS]> {
        let Some(id) = &self.only else {
            let images = recipe.images_within(if self.quick { QUICK_IMAGES } else { self.limit.unwrap_or(usize::MAX) });
            return Ok(Task::chosen(recipe, &images.into_iter().map(|image| image.id).collect()));
        };
        if Task::named(recipe, id).is_none() {
            let example = recipe.images().pop().map_or(String::new(), |image| image.id);
            return Err(wrong_use(format!("--only {id}: not part of this set; images are named like {example}")));
        }
        Ok(Task::chosen(recipe, &BTreeSet::from([id.clone()])))
    }
}

/// Help of `--looks`.
fn looks_help() -> String {
    format!("Looks of the photographs [default: all]: {}", Look::names())
}

/// Returns the looks of these names in their order; all of them if no name is given.
fn chosen_looks(words: &[String]) -> Result<Vec<Look>> {
    Look::chosen(words).map_err(|unknown| wrong_use(format!("--looks {unknown}")))
}

/// Reports the tasks without doing them.
fn report_plan(
    recipe: &ImageRecipe,
    steps: &[Vec<Task>; STEPS],
    set: Option<&ImageSet>,
    console: &Console,
) -> Result<()> {
    let mut missing = 0;
    for task in steps.iter().flatten() {
        let is_there = set.is_some_and(|set| task.is_there(set));
        missing += usize::from(!is_there);
        console.answer_line(&PlanAnswer { task: task.id(), needs: task.needs(recipe), is_there })?;
    }
    let all: usize = steps.iter().map(Vec::len).sum();
    console.step("dry run", format!("{missing} tasks would be done, {} are done already", all - missing));
    Ok(())
}
