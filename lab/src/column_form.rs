//! Forms of the dependence of the rate on a table column: each is a template of an effect file.

use effects::Dimension;

use super::summary::{EffectSummary, ParameterSummary, significant};
use super::table_steps::KELVIN;
use crate::criteria::{
    COLUMN_CHANGE_MOST, COLUMN_CHANGE_TYPICAL, COLUMN_FLOOR_LEVELS, COLUMN_FLOOR_LONGEST, COLUMN_FLOOR_MOST,
    COLUMN_FLOOR_SHORTEST, COLUMN_FORM_LEVELS, COLUMN_POWER_RATIO,
};

/// Functional form of a dependence.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum ColumnForm {
    /// An exponential; to first order, any smooth dependence.
    Exponential,
    /// A straight line.
    Line,
    /// A power.
    Power,
    /// An exponential that approaches a floor.
    Floor,
}

/// Description of a column for its effect file.
pub(super) struct Written<'a> {
    /// Display name of the column.
    pub(super) shown: &'a str,
    /// Unit of its values.
    pub(super) unit: &'a str,
    /// Dimension of the unit.
    pub(super) dimension: Dimension,
    /// Values of the calibration rows in that unit, ascending.
    pub(super) values: &'a [f64],
}

impl ColumnForm {
    /// All forms; a column's family bears the name of the first.
    pub(super) const ALL: [Self; 4] = [Self::Exponential, Self::Line, Self::Power, Self::Floor];

    /// Name of the effect of this form, given that of the column's first form.
    pub(super) fn name(self, column: &str) -> String {
        match self {
            Self::Exponential => column.to_owned(),
            Self::Line => format!("line-of-{column}"),
            Self::Power => format!("power-of-{column}"),
            Self::Floor => format!("floor-of-{column}"),
        }
    }

    fn text(self) -> &'static str {
        match self {
            Self::Exponential => include_str!("table_effects/column.toml"),
            Self::Line => include_str!("table_effects/column-line.toml"),
            Self::Power => include_str!("table_effects/column-power.toml"),
            Self::Floor => include_str!("table_effects/column-floor.toml"),
        }
    }

    /// Name and text of the effect file of a column; `None` where its values cannot show the form.
    pub(super) fn file(self, name: &str, column: &Written) -> Option<(String, String)> {
        let (least, greatest) = (*column.values.first()?, *column.values.last()?);
        let (width, middle) = (greatest - least, column.values[column.values.len() / 2]);
        let levels = 1 + column.values.windows(2).filter(|pair| pair[1] > pair[0]).count();
        let ratio = if least > 0.0 { greatest / least } else { f64::NAN };
        let shows = match self {
            Self::Exponential => true,
            Self::Line => levels >= COLUMN_FORM_LEVELS,
            Self::Power => levels >= COLUMN_FORM_LEVELS && column.dimension != KELVIN && ratio >= COLUMN_POWER_RATIO,
            Self::Floor => levels >= COLUMN_FLOOR_LEVELS,
        };
        if !(shows && width > 0.0 && width.is_finite()) {
            return None;
        }
        let mut text = self.text().to_owned();
        // A placeholder whose name contains another one comes before it.
        for (place, number) in [
            ("POWER_MOST", COLUMN_CHANGE_MOST / ratio.ln()),
            ("POWER_TYPICAL", COLUMN_CHANGE_TYPICAL / ratio.ln()),
            ("FLOOR_MOST", COLUMN_FLOOR_MOST),
            ("FLOOR_TYPICAL", COLUMN_CHANGE_TYPICAL),
            ("SHORTEST", COLUMN_FLOOR_SHORTEST * width),
            ("LONGEST", COLUMN_FLOOR_LONGEST * width),
            ("LOWEST", 0.5 * least),
            ("SCALE", (COLUMN_FLOOR_SHORTEST * COLUMN_FLOOR_LONGEST).sqrt() * width),
            ("START", least),
            ("MOST", COLUMN_CHANGE_MOST / width),
            ("TYPICAL", COLUMN_CHANGE_TYPICAL / width),
            ("LEAST", least - width),
            ("GREATEST", greatest + width),
            ("MIDDLE", middle),
        ] {
            text = text.replace(place, &format!("{number:?}"));
        }
        let text = text.replace("PER_UNIT", &per(column.unit)).replace("UNIT", column.unit);
        Some((format!("{name}.toml"), text.replace("NAME", name).replace("COLUMN", column.shown)))
    }

    /// Sentence on a fitted effect of this form; `None` if it has no size.
    pub(super) fn words(self, effect: &EffectSummary, column: &str) -> Option<String> {
        let size = |name: &str| effect.parameters.get(name);
        let percent = |of: &ParameterSummary| (significant(100.0 * of.value), interval(of, 100.0, " %"));
        let unit = |of: &ParameterSummary| {
            if of.unit == "1" { "one".to_owned() } else { of.unit.trim_start_matches("1/").to_owned() }
        };
        Some(match self {
            Self::Exponential | Self::Line => {
                let change = size("change")?;
                let (shown, interval) = percent(change);
                let of = if self == Self::Line { " of its value in the middle" } else { "" };
                format!("The rate changes by {shown} %{of} per {} of column {column:?}{interval}.", unit(change))
            }
            Self::Power => {
                let exponent = size("exponent")?;
                let (shown, interval) = (significant(exponent.value), interval(exponent, 1.0, ""));
                format!("The rate scales with the power {shown} of column {column:?}{interval}.")
            }
            Self::Floor => {
                let (amount, scale) = (size("amount")?, size("scale")?);
                let (shown, interval) = percent(amount);
                format!(
                    "The rate changes by {shown} % with column {column:?}{interval}, and 1/e of that is left after {}.",
                    scale.quantity()
                )
            }
        })
    }
}

/// Interval of a value in words; empty if there is none.
fn interval(of: &ParameterSummary, scale: f64, unit: &str) -> String {
    let shown = |value: f64| significant(scale * value);
    of.interval.map_or(String::new(), |[low, high]| format!(" (95 % from {} to {}{unit})", shown(low), shown(high)))
}

/// Reciprocal of a unit.
fn per(unit: &str) -> String {
    match unit {
        "1" => unit.to_owned(),
        _ if unit.contains([' ', '/', '*', '^', '(']) => format!("1/({unit})"),
        _ => format!("1/{unit}"),
    }
}
