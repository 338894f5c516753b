//! Report data of passes and scans: maps, sections, volumes, the waterfall.

use sdf_bake::PixelGrid;

use super::data::DisplayUnit;
use lab::ErrorUnit;
use trials::measure::Registration;
use trials::trial::Role;

/// A pass that was compared.
#[derive(Clone, Debug)]
pub struct ComparedPass {
    /// Trial and pass, such as `plate-03, pass 1`.
    pub name: String,
    /// Role of the pass: fitted, or held out.
    pub role: Role,
    /// Force setpoint [N].
    pub force: Option<f64>,
    /// Feed [m/s].
    pub feed: Option<f64>,
    /// Spindle speed [rad/s].
    pub spindle_speed: Option<f64>,
    /// Scan noise [m]: root mean square of one pixel's error in its scan.
    pub noise_floor: Option<f64>,
    /// Registration of its scan on the untouched surface.
    pub alignment: Option<Registration>,
}

/// Error measure of the waterfall.
#[derive(Clone, Debug)]
pub struct Misfit {
    /// Name of the measure, such as `height, root mean square` or `pixels that disagree`.
    pub name: String,
    /// Display unit, such as µm or %.
    pub unit: DisplayUnit,
}

impl Misfit {
    /// Height error in micrometres.
    pub fn heights() -> Self {
        Self { name: "height, root mean square".to_owned(), unit: DisplayUnit::new("µm", 1e-6) }
    }

    /// Errors of scans, or of the removal of a table's rows.
    pub fn of(unit: ErrorUnit) -> Self {
        match unit {
            ErrorUnit::Metre => Self::heights(),
            ErrorUnit::Share => Self { name: "removal".to_owned(), unit: DisplayUnit::new("%", 0.01) },
        }
    }
}

/// Error after each step, from the raw difference to the noise floor.
#[derive(Clone, Debug)]
pub struct Waterfall {
    /// Error measure of the steps.
    pub misfit: Misfit,
    /// Names of the passes whose volumes are listed, such as `plate-03, pass 1`.
    pub passes: Vec<String>,
    /// Raw, registered, base model, each added effect; the last one is the noise floor.
    pub steps: Vec<WaterfallStep>,
    /// Notes, one sentence each.
    pub notes: Vec<String>,
}

/// One step of the waterfall.
#[derive(Clone, Debug, Default)]
pub struct WaterfallStep {
    /// Name, such as `base model` or `+ grit-dulling`.
    pub name: String,
    /// Error over calibration passes, SI.
    pub calibration: Option<f64>,
    /// Error over evaluation passes, SI.
    pub evaluation: Option<f64>,
    /// Error of the volume that each pass removed and its standard uncertainty, relative to the measured volume [1];
    /// the same volume as in [`PassVolume`].
    pub volume_errors: Vec<Option<(f64, f64)>>,
    /// Root mean square of the error of the plateaus' slopes across the path [1].
    pub plateau_slope: Option<f64>,
    /// Mean intersection over union of the exposed areas [1].
    pub overlap: Option<f64>,
    /// Unexplained share of the base model's excess [1]: 1 at the base model, `None` before it and at the floor.
    pub unexplained: Option<f64>,
}

/// Removed volume of a pass.
#[derive(Clone, Debug)]
pub struct PassVolume {
    /// The pass.
    pub pass: String,
    /// Measured [m³].
    pub measured: f64,
    /// Its standard uncertainty from noise and alignment [m³].
    pub uncertainty: f64,
    /// Simulated with the base model [m³].
    pub base: f64,
    /// Simulated with the effect [m³].
    pub with_effect: Option<f64>,
}

/// Comparison of one scan with the simulation.
#[derive(Clone, Debug)]
pub struct ScanComparison {
    /// The pass after which it was taken, such as `plate-03, pass 1`.
    pub pass: String,
    /// Role of the pass: fitted, or held out.
    pub role: Role,
    /// The maps.
    pub maps: Maps,
}

/// Content of a scan.
#[derive(Clone, Debug)]
pub enum Maps {
    /// Heights after grinding.
    Heights(HeightMaps),
    /// Exposed substrate after sanding.
    Exposure(ExposureMaps),
}

/// Residuals of a height map: measured - simulated, so that positive is material left over.
#[derive(Clone, Debug)]
pub struct HeightMaps {
    /// Positions of the pixels.
    pub pixels: PixelGrid,
    /// Measured - base model [m], NaN where missing, shape `[ny, nx]`.
    pub base: Vec<f64>,
    /// Measured - model with the effects found [m]; `None` without one.
    pub with_effect: Option<Vec<f64>>,
    /// Pixels over which statistics are taken, such as those the tool touched; shape `[ny, nx]`.
    pub judged: Vec<bool>,
    /// Description of these pixels, such as `touched by the tool`.
    pub judged_as: String,
    /// Scan noise [m]: root mean square of one pixel's error.
    pub noise_floor: f64,
}

/// Exposed substrate after sanding, measured and simulated.
#[derive(Clone, Debug)]
pub struct ExposureMaps {
    /// Positions of the pixels.
    pub pixels: PixelGrid,
    /// Measured; `None` where the optics were undecided, shape `[ny, nx]`.
    pub measured: Vec<Option<bool>>,
    /// Simulated with the base model, shape `[ny, nx]`.
    pub base: Vec<bool>,
    /// Simulated with the effects found, shape `[ny, nx]`.
    pub with_effect: Option<Vec<bool>>,
}

/// Direction of a section.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Direction {
    /// Across the bead at this x [m].
    Across(f64),
    /// Along x at this y [m].
    Along(f64),
    /// Along the crest.
    AlongCrest,
}

/// A section through a scan.
#[derive(Clone, Debug)]
pub struct ScanSection {
    /// The pass after which the scan was taken.
    pub pass: String,
    /// Direction of the section.
    pub direction: Direction,
    /// Position along the section [m].
    pub position: Vec<f64>,
    /// Measured heights, levelled on the untouched surface [m], NaN where missing.
    pub measured: Vec<f64>,
    /// Heights of the base model, shifted sideways to where they fit best [m].
    pub base: Vec<f64>,
    /// Heights with the effects found, likewise [m].
    pub with_effect: Option<Vec<f64>>,
    /// Scan noise [m]: root mean square of one pixel's error.
    pub noise_floor: f64,
}

/// Mean of (measured - simulated) / simulated removal over a bin of a covariate; when sanding, of the share of
/// substrate.
#[derive(Clone, Copy, Debug)]
pub struct Bin {
    /// Mean of the covariate, SI.
    pub covariate: f64,
    /// Mean relative residual [1].
    pub residual: f64,
    /// Its 95 % band from the block bootstrap [1].
    pub band: [f64; 2],
}

/// Residual of the base model over one covariate.
#[derive(Clone, Debug)]
pub struct CovariatePlot {
    /// Name, such as `contact pressure`.
    pub name: String,
    /// Display unit.
    pub unit: DisplayUnit,
    /// Bins in ascending order of the covariate.
    pub bins: Vec<Bin>,
    /// The same bins with the effects found; empty if there are none.
    pub with_effect: Vec<Bin>,
    /// Share of the excess variance that a spline of it explains [1].
    pub share: f64,
    /// Fall of the share that all covariates explain together when this one is left out [1].
    pub drop: f64,
    /// P-value of the share where residuals do not depend on the covariate [1].
    pub p_value: f64,
    /// P-value that the largest share of any covariate reaches this one where none matters [1].
    pub p_value_of_all: f64,
}
