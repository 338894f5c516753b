//! A dial that is out of range: its name, what was found and what would do.

use thiserror::Error;

/// Why a request cannot be met on any part.
#[derive(Clone, Debug, Error, PartialEq)]
#[error("the {dial} is {found}; it must be {accepted}")]
pub struct DialFault {
    /// Name of the dial, such as `ripple pitch`.
    pub dial: &'static str,
    /// Its value, with its unit.
    pub found: String,
    /// What would be accepted.
    pub accepted: String,
}

/// A number to six digits, short whatever its size.
pub(crate) fn shown(value: f64) -> String {
    format!("{:?}", format!("{value:.5e}").parse::<f64>().unwrap_or(value))
}

/// A length [m] in millimetres.
pub(crate) fn shown_mm(length: f64) -> String {
    format!("{} mm", shown(1e3 * length))
}
