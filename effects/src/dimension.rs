//! Physical dimensions as exponents of kilogram, metre, second and kelvin. Angles have none.

use std::fmt;
use std::ops::{Div, Mul};

/// Exponents are stored in twelfths, so that square and cube roots are exact.
const TWELFTHS: i32 = 12;

/// Symbols of the base units, in the order of the exponents.
const BASE: [&str; 4] = ["kg", "m", "s", "K"];

/// Derived units in which a dimension is printed, in order of preference.
const NAMED: [(&str, Dimension); 4] = [
    ("N", Dimension::whole([1, 1, -2, 0])),
    ("Pa", Dimension::whole([1, -1, -2, 0])),
    ("J", Dimension::whole([1, 2, -2, 0])),
    ("W", Dimension::whole([1, 2, -3, 0])),
];

/// A physical dimension.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, Default)]
pub struct Dimension {
    twelfths: [i32; 4],
}

impl Dimension {
    /// Dimensionless.
    pub const NONE: Self = Self::whole([0; 4]);

    /// Dimension with whole exponents of kg, m, s and K.
    pub const fn whole([kg, m, s, k]: [i32; 4]) -> Self {
        Self { twelfths: [kg * TWELFTHS, m * TWELFTHS, s * TWELFTHS, k * TWELFTHS] }
    }

    /// True if it is dimensionless.
    pub fn is_none(self) -> bool {
        self == Self::NONE
    }

    /// Raises this dimension to a power; `None` if the exponents are no longer multiples of 1/12.
    pub fn to_power(self, exponent: f64) -> Option<Self> {
        let mut twelfths = [0; 4];
        for (to, from) in twelfths.iter_mut().zip(self.twelfths) {
            let raised = f64::from(from) * exponent;
            // One third is not exact in binary: values within 1e-9 of a twelfth count as that twelfth.
            if (raised - raised.round()).abs() > 1e-9 || raised.abs() > 1e6 {
                return None;
            }
            *to = raised.round() as i32;
        }
        Some(Self { twelfths })
    }
}

impl Mul for Dimension {
    type Output = Self;

    fn mul(self, other: Self) -> Self {
        Self { twelfths: std::array::from_fn(|i| self.twelfths[i] + other.twelfths[i]) }
    }
}

impl Div for Dimension {
    type Output = Self;

    fn div(self, other: Self) -> Self {
        Self { twelfths: std::array::from_fn(|i| self.twelfths[i] - other.twelfths[i]) }
    }
}

impl fmt::Display for Dimension {
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        let named = NAMED.iter().filter(|_| self.twelfths[0] == TWELFTHS).map(|&(name, unit)| (name, *self / unit));
        let bare = named.min_by_key(|(_, rest)| rest.twelfths.map(i32::abs).iter().sum::<i32>());
        let (first, rest) = bare.map_or((None, *self), |(name, rest)| (Some(name), rest));
        let factor = |(symbol, twelfths): (&&str, i32)| match twelfths {
            TWELFTHS => (*symbol).to_owned(),
            whole if whole % TWELFTHS == 0 => format!("{symbol}^{}", whole / TWELFTHS),
            part => format!("{symbol}^({part}/{TWELFTHS})"),
        };
        let above = BASE.iter().zip(rest.twelfths).filter(|(_, e)| *e > 0).map(factor);
        let above: Vec<String> = first.map(str::to_owned).into_iter().chain(above).collect();
        let below: Vec<String> =
            BASE.iter().zip(rest.twelfths).filter(|(_, e)| *e < 0).map(|(s, e)| factor((s, -e))).collect();
        let above = if above.is_empty() { "1".to_owned() } else { above.join(" ") };
        match below.len() {
            0 => f.write_str(&above),
            1 => write!(f, "{above}/{}", below[0]),
            _ => write!(f, "{above}/({})", below.join(" ")),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn dimensions_are_shown_as_an_engineer_writes_them() {
        for (exponents, shown) in [
            ([0, 0, 0, 0], "1"),
            ([1, -1, -2, 0], "Pa"),
            ([1, 1, -2, 0], "N"),
            ([0, 1, -1, 0], "m/s"),
            ([-1, 2, 1, 0], "m^2 s/kg"),
            ([1, -2, -2, 0], "Pa/m"),
            ([1, 2, -3, -1], "W/K"),
            ([0, 0, 0, 1], "K"),
        ] {
            assert_eq!(Dimension::whole(exponents).to_string(), shown);
        }
    }

    #[test]
    fn roots_are_exact_and_odd_powers_are_refused() {
        let area = Dimension::whole([0, 2, 0, 0]);
        assert_eq!(area.to_power(0.5), Some(Dimension::whole([0, 1, 0, 0])));
        assert_eq!(area.to_power(1.0 / 3.0).and_then(|root| root.to_power(3.0)), Some(area));
        assert_eq!(area.to_power(0.7), None);
        assert_eq!(Dimension::NONE.to_power(0.7), Some(Dimension::NONE));
        assert_eq!(
            area.to_power(0.5).map(|length| length.to_power(1.0 / 3.0).unwrap().to_string()).unwrap(),
            "m^(4/12)"
        );
    }
}
