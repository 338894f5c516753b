//! `robofin weld`: from a mesh file to an asset folder.

use std::path::{Path, PathBuf};

use anyhow::{Context, Result};
use clap::Args;
use serde::Serialize;

use super::flags::{MeshFlags, OutFlags, optional_mm, within};
use crate::asset::{self, Extras, MANIFEST_FILE, Manifest, UsdMode};
use crate::console::Console;
use crate::folder::StagedFolder;
use crate::part::Part;
use crate::workpiece::{WeldWishes, WeldingOptions, weld_part};
use crate::wrong_use;

/// Example: robofin weld part.obj --out out/part --seed 7
#[derive(Debug, Args)]
#[command(
    after_help = "Example:\n  robofin weld data/bracket.obj --out out/bracket --seed 7 --length-mm 60 --width-mm 8"
)]
pub(super) struct WeldArgs {
    /// Mesh file: OBJ, STL, PLY, GLB or glTF.
    file: PathBuf,
    #[command(flatten)]
    out: OutFlags,
    /// Seed of every random choice; the same seed gives the same bytes.
    #[arg(long, default_value_t = 1, allow_negative_numbers = true)]
    seed: u64,
    #[command(flatten)]
    mesh: MeshFlags,
    #[command(flatten)]
    wishes: WeldFlags,
    /// USD file: auto makes it if Python can be had, require fails without it, off leaves it out.
    #[arg(long, value_enum, default_value_t)]
    usd: UsdMode,
}

/// What is fixed of the weld; the rest is chosen for the part.
#[derive(Clone, Debug, Default, Args)]
pub(super) struct WeldFlags {
    /// Length of the weld's centreline [mm].
    #[arg(long, value_name = "MM", allow_negative_numbers = true)]
    length_mm: Option<f64>,
    /// Width of the bead between its toes [mm].
    #[arg(long, value_name = "MM", allow_negative_numbers = true)]
    width_mm: Option<f64>,
    /// Height of the bead above the surface [mm].
    #[arg(long, value_name = "MM", allow_negative_numbers = true)]
    height_mm: Option<f64>,
    /// Root mean square of the centreline's geodesic curvature [1/m]; 0 is a geodesic.
    #[arg(long, value_name = "PER_M", allow_negative_numbers = true)]
    curvature_per_m: Option<f64>,
    /// Least exposure: the cosine-weighted share of the hemisphere above the weld that must be free, 0 to 1.
    #[arg(long, value_name = "SHARE", allow_negative_numbers = true)]
    min_exposure: Option<f64>,
}

impl WeldFlags {
    pub(super) fn wishes(&self) -> Result<WeldWishes> {
        if let Some(share) = self.min_exposure.filter(|share| !(0.0..=1.0).contains(share)) {
            return Err(wrong_use(format!("--min-exposure {share}: a share from 0 to 1 is expected")));
        }
        if let Some(curvature) = self.curvature_per_m {
            within("--curvature-per-m", curvature, (0.0, 1e4))?;
        }
        Ok(WeldWishes {
            length: optional_mm("--length-mm", self.length_mm)?,
            width: optional_mm("--width-mm", self.width_mm)?,
            height: optional_mm("--height-mm", self.height_mm)?,
            curvature: self.curvature_per_m,
            exposure: self.min_exposure,
        })
    }
}

/// The answer of `weld --json`.
#[derive(Serialize)]
struct WeldAnswer<'a> {
    asset: &'a Path,
    seconds: f64,
    #[serde(flatten)]
    manifest: Manifest,
}

pub(super) fn run(args: &WeldArgs, console: &Console) -> Result<()> {
    let started = std::time::Instant::now();
    args.mesh.solid_only("robofin weld")?;
    let options = WeldingOptions {
        seed: args.seed,
        fineness: args.mesh.fineness()?,
        band_voxels: args.mesh.band_voxels()?,
        sign: args.mesh.sign.into(),
        wishes: args.wishes.wishes()?,
    };
    let folder = StagedFolder::new(&args.out.out, MANIFEST_FILE, args.out.force)?;
    let part = Part::load(&args.file, args.mesh.unit.into())?;
    part.describe(console);
    let workpiece = weld_part(part, &options, console).with_context(|| args.file.display().to_string())?;
    let place = asset::write(&workpiece, &options, folder, Extras::full(args.usd), console)?;
    let manifest = Manifest::read(&place)?;
    console.step("done", format!("{}", args.out.out.display()));
    console.answer(&WeldAnswer { asset: &args.out.out, seconds: started.elapsed().as_secs_f64(), manifest })
}
