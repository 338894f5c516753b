//! A row of a robot's log.

use glam::DVec3;
use serde::{Deserialize, Serialize};

/// One row of a log, as robot and force sensor report it.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct LogRow {
    /// Time of the controller's clock, or since the start of a simulated pass [s].
    pub time: f64,
    /// The tool's reference point: centre of a wheel or of a pad's face [m].
    pub position: DVec3,
    /// Normal force [N].
    pub force: f64,
    /// Speed of the spindle [rad/s].
    pub spindle_speed: f64,
    /// Approach axis, unit, out of the part.
    pub approach: DVec3,
}
