//! Figures of an episode.

use effects::Process;

use crate::reward::{OVER, left};
use crate::strip::Strip;
use crate::task::Task;

/// Names of the figures, in their order.
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

/// Figures of an episode so far.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Metrics {
    /// Share of the bead, or of the strip's coating, that is left.
    pub left: f64,
    /// Largest depth below the target [m].
    pub gouge_depth: f64,
    /// Volume missing below the target [m³].
    pub gouge_volume: f64,
    /// Volume removed, Eq. (1) [m³].
    pub removed_volume: f64,
    /// Its difference from the bead's volume, as a share of that; 0 when sanding.
    pub removed_error: f64,
    /// Share of the strip whose dose is four times what takes the coating off.
    pub oversanded: f64,
    /// Root mean square of force minus setpoint in contact [N].
    pub force_error: f64,
    /// Time in contact [s].
    pub contact_time: f64,
    /// Time of the episode [s].
    pub time: f64,
    /// Sum of the rewards.
    pub total: f64,
}

impl Metrics {
    /// Brings the figures of the surface up to date.
    pub(crate) fn look(&mut self, task: &Task, strip: &Strip) {
        self.left = left(task, strip);
        self.gouge_depth = strip.deepest();
        self.gouge_volume = strip.volumes()[1];
        self.oversanded = strip.share_dosed(OVER);
        if task.process == Process::Grinding {
            self.removed_error = (self.removed_volume - task.volume) / task.volume;
        }
    }

    /// The figures in the order of [`METRICS`].
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
