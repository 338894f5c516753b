//! `robofin render`: a picture of an asset or a field.

use std::path::{Path, PathBuf};

use anyhow::{Context, Result};
use clap::Args;
use sdf_bake::{BrickGrid, nvdb};
use serde::Serialize;

use super::flags::OutFlags;
use crate::asset::{AssetFields, Manifest, WeldTruth, Welds};
use crate::console::Console;
use crate::folder::{refuse_occupied, write_file};
use crate::picture::{SAMPLES_PER_SIDE, overview, to_png};
use crate::wrong_use;

#[derive(Debug, Args)]
#[command(
    after_help = "Examples:\n  robofin render out/bracket --out out/bracket.png\n  robofin render out/bracket.nvdb --size 640x480 --out out/field.png"
)]
pub(super) struct RenderArgs {
    /// Asset folder, or a NanoVDB file with a level set `phi`.
    source: PathBuf,
    #[command(flatten)]
    out: OutFlags,
    /// Width and height of the picture [pixels].
    #[arg(long, default_value = "960x720")]
    size: String,
}

/// The answer of `render --json`.
#[derive(Serialize)]
struct RenderAnswer<'a> {
    out: &'a Path,
    width: usize,
    height: usize,
    seconds: f64,
}

pub(super) fn run(args: &RenderArgs, console: &Console) -> Result<()> {
    let started = std::time::Instant::now();
    let size = parse_size(&args.size)?;
    refuse_occupied(&args.out.out, "", args.out.force)?;
    let (grid, weld) = open(&args.source)?;
    let picture = overview(&grid, weld.as_ref(), size, SAMPLES_PER_SIDE)?;
    write_file(&args.out.out, &to_png(&picture)?, args.out.force)?;
    console.step("picture", format!("{} x {} in {}", size.0, size.1, args.out.out.display()));
    let seconds = started.elapsed().as_secs_f64();
    console.answer(&RenderAnswer { out: &args.out.out, width: size.0, height: size.1, seconds })
}

/// The field to draw, and the weld that should be seen.
fn open(source: &Path) -> Result<(BrickGrid, Option<WeldTruth>)> {
    if source.is_dir() {
        Manifest::read(source)?;
        let weld = Welds::read(source)?.welds.into_iter().next();
        return Ok((AssetFields::open(source)?.welded, weld));
    }
    let context = || source.display().to_string();
    let file = nvdb::read(&std::fs::read(source).with_context(context)?).with_context(context)?;
    let phi = file.grid("phi").with_context(|| format!("{}: no grid `phi`", source.display()))?;
    let mut grid = phi.to_bricks().with_context(context)?;
    if let Some(labels) = file.grid("weld_id") {
        labels.attach_labels(&mut grid).with_context(context)?;
    }
    Ok((grid, None))
}

pub(super) fn parse_size(text: &str) -> Result<(usize, usize)> {
    let wrong =
        || wrong_use(format!("--size {text}: WIDTHxHEIGHT from 16 to 4096 pixels is expected, for example 960x720"));
    let (width, height) = text.split_once('x').ok_or_else(wrong)?;
    match (width.parse(), height.parse()) {
        (Ok(width), Ok(height)) if (16..=4096).contains(&width) && (16..=4096).contains(&height) => Ok((width, height)),
        _ => Err(wrong()),
    }
}
