//! Coverage: the share of 95 % intervals that contain the true value.

use std::collections::BTreeMap;

use serde::{Deserialize, Serialize};
use trials::measure::median;
use virtual_lab::{Answer, Quantity};

use super::rate::Rate;
use lab::ParameterSummary;

/// A parameter of a final model with its true value.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Interval {
    /// `law.parameter` or `effect.parameter`.
    pub name: String,
    /// True if the parameter belongs to the base law.
    pub is_base: bool,
    /// True value, in the parameter's unit.
    pub truth: f64,
    /// Fitted value, in the parameter's unit.
    pub value: f64,
    /// Ends of its 95 % interval; `None` if the data do not determine the parameter.
    pub ends: Option<[f64; 2]>,
}

impl Interval {
    /// Intervals of all parameters whose true value is in the answer; those with one value per pass or scan are left
    /// out.
    pub fn all(parameters: &[ParameterSummary], answer: &Answer) -> Vec<Self> {
        let of_effects = answer.effects.iter().flat_map(|effect| {
            effect.parameters.iter().map(|(name, quantity)| (format!("{}.{name}", effect.name), quantity))
        });
        let of_effects: BTreeMap<String, &Quantity> = of_effects.collect();
        let one = |quantity: &Quantity| match quantity.values.as_slice() {
            [only] => only.parse::<f64>().ok(),
            _ => None,
        };
        let interval = |parameter: &ParameterSummary| {
            let base = answer.base.get(&parameter.name);
            let quantity = base.or_else(|| of_effects.get(&parameter.name).copied())?;
            let truth = one(quantity).filter(|truth| truth.is_finite())?;
            let (name, value, ends) = (parameter.name.clone(), parameter.value, parameter.interval);
            Some(Self { name, is_base: base.is_some(), truth, value, ends })
        };
        parameters.iter().filter_map(interval).collect()
    }

    /// True if the interval contains the true value; `None` without an interval.
    pub fn holds(&self) -> Option<bool> {
        self.ends.map(|[low, high]| (low..=high).contains(&self.truth))
    }
}

/// Intervals of one parameter, or of all parameters of effects.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Coverage {
    /// The parameter; `effects` for those of correctly named effects.
    pub name: String,
    /// Share of the intervals that contain the true value.
    pub held: Rate,
    /// Number of fitted values without an interval, because the data do not determine them.
    pub without: usize,
    /// Median ratio of the fitted to the true value; for parameters of the base law only.
    pub ratio: Option<f64>,
}

/// Coverage by parameter.
pub fn coverage<'a>(intervals: impl Iterator<Item = &'a Interval>) -> Vec<Coverage> {
    let mut by_name: BTreeMap<(bool, &str), Vec<&Interval>> = BTreeMap::new();
    for interval in intervals {
        let name = if interval.is_base { interval.name.as_str() } else { "effects" };
        by_name.entry((!interval.is_base, name)).or_default().push(interval);
    }
    let row = |((_, name), own): ((bool, &str), Vec<&Interval>)| Coverage {
        name: name.to_owned(),
        held: Rate::new(own.iter().filter_map(|interval| interval.holds())),
        without: own.iter().filter(|interval| interval.ends.is_none()).count(),
        ratio: median(own.iter().filter(|i| i.is_base).map(|interval| interval.value / interval.truth).collect()),
    };
    by_name.into_iter().map(row).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn intervals_are_counted_by_parameter_and_those_of_effects_together() {
        let interval = |name: &str, truth: f64, ends: Option<[f64; 2]>| Interval {
            name: name.to_owned(),
            is_base: name.starts_with("winkler"),
            truth,
            value: 2.0 * truth,
            ends,
        };
        let all = [
            interval("winkler.stiffness", 30.0, Some([28.0, 31.0])),
            interval("winkler.stiffness", 30.0, Some([30.5, 31.0])),
            interval("winkler.stiffness", 30.0, None),
            interval("tool-tilt.roll_angle", 12.0, Some([11.0, 12.0])),
        ];
        let rows = coverage(all.iter());
        assert_eq!(rows.len(), 2);
        assert_eq!(
            (rows[0].name.as_str(), rows[0].held.hits, rows[0].held.of, rows[0].without),
            ("winkler.stiffness", 1, 2, 1)
        );
        assert_eq!((rows[1].name.as_str(), rows[1].held.hits, rows[1].held.of), ("effects", 1, 1), "its end counts");
        assert_eq!((rows[0].ratio, rows[1].ratio), (Some(2.0), None));
    }
}
