//! Hypotheses: effects that are still in play, and none of them.

use effects::CompiledModel;
use nalgebra::{DMatrix, DVector};

use super::score::Belief;
use lab::criteria::{DERIVATIVE_CHANGE_AIM, DERIVATIVE_LONGEST_STEP, NAMED_PROBABILITY, NEXT_TRIAL_HYPOTHESES};
use lab::{Diagnosis, Finding, Fit, Round, moved, prior};

/// Name of the hypothesis that no effect of the library is the cause.
const NONE: &str = "none of these";

/// A model that may be the right one.
#[derive(Clone, Copy)]
pub struct Hypothesis<'a> {
    /// Name of its effect.
    pub name: &'a str,
    /// Unnormalised probability.
    pub probability: f64,
    /// The model, fitted to all earlier data.
    pub fit: &'a Fit,
}

impl<'a> Hypothesis<'a> {
    fn of(finding: &'a Finding) -> Self {
        Self { name: finding.suspect.name(), probability: finding.probability, fit: &finding.suspect.fit }
    }

    /// Its normalised probability, and the precision of its parameters from earlier data and the library's ranges.
    ///
    /// - `sum`: of all probabilities
    /// - `spread`: standard deviation of whitened residuals that is attributed to noise
    pub(super) fn belief(&self, sum: f64, spread: f64) -> Belief {
        let data = self.fit.jacobian.tr_mul(&self.fit.jacobian) / (spread * spread);
        let precision = data + DMatrix::from_diagonal(&prior(&self.fit.coordinates));
        Belief { probability: self.probability / sum, precision }
    }

    /// The model at its best values, then with each coordinate moved by a finite difference; and these steps.
    pub(super) fn models(&self) -> (Vec<CompiledModel>, DVector<f64>) {
        let fit = self.fit;
        let mut models = vec![fit.model.clone()];
        let mut ways = DVector::zeros(fit.at.len());
        for (k, coordinate) in fit.coordinates.iter().enumerate() {
            let change = fit.jacobian.column(k).norm().max(f64::MIN_POSITIVE);
            let step = (DERIVATIVE_CHANGE_AIM / change).clamp(coordinate.step(), DERIVATIVE_LONGEST_STEP);
            let ends = [step, -step].map(|step| coordinate.clamped(fit.at[k] + step));
            let farther = |end: &f64| (end - fit.at[k]).abs();
            let end = if farther(&ends[0]) >= 0.5 * step { ends[0] } else { ends[1] };
            let mut at = fit.at.clone();
            at[k] = end;
            ways[k] = end - fit.at[k];
            models.push(moved(&fit.model, &fit.coordinates, &at));
        }
        (models, ways)
    }

    /// True if the model has a parameter of its own for each pass or scan.
    pub(super) fn has_rows(&self) -> bool {
        self.fit.model.parameters().iter().any(|slot| slot.row.is_some())
    }
}

/// The hypotheses between which no verdict decides, most probable first; empty if only one is left.
fn live(round: &Round) -> Vec<Hypothesis<'_>> {
    let Some(best) = round.best().filter(|best| best.probability < NAMED_PROBABILITY) else { return Vec::new() };
    let mut all = vec![Hypothesis::of(best)];
    all.extend(round.indistinguishable().into_iter().map(Hypothesis::of));
    all.truncate(NEXT_TRIAL_HYPOTHESES);
    // The probability that an untested effect is denied goes to "none of these".
    let none = 1.0 - round.findings.iter().map(|finding| finding.probability).sum::<f64>();
    if none * NAMED_PROBABILITY >= best.probability * (1.0 - NAMED_PROBABILITY) {
        all.push(Hypothesis { name: NONE, probability: none, fit: &round.base });
    }
    if all.len() > 1 { all } else { Vec::new() }
}

/// The search of a diagnosis whose hypotheses are still in play, and these; `None` if only one is left.
pub fn live_hypotheses(diagnosis: &Diagnosis) -> Option<(&Round, Vec<Hypothesis<'_>>)> {
    let round = diagnosis.rounds.iter().rev().find(|round| round.best().is_some())?;
    let live = live(round);
    (!live.is_empty()).then_some((round, live))
}
