//! `robofin demo`: the whole road on the bundled part, and a study of the bundled riddle.

use std::fs;
use std::path::{Path, PathBuf};
use std::time::Instant;

use anyhow::Result;
use clap::Args;
use serde::Serialize;
use sim::Wheel;
use sim::effect::{CompiledModel, Library, Model, RowCounts};

use super::flags::{SEEDS, whole};
use super::study::STUDY_NAMES;
use crate::asset::{self, ASSET_NAMES, Extras, MANIFEST_FILE, UsdMode, write_json};
use crate::console::Console;
use crate::finishing::{self, GRIND_FILE, GROUND_NAMES, GrindSummary, Ground, PAGE_FILE, Plan, grind_asset};
use crate::folder::StagedFolder;
use crate::output::{FolderKind, Out};
use crate::part::Part;
use crate::riddle::{Opened, RIDDLE_NAME, open, unpack};
use crate::snapshot::Keeping;
use crate::study::{Course, Measurements, STUDY_FILE, StudyRecord, inputs_sha256};
use crate::study_report::story;
use crate::virtual_lab::write::CAMPAIGN_NAMES;
use crate::workpiece::{Fineness, WeldWishes, WeldingOptions, weld_part};

/// Name of the figures file in a demo folder.
const DEMO_FILE: &str = "demo.json";
/// The folder of a demo.
const DEMO: FolderKind = FolderKind {
    marker: DEMO_FILE,
    key: "real_time_factor",
    names: &[
        ("", &[PAGE_FILE]),
        ("asset/", &[MANIFEST_FILE]),
        ("asset/", ASSET_NAMES),
        ("grind/", &[GRIND_FILE]),
        ("grind/", GROUND_NAMES),
        ("study/", &[STUDY_FILE, "story.svg", "first-look.key"]),
        ("study/", STUDY_NAMES),
        ("study/first-look/", CAMPAIGN_NAMES),
    ],
};
/// Folder of the study in a demo folder.
const STUDY_FOLDER: &str = "study";
/// Seed of the study's draws.
const STUDY_SEED: u64 = 1;

#[derive(Debug, Args)]
#[command(after_help = "Example:\n  robofin demo --out out/demo")]
pub(super) struct DemoArgs {
    /// Folder to make [default: the first free of out/demo, out/demo-2, ...].
    #[arg(long, value_name = "DIR")]
    out: Option<PathBuf>,
    /// Replace what is there.
    #[arg(long)]
    force: bool,
    /// Seed of every random choice.
    #[arg(long, default_value_t = 4, allow_negative_numbers = true, value_parser = whole::<u64>(SEEDS))]
    seed: u64,
    /// USD file: auto makes it if Python can be had, require fails without it, off leaves it out.
    #[arg(long, value_enum, default_value_t)]
    usd: UsdMode,
}

/// `demo.json`, and the answer of `demo --json`.
#[derive(Serialize)]
struct DemoAnswer<'a> {
    out: &'a Path,
    page: PathBuf,
    seconds: f64,
    real_time_factor: f64,
    grind: GrindSummary,
    study: Opened,
}

pub(super) fn run(args: &DemoArgs, console: &Console) -> Result<()> {
    let started = Instant::now();
    let out = args.out.clone().unwrap_or_else(first_free);
    let folder = StagedFolder::new(&Out { place: &out, force: args.force, inputs: &[] }, &DEMO)?;
    let ground = weld_and_grind(args, folder.path(), console)?;
    let study = study(&folder.path().join(STUDY_FOLDER), console)?;
    let seconds = started.elapsed().as_secs_f64();
    let answer = DemoAnswer {
        out: &out,
        page: out.join(PAGE_FILE),
        seconds,
        real_time_factor: ground.real_time_factor(),
        grind: ground.summary(),
        study,
    };
    write_json(&folder.path().join(DEMO_FILE), &answer)?;
    folder.commit()?;
    let pages = [PAGE_FILE.into(), Path::new(STUDY_FOLDER).join("report.html")].map(|page| out.join(page));
    console.step("done", format!("in {seconds:.1} s; open {} and {}", pages[0].display(), pages[1].display()));
    console.answer(&answer)
}

/// Welds, bakes, grinds and draws the bundled part.
fn weld_and_grind(args: &DemoArgs, folder: &Path, console: &Console) -> Result<Ground> {
    let part = Part::bundled()?;
    part.describe(console);
    let options = demo_options(args.seed);
    let workpiece = weld_part(part, &options, console)?;
    let asset = folder.join("asset");
    let asset_folder = StagedFolder::fresh(&asset)?;
    asset::write(&workpiece, &options, asset_folder, Extras::full(args.usd), console)?;

    let wheel = Wheel::cylinder(0.05, 0.02);
    let model = Model::parse("the base law", "process = \"grinding\"", Library::builtin())?;
    let model = CompiledModel::new(&model, Library::builtin(), RowCounts::default())?;
    let grind_folder = StagedFolder::fresh(&folder.join("grind"))?;
    let keeping = (&Keeping::default(), grind_folder.path());
    let mut ground = grind_asset(&asset, (wheel, Plan::default()), model, keeping, (None, console))?;
    if let Some(error) = ground.stopped.take() {
        return Err(error);
    }
    let page = finishing::write(&ground, &asset, grind_folder, console)?;
    console.step("weld", finishing::describe_rest(&ground));
    fs::write(folder.join(PAGE_FILE), page)?;
    Ok(ground)
}

/// Studies the bundled riddle to the end, then opens its seal.
fn study(folder: &Path, console: &Console) -> Result<Opened> {
    let (campaign, key) = (folder.join(RIDDLE_NAME), folder.join(format!("{RIDDLE_NAME}.key")));
    unpack(&campaign, &key)?;
    let library = Library::builtin();
    let measurements = Measurements::read(&campaign)?;
    let data = measurements.data()?;
    console.step("riddle", format!("{RIDDLE_NAME}: {}; something may be hidden in them", data.describe()));
    let model = Model::new(data.evidence().process());
    let record = StudyRecord::new(inputs_sha256(&campaign)?, STUDY_SEED);
    let mut course = Course::new(data, library, model, record)?;
    super::study::advance(&mut course, false, &|_| Ok(()), console)?;
    let report = super::study::write_files(&mut course, folder, library, console)?;
    let (opened, sealed) = open(&campaign, &key, &course)?;
    fs::write(folder.join("story.svg"), story(&report, &sealed))?;
    console.step("seal", format!("opened; hidden was {}", sealed.hidden.join(", ")));
    console.step("", if opened.is_right { "the study was right" } else { "the study was WRONG" });
    Ok(opened)
}

/// A bead of ordinary size at a voxel that resolves it. With the default seed it lies on the base plate, clear of tube
/// and upright, so that the wheel reaches all of it.
fn demo_options(seed: u64) -> WeldingOptions {
    WeldingOptions {
        seed,
        fineness: Fineness::Voxel(0.4e-3),
        band_voxels: crate::workpiece::DEFAULT_BAND,
        sign: sdf_bake::SignChoice::Auto,
        wishes: WeldWishes {
            length: Some([0.075; 2]),
            width: Some(0.01),
            height: Some(0.003),
            curvature: Some([6.0; 2]),
            exposure: Some([0.9, 1.0]),
            ..WeldWishes::default()
        },
    }
}

fn first_free() -> PathBuf {
    let names = std::iter::once("out/demo".to_owned()).chain((2..).map(|i| format!("out/demo-{i}")));
    names.map(PathBuf::from).find(|path| !path.exists()).unwrap_or_else(|| PathBuf::from("out/demo"))
}
