//! Share of the explainable held-out error that a study explains.

use serde::{Deserialize, Serialize};
use trials::measure::median;

/// Least ratio of the base model's held-out error to the floor at which a gap is reported: below, noise dominates.
const LEAST_GAP: f64 = 1.25;

/// Errors of the held-out passes [m].
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Errors {
    /// Error of the fitted base law.
    pub base: Option<f64>,
    /// Error of the final model.
    pub found: Option<f64>,
    /// Noise floor: the error that a perfect model would leave.
    pub floor: Option<f64>,
}

impl Errors {
    /// Share of the gap between base model and noise floor that the final model closes; `None` if the gap is too small.
    pub fn closed(&self) -> Option<f64> {
        let (base, found, floor) = (self.base?, self.found?, self.floor?);
        (base >= LEAST_GAP * floor).then(|| (base - found) / (base - floor))
    }
}

/// Closed gaps of several cases.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct GapClosed {
    /// Number of cases with a gap.
    pub cases: usize,
    /// Median closed share.
    pub median: Option<f64>,
    /// Mean closed share; a model that is worse than the base law counts as negative.
    pub mean: Option<f64>,
}

impl GapClosed {
    /// Computes the gaps from the errors of each case.
    pub fn new<'a>(errors: impl Iterator<Item = &'a Errors>) -> Self {
        let shares: Vec<f64> = errors.filter_map(Errors::closed).collect();
        let mean = (!shares.is_empty()).then(|| shares.iter().sum::<f64>() / shares.len() as f64);
        Self { cases: shares.len(), median: median(shares), mean }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_gap_is_between_base_law_and_noise_floor() {
        let errors = |base: f64, found: f64| Errors { base: Some(base), found: Some(found), floor: Some(3.0) };
        assert_eq!(errors(13.0, 5.0).closed(), Some(0.8));
        assert_eq!(errors(13.0, 13.0).closed(), Some(0.0));
        assert_eq!(errors(13.0, 18.0).closed(), Some(-0.5));
        assert_eq!(errors(3.5, 3.0).closed(), None, "noise decides");
        assert_eq!(Errors::default().closed(), None);
        let all = [errors(13.0, 5.0), errors(13.0, 13.0), errors(13.0, 3.0), errors(3.5, 3.0)];
        let closed = GapClosed::new(all.iter());
        assert_eq!((closed.cases, closed.median, closed.mean), (3, Some(0.8), Some(0.6)));
    }
}
