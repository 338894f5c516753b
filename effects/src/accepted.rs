//! Values of a parameter that a model may state.

use super::error::Problem;
use super::unit::Unit;

/// Relative rounding error of two unit conversions, a few units in the last place.
const ROUNDING: f64 = 1e-14;

/// Values that a parameter may have [SI].
#[derive(Clone, Copy, Debug)]
pub struct Accepted<'a> {
    /// Least and greatest plausible value [SI].
    pub(super) range: [f64; 2],
    /// Null value, at which the effect vanishes; it may lie outside the range.
    pub(super) null: Option<f64>,
    /// Typical value; it may lie outside the range if it is the null value.
    pub(super) default: f64,
    /// Unit in files and tables.
    pub(super) unit: Unit,
    /// The unit as written.
    pub(super) unit_text: &'a str,
}

impl Accepted<'_> {
    /// Rejects a value [SI] that is neither within the range, nor the null value, nor the typical value.
    ///
    /// # Errors
    /// The value and the range, in the parameter's unit.
    pub fn check(&self, value: f64) -> Result<(), Problem> {
        // A value in a different unit from the range may differ by the rounding of both conversions.
        let [low, high] = self.range;
        let within = (low - ROUNDING * low.abs()..=high + ROUNDING * high.abs()).contains(&value);
        if within || Some(value) == self.null || value == self.default {
            return Ok(());
        }
        let null = match self.null.filter(|null| !(low..=high).contains(null)) {
            Some(null) => format!(", or {}, where the effect vanishes,", self.unit.show(null)),
            None => String::new(),
        };
        let expected = format!("a value from {} to {}{null}", self.shown(low), self.shown(high));
        Err(Problem::Value { found: self.shown(value), expected })
    }

    fn shown(&self, value: f64) -> String {
        let unit = if self.unit_text == "1" { String::new() } else { format!(" {}", self.unit_text) };
        format!("{}{unit}", self.unit.show(value))
    }
}
