//! Controllers: the laws by which the tool is lifted from its path.

use serde::{Deserialize, Serialize};

/// A robot's force controller.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "lowercase", tag = "kind")]
pub enum Controller {
    /// The force is the setpoint at every time.
    Ideal,
    /// `M z'' = (F - F_set) - B z'`, sampled every period. Without mass it is of first order, `B z' = F - F_set`; its samples
    /// swing, as those of a real one, where the period is longer than 2 B over the contact's stiffness [N/m].
    Admittance {
        /// M [kg]; 0 for one of first order.
        mass: f64,
        /// B [N s/m].
        damping: f64,
        /// Time between samples [s].
        period: f64,
    },
    /// The tool keeps to its path; the force follows.
    Replay,
}
