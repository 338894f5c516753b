//! `robofin weld`: makes an asset folder from a mesh file.

use std::path::{Path, PathBuf};

use anyhow::{Context, Result};
use clap::{Args, ValueEnum};
use serde::Serialize;
use weldgen::access::{ToolKind, ToolShape};
use weldgen::{Difficulty, Placement, Stitch, dials};

use super::bead_flags::{BEAD, BeadFlags};
use super::flags::{MESH, MeshFlags, OutFlags, SEEDS, metres, solid_only};
use super::values::{number, positive, range, whole};
use crate::asset::{self, ASSET, Extras, Manifest, UsdMode};
use crate::console::Console;
use crate::part::Part;
use crate::workpiece::{WeldSettings, WeldingOptions, weld_part};
use export::mass::STEEL_DENSITY;
use files::folder::StagedFolder;

/// Heading of the help for flags that add to the files.
const FILES: &str = "Files";

/// Heading of the help for the weld's curve.
const CURVE: &str = "Curve";
/// Heading of the help for exposure and tool access.
const ACCESS: &str = "Exposure and access";

/// Example: robofin weld part.obj --out out/part --seed 7
#[derive(Debug, Args)]
#[command(
    after_help = "Examples:\n  robofin weld data/bracket.obj --out out/bracket --seed 7 --length-mm 60 --width-mm 8\n  \
                  robofin weld data/bracket.obj --out out/hard --difficulty hard --count 2\n  \
                  robofin weld data/bracket.obj --out out/shade --length-mm 20..40 --curvature-per-m 5..20 \
                  --exposure 0.4..0.7\n  \
                  robofin weld data/bracket.obj --out out/fillet --place seam --width-mm 6 --ripple-pitch-mm 2 --pores 3",
    mut_arg("shell_mm", solid_only)
)]
pub(super) struct WeldArgs {
    /// Mesh file: OBJ, STL, PLY, GLB or glTF.
    file: PathBuf,
    #[command(flatten)]
    out: OutFlags,
    /// Seed of every random choice; the same seed gives the same bytes.
    #[arg(long, default_value_t = 1, allow_negative_numbers = true, value_parser = whole::<u64>(SEEDS))]
    seed: u64,
    /// USD file: auto makes it if Python can be had, require fails without it, off leaves it out.
    #[arg(long, value_enum, default_value_t)]
    usd: UsdMode,
    /// Density of part and welds, for mass and inertia [kg/m³].
    #[arg(
        long,
        value_name = "KG_PER_M3",
        default_value_t = STEEL_DENSITY,
        allow_negative_numbers = true,
        value_parser = positive,
        help_heading = FILES
    )]
    density: f64,
    /// Also writes light meshes and robot models (light.glb, part.mjcf.xml, part.urdf and their STL meshes).
    #[arg(long, help_heading = FILES)]
    models: bool,
    /// Also writes the fields as OpenVDB (fields.vdb), for Blender and Houdini.
    #[arg(long, help_heading = FILES)]
    vdb: bool,
    #[command(flatten, next_help_heading = MESH)]
    mesh: MeshFlags,
    #[command(flatten)]
    wishes: WeldFlags,
}

/// Requested properties of the weld; the others are chosen for the part. Ranges: `40..80`; the seed draws from them.
#[derive(Clone, Debug, Default, Args)]
pub(super) struct WeldFlags {
    /// Preset of length, curvature and exposure; each can be fixed beside it.
    #[arg(long, value_enum, default_value_t, help_heading = CURVE)]
    difficulty: DifficultyFlag,
    /// Number of welds on the part; they keep a distance.
    #[arg(
        long,
        value_name = "N",
        allow_negative_numbers = true,
        value_parser = whole::<u16>([1, 1000]),
        help_heading = CURVE
    )]
    count: Option<u16>,
    /// Length of the weld's centreline, or a range [mm].
    #[arg(long, value_name = "MM", allow_negative_numbers = true, value_parser = range(positive), help_heading = CURVE)]
    length_mm: Option<[f64; 2]>,
    /// Where the weld runs; `seam` lays fillets in concave creases, `butt` joins halves that a plane parts.
    #[arg(long, value_enum, default_value_t, help_heading = CURVE)]
    place: PlaceFlag,
    /// Length of each bead of an intermittent weld [mm].
    #[arg(
        long,
        value_name = "MM",
        requires = "stitch_pitch_mm",
        allow_negative_numbers = true,
        value_parser = positive,
        help_heading = CURVE
    )]
    stitch_mm: Option<f64>,
    /// Distance from the start of a bead of an intermittent weld to that of the next [mm].
    #[arg(
        long,
        value_name = "MM",
        requires = "stitch_mm",
        allow_negative_numbers = true,
        value_parser = positive,
        help_heading = CURVE
    )]
    stitch_pitch_mm: Option<f64>,
    /// Width of the bead between its toes [mm].
    #[arg(long, value_name = "MM", allow_negative_numbers = true, value_parser = positive, help_heading = BEAD)]
    width_mm: Option<f64>,
    /// Height of the bead above the surface [mm].
    #[arg(long, value_name = "MM", allow_negative_numbers = true, value_parser = positive, help_heading = BEAD)]
    height_mm: Option<f64>,
    #[command(flatten)]
    form: BeadFlags,
    /// Root mean square of the centreline's geodesic curvature, or a range [1/m]; 0 is a geodesic.
    #[arg(
        long,
        value_name = "PER_M",
        allow_negative_numbers = true,
        value_parser = range(number(dials::CURVATURE_RMS.range)),
        help_heading = CURVE
    )]
    curvature_per_m: Option<[f64; 2]>,
    /// Largest geodesic curvature [1/m] [default: three times the root mean square asked].
    #[arg(
        long,
        value_name = "PER_M",
        allow_negative_numbers = true,
        value_parser = number(dials::CURVATURE_MAX.range),
        help_heading = CURVE
    )]
    curvature_max_per_m: Option<f64>,
    /// Correlation length of the geodesic curvature [mm] [default: half the length].
    #[arg(long, value_name = "MM", allow_negative_numbers = true, value_parser = positive, help_heading = CURVE)]
    correlation_mm: Option<f64>,
    /// Least exposure along the weld, or a range for it: the cosine-weighted free share of the hemisphere, 0 to 1.
    #[arg(
        long,
        value_name = "SHARE",
        allow_negative_numbers = true,
        value_parser = range(number(dials::EXPOSURE.range)),
        conflicts_with = "min_exposure",
        help_heading = ACCESS
    )]
    exposure: Option<[f64; 2]>,
    /// The same as --exposure SHARE..1.
    #[arg(
        long,
        value_name = "SHARE",
        allow_negative_numbers = true,
        value_parser = number(dials::EXPOSURE.range),
        help_heading = ACCESS
    )]
    min_exposure: Option<f64>,
    /// Length of exposure rays: geometry farther away does not shade [mm] [default: a quarter of the part's diagonal].
    #[arg(long, value_name = "MM", allow_negative_numbers = true, value_parser = positive, help_heading = ACCESS)]
    exposure_reach_mm: Option<f64>,
    /// Tool whose access to the weld is measured.
    #[arg(long, value_enum, default_value_t, help_heading = ACCESS)]
    access_tool: AccessToolFlag,
    /// Radius of that tool [mm].
    #[arg(
        long,
        value_name = "MM",
        default_value_t = 50.0,
        allow_negative_numbers = true,
        value_parser = positive,
        help_heading = ACCESS
    )]
    access_radius_mm: f64,
    /// Width of that tool along its axis [mm].
    #[arg(
        long,
        value_name = "MM",
        default_value_t = 10.0,
        allow_negative_numbers = true,
        value_parser = positive,
        help_heading = ACCESS
    )]
    access_width_mm: f64,
    /// Least mean share of that tool's poses that are clear of the part, 0 to 1.
    #[arg(
        long,
        value_name = "SHARE",
        allow_negative_numbers = true,
        value_parser = number(dials::LEAST_ACCESS.range),
        help_heading = ACCESS
    )]
    min_access: Option<f64>,
}

/// Difficulty of finishing the weld.
#[derive(Clone, Copy, Debug, Default, ValueEnum)]
enum DifficultyFlag {
    /// Short, nearly straight, in the open.
    Easy,
    /// A quarter to half a diagonal long, gently winding.
    #[default]
    Medium,
    /// Long, winding, in the shade of the part if it has any.
    Hard,
}

/// Placement of the weld.
#[derive(Clone, Copy, Debug, Default, ValueEnum)]
enum PlaceFlag {
    /// On smooth ground.
    #[default]
    Surface,
    /// In a concave crease.
    Seam,
    /// Where a plane cuts smooth ground, as a butt joint of two halves.
    Butt,
    /// In a crease or on smooth ground; the seed decides.
    Mixed,
}

/// Tool for the access to the weld.
#[derive(Clone, Copy, Debug, Default, ValueEnum)]
enum AccessToolFlag {
    /// A wheel on its rim.
    #[default]
    Wheel,
    /// A pad on its face.
    Pad,
}

impl WeldFlags {
    pub(super) fn wishes(&self) -> WeldSettings {
        WeldSettings {
            difficulty: match self.difficulty {
                DifficultyFlag::Easy => Difficulty::Easy,
                DifficultyFlag::Medium => Difficulty::Medium,
                DifficultyFlag::Hard => Difficulty::Hard,
            },
            count: self.count,
            placement: match self.place {
                PlaceFlag::Surface => Placement::Surface,
                PlaceFlag::Seam => Placement::Seam,
                PlaceFlag::Butt => Placement::Butt,
                PlaceFlag::Mixed => Placement::Mixed,
            },
            stitch: self.stitch(),
            shape: self.form.shape(),
            convexity: self.form.convexity,
            form: self.form.request(),
            toe_radius: self.form.toe_radius(),
            length: self.length_mm.map(|range| range.map(|mm| mm * 1e-3)),
            width: metres(self.width_mm),
            height: metres(self.height_mm),
            curvature: self.curvature_per_m,
            curvature_max: self.curvature_max_per_m,
            correlation: metres(self.correlation_mm),
            exposure: self.exposure.or(self.min_exposure.map(|least| [least, 1.0])),
            exposure_reach: metres(self.exposure_reach_mm),
            tool: self.tool(),
            min_access: self.min_access,
        }
    }

    fn tool(&self) -> ToolShape {
        ToolShape {
            kind: match self.access_tool {
                AccessToolFlag::Wheel => ToolKind::Wheel,
                AccessToolFlag::Pad => ToolKind::Pad,
            },
            radius: self.access_radius_mm * 1e-3,
            width: self.access_width_mm * 1e-3,
        }
    }

    fn stitch(&self) -> Option<Stitch> {
        let (length, pitch) = (metres(self.stitch_mm), metres(self.stitch_pitch_mm));
        length.zip(pitch).map(|(length, pitch)| Stitch { length, pitch })
    }
}

/// The answer of `weld --json`.
#[derive(Serialize)]
struct WeldAnswer<'a> {
    asset: &'a Path,
    seconds: f64,
    /// Warnings on implausible or unmet properties.
    warnings: Vec<String>,
    #[serde(flatten)]
    manifest: Manifest,
}

pub(super) fn run(args: &WeldArgs, console: &Console) -> Result<()> {
    let started = std::time::Instant::now();
    let options = WeldingOptions {
        seed: args.seed,
        fineness: args.mesh.fineness(),
        band_voxels: args.mesh.band,
        sign: args.mesh.sign.into(),
        wishes: args.wishes.wishes(),
    };
    let folder = StagedFolder::new(&args.out.beside(&[&args.file]), &ASSET)?;
    let part = Part::load(&args.file, args.mesh.unit.into())?;
    part.describe(console);
    let workpiece = weld_part(part, &options, console).with_context(|| args.file.display().to_string())?;
    let extras = Extras { density: Some(args.density), models: args.models, vdb: args.vdb, ..Extras::full(args.usd) };
    let place = asset::write(&workpiece, &options, folder, extras, console)?;
    let manifest = Manifest::read(&place)?;
    console.step("done", format!("{}", args.out.out.display()));
    let (asset, seconds) = (&args.out.out, started.elapsed().as_secs_f64());
    console.answer(&WeldAnswer { asset, seconds, warnings: workpiece.warnings(), manifest })
}
