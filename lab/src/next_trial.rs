//! The trial that would tell two rivals apart: variants of a trial that was made, simulated with both.

use nalgebra::{Cholesky, DMatrix, DVector};
use rayon::prelude::*;
use serde::Serialize;
use statrs::distribution::{ContinuousCDF, Normal};

use super::coordinates::{Coordinate, moved};
use super::diagnose::Diagnosis;
use super::evidence::{Evidence, EvidenceError, Split};
use super::fit::Fit;
use super::observation::Observation;
use super::scans::ScanEvidence;
use trials::trial::{Role, Trial};

/// Revolutions per minute of one rad/s.
const RPM: f64 = 60.0 / std::f64::consts::TAU;

/// What may be changed of a pass.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Change {
    Force(f64),
    Feed(f64),
    Spindle(f64),
    Backwards,
}

/// Changes that are tried, one at a time; the passes as they were come first.
const CHANGES: [Option<Change>; 8] = [
    None,
    Some(Change::Force(0.6)),
    Some(Change::Force(1.6)),
    Some(Change::Feed(0.5)),
    Some(Change::Feed(2.0)),
    Some(Change::Spindle(0.6)),
    Some(Change::Backwards),
    Some(Change::Spindle(1.4)),
];

/// A trial worth making.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct NextTrial {
    /// What to do.
    pub summary: String,
    /// Force of each pass [N].
    pub force_n: Vec<f64>,
    /// Feed of each pass [mm/s].
    pub feed_mm_s: Vec<f64>,
    /// Spindle speed of each pass [rpm].
    pub spindle_rpm: Vec<f64>,
    /// The two effects that it would tell apart; or the one effect whose prediction it would test.
    pub separates: Vec<String>,
    /// Expected difference of their sums of squares; for one effect, of those with and without it.
    pub expected_delta_chi2: f64,
    /// Probability that the better of the two is the right one afterwards.
    pub probability_right: f64,
}

impl NextTrial {
    /// The same trial as a test of its first effect, for which no rival is left.
    pub(super) fn into_test(mut self) -> Self {
        self.separates.truncate(1);
        self
    }
}

/// The trial on which the effect that was found last changes most, so that it tests what the effect predicts; `None`
/// where nothing was found.
///
/// # Errors
/// When a variant cannot be prepared or simulated.
pub fn testing_trial(evidence: &ScanEvidence, diagnosis: &Diagnosis) -> Result<Option<NextTrial>, EvidenceError> {
    let Some((round, found)) = diagnosis.last_found() else { return Ok(None) };
    let with = (found.suspect.name(), &found.suspect.fit);
    Ok(next_trial(evidence, (with, ("without it", &round.base)))?.map(NextTrial::into_test))
}

/// The trial that would tell the two rivals of a diagnosis apart, where two are still in play.
///
/// # Errors
/// When a variant cannot be prepared or simulated.
pub fn separating_trial(evidence: &ScanEvidence, diagnosis: &Diagnosis) -> Result<Option<NextTrial>, EvidenceError> {
    let Some([one, other]) = diagnosis.rivals().map(|rivals| rivals.map(|rival| &rival.suspect)) else {
        return Ok(None);
    };
    next_trial(evidence, ((one.name(), &one.fit), (other.name(), &other.fit)))
}

/// The variant of the first trial that tells two fitted rivals apart best, even if their other parameters are fitted
/// anew (Atkinson and Fedorov 1975).
///
/// # Errors
/// When a variant cannot be prepared or simulated.
pub fn next_trial(
    evidence: &ScanEvidence,
    (first, second): ((&str, &Fit), (&str, &Fit)),
) -> Result<Option<NextTrial>, EvidenceError> {
    let template = evidence.simulation.trials[0].trial;
    let tried = |change: &Option<Change>| -> Result<(NextTrial, f64), EvidenceError> {
        let trial = varied(template, *change);
        let delta_chi2 = separation(evidence, &trial, first.1, second.1)?;
        Ok((stated(&trial, *change, [first.0, second.0], delta_chi2), delta_chi2))
    };
    let all: Vec<_> = CHANGES.par_iter().map(tried).collect();
    let known = all.into_iter().filter_map(Result::ok);
    Ok(known.max_by(|a, b| a.1.total_cmp(&b.1)).map(|(trial, _)| trial))
}

/// Least difference of two rivals' predictions of a trial, over all changes of the second's parameters that earlier data
/// allow.
fn separation(evidence: &ScanEvidence, trial: &Trial, first: &Fit, second: &Fit) -> Result<f64, EvidenceError> {
    let trials = [trial.clone()];
    let mut there = ScanEvidence::new(&trials, None)?;
    there.observation = evidence.observation.or(Some(Observation::default()));
    let of = |fit: &Fit| there.residuals(&fit.model, Split::Calibration);
    let (a, b) = (of(first)?, of(second)?);
    let difference = DVector::from_iterator(a.len(), a.iter().zip(&b).map(|(a, b)| b - a));
    let column = |(k, coordinate): (usize, &Coordinate)| -> Result<DVector<f64>, EvidenceError> {
        let mut at = second.at.clone();
        at[k] = coordinate.clamped(at[k] + coordinate.step());
        let step = at[k] - second.at[k];
        let there = there.residuals(&moved(&second.model, &second.coordinates, &at), Split::Calibration)?;
        let scale = if step == 0.0 { 0.0 } else { 1.0 / step };
        Ok(DVector::from_iterator(b.len(), there.iter().zip(&b).map(|(c, b)| scale * (c - b))))
    };
    let columns: Vec<DVector<f64>> = second.coordinates.iter().enumerate().map(column).collect::<Result<_, _>>()?;
    Ok(left_after_refit(&difference, &DMatrix::from_columns(&columns), second))
}

/// Sum of squares that is left of a difference of whitened predictions [1] when a fit may follow it.
///
/// - `jacobian`: derivatives of the predictions, shape [data, coordinates of the fit]; the fit's own data hold it where it is
pub(super) fn left_after_refit(difference: &DVector<f64>, jacobian: &DMatrix<f64>, fit: &Fit) -> f64 {
    let mut normal = jacobian.tr_mul(jacobian) + fit.jacobian.tr_mul(&fit.jacobian);
    (0..normal.nrows()).for_each(|k| normal[(k, k)] += 1e-9);
    let pull = jacobian.tr_mul(difference);
    let explained = Cholesky::new(normal).map_or(0.0, |factor| pull.dot(&factor.solve(&pull)));
    (difference.norm_squared() - explained).max(0.0)
}

/// A trial with all its passes changed, and all of them open to fits.
fn varied(template: &Trial, change: Option<Change>) -> Trial {
    let mut trial = template.clone();
    for pass in &mut trial.passes {
        pass.role = Role::Calibration;
        match change {
            None => {}
            Some(Change::Force(factor)) => {
                pass.force_setpoint *= factor;
                pass.log.rows.iter_mut().for_each(|row| row.force *= factor);
            }
            Some(Change::Feed(factor)) => {
                pass.feed *= factor;
                pass.log.rows.iter_mut().for_each(|row| row.time /= factor);
            }
            Some(Change::Spindle(factor)) => {
                pass.spindle_speed *= factor;
                pass.log.rows.iter_mut().for_each(|row| row.spindle_speed *= factor);
            }
            Some(Change::Backwards) => {
                let (Some(first), Some(last)) = (pass.log.rows.first(), pass.log.rows.last()) else { continue };
                let sum = (first.position + last.position).with_z(0.0);
                pass.direction = -pass.direction;
                pass.log.rows.iter_mut().for_each(|row| row.position = (sum - row.position).with_z(row.position.z));
            }
        }
    }
    trial
}

fn stated(trial: &Trial, change: Option<Change>, separates: [&str; 2], delta_chi2: f64) -> NextTrial {
    let what = match change {
        None => "the same passes on a new workpiece".to_owned(),
        Some(Change::Force(factor)) => format!("the same passes at {factor} times the force"),
        Some(Change::Feed(factor)) => format!("the same passes at {factor} times the feed"),
        Some(Change::Spindle(factor)) => format!("the same passes at {factor} times the spindle speed"),
        Some(Change::Backwards) => "the same passes in the opposite direction".to_owned(),
    };
    let each = |value: fn(&trials::trial::Pass) -> f64| trial.passes.iter().map(value).collect();
    NextTrial {
        summary: format!("Repeat {}: {what}.", trial.name),
        force_n: each(|pass| pass.force_setpoint),
        feed_mm_s: each(|pass| pass.feed * 1e3),
        spindle_rpm: each(|pass| pass.spindle_speed * RPM),
        separates: separates.map(str::to_owned).to_vec(),
        expected_delta_chi2: delta_chi2,
        probability_right: Normal::standard().cdf(0.5 * delta_chi2.sqrt()),
    }
}
