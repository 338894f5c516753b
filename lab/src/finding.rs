//! An effect that was fitted, and what speaks for it.

use super::cross_validation::{CrossValidation, Prediction};
use super::evidence::{Agreement, Evidence, EvidenceError, Split};
use super::fit::Fit;
use super::reserve::Reserve;
use super::significance::NullDraws;
use super::suspect::Suspect;
use super::verdict::{Searched, least_size, rms};
use crate::criteria::SIGNIFICANCE_LEVEL;

/// An effect that was found, or might be.
#[derive(Clone)]
pub struct Finding {
    /// The effect fitted.
    pub suspect: Suspect,
    /// Fall of the sum of squares, over the spread of what is left.
    pub delta_chi2: f64,
    /// P-value of such a fall for the luckiest of all effects.
    pub p_value: f64,
    /// Root mean square of what it changes in the calibration data or takes from their errors, whichever is more, in their unit.
    pub size: f64,
    /// Probability among all effects that were fitted, and none of them.
    pub probability: f64,
    /// Agreement with the calibration data; empty where the effect is not significant.
    pub calibration: Vec<Agreement>,
    /// Agreement with the held-out data, opened once the search has ended; empty of effects that were not found.
    pub evaluation: Vec<Agreement>,
    /// Prediction of each fold of the calibration data by the model with the effect.
    pub prediction: Prediction,
    /// Root mean square of what the closure explains beside it, in the data's unit.
    pub closed: f64,
    /// Share of its prior odds in those of its family: all forms of a dependence are as likely beforehand, and the one that
    /// predicts best stands for them. 0 of a form that another one stands for.
    pub share: f64,
    /// True if it is admissible: significant and large enough to be named.
    pub is_admissible: bool,
    /// Reason why it cannot be named alone, even if it fits far better than all others.
    pub reserve: Option<Reserve>,
}

/// Reference for effects: the base fit, its agreement, draws of noise, and folds for prediction.
pub(super) struct Against<'a> {
    /// The model without the effect.
    pub base: &'a Fit,
    /// Its agreement with the calibration data.
    pub calibration: &'a [Agreement],
    /// Draws of noise with the largest Δχ² of any effect in each, for p-values.
    pub draws: &'a NullDraws,
    /// Calibration data in folds.
    pub folds: &'a CrossValidation,
    /// Standard deviation of what the best model leaves, whitened.
    pub spread: f64,
}

impl Finding {
    /// Name of its family.
    pub(super) fn family(&self) -> &str {
        &self.suspect.screened.candidate.family
    }

    /// The model with it, as a link of a chain of searches.
    pub fn as_searched(&self) -> Searched {
        Searched {
            calibration: self.calibration.clone(),
            evaluation: self.evaluation.clone(),
            closed: self.closed,
            probability: self.probability,
        }
    }

    /// # Errors
    /// When the model with the effect cannot be simulated.
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
            size,
            probability: 0.0,
            calibration,
            evaluation: Vec::new(),
            closed: prediction.closed_size(evidence),
            prediction,
            share: 1.0,
            is_admissible: is_real && size > least_size(before),
            reserve: if is_real { Reserve::of(&suspect, *spread, conditions) } else { None },
            suspect,
        })
    }
}
