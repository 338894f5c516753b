//! Flags shared by several verbs.

use std::path::{Path, PathBuf};

use clap::{Arg, Args, ValueEnum};
use sdf_bake::SignChoice;
use sdf_bake::read::UnitChoice;

use super::values::{number, positive, whole};
use crate::workpiece::Fineness;
use files::output::OutputPath;

/// Default number of voxels along the longest side.
const DEFAULT_RESOLUTION: u32 = 256;
/// Accepted numbers of voxels along a side or diagonal.
const VOXELS: [u64; 2] = [8, 4096];
/// Accepted numbers of processes or meshes at once.
pub(super) const JOBS: [u64; 2] = [1, 256];
/// Accepted limits on the number of items.
pub(super) const LIMITS: [u64; 2] = [1, u64::MAX];
/// Accepted seeds: any 64-bit number.
pub(super) const SEEDS: [u64; 2] = [0, u64::MAX];

/// Unit of a mesh file.
#[derive(Clone, Copy, Debug, Default, ValueEnum)]
pub(super) enum UnitFlag {
    /// Taken from the format and the size; an assumption is reported.
    #[default]
    Auto,
    /// Metres.
    M,
    /// Millimetres.
    Mm,
    /// Inches.
    Inch,
}

impl From<UnitFlag> for UnitChoice {
    fn from(flag: UnitFlag) -> Self {
        match flag {
            UnitFlag::Auto => Self::Auto,
            UnitFlag::M => Self::Metre,
            UnitFlag::Mm => Self::Millimetre,
            UnitFlag::Inch => Self::Inch,
        }
    }
}

/// Rule that distinguishes inside from outside.
#[derive(Clone, Copy, Debug, Default, ValueEnum)]
pub(super) enum SignFlag {
    /// Whatever suits the surface; refuses an open one whose inside is unclear.
    #[default]
    Auto,
    /// Angle-weighted normals; refuses a surface on which they can err.
    Normal,
    /// As auto, also where an open surface leaves the inside to a guess.
    Winding,
}

impl From<SignFlag> for SignChoice {
    fn from(flag: SignFlag) -> Self {
        match flag {
            SignFlag::Auto => Self::Auto,
            SignFlag::Normal => Self::Normal,
            SignFlag::Winding => Self::Winding,
        }
    }
}

/// Heading of the help for reading and baking a mesh.
pub(super) const MESH: &str = "Mesh and field";
/// Heading of the help for order, number and limits of jobs.
pub(super) const RUNS: &str = "Runs";

/// Reading and baking a mesh.
#[derive(Clone, Debug, Args)]
pub(super) struct MeshFlags {
    /// Unit of the file's coordinates.
    #[arg(long, value_enum, default_value_t)]
    pub(super) unit: UnitFlag,
    /// Distance between voxels [mm].
    #[arg(
        long,
        value_name = "MM",
        conflicts_with = "resolution",
        allow_negative_numbers = true,
        value_parser = positive
    )]
    pub(super) voxel_mm: Option<f64>,
    /// Voxels along the longest side [default: 256].
    #[arg(long, value_name = "N", allow_negative_numbers = true, value_parser = whole::<u32>(VOXELS))]
    pub(super) resolution: Option<u32>,
    /// Voxels along the diagonal of the bounding box, instead of the longest side.
    #[arg(
        long,
        value_name = "N",
        conflicts_with_all = ["resolution", "voxel_mm"],
        allow_negative_numbers = true,
        value_parser = whole::<u32>(VOXELS)
    )]
    pub(super) diagonal: Option<u32>,
    /// Half width of the band [voxels].
    #[arg(
        long,
        value_name = "VOXELS",
        default_value_t = 3.0,
        allow_negative_numbers = true,
        value_parser = number([2.0, 64.0])
    )]
    pub(super) band: f64,
    /// Rule that distinguishes inside from outside.
    #[arg(long, value_enum, default_value_t)]
    pub(super) sign: SignFlag,
    /// Bake the surface itself as a shell of this thickness [mm], instead of what it encloses.
    #[arg(long, value_name = "MM", conflicts_with = "sign", allow_negative_numbers = true, value_parser = positive)]
    pub(super) shell_mm: Option<f64>,
}

impl MeshFlags {
    /// Returns the requested voxel size.
    pub(super) fn fineness(&self) -> Fineness {
        self.fineness_or(Fineness::Resolution(DEFAULT_RESOLUTION))
    }

    /// Returns the requested voxel size, or another default.
    pub(super) fn fineness_or(&self, default: Fineness) -> Fineness {
        let across = self.diagonal.map(Fineness::Diagonal).or(self.resolution.map(Fineness::Resolution));
        metres(self.voxel_mm).map(Fineness::Voxel).or(across).unwrap_or(default)
    }

    /// Returns the requested thickness of the shell [m].
    pub(super) fn shell(&self) -> Option<f64> {
        metres(self.shell_mm)
    }
}

/// Where results go.
#[derive(Clone, Debug, Args)]
pub(super) struct OutFlags {
    /// Folder or file to make.
    #[arg(long, value_name = "PATH")]
    pub(super) out: PathBuf,
    /// Replace an earlier result of this command there; never an input, nor a folder that holds anything else.
    #[arg(long)]
    pub(super) force: bool,
}

impl OutFlags {
    /// Returns the output path, with the inputs of the verb.
    pub(super) fn beside<'a>(&'a self, inputs: &'a [&'a Path]) -> OutputPath<'a> {
        OutputPath { place: &self.out, force: self.force, inputs }
    }
}

/// Refuses and hides `--shell-mm` of a verb that needs a solid part.
pub(super) fn solid_only(shell: Arg) -> Arg {
    shell
        .hide(true)
        .value_parser(|_: &str| Err::<f64, _>("only `robofin bake` takes it, and a weld needs a solid part".to_owned()))
}

/// Accepted contact stiffness [Pa/m]: from the law's softest foam to ten times its hardest wheel.
pub(super) const STIFFNESS: [f64; 2] = [1e5, 1e14];

/// Converts millimetres to metres, if given.
pub(super) fn metres(mm: Option<f64>) -> Option<f64> {
    mm.map(|mm| mm * 1e-3)
}
