//! Steps of a fit: each lowers χ², and derivatives are renewed when they are outdated.

use std::ops::Range;

use super::{DAMPING, Fit, FitOptions, Place};
use crate::criteria::{FIT_CONVERGED_DELTA_CHI2, NUMERICAL_NOISE};
use crate::evidence::Evidence;

/// Least damping: below it, many tries would be needed to shorten a failed step.
const LEAST_DAMPING: f64 = 1e-5;
/// Range of the actual over the predicted fall of χ² in which the derivatives are kept.
const KEPT_OF_PROMISE: Range<f64> = 0.5..2.0;
/// Most lengths tried for one step.
const TRIES: usize = 3;

/// Outcome of an attempt to improve a fit.
enum Step {
    /// χ² fell.
    Better {
        /// Fall of χ² that the derivatives predicted.
        promised: f64,
    },
    /// No step is worth its cost.
    None,
}

impl Fit {
    /// Takes steps until none is worth its cost. Existing derivatives are used first; those of a converged fit are as
    /// good as new ones, and so are those from a place whose data differ by no more than numerical noise.
    pub(crate) fn stepped(mut self, evidence: &dyn Evidence, options: FitOptions) -> Self {
        let mut damping = DAMPING.0;
        let mut left = options.derivatives;
        let mut from: Option<Place> = std::mem::take(&mut self.converged).then(|| self.here());
        let mut known = self.jacobian.iter().any(|derivative| *derivative != 0.0);
        for _ in 0..options.steps {
            if !known {
                if left == 0 {
                    break;
                }
                from = Some(self.here());
                self.renew_derivatives(evidence);
                left -= 1;
            }
            let before = self.chi2;
            match self.improve(evidence, &mut damping) {
                Step::Better { promised } => known = KEPT_OF_PROMISE.contains(&((before - self.chi2) / promised)),
                Step::None if from.as_ref().is_some_and(|from| self.is_near(from)) => {
                    self.converged = true;
                    break;
                }
                Step::None => known = false,
            }
        }
        self
    }

    /// True if the data at a place differ by no more than numerical noise.
    fn is_near(&self, place: &Place) -> bool {
        self.here().distance(place) <= NUMERICAL_NOISE
    }

    /// Takes one step that lowers χ². Each try updates the derivatives, also a failed one.
    fn improve(&mut self, evidence: &dyn Evidence, damping: &mut f64) -> Step {
        let worth = FIT_CONVERGED_DELTA_CHI2 * self.chi2_per_datum().max(1.0);
        for _ in 0..TRIES {
            let Some((at, promised)) = self.step(&self.residuals, *damping) else { return Step::None };
            if promised < worth {
                return Step::None;
            }
            if let Some(tried) = self.tried(evidence, at) {
                let along = self.along_line(&tried).and_then(|place| self.tried(evidence, place));
                let best = along.into_iter().fold(tried, |a, b| if b.chi2 < a.chi2 { b } else { a });
                self.update_jacobian(&best);
                if best.chi2 < self.chi2 {
                    let kept = self.chi2 - best.chi2;
                    *damping =
                        if kept > 0.25 * promised { (DAMPING.1 * *damping).max(LEAST_DAMPING) } else { *damping };
                    self.go_to(best);
                    return Step::Better { promised };
                }
            }
            *damping *= DAMPING.2;
        }
        Step::None
    }
}
