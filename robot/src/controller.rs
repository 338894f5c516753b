//! Controllers: the laws that set the tool's travel from its path.

use serde::{Deserialize, Serialize};

/// A robot's force controller.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "lowercase", tag = "kind")]
pub enum Controller {
    /// The force equals the setpoint at all times.
    Ideal,
    /// `M z'' = (F - F_set) - B z'`, sampled once per period. Without mass it is of first order, `B z' = F - F_set`.
    /// Its samples oscillate, as those of a real one, if the period exceeds 2 B over the contact's stiffness [N/m].
    Admittance {
        /// M [kg]; 0 for a first-order controller.
        mass: f64,
        /// B [N s/m].
        damping: f64,
        /// Time between samples [s].
        period: f64,
    },
    /// The tool keeps to its path; the force is a result.
    Replay,
}
