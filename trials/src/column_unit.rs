//! Units of columns: those of effect files, degrees Celsius, and unit suffixes of column names.

use effects::{Dimension, Unit};
use files::input::without_content;

/// Unit of a spindle speed that means revolutions per second.
const TURNS_A_SECOND: &str = "Hz";
/// Zero of the Celsius scale [K].
const CELSIUS: f64 = 273.15;
/// Names of degrees Celsius.
const CELSIUS_NAMES: [&str; 3] = ["°C", "degC", "C"];
/// Unit suffixes of column names, the longest first.
const ENDS: [(&str, &str); 23] = [
    ("_mm_s", "mm/s"),
    ("_m_s", "m/s"),
    ("_mm2", "mm^2"),
    ("_mm3", "mm^3"),
    ("_deg", "deg"),
    ("_min", "min"),
    ("_mpa", "MPa"),
    ("_kpa", "kPa"),
    ("_rpm", "rpm"),
    ("_pct", "%"),
    ("_mm", "mm"),
    ("_um", "um"),
    ("_ms", "ms"),
    ("_hz", "Hz"),
    ("_kg", "kg"),
    ("_pa", "Pa"),
    ("_m", "m"),
    ("_n", "N"),
    ("_s", "s"),
    ("_h", "h"),
    ("_c", "degC"),
    ("_k", "K"),
    ("_w", "W"),
];

/// A unit of a column.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct ColumnUnit {
    unit: Unit,
    /// Factor from the file's values to `unit`.
    times: f64,
    /// SI value of the file's zero.
    zero: f64,
}

impl ColumnUnit {
    pub(crate) fn parse(text: &str) -> Result<Self, String> {
        if CELSIUS_NAMES.contains(&text) {
            return Ok(Self { unit: Unit::si(Dimension::whole([0, 0, 0, 1])), times: 1.0, zero: CELSIUS });
        }
        let unit = Unit::parse(text).map_err(|error| without_content(&error.to_string()))?;
        Ok(Self { unit, times: 1.0, zero: 0.0 })
    }

    /// Parses the unit of a spindle speed, where `Hz` means revolutions per second.
    pub(crate) fn parse_spindle(text: &str) -> Result<Self, String> {
        if text == TURNS_A_SECOND { Ok(Self { times: 60.0, ..Self::parse("rpm")? }) } else { Self::parse(text) }
    }

    pub(crate) fn dimension(self) -> Dimension {
        self.unit.dimension
    }

    /// Converts a value of the file to SI.
    pub(crate) fn to_si(self, value: f64) -> f64 {
        self.unit.to_si(self.times * value) + self.zero
    }

    /// SI value of one unit, and of the file's zero.
    pub(crate) fn scale(self) -> (f64, f64) {
        (self.unit.to_si(self.times), self.zero)
    }
}

/// Splits a column name into the name and its unit suffix; the unit is that of a plain number if there is no suffix.
pub(crate) fn named_unit(name: &str) -> (&str, &'static str) {
    let lower = name.to_ascii_lowercase();
    let found = ENDS.into_iter().find(|(end, _)| lower.len() > end.len() && lower.ends_with(end));
    found.map_or((name, "1"), |(end, unit)| (&name[..name.len() - end.len()], unit))
}

/// A number and its unit, such as `5 %`.
pub(crate) fn quantity(text: &str) -> Option<(f64, ColumnUnit)> {
    let (number, unit) = split(text)?;
    Some((number, ColumnUnit::parse(unit).ok()?))
}

/// Splits a text into a number and its unit, `1` if there is none; `None` if the text does not begin with a number.
pub(crate) fn split(text: &str) -> Option<(f64, &str)> {
    let text = text.trim();
    let (number, unit) =
        text.split_once(char::is_whitespace).or_else(|| Some((text.strip_suffix('%')?, "%"))).unwrap_or((text, "1"));
    Some((number.parse().ok()?, unit.trim()))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_name_ends_with_its_unit_or_is_a_plain_number() {
        for (name, expected) in [
            ("humidity_pct", ("humidity", "%")),
            ("Flow_mm_s", ("Flow", "mm/s")),
            ("coolant_c", ("coolant", "degC")),
            ("dresser_hours", ("dresser_hours", "1")),
            ("_mm", ("_mm", "1")),
            ("°_n", ("°", "N")),
        ] {
            assert_eq!(named_unit(name), expected);
        }
        assert!(ENDS.iter().all(|(_, unit)| ColumnUnit::parse(unit).is_ok()));
    }

    #[test]
    fn a_quantity_is_a_number_and_a_unit() {
        assert_eq!(split("3.5 h"), Some((3.5, "h")));
        assert_eq!(split("45%"), Some((45.0, "%")));
        assert_eq!(split("7"), Some((7.0, "1")));
        assert_eq!(split("mm"), None);
        let (value, unit) = quantity("21 degC").expect("a temperature");
        assert!((unit.to_si(value) - 294.15).abs() < 1e-12);
    }
}
