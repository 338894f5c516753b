//! `robofin demo`: all steps on the bundled part, and a study of the bundled sealed example.

use std::fs;
use std::path::{Path, PathBuf};
use std::time::Instant;

use anyhow::Result;
use clap::Args;
use effects::{CompiledModel, Library, Model, RowCounts};
use robot::Wheel;
use serde::Serialize;
use sim::Executor;
use weldgen::Placement;

use super::flags::SEEDS;
use super::study::STUDY_NAMES;
use super::values::whole;
use crate::asset::{self, ASSET_NAMES, Extras, MANIFEST_FILE, UsdMode, write_json};
use crate::console::Console;
use crate::finishing::{
    self, GRIND_FILE, GROUND_NAMES, GrindSummary, Grinding, Ground, PAGE_FILE, Plan, Session, grind_asset,
};
use crate::part::Part;
use crate::sealed_example::{EXAMPLE_NAME, unpack};
use crate::workpiece::{Fineness, WeldSettings, WeldingOptions, weld_part};
use benchmark::OpenedSeal;
use files::folder::StagedFolder;
use files::output::{FolderKind, OutputPath};
use report::study::{Sealed, story};
use study::snapshot::Keeping;
use study::{Measurements, STUDY_FILE, StudyRecord, StudyState, inputs_sha256};
use trials::trial::PLAN_NAMES;
use virtual_lab::write::CAMPAIGN_NAMES;

/// Name of the result file in a demo folder.
const DEMO_FILE: &str = "demo.json";
/// Kind of a demo's folder.
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
        ("study/effects/", &["*.toml"]),
        ("study/next-trial/", PLAN_NAMES),
        ("study/next-trial/part-1/", PLAN_NAMES),
        ("study/next-trial/part-2/", PLAN_NAMES),
        ("study/first-look/", CAMPAIGN_NAMES),
    ],
};
/// Folder of the study in a demo folder.
const STUDY_FOLDER: &str = "study";
/// Radius of the wheel [m]: small enough to fit beside the plate at the end of the gusset.
const WHEEL_RADIUS: f64 = 0.008;
/// Width of the wheel [m]: half of the fillet's width, so that it does not touch the adjacent walls.
const WHEEL_WIDTH: f64 = 0.004;
/// Feed along the fillet [m/s]: two passes remove less than a millimetre.
const FEED: f64 = 10e-3;
/// Seed of the weld; it selects the corner of the bracket for the fillet.
const DEFAULT_SEED: u64 = 7;
/// Links of the page, with their words.
const LINKS: [(&str, &str); 6] = [
    ("study/report.html", "The study: what was hidden in a sealed example, and how it was found"),
    ("study/story.svg", "The study in one drawing"),
    ("asset/workpiece.glb", "The welded workpiece in 3D (glTF)"),
    ("asset/", "Files of the asset"),
    ("grind/index.html", "The grinding, with its fields and logs"),
    ("demo.json", "All figures of this page"),
];
/// Seed of the study's permutations.
const STUDY_SEED: u64 = 1;

#[derive(Debug, Args)]
#[command(after_help = "Example:\n  robofin demo --out out/demo")]
pub(super) struct DemoArgs {
    /// Folder to make [default: the first free of out/demo, out/demo-2, ...].
    #[arg(long, value_name = "DIR")]
    out: Option<PathBuf>,
    /// Replace an earlier demo there, unless the folder holds anything else.
    #[arg(long)]
    force: bool,
    /// Seed of every random choice.
    #[arg(long, default_value_t = DEFAULT_SEED, allow_negative_numbers = true, value_parser = whole::<u64>(SEEDS))]
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
    study: OpenedSeal,
}

/// Runs a study to its end.
type Search<'a> = &'a dyn Fn(&mut StudyState) -> Result<()>;

pub(super) fn run(args: &DemoArgs, console: &Console) -> Result<()> {
    make(args, &|course| super::study::advance(course, false, &|_| Ok(()), console), console)
}

fn make(args: &DemoArgs, search: Search, console: &Console) -> Result<()> {
    let started = Instant::now();
    let out = args.out.clone().unwrap_or_else(first_free);
    let folder = StagedFolder::new(&OutputPath { place: &out, force: args.force, inputs: &[] }, &DEMO)?;
    let ground = weld_and_grind(args, folder.path(), console)?;
    let study = study(&folder.path().join(STUDY_FOLDER), search, console)?;
    let seconds = started.elapsed().as_secs_f64();
    let answer = DemoAnswer {
        out: &out,
        page: out.join(PAGE_FILE),
        seconds,
        real_time_factor: ground.run.real_time_factor(),
        grind: ground.summary(),
        study,
    };
    write_json(&folder.path().join(DEMO_FILE), &answer)?;
    folder.commit()?;
    let pages = [PAGE_FILE.into(), Path::new(STUDY_FOLDER).join("report.html")].map(|page| out.join(page));
    console.step("done", format!("in {seconds:.1} s; open {} and {}", pages[0].display(), pages[1].display()));
    console.answer(&answer)
}

/// Welds, bakes, grinds and renders the bundled part.
fn weld_and_grind(args: &DemoArgs, folder: &Path, console: &Console) -> Result<Ground> {
    let part = Part::bundled()?;
    part.describe(console);
    let options = demo_options(args.seed);
    let workpiece = weld_part(part, &options, console)?;
    let asset = folder.join("asset");
    let asset_folder = StagedFolder::fresh(&asset)?;
    asset::write(&workpiece, &options, asset_folder, Extras::full(args.usd), console)?;

    let wheel = Wheel::cylinder(WHEEL_RADIUS, WHEEL_WIDTH);
    let plan = Plan { feed: FEED, ..Plan::default() };
    let model = Model::parse("the base law", "process = \"grinding\"", Library::builtin())?;
    let model = CompiledModel::new(&model, Library::builtin(), RowCounts::default())?;
    let grind_folder = StagedFolder::fresh(&folder.join("grind"))?;
    let (grinding, session) = (Grinding { wheel, plan, model }, Session { executor: Executor::Cpu, console });
    let mut ground = grind_asset(&asset, grinding, &Keeping::default(), grind_folder.path(), session)?;
    if let Some(error) = ground.run.stopped.take() {
        return Err(error);
    }
    let links = LINKS.map(|(address, words)| (address.to_owned(), words.to_owned()));
    let page = finishing::write(&ground, &asset, grind_folder, &links, console)?;
    console.step("weld", finishing::describe_rest(&ground));
    fs::write(folder.join(PAGE_FILE), page)?;
    Ok(ground)
}

/// Studies the bundled sealed example to the end, then opens its seal.
fn study(folder: &Path, search: Search, console: &Console) -> Result<OpenedSeal> {
    let (campaign, key) = (folder.join(EXAMPLE_NAME), folder.join(format!("{EXAMPLE_NAME}.key")));
    unpack(&campaign, &key)?;
    let library = Library::builtin();
    let measurements = Measurements::read(&campaign)?;
    let data = measurements.data()?;
    console.step("sealed example", format!("{EXAMPLE_NAME}: {}; something may be hidden in them", data.describe()));
    let model = Model::new(data.evidence().process());
    let record = StudyRecord::new(inputs_sha256(&campaign)?, STUDY_SEED);
    let mut course = StudyState::new(data, library, model, record)?;
    search(&mut course)?;
    let report = super::study::write_files(&mut course, folder, library, console)?;
    let opened = OpenedSeal::open(&campaign, &key, &course)?;
    let (sha256, hidden, found) = (&opened.sha256, &opened.hidden_lines, &opened.found_lines);
    console.step("seal", format!("opened; hidden was {}", hidden.join(", ")));
    let (hidden, found, is_right) = (hidden.clone(), found.clone(), opened.is_right);
    let sealed = Sealed { sha256: sha256.clone(), hidden, found, is_right };
    fs::write(folder.join("story.svg"), story(&report, &sealed))?;
    console.step("", if opened.is_right { "the study was right" } else { "the study was WRONG" });
    Ok(opened)
}

/// Returns options for a fillet in a corner, clear of walls at its ends. With the default seed it joins the foot of the
/// gusset to the base plate, facing up, so that the wheel reaches all of it.
fn demo_options(seed: u64) -> WeldingOptions {
    WeldingOptions {
        seed,
        fineness: Fineness::Voxel(0.4e-3),
        band_voxels: crate::workpiece::DEFAULT_BAND,
        sign: sdf_bake::SignChoice::Auto,
        wishes: WeldSettings {
            placement: Placement::Seam,
            length: Some([0.016; 2]),
            width: Some(0.008),
            convexity: 0.1,
            exposure: Some([0.2, 1.0]),
            ..WeldSettings::default()
        },
    }
}

fn first_free() -> PathBuf {
    let names = std::iter::once("out/demo".to_owned()).chain((2..).map(|i| format!("out/demo-{i}")));
    names.map(PathBuf::from).find(|path| !path.exists()).unwrap_or_else(|| PathBuf::from("out/demo"))
}

#[cfg(test)]
mod tests {
    use files::json_file::read_json;
    use lab::Verdict;
    use serde_json::Value;

    use super::*;

    #[test]
    fn the_demo_runs_from_the_part_to_the_opened_seal() {
        let place = tempfile::tempdir().expect("a temporary folder");
        let out = place.path().join("demo");
        let args = DemoArgs { out: Some(out.clone()), force: false, seed: DEFAULT_SEED, usd: UsdMode::Off };
        // The search takes minutes; here it is replaced by a comparison that finds nothing.
        let search = |course: &mut StudyState| {
            course.step(&|_, _, _| {})?;
            course.record.verdict = Some(Verdict::NothingMissing);
            Ok(())
        };
        make(&args, &search, &Console::silent()).expect("a whole demo");
        for file in [PAGE_FILE, "asset/asset.json", "grind/ground.nvdb", "study/report.html", "study/story.svg"] {
            assert!(out.join(file).is_file(), "{file}");
        }
        let page = fs::read_to_string(out.join(PAGE_FILE)).expect("a page");
        for (address, _) in LINKS {
            assert!(page.contains(&format!("href=\"{address}\"")) && out.join(address).exists(), "{address}");
        }
        let answer: Value = read_json(&out.join(DEMO_FILE), "the figures of a demo").expect("figures");
        let [field, law] = ["removed_mm3", "removed_by_law_mm3"].map(|key| {
            answer["grind"][key]
                .as_array()
                .expect("a volume of each pass")
                .iter()
                .filter_map(Value::as_f64)
                .sum::<f64>()
        });
        assert!(field > 1.0 && (law / field - 1.0).abs() < 0.05, "{field} and {law} mm³");
        let opened = &answer["study"];
        assert!(opened["hidden"] == serde_json::json!(["grit-dulling"]) && opened["is_right"] == false, "{opened}");
        assert_eq!(opened["measurements_unchanged"], true);
        let left: Vec<_> =
            fs::read_dir(place.path()).expect("the folder").map(|e| e.expect("an entry").path()).collect();
        assert_eq!(left, [out], "nothing is left over");
        assert!(make(&args, &|_| panic!("no work is begun"), &Console::silent()).is_err(), "the place is taken");
    }

    #[test]
    fn the_demo_welds_the_foot_of_the_gusset_from_above() {
        // The weld does not depend on the voxel; a coarse field bakes faster.
        let options = WeldingOptions { fineness: Fineness::Voxel(1.6e-3), ..demo_options(DEFAULT_SEED) };
        let part = Part::bundled().expect("the bundled part");
        let workpiece = weld_part(part, &options, &Console::silent()).expect("a welded bracket");
        let [placed] = &workpiece.welds[..] else { panic!("{} welds", workpiece.welds.len()) };
        // The gusset stands on the plate's top, z = 10 mm, from x = -70 to -38 mm, between y = 25 and 33 mm.
        for point in &placed.weld.curve.points {
            let at = point.position * 1e3;
            assert!((at.z - 10.0).abs() < 0.01 && (-70.0..-38.0).contains(&at.x), "{at}");
            assert!((at.y - 25.0).abs() < 0.01 || (at.y - 33.0).abs() < 0.01, "{at}");
            assert!(point.normal.z > 0.7, "the fillet faces {}", point.normal);
        }
        // The wheel must fit beside the upright plate at x = -70 mm.
        let room = placed.weld.curve.points.iter().map(|point| point.position.x + 0.070).fold(f64::INFINITY, f64::min);
        assert!(room > WHEEL_RADIUS, "{room} m to the upright plate");
    }
}
