//! Units in common notation: `mm^3`, `1/(Pa s)`, `MPa/mm`, `rpm`.
//!
//! ```
//! use effects::Unit;
//!
//! let unit = Unit::parse("mm/(MPa s)").unwrap();
//! assert_eq!(unit.to_si(1.4), 1.4e-9);
//! assert_eq!(unit.from_si(1.4e-9), 1.4);
//! ```

use super::dimension::Dimension;

/// A unit: its dimension and its size in SI units, `scale · 10^decimals`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Unit {
    /// Physical dimension.
    pub dimension: Dimension,
    scale: f64,
    decimals: i32,
}

/// Reason why a text is not a unit.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum UnitError {
    /// An unknown name.
    #[error("unknown unit `{0}`; known are {known}, alone or with a prefix n, u, m, c, k, M, G", known = known())]
    Unknown(String),
    /// Text not of the form `name^n name/(name name)`.
    #[error(
        "`{text}` cannot be read as a unit after its first {read} characters; write it as mm^3, 1/(Pa s) or MPa/mm"
    )]
    Malformed {
        /// The text.
        text: String,
        /// Number of characters understood.
        read: usize,
    },
}

/// Units that take prefixes: symbol, exponents of kg, m, s, K, decimals.
const PREFIXED: [(&str, [i32; 4], i32); 9] = [
    ("m", [0, 1, 0, 0], 0),
    ("g", [1, 0, 0, 0], -3),
    ("s", [0, 0, 1, 0], 0),
    ("K", [0, 0, 0, 1], 0),
    ("N", [1, 1, -2, 0], 0),
    ("Pa", [1, -1, -2, 0], 0),
    ("J", [1, 2, -2, 0], 0),
    ("W", [1, 2, -3, 0], 0),
    ("Hz", [0, 0, -1, 0], 0),
];

/// Units without prefixes: symbol, exponents of s, scale.
const ALONE: [(&str, i32, f64); 8] = [
    ("1", 0, 1.0),
    ("rad", 0, 1.0),
    ("mrad", 0, 1.0),
    ("deg", 0, std::f64::consts::PI / 180.0),
    ("%", 0, 1.0),
    ("rpm", -1, std::f64::consts::TAU / 60.0),
    ("min", 1, 60.0),
    ("h", 1, 3600.0),
];

const PREFIXES: [(&str, i32); 8] =
    [("n", -9), ("u", -6), ("µ", -6), ("m", -3), ("c", -2), ("k", 3), ("M", 6), ("G", 9)];

/// Greatest length of a unit [bytes]; it bounds the nesting of brackets.
const LONGEST: usize = 100;

fn known() -> String {
    let alone = ALONE.iter().map(|unit| unit.0);
    PREFIXED.iter().map(|unit| unit.0).chain(alone).collect::<Vec<_>>().join(", ")
}

impl Unit {
    /// Dimensionless unit.
    pub const ONE: Self = Self { dimension: Dimension::NONE, scale: 1.0, decimals: 0 };

    /// The SI unit of a dimension.
    pub fn si(dimension: Dimension) -> Self {
        Self { dimension, ..Self::ONE }
    }

    /// Parses a unit: factors side by side or with `*`, powers with `^`, one or more `/`, round brackets.
    ///
    /// # Errors
    /// An unknown name, or text that cannot be parsed.
    pub fn parse(text: &str) -> Result<Self, UnitError> {
        let mut reader = Reader { text, at: 0 };
        if text.len() > LONGEST {
            return Err(reader.malformed());
        }
        let unit = reader.product()?;
        if reader.rest().is_empty() { Ok(unit) } else { Err(reader.malformed()) }
    }

    /// Parses a value with its unit, such as `350 mm^3`: returns the value in SI units, and the unit. A plain number
    /// has unit 1.
    ///
    /// # Errors
    /// Text that cannot be parsed, with the expected form.
    pub fn quantity(text: &str) -> Result<(f64, Self), String> {
        let text = text.trim();
        let end = text.find(|c: char| !(c.is_ascii_digit() || "+-.eE".contains(c))).unwrap_or(text.len());
        let number = text[..end].parse().ok().filter(|number: &f64| number.is_finite());
        let number = number.ok_or_else(|| format!("{text:?}: a number and its unit is expected, such as 350 mm^3"))?;
        let unit = text[end..].trim();
        let unit = if unit.is_empty() { Self::ONE } else { Self::parse(unit).map_err(|error| error.to_string())? };
        Ok((unit.to_si(number), unit))
    }

    /// Returns the unit of a single symbol, with or without prefix.
    pub fn atom(symbol: &str) -> Option<Self> {
        if let Some(&(name, seconds, scale)) = ALONE.iter().find(|unit| unit.0 == symbol) {
            let decimals = match name {
                "mrad" => -3,
                "%" => -2,
                _ => 0,
            };
            return Some(Self { dimension: Dimension::whole([0, 0, seconds, 0]), scale, decimals });
        }
        let plain = |symbol: &str, shift: i32| {
            let &(_, exponents, decimals) = PREFIXED.iter().find(|unit| unit.0 == symbol)?;
            Some(Self { dimension: Dimension::whole(exponents), scale: 1.0, decimals: decimals + shift })
        };
        plain(symbol, 0)
            .or_else(|| PREFIXES.iter().find_map(|(prefix, shift)| plain(symbol.strip_prefix(prefix)?, *shift)))
    }

    /// Converts a value in this unit to SI.
    pub fn to_si(self, value: f64) -> f64 {
        scale_by_ten(value * self.scale, self.decimals)
    }

    /// Converts a value in SI to this unit.
    pub fn from_si(self, value: f64) -> f64 {
        scale_by_ten(value, -self.decimals) / self.scale
    }

    /// Shortest decimal that parses back in this unit to the same SI value.
    pub fn show(self, si: f64) -> String {
        let value = self.from_si(si);
        if !value.is_finite() || value == 0.0 {
            return format!("{value}");
        }
        let texts = (0..17).map(|digits| format!("{value:.digits$e}"));
        let text = texts.map(|text| text.parse().unwrap_or(value)).find(|&near: &f64| self.to_si(near) == si);
        let near = text.unwrap_or(value);
        if (1e-4..1e6).contains(&near.abs()) { format!("{near}") } else { format!("{near:e}") }
    }

    fn to_power(self, power: i32) -> Self {
        let dimension = self.dimension.to_power(f64::from(power)).unwrap_or(self.dimension);
        Self { dimension, scale: self.scale.powi(power), decimals: self.decimals * power }
    }

    fn times(self, other: Self) -> Self {
        Self {
            dimension: self.dimension * other.dimension,
            scale: self.scale * other.scale,
            decimals: self.decimals + other.decimals,
        }
    }
}

/// `value · 10^decimals`, computed by shifting the decimal point: 0.2 cm^3 is 2e-7 m^3 to the last bit.
fn scale_by_ten(value: f64, decimals: i32) -> f64 {
    let shifted = || {
        let text = format!("{value:e}");
        let (digits, exponent) = text.split_once('e')?;
        let exponent: i32 = exponent.parse().ok()?;
        format!("{digits}e{}", exponent + decimals).parse().ok()
    };
    if decimals == 0 { value } else { shifted().unwrap_or(value) }
}

struct Reader<'a> {
    text: &'a str,
    at: usize,
}

impl<'a> Reader<'a> {
    /// Remaining text, without leading blanks.
    fn rest(&mut self) -> &'a str {
        let rest = &self.text[self.at..];
        let trimmed = rest.trim_start();
        self.at += rest.len() - trimmed.len();
        trimmed
    }

    fn take(&mut self, sign: char) -> bool {
        let taken = self.rest().starts_with(sign);
        if taken {
            self.at += sign.len_utf8();
        }
        taken
    }

    fn malformed(&self) -> UnitError {
        UnitError::Malformed { text: self.text.to_owned(), read: self.text[..self.at].chars().count() }
    }

    fn product(&mut self) -> Result<Unit, UnitError> {
        let mut unit = self.factor()?;
        loop {
            if self.take('/') {
                unit = unit.times(self.factor()?.to_power(-1));
            } else if self.take('*') || self.take('·') || !matches!(self.rest().chars().next(), None | Some(')')) {
                unit = unit.times(self.factor()?);
            } else {
                return Ok(unit);
            }
        }
    }

    fn factor(&mut self) -> Result<Unit, UnitError> {
        let unit = if self.take('(') {
            let inside = self.product()?;
            if !self.take(')') {
                return Err(self.malformed());
            }
            inside
        } else {
            self.symbol()?
        };
        if self.take('^') { Ok(unit.to_power(self.power()?)) } else { Ok(unit) }
    }

    fn symbol(&mut self) -> Result<Unit, UnitError> {
        let rest = self.rest();
        let length = rest.find(|c: char| !(c.is_alphabetic() || c == '%')).unwrap_or(rest.len());
        let length = if rest.starts_with('1') { 1 } else { length };
        if length == 0 {
            return Err(self.malformed());
        }
        let symbol = &rest[..length];
        let unit = Unit::atom(symbol).ok_or_else(|| UnitError::Unknown(symbol.to_owned()))?;
        self.at += length;
        Ok(unit)
    }

    fn power(&mut self) -> Result<i32, UnitError> {
        let rest = self.rest();
        let digits = rest.strip_prefix('-').unwrap_or(rest);
        let length = digits.find(|c: char| !c.is_ascii_digit()).unwrap_or(digits.len());
        let length = length + (rest.len() - digits.len());
        let power: i32 = rest[..length].parse().map_err(|_| self.malformed())?;
        if !(-9..=9).contains(&power) {
            return Err(self.malformed());
        }
        self.at += length;
        Ok(power)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn quantities_are_read_with_their_unit_and_refused_without_a_number() {
        assert_eq!(Unit::quantity("350 mm^3"), Ok((350e-9, Unit::parse("mm^3").unwrap())));
        assert_eq!(Unit::quantity(" -2e-3m "), Ok((-2e-3, Unit::parse("m").unwrap())));
        assert_eq!(Unit::quantity("0.5"), Ok((0.5, Unit::ONE)));
        assert!(Unit::quantity("mm").unwrap_err().contains("350 mm^3"));
        assert!(Unit::quantity("3 furlong").unwrap_err().contains("furlong"));
    }

    #[test]
    fn units_convert_to_si_without_stray_digits() {
        for (text, value, si, dimension) in [
            ("mm^3", 350.0, 350e-9, [0, 3, 0, 0]),
            ("1/(Pa s)", 2.0, 2.0, [-1, 1, 1, 0]),
            ("mm/(MPa s)", 1.4, 1.4e-9, [-1, 2, 1, 0]),
            ("MPa/mm", 0.012, 1.2e7, [1, -2, -2, 0]),
            ("1/(MPa mm)", 0.026, 2.6e-5, [-1, 0, 2, 0]),
            ("um", 20.0, 20e-6, [0, 1, 0, 0]),
            ("µm", 20.0, 20e-6, [0, 1, 0, 0]),
            ("kg", 2.0, 2.0, [1, 0, 0, 0]),
            ("cm^3", 0.2, 2e-7, [0, 3, 0, 0]),
            ("N/mm", 3.0, 3000.0, [1, 0, -2, 0]),
            ("mrad", 12.0, 0.012, [0, 0, 0, 0]),
            ("%", 3.0, 0.03, [0, 0, 0, 0]),
            ("min", 2.0, 120.0, [0, 0, 1, 0]),
            ("K/W", 2.0, 2.0, [-1, -2, 3, 1]),
            ("1", 7.0, 7.0, [0, 0, 0, 0]),
            ("Pa m^-1*s", 7.0, 7.0, [1, -2, -1, 0]),
        ] {
            let unit = Unit::parse(text).unwrap();
            assert_eq!(unit.to_si(value), si, "{text}");
            assert_eq!(unit.dimension, Dimension::whole(dimension), "{text}");
            assert_eq!(unit.show(si), format!("{value}"), "{text}");
        }
        assert!((Unit::parse("rpm").unwrap().to_si(6000.0) / 628.318_530_717_958_6 - 1.0).abs() < 1e-15);
        assert_eq!(Unit::parse("deg").unwrap().to_si(180.0), std::f64::consts::PI);
    }

    #[test]
    fn what_is_no_unit_is_named() {
        assert_eq!(Unit::parse("mm/furlong"), Err(UnitError::Unknown("furlong".to_owned())));
        assert!(matches!(Unit::parse(&"(".repeat(100_000)), Err(UnitError::Malformed { .. })));
        for text in ["", "mm^", "mm^x", "(mm", "mm)", "/s", "mm//s", "mm^99"] {
            assert!(matches!(Unit::parse(text), Err(UnitError::Malformed { .. })), "{text}");
        }
    }
}
