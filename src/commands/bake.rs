//! `robofin bake`: bakes mesh files into NanoVDB signed distance fields.

use std::path::{Path, PathBuf};
use std::time::Instant;

use anyhow::{Context, Result, bail};
use clap::Args;
use serde::Serialize;

use super::flags::{JOBS, MESH, MeshFlags, OutFlags};
use super::values::whole;
use crate::baking::{FIELD, FieldFacts, FieldSettings, bake_part};
use crate::cache::{Batch, Cache, Entry, INDEX_FILE, Outcome, find_meshes};
use crate::console::Console;
use crate::in_full;
use crate::part::Part;
use crate::store::Occupied;
use files::folder::StagedFile;
use sdf_bake::memory_budget;

#[derive(Debug, Args)]
#[command(
    after_help = "One mesh becomes the file --out. Several, or a folder, become a folder of fields named by content, with an index.

Examples:
  robofin bake data/bracket.obj --resolution 256 --out out/bracket.nvdb
  robofin bake parts more/plate.stl --voxel-mm 0.5 --out out/fields
  robofin bake parts --voxel-mm 0.5 --out out/fields --resume --jobs 4 --json"
)]
pub(super) struct BakeArgs {
    /// Mesh files (OBJ, STL, PLY, GLB or glTF), and folders with mesh files anywhere below.
    #[arg(required = true, value_name = "MESH|FOLDER")]
    meshes: Vec<PathBuf>,
    #[command(flatten)]
    out: OutFlags,
    /// Continue in the folder of an earlier run: what is complete there is not baked again.
    #[arg(long, conflicts_with = "force")]
    resume: bool,
    /// Meshes at once in a folder; the results do not depend on it, and neither does the limit of memory for fields.
    #[arg(
        long,
        value_name = "J",
        default_value_t = 1,
        allow_negative_numbers = true,
        value_parser = whole::<usize>(JOBS)
    )]
    jobs: usize,
    #[command(flatten, next_help_heading = MESH)]
    mesh: MeshFlags,
}

/// The answer of `bake --json`, one line for each mesh.
#[derive(Serialize)]
struct BakeAnswer<'a> {
    mesh: &'a str,
    out: &'a str,
    #[serde(flatten)]
    facts: &'a FieldFacts,
    bytes: u64,
    bake_s: f64,
    process_s: f64,
    cached: bool,
}

/// The answer for a mesh that failed.
#[derive(Serialize)]
struct Failure<'a> {
    mesh: &'a str,
    error: String,
}

pub(super) fn run(args: &BakeArgs, console: &Console) -> Result<()> {
    let settings = FieldSettings {
        unit: args.mesh.unit.into(),
        fineness: args.mesh.fineness(),
        band_voxels: args.mesh.band,
        sign: args.mesh.sign.into(),
        shell: args.mesh.shell(),
    };
    match args.meshes.as_slice() {
        [mesh] if !mesh.is_dir() && !args.resume => bake_one(mesh, &settings, &args.out, console),
        _ => bake_many(args, settings, console),
    }
}

/// Bakes one mesh into one file.
fn bake_one(mesh: &Path, settings: &FieldSettings, out: &OutFlags, console: &Console) -> Result<()> {
    let started = Instant::now();
    let file = StagedFile::new(&out.beside(&[mesh]), &FIELD)?;
    let part = Part::load(mesh, settings.unit)?;
    part.describe(console);
    let name = || mesh.display().to_string();
    let options = settings.options(&part);
    memory_budget::check(&part.mesh, &options).with_context(name)?;
    let field = bake_part(&part, &options).with_context(name)?;
    console.step("bake", &field.description);
    file.commit(&field.bytes)?;
    console.step("field", format!("{:.1} MB in {}", field.bytes.len() as f64 / 1e6, out.out.display()));
    console.answer_line(&BakeAnswer {
        mesh: &name(),
        out: &out.out.to_string_lossy(),
        facts: &field.facts,
        bytes: field.bytes.len() as u64,
        bake_s: field.bake_s,
        process_s: started.elapsed().as_secs_f64(),
        cached: false,
    })
}

/// Numbers of meshes by outcome.
#[derive(Default)]
struct Tally {
    baked: usize,
    cached: usize,
    failed: usize,
}

/// Bakes many meshes into a cache.
fn bake_many(args: &BakeArgs, settings: FieldSettings, console: &Console) -> Result<()> {
    let started = Instant::now();
    let sources = find_meshes(&args.meshes)?;
    let occupied = match (args.resume, args.out.force) {
        (true, _) => Occupied::Resume,
        (_, true) => Occupied::Replace,
        _ => Occupied::Refuse,
    };
    let cache = Cache::prepare(&args.out.out, occupied)?;
    let meshes = sources.len();
    let bar = console.bar("bake", meshes as u64);
    let mut tally = Tally::default();
    Batch { cache: &cache, settings, jobs: args.jobs }.run(sources, |outcome| {
        bar.suspend(|| report_outcome(outcome, &cache, &mut tally, console))?;
        bar.inc(1);
        Ok(())
    })?;
    bar.finish_and_clear();
    let Tally { baked, cached, failed } = tally;
    let seconds = started.elapsed().as_secs_f64();
    let index = cache.folder().join(INDEX_FILE);
    let counts = format!("{baked} baked, {cached} cached, {failed} failed in {seconds:.1} s");
    console.step("fields", format!("{counts}\nlisted in {}", index.display()));
    if failed > 0 {
        bail!("{failed} of {meshes} meshes failed, for the reasons above; --resume tries only them again");
    }
    Ok(())
}

/// Reports the outcome of one mesh, for people and as JSON.
fn report_outcome(outcome: &Outcome, cache: &Cache, tally: &mut Tally, console: &Console) -> Result<()> {
    let mesh = outcome.mesh.to_string_lossy();
    let Entry { key, record, bake_s } = match &outcome.result {
        Ok(entry) => entry,
        Err(error) => {
            tally.failed += 1;
            console.step("failed", in_full(error));
            return console.answer_line(&Failure { mesh: &mesh, error: in_full(error) });
        }
    };
    let facts = &record.facts;
    let about = format!("{mesh}: {} bricks, voxel {:.4} mm, {}", facts.bricks, facts.voxel_mm, facts.integrals());
    match bake_s {
        Some(seconds) => {
            tally.baked += 1;
            console.step("bake", format!("{about}, {} in {seconds:.2} s", facts.sign_method));
        }
        None => {
            tally.cached += 1;
            console.step("cached", about);
        }
    }
    console.answer_line(&BakeAnswer {
        mesh: &mesh,
        out: &cache.field_path(key).to_string_lossy(),
        facts,
        bytes: record.field.bytes,
        bake_s: bake_s.unwrap_or(0.0),
        process_s: outcome.process_s,
        cached: bake_s.is_none(),
    })
}
