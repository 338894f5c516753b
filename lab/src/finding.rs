//! A fitted effect and the evidence for it.

use super::cross_validation::{CrossValidation, Prediction};
use super::evidence::{Agreement, Evidence, EvidenceError, Split};
use super::fit::Fit;
use super::reserve::Reserve;
use super::significance::NullDraws;
use super::suspect::Suspect;
use super::verdict::{Searched, least_size, rms};
use crate::criteria::SIGNIFICANCE_LEVEL;

/// An effect that was found, or is a candidate.
#[derive(Clone)]
pub struct Finding {
    /// The fitted effect.
    pub suspect: Suspect,
    /// Fall of χ², divided by the variance of the remaining residuals.
    pub delta_chi2: f64,
    /// P-value: probability that noise alone gives the best of all effects such a Δχ².
    pub p_value: f64,
    /// Least probability of noise alone at this p-value.
    pub least_none: f64,
    /// Size of the effect, in the data's unit: the larger of the root mean square change of the calibration data and
    /// the reduction of their error.
    pub size: f64,
    /// Posterior probability among all fitted effects and the hypothesis that none of them is the cause.
    pub probability: f64,
    /// Agreement with the calibration data; empty where the effect is not significant.
    pub calibration: Vec<Agreement>,
    /// Agreement with the held-out data, opened once the search has ended; empty for effects that were not found.
    pub evaluation: Vec<Agreement>,
    /// Cross-validated prediction by the model with the effect.
    pub prediction: Prediction,
    /// Root mean square of the part that the closure explains beside it, in the data's unit.
    pub closed: f64,
    /// Factor on the prior odds from the family: all forms of a dependence are equally likely a priori, and the one
    /// that predicts best represents them. 0 for a form that another one represents.
    pub share: f64,
    /// True if it is admissible: significant, large enough to be named or as good an explanation as one that is, and from
    /// data that depend on the settings.
    pub is_admissible: bool,
    /// Reason why it cannot be named alone, even if it fits far better than all others.
    pub reserve: Option<Reserve>,
}

/// Reference for effects: the base fit, its agreement, draws of noise, and cross-validation folds.
pub(super) struct Against<'a> {
    /// The fit without the effect.
    pub base: &'a Fit,
    /// Its agreement with the calibration data.
    pub calibration: &'a [Agreement],
    /// Draws of noise with the largest Δχ² of any effect in each, for p-values.
    pub draws: &'a NullDraws,
    /// Cross-validation of the calibration data.
    pub folds: &'a CrossValidation,
    /// Standard deviation of the best model's whitened residuals.
    pub spread: f64,
}

impl Finding {
    /// Name of its family.
    pub(super) fn family(&self) -> &str {
        &self.suspect.screened.candidate.family
    }

    /// Returns false for an effect that cannot be what is missing, however well it fits: at the far end of its range, or
    /// with a value for each pass.
    pub(super) fn may_be_cause(&self) -> bool {
        !self.suspect.is_on_bound() && self.reserve != Some(Reserve::ValuePerPass)
    }

    /// Returns true for an effect that noise alone would hardly show, of whatever size.
    pub(super) fn is_significant(&self) -> bool {
        self.size > 0.0
    }

    /// Returns the model with the effect as an element of a chain of searches.
    pub fn as_searched(&self) -> Searched {
        Searched {
            calibration: self.calibration.clone(),
            evaluation: self.evaluation.clone(),
            closed: self.closed,
            probability: self.probability,
        }
    }

    /// # Errors
    /// If the model with the effect cannot be simulated.
    pub(super) fn new(evidence: &dyn Evidence, suspect: Suspect, against: &Against) -> Result<Self, EvidenceError> {
        let Against { base, calibration: before, draws, folds, spread } = against;
        let p_value = draws.p_value(base, &suspect.fit);
        let is_real = p_value < SIGNIFICANCE_LEVEL && !suspect.is_null();
        let calibration =
            if is_real { evidence.agreement(&suspect.fit.model, Split::Calibration)? } else { Vec::new() };
        let change: Vec<f64> = base.residuals.iter().zip(&suspect.fit.residuals).map(|(b, a)| b - a).collect();
        let explained = rms(before, |a| a.rms).powi(2) - rms(&calibration, |a| a.rms).powi(2);
        let size = if is_real { evidence.size(&change).max(explained.max(0.0).sqrt()) } else { 0.0 };
        let conditions = evidence.conditions(&suspect.fit.model)?;
        let prediction = folds.prediction(&suspect.fit);
        Ok(Self {
            delta_chi2: (base.chi2 - suspect.fit.chi2) / (spread * spread),
            p_value,
            least_none: draws.least_null_probability(base, &suspect.fit),
            size,
            probability: 0.0,
            calibration,
            evaluation: Vec::new(),
            closed: prediction.closed_size(evidence),
            prediction,
            share: 1.0,
            is_admissible: is_real && size > least_size(before) && evidence.unrelated().is_none(),
            reserve: if is_real { Reserve::of(&suspect, *spread, conditions) } else { None },
            suspect,
        })
    }
}
