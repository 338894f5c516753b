//! Trials: workpieces that were scanned, finished in passes, and scanned after each pass (`finishing-trial/1`).
//!
//! The road of the data: [`Campaign::read`] finds the trial folders, [`Trial::read`] reads `trial.toml` (`manifest`),
//! each scan by its content (`scan`, `height_csv`, `keyence`, `x3p`, `mesh_scan`) and each log (`log`), and checks that
//! they fit each other (`plausible`). All is SI here; millimetres stay in the files.

mod campaign;
mod error;
mod finding;
mod height_csv;
mod keyence;
mod log;
mod manifest;
mod mesh_scan;
mod plausible;
mod poses;
mod read;
mod scan;
mod table;
mod write;
mod x3p;

use std::path::PathBuf;

use glam::DVec3;
use sdf_bake::HeightMap;
use serde::Serialize;

use crate::measure::{despiked, unlike_repeat};

pub use campaign::Campaign;
pub use error::{Place, TrialError};
pub use finding::{Finding, Severity};
pub use log::{APPROACH_COLUMNS, Covariate, Log, LogRow, REQUIRED_COLUMNS, RPM, read_log};
pub use manifest::{Process, Role, TRIAL_FILE, TRIAL_FORMAT};
pub(crate) use manifest::{Source, nearest};
pub use plausible::least_gap;
pub use poses::{ClockJump, Contact, ToolPath, ToolPose};
pub use scan::{ExposureMask, LabelMap, Read, ScanFrame, read_exposure, read_heights, read_labels};
pub(crate) use table::{Row as TextRow, Table as TextTable};
pub use write::{exposure_csv, heights_csv, labels_csv, log_csv, write_trial};

/// The tool's shape.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub enum Tool {
    /// A cylinder that turns about its axis.
    Wheel {
        /// Radius [m].
        radius: f64,
        /// Width along the axis [m].
        width: f64,
        /// Axis, unit.
        axis: DVec3,
    },
    /// A flat disc that faces against the approach axis.
    Pad {
        /// Radius [m].
        radius: f64,
    },
}

impl Tool {
    /// Half of what the tool covers across its feed [m]: a map continued that far has no edge under it.
    pub fn half_width(&self) -> f64 {
        match *self {
            Self::Wheel { width, .. } => 0.5 * width,
            Self::Pad { radius } => radius,
        }
    }
}

/// What held the force.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub enum Controller {
    /// `mass · z'' = (F - setpoint) - damping · z'`.
    Admittance {
        /// Virtual mass [kg].
        mass: f64,
        /// Virtual damping [N s/m].
        damping: f64,
        /// Time between two control steps [s].
        period: f64,
    },
    /// The force is the setpoint.
    Ideal,
}

/// The workpiece before the first pass.
#[derive(Clone, Debug, PartialEq)]
pub struct Scans {
    /// Surface before the first pass.
    pub before: HeightMap,
    /// The same surface scanned again.
    pub repeats: Vec<HeightMap>,
    /// Material of each pixel.
    pub material: Option<LabelMap>,
}

impl Scans {
    /// The surface before the first pass without the spikes that only the repeated scan shows.
    pub fn checked_before(&self) -> HeightMap {
        self.repeats.first().map_or_else(|| self.before.clone(), |repeat| unlike_repeat(&self.before, repeat))
    }

    /// The surface before the first pass without any spikes.
    pub fn clean_before(&self) -> HeightMap {
        despiked(&self.checked_before()).0
    }
}

/// What was seen after a pass.
#[derive(Clone, Debug, PartialEq)]
pub enum PassScan {
    /// The ground surface.
    Heights(HeightMap),
    /// Where sanding went through the coating.
    Exposure(ExposureMask),
}

/// One pass of the tool.
#[derive(Clone, Debug, PartialEq)]
pub struct Pass {
    /// What robot, sensor and drive reported.
    pub log: Log,
    /// What was seen afterwards.
    pub scan: PassScan,
    /// Whether it may be fitted.
    pub role: Role,
    /// Force that the controller should hold [N].
    pub force_setpoint: f64,
    /// Speed along the path [m/s].
    pub feed: f64,
    /// Nominal spindle speed [rad/s].
    pub spindle_speed: f64,
    /// Feed direction, unit.
    pub direction: DVec3,
}

/// A trial with all its data.
#[derive(Clone, Debug, PartialEq)]
pub struct Trial {
    /// Where it was read.
    pub folder: PathBuf,
    /// Its name.
    pub name: String,
    /// What the tool does.
    pub process: Process,
    /// The tool.
    pub tool: Tool,
    /// Whether the tool was dressed or new before the first pass; otherwise it carries on from the trial before.
    pub fresh: bool,
    /// The workpiece before.
    pub scans: Scans,
    /// What held the force; `None`: z is replayed from the log.
    pub controller: Option<Controller>,
    /// Thickness of the coating [m].
    pub coating: Option<f64>,
    /// Passes in order of time.
    pub passes: Vec<Pass>,
    /// What was understood of the files where it was not the plain case, one sentence each.
    pub notes: Vec<String>,
    /// Those of the notes that checks of the files against each other made, for machines.
    pub findings: Vec<Finding>,
}
