//! Trials: workpieces that are scanned, finished in passes, and scanned after each pass (`finishing-trial/1`).
//!
//! Flow of the data: [`Campaign::read`] finds the trial folders. [`Trial::read`] reads `trial.toml` (`manifest`), each
//! scan by its content (`scan`) and each log (`log`), finds the quantities for formulas (`columns`), and checks that
//! the files are consistent (`plausible`). All is SI here; millimetres stay in the files.

mod campaign;
mod columns;
mod error;
mod finding;
mod frame_offset;
mod log;
mod log_columns;
mod manifest;
mod pass_scan;
mod plan;
mod plausible;
mod poses;
mod read;
mod read_scans;
mod resample;
mod scan;
mod strokes;
mod write;

use std::path::PathBuf;

use effects::Process;
use glam::DVec3;
use robot::{Controller, Pad, Tool, Wheel};
use sdf_bake::HeightMap;

use crate::measure::{despiked, unlike_repeat};

pub use campaign::Campaign;
pub use columns::{QuantitySource, TrialColumn};
pub use error::{Place, TrialError};
pub use finding::{Checked, Finding, Severity};
pub use frame_offset::{FrameErrors, FrameOffset};
pub use log::{APPROACH_COLUMNS, Covariate, Log, REQUIRED_COLUMNS, RPM, read_log};
pub use manifest::{Role, TRIAL_FILE, TRIAL_FORMAT};
pub(crate) use manifest::{Source, nearest};
pub use pass_scan::PassScan;
pub use plan::{PLAN_NAMES, write_plan};
pub use plausible::least_gap;
pub use poses::{ClockJump, Contact, ToolPath, ToolPose};
pub(crate) use read_scans::PLANE;
pub use scan::{ExposureMask, LabelMap, Read, ScanFrame, read_exposure, read_heights, read_labels};
pub(crate) use strokes::strokes;
pub use write::{exposure_csv, heights_csv, labels_csv, log_csv, write_trial};

/// A tool as mounted on the robot.
#[derive(Clone, Debug, PartialEq)]
pub struct HeldTool {
    /// Its shape.
    pub shape: Tool,
    /// A wheel's axis, unit; `None` for a tool that spins about the approach axis.
    pub axis: Option<DVec3>,
}

impl HeldTool {
    /// A cylinder of a radius and a width [m] that spins about an axis.
    pub fn wheel(radius: f64, width: f64, axis: DVec3) -> Self {
        Self { shape: Wheel::cylinder(radius, width).into(), axis: Some(axis) }
    }

    /// A flat disc of a radius [m] that faces against the approach axis.
    pub fn pad(radius: f64) -> Self {
        Self { shape: Pad { radius }.into(), axis: None }
    }

    /// Half the tool's width across its feed [m]: a map extended by that much has no edge under the tool.
    pub fn half_width(&self) -> f64 {
        0.5 * self.shape.width()
    }
}

/// Scans of the workpiece before the first pass.
#[derive(Clone, Debug, PartialEq)]
pub struct Scans {
    /// Surface before the first pass.
    pub before: HeightMap,
    /// True if that surface was not scanned: it is the one of the drawing, without noise.
    pub is_nominal: bool,
    /// Repeated scans of the same surface.
    pub repeats: Vec<HeightMap>,
    /// Material of each pixel.
    pub material: Option<LabelMap>,
}

impl Scans {
    /// The surface before the first pass without the spikes that only the repeated scan shows.
    pub fn checked_before(&self) -> HeightMap {
        self.repeats.first().map_or_else(|| self.before.clone(), |repeat| unlike_repeat(&self.before, repeat))
    }

    /// The surface before the first pass without its spikes.
    pub fn clean_before(&self) -> HeightMap {
        despiked(&self.checked_before()).0
    }
}

/// One pass of the tool.
#[derive(Clone, Debug, PartialEq)]
pub struct Pass {
    /// Readings of robot, sensor and drive.
    pub log: Log,
    /// Scan after the pass; [missing](PassScan::is_missing) if there was none.
    pub scan: PassScan,
    /// Split: calibration or evaluation.
    pub role: Role,
    /// Setpoint of the controller [N].
    pub force_setpoint: f64,
    /// Speed along the path [m/s].
    pub feed: f64,
    /// Nominal spindle speed [rad/s].
    pub spindle_speed: f64,
    /// Feed direction, unit.
    pub direction: DVec3,
}

/// Source of the controller's setpoint.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum ForceInput {
    /// The setpoint of each pass.
    #[default]
    Setpoint,
    /// The logged force.
    Log,
}

/// A trial with all its data.
#[derive(Clone, Debug, PartialEq)]
pub struct Trial {
    /// Folder from which it was read.
    pub folder: PathBuf,
    /// Its name.
    pub name: String,
    /// Process: grinding or sanding.
    pub process: Process,
    /// The tool.
    pub tool: HeldTool,
    /// True if the tool was dressed or new before the first pass; otherwise it keeps its wear from the previous trial.
    pub fresh: bool,
    /// Scans of the workpiece before the first pass.
    pub scans: Scans,
    /// Force controller; a replay of the logged z if the files name none.
    pub controller: Controller,
    /// Source of the controller's setpoint.
    pub force_input: ForceInput,
    /// Prior standard deviations of the errors of the robot's frame and clock.
    pub frame_errors: FrameErrors,
    /// Transform that was applied to the logs since they were read.
    pub frame_offset: FrameOffset,
    /// Thickness of the coating [m].
    pub coating: Option<f64>,
    /// Passes in order of time.
    pub passes: Vec<Pass>,
    /// Quantities for formulas, besides pose, force and speed.
    pub columns: Vec<TrialColumn>,
    /// Notes on the interpretation of unusual files, one sentence each.
    pub notes: Vec<String>,
    /// The notes that come from consistency checks, machine-readable.
    pub findings: Vec<Finding>,
}

impl Trial {
    /// The first scan after a pass, and all passes up to it; `None` if none was scanned.
    pub fn first_scanned(&self) -> Option<(&[Pass], &PassScan)> {
        let first = self.passes.iter().position(|pass| !pass.scan.is_missing())?;
        Some((&self.passes[..=first], &self.passes[first].scan))
    }
}
