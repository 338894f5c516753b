//! What a pass leaves behind besides the part.

use glam::DVec3;
use serde::{Deserialize, Serialize};

/// One row of the log, as robot and force sensor would report it.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct LogRow {
    /// Since the start of the pass [s].
    pub time: f64,
    /// Centre of the wheel [m].
    pub position: DVec3,
    /// Approach axis, unit, out of the part.
    pub approach: DVec3,
    /// Normal force [N].
    pub force: f64,
    /// Speed of the wheel [rad/s].
    pub spindle_speed: f64,
}

/// One pass.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct PassRecord {
    /// From the air, over the surface, back into the air.
    pub log: Vec<LogRow>,
    /// Steps taken.
    pub steps: usize,
    /// Steps in which there was nothing to press against.
    pub steps_in_air: usize,
    /// Volume lost by the field [m³].
    pub removed_volume: f64,
    /// `∫∫ k max(p - p_c, 0) dA dt` over the contact patch [m³]: what Eq. (1) asks for.
    pub removed_volume_by_law: f64,
    /// `∫ F dt` [N s]. For p_c = 0 and gentle slopes, k times this is the removed volume.
    pub impulse: f64,
    /// Root mean square of force minus setpoint, over the steps in contact [N].
    pub force_rms_error: f64,
    /// Highest pressure met [Pa].
    pub pressure_max: f64,
    /// Time simulated [s].
    pub duration: f64,
}
