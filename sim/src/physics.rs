//! What happens in a contact: pressure from depth, recession and dose from pressure.

use serde::{Deserialize, Serialize};

/// Columns in contact, one lane each.
#[derive(Clone, Debug, Default)]
pub struct Lanes {
    /// Mean depth over the wet share of the square [m].
    pub depth: Vec<f64>,
    /// Slip speed [m/s].
    pub slip_speed: Vec<f64>,
}

/// The base laws.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct BaseLaw {
    /// K [Pa/m].
    pub stiffness: f64,
    /// k [m/(Pa s)].
    pub grind_rate: f64,
    /// p_c [Pa].
    pub threshold_pressure: f64,
    /// K_P/h_c [1/(Pa m)].
    pub sanding_rate: f64,
}

impl BaseLaw {
    /// `p = K depth` [Pa].
    pub fn pressure(&self, depth: &[f64], out: &mut Vec<f64>) {
        out.clear();
        out.extend(depth.iter().map(|d| self.stiffness * d));
    }

    /// Eq. (1): `r = k max(p - p_c, 0)` [m/s].
    pub fn rate(&self, pressure: &[f64], out: &mut Vec<f64>) {
        out.clear();
        out.extend(pressure.iter().map(|p| self.grind_rate * (p - self.threshold_pressure).max(0.0)));
    }
}
