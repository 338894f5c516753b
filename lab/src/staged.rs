//! Staged fit: first the removal rate from the total removal, then the other parameters from the profiles.

use effects::{CompiledModel, Kind, Scale, Variable};

use super::coordinates::{Coordinate, moved};
use super::evidence::{EvidenceError, Split};
use super::fit::{Estimate, Fit, FitOptions};
use super::totals::{Total, Totals};
use crate::criteria::STAGED_RATE_TOLERANCE;

/// Most simulations in the search for the rate.
const MOST_RUNS: usize = 12;
/// Longest step of the rate [logarithm].
const LONGEST_STEP: f64 = 1.5;

/// Result of a staged fit, beside the fit of the second stage.
pub struct Staged {
    /// Removal rate fitted to the totals.
    pub rate: Estimate,
    /// Totals after each stage: once the rate was fitted, and once the other parameters were fitted to the profiles.
    pub totals: [Vec<Total>; 2],
}

impl Staged {
    /// Fits the calibration data in two stages. The returned fit is that of the second stage, of all parameters but the
    /// rate. `None` if no free parameter of a law is a removal rate.
    ///
    /// # Errors
    /// If the model cannot be simulated.
    pub fn new(evidence: &dyn Totals, model: &CompiledModel) -> Result<Option<(Self, Fit)>, EvidenceError> {
        let mut coordinates = evidence.coordinates(model);
        let Some(place) = coordinates.iter().position(|coordinate| is_rate(model, coordinate)) else { return Ok(None) };
        let rate = (coordinates.remove(place), STAGED_RATE_TOLERANCE);
        let (rate, model, first) = fit_rate(evidence, model, rate)?;
        let profiles = Fit::new(evidence, &model, coordinates, FitOptions::default())?;
        let second = evidence.totals(&profiles.model, Split::Calibration)?;
        Ok(Some((Self { rate, totals: [first, second] }, profiles)))
    }
}

/// Returns true if a parameter is the factor of the removal law.
pub(super) fn is_rate(model: &CompiledModel, coordinate: &Coordinate) -> bool {
    let removes = |value: Variable| matches!(value, Variable::Rate | Variable::DoseRate);
    let mut laws = model.effects().filter(|law| law.kind == Kind::Law && law.name == coordinate.slot.owner);
    coordinate.slot.scale == Scale::Log
        && laws.any(|law| law.changes_in(model.process()).any(|change| removes(change.value)))
}

/// Finds the rate by the secant method on the mean log ratio of measured to predicted totals, to a tolerance of that
/// mean.
pub(super) fn fit_rate(
    evidence: &dyn Totals,
    model: &CompiledModel,
    (rate, tolerance): (Coordinate, f64),
) -> Result<(Estimate, CompiledModel, Vec<Total>), EvidenceError> {
    let mut at = rate.clamped(rate.from_value(model.value(rate.index)));
    // The removal grows about in proportion to the rate.
    let mut slope = -1.0;
    let mut before: Option<(f64, f64)> = None;
    for _ in 0..MOST_RUNS {
        let model = moved(model, std::slice::from_ref(&rate), &[at]);
        let off = shortfall(&evidence.totals(&model, Split::Calibration)?);
        if let Some((there, other)) = before.filter(|(there, _)| *there != at) {
            slope = ((off - other) / (at - there)).min(-0.1);
        }
        if off.abs() < tolerance {
            break;
        }
        before = Some((at, off));
        at = rate.clamped(at + (-off / slope).clamp(-LONGEST_STEP, LONGEST_STEP));
    }
    let model = moved(model, std::slice::from_ref(&rate), &[at]);
    let totals = evidence.totals(&model, Split::Calibration)?;
    let weight: f64 = totals.iter().map(weight).sum();
    let estimate = Estimate {
        value: rate.value(at),
        sigma: 1.0 / (weight.sqrt() * slope.abs()),
        bound: rate.bound(at),
        coordinate: rate,
    };
    Ok((estimate, model, totals))
}

/// Mean log ratio of measured to predicted totals, weighted by inverse variance. A scan without a measured total has no
/// weight; where no scan has one, nothing is short.
fn shortfall(totals: &[Total]) -> f64 {
    let one = |total: &Total| {
        let ratio = (total.measured / total.predicted).ln();
        weight(total) * ratio.clamp(-LONGEST_STEP, LONGEST_STEP)
    };
    let weighed: Vec<&Total> = totals.iter().filter(|total| weight(total) > 0.0).collect();
    let sum: f64 = weighed.iter().map(|total| one(total)).sum();
    sum / weighed.iter().map(|total| weight(total)).sum::<f64>().max(f64::MIN_POSITIVE)
}

fn weight(total: &Total) -> f64 {
    (total.measured / total.sigma).powi(2)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn total([measured, predicted]: [f64; 2]) -> Total {
        Total { about: String::new(), measured, predicted, sigma: 1.0 }
    }

    #[test]
    fn a_scan_that_shows_no_removal_says_nothing_on_the_rate() {
        let of = |totals: &[[f64; 2]]| shortfall(&totals.iter().copied().map(total).collect::<Vec<_>>());
        assert!((of(&[[20.0, 10.0], [40.0, 20.0]]) - 2f64.ln()).abs() < 1e-12);
        for silent in [[0.0, 0.0], [0.0, 5.0]] {
            assert!((of(&[[20.0, 10.0], silent]) - 2f64.ln()).abs() < 1e-12, "{silent:?}");
            assert_eq!(of(&[silent]), 0.0);
        }
        assert_eq!(of(&[[20.0, 0.0]]), LONGEST_STEP, "nothing is predicted yet");
    }
}
