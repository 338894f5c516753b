//! Flags that several verbs share.

use std::path::{Path, PathBuf};
use std::str::FromStr;

use anyhow::Result;
use clap::{Args, ValueEnum};
use sdf_bake::SignChoice;
use sdf_bake::read::UnitChoice;

use crate::workpiece::Fineness;
use crate::wrong_use;
use files::output::Out;

/// Default number of voxels along the longest side.
const DEFAULT_RESOLUTION: u32 = 256;
/// Voxels along a side or diagonal that are accepted.
const VOXELS: [u64; 2] = [8, 4096];
/// Processes or meshes at once that are accepted; no machine for this can hold more.
pub(super) const JOBS: [u64; 2] = [1, 256];
/// Items that a run may be limited to.
pub(super) const LIMITS: [u64; 2] = [1, u64::MAX];
/// Seeds: any number of 64 bits.
pub(super) const SEEDS: [u64; 2] = [0, u64::MAX];

/// Unit of a mesh file.
#[derive(Clone, Copy, Debug, Default, ValueEnum)]
pub(super) enum UnitFlag {
    /// Taken from the format and the size; what was assumed is said.
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

/// How inside and outside are told apart.
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
/// Heading of the help for the order, the number and the limits of jobs.
pub(super) const RUNS: &str = "Runs";

/// Reading and baking a mesh.
#[derive(Clone, Debug, Args)]
pub(super) struct MeshFlags {
    /// Unit of the file's coordinates.
    #[arg(long, value_enum, default_value_t)]
    pub(super) unit: UnitFlag,
    /// Distance between voxels [mm].
    #[arg(long, value_name = "MM", conflicts_with = "resolution", allow_negative_numbers = true)]
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
    #[arg(long, value_name = "VOXELS", default_value_t = 3.0, allow_negative_numbers = true)]
    pub(super) band: f64,
    /// How inside and outside are told apart.
    #[arg(long, value_enum, default_value_t)]
    pub(super) sign: SignFlag,
    /// Bake the surface itself as a shell of this thickness [mm], instead of what it encloses.
    #[arg(long, value_name = "MM", conflicts_with = "sign", allow_negative_numbers = true)]
    pub(super) shell_mm: Option<f64>,
}

impl MeshFlags {
    /// The voxel size asked for.
    pub(super) fn fineness(&self) -> Result<Fineness> {
        self.fineness_or(Fineness::Resolution(DEFAULT_RESOLUTION))
    }

    /// The voxel size asked for, or another default.
    pub(super) fn fineness_or(&self, default: Fineness) -> Result<Fineness> {
        if let Some(mm) = self.voxel_mm {
            return Ok(Fineness::Voxel(positive("--voxel-mm", mm)? * 1e-3));
        }
        let across = self.diagonal.map(Fineness::Diagonal).or(self.resolution.map(Fineness::Resolution));
        Ok(across.unwrap_or(default))
    }

    /// The thickness of the shell asked for [m].
    pub(super) fn shell(&self) -> Result<Option<f64>> {
        optional_mm("--shell-mm", self.shell_mm)
    }

    /// Refuses `--shell-mm` where the part must be solid.
    pub(super) fn solid_only(&self, verb: &str) -> Result<()> {
        match self.shell_mm {
            Some(_) => Err(wrong_use(format!("--shell-mm: only `robofin bake` takes it; `{verb}` needs a solid part"))),
            None => Ok(()),
        }
    }

    /// The band asked for [voxels].
    pub(super) fn band_voxels(&self) -> Result<f64> {
        if !(2.0..=64.0).contains(&self.band) {
            return Err(wrong_use(format!("--band {}: 2 to 64 voxels are accepted", self.band)));
        }
        Ok(self.band)
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
    /// The place asked for, with what the verb reads.
    pub(super) fn beside<'a>(&'a self, inputs: &'a [&'a Path]) -> Out<'a> {
        Out { place: &self.out, force: self.force, inputs }
    }
}

/// One number, or two with `..` between: a range to draw from, both ends included.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct RangeFlag(pub(super) [f64; 2]);

impl FromStr for RangeFlag {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let number = |word: &str| {
            word.trim().parse::<f64>().map_err(|_| format!("{word:?} is no number; a number, or A..B, is expected"))
        };
        match text.split_once("..") {
            None => Ok(Self([number(text)?; 2])),
            Some((low, high)) => match [number(low)?, number(high)?] {
                [low, high] if low > high => Err(format!("{low} is above {high}; the lower end comes first")),
                range => Ok(Self(range)),
            },
        }
    }
}

impl RangeFlag {
    /// Both ends checked as a number of the flag would be.
    pub(super) fn checked(self, check: impl Fn(f64) -> Result<f64>) -> Result<[f64; 2]> {
        let [low, high] = self.0;
        Ok([check(low)?, check(high)?])
    }
}

/// Reads a whole number between bounds, both included.
pub(super) fn whole<T: TryFrom<u64>>(
    [least, most]: [u64; 2],
) -> impl Fn(&str) -> Result<T, String> + Clone + Send + Sync {
    move |text| {
        let number = text.parse::<u64>().ok().filter(|number| (least..=most).contains(number));
        number.and_then(|number| T::try_from(number).ok()).ok_or_else(|| match most {
            u64::MAX => format!("a whole number of 64 bits, {least} or more, is accepted"),
            _ => format!("a whole number from {least} to {most} is accepted"),
        })
    }
}

/// Checks that a flag's number is finite and above zero.
pub(super) fn positive(flag: &str, value: f64) -> Result<f64> {
    if value > 0.0 && value.is_finite() {
        Ok(value)
    } else {
        Err(wrong_use(format!("{flag} {value:?}: a number above zero is expected")))
    }
}

/// Checks that a flag's number is within bounds, both included.
pub(super) fn within(flag: &str, value: f64, (least, most): (f64, f64)) -> Result<f64> {
    if (least..=most).contains(&value) {
        Ok(value)
    } else {
        Err(wrong_use(format!("{flag} {value:?}: {least:?} to {most:?} is accepted")))
    }
}

/// Contact stiffness that verbs accept [Pa/m]: from the softest foam that the law is calibrated for to ten times its
/// hardest wheel.
const STIFFNESS: (f64, f64) = (1e5, 1e14);

/// Checks `--stiffness` [Pa/m].
pub(super) fn stiffness(value: f64) -> Result<f64> {
    within("--stiffness", value, STIFFNESS)
}

/// As [`positive`], for a flag in millimetres; the result is in metres.
pub(super) fn optional_mm(flag: &str, value: Option<f64>) -> Result<Option<f64>> {
    value.map(|mm| Ok(positive(flag, mm)? * 1e-3)).transpose()
}
