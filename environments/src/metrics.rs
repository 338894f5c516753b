//! Metrics of an episode.

use effects::Signal;

use crate::reward::{OVERSANDED_DOSE, left};
use crate::strip::Strip;
use crate::task::Task;

/// Names of the metrics, in their order.
pub const METRICS: [&str; 10] = [
    "left",
    "gouge_depth",
    "gouge_volume",
    "removed_volume",
    "removed_error",
    "oversanded",
    "force_error",
    "contact_time",
    "time",
    "return",
];

/// Metrics of an episode so far.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Metrics {
    /// Remaining share of the bead, or of the strip that is still coated.
    pub left: f64,
    /// Greatest depth below the target [m].
    pub gouge_depth: f64,
    /// Missing volume below the target [m³].
    pub gouge_volume: f64,
    /// Removed volume, Eq. (1) [m³].
    pub removed_volume: f64,
    /// Removed volume minus the bead's volume, relative to the bead's volume; 0 for sanding.
    pub removed_error: f64,
    /// Share of the strip with a dose of four or more; the coating is gone at one.
    pub oversanded: f64,
    /// Root mean square of force minus setpoint in contact [N].
    pub force_error: f64,
    /// Time in contact [s].
    pub contact_time: f64,
    /// Time of the episode [s].
    pub time: f64,
    /// Sum of the rewards so far.
    pub total: f64,
}

impl Metrics {
    /// Updates the metrics that depend on the surface.
    pub(crate) fn look(&mut self, task: &Task, strip: &Strip) {
        self.left = left(task, strip);
        self.gouge_depth = strip.deepest();
        self.gouge_volume = strip.volumes()[1];
        self.oversanded = strip.share_dosed(OVERSANDED_DOSE);
        if task.process.signal() == Signal::Height {
            self.removed_error = (self.removed_volume - task.volume) / task.volume;
        }
    }

    /// Returns the metrics in the order of [`METRICS`].
    pub fn values(&self) -> [f64; METRICS.len()] {
        [
            self.left,
            self.gouge_depth,
            self.gouge_volume,
            self.removed_volume,
            self.removed_error,
            self.oversanded,
            self.force_error,
            self.contact_time,
            self.time,
            self.total,
        ]
    }
}
