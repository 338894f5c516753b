//! Error for a dial that is out of range: its name, the value found and the accepted values.

use thiserror::Error;

/// A dial that no part can satisfy.
#[derive(Clone, Debug, Error, PartialEq)]
#[error("the {dial} is {found}; it must be {accepted}")]
pub struct DialFault {
    /// Name of the dial, such as `ripple pitch`.
    pub dial: &'static str,
    /// Value with its unit.
    pub found: String,
    /// Accepted values.
    pub accepted: String,
}

/// Formats a number with six significant digits.
pub(crate) fn shown(value: f64) -> String {
    format!("{:?}", format!("{value:.5e}").parse::<f64>().unwrap_or(value))
}

/// Formats a length [m] in millimetres.
pub(crate) fn shown_mm(length: f64) -> String {
    format!("{} mm", shown(1e3 * length))
}
