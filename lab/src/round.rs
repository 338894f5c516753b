//! One search: every effect of the library is tried beside a fitted model, and the best are fitted and weighed.

use effects::{Library, Model};
use rayon::prelude::*;

use super::cross_validation::{CrossValidation, Prediction};
use super::diagnose::{OnProgress, spread};
use super::evidence::{Agreement, Evidence, EvidenceError, Split};
use super::finding::{Against, Finding};
use super::fit::Fit;
use super::leaders::with_leaders_completed;
use super::model_weights::{admitted, is_near, probabilities};
use super::neighbourhood::Neighbourhood;
use super::probe::Candidate;
use super::reserve::Reserve;
use super::response::Projector;
use super::screen::Screened;
use super::significance::null_delta_chi2;
use super::space_mapping::Lattices;
use super::suspect::{in_order, suspects};
use super::verdict::{Searched, Standing, least_size};
use crate::criteria::{NAMED_PROBABILITY, NONE_MOST, RESERVED_PROBABILITY};

/// Lets the best-predicting form of each dependence represent the family, at the mean likelihood of all its forms. An
/// admissible form is preferred.
pub(super) fn share_odds(findings: &mut [Finding]) {
    let rank = |finding: &Finding| (finding.is_admissible && finding.may_be_cause(), finding.prediction.total());
    let ranks: Vec<(bool, f64)> = findings.iter().map(rank).collect();
    let families: Vec<String> = findings.iter().map(|finding| finding.family().to_owned()).collect();
    for (k, finding) in findings.iter_mut().enumerate() {
        let forms: Vec<usize> = (0..families.len()).filter(|&j| families[j] == families[k]).collect();
        let is_better =
            |a: usize, b: usize| ranks[a].0.cmp(&ranks[b].0).then(ranks[a].1.total_cmp(&ranks[b].1)).is_gt();
        let best =
            forms.iter().copied().fold(forms[0], |best, other| if is_better(other, best) { other } else { best });
        let mean = forms.iter().map(|&j| (ranks[j].1 - ranks[best].1).min(0.0).exp()).sum::<f64>() / forms.len() as f64;
        finding.share = if best == k { mean } else { 0.0 };
    }
}

/// One search for a missing effect.
#[derive(Clone)]
pub struct Round {
    /// Fit of the model that the search starts from.
    pub base: Fit,
    /// Its agreement with the calibration data.
    pub calibration: Vec<Agreement>,
    /// Its agreement with the held-out data; empty until the search has ended.
    pub evaluation: Vec<Agreement>,
    /// Cross-validated prediction by the base model.
    pub prediction: Prediction,
    /// Root mean square of the part that the closure explains beside it, in the data's unit.
    pub closed: f64,
    /// All effects, by name.
    pub screened: Vec<Screened>,
    /// The effects that were fitted, most probable first.
    pub findings: Vec<Finding>,
    /// Probability that none of them is the cause.
    pub none: f64,
    /// Standard deviation of the best model's whitened residuals.
    pub spread: f64,
    /// True if its best effect was found as a pair with that of the next search, so it need not fit alone.
    pub is_half: bool,
    /// Seed of all draws.
    pub(super) seed: u64,
}

impl Round {
    /// # Errors
    /// If the model cannot be simulated.
    pub(super) fn new(
        evidence: &dyn Evidence,
        (model, base): (&Model, Fit),
        library: &Library,
        (seed, progress): (u64, OnProgress),
    ) -> Result<Self, EvidenceError> {
        let quicker = evidence.quicker();
        let near = |place: Fit| Neighbourhood::new((evidence, quicker.as_deref()), (model, place), library, progress);
        let other = base.is_poor().then(|| base.other_minimum(evidence)).flatten().map(near);
        let near = other.into_iter().fold(near(base.clone()), Neighbourhood::or);
        let Neighbourhood { place, screened, .. } = &near;
        let lattices = Lattices { usual: evidence, quicker: near.surrogate.as_ref().map(|surrogate| surrogate as _) };
        let (projector, count) = (Projector::new(place), screened.len());
        let mut fitted = suspects(lattices, place, screened, &|name| progress(name, count, count));
        fitted.retain(|suspect| suspect.fit.chi2 < base.chi2);
        let fitted = in_order(with_leaders_completed(lattices, &base, fitted, seed));
        let best = fitted.first().map_or(&base, |best| &best.fit);
        let spread = spread(&best.residuals);
        let draws = null_delta_chi2(&projector, screened, &best.residuals, &evidence.blocks(Split::Calibration), seed);
        let calibration = evidence.agreement(&base.model, Split::Calibration)?;
        let folds = CrossValidation::new(evidence, best);
        let against = Against { base: &base, calibration: &calibration, draws: &draws, folds: &folds, spread };
        let finding = |suspect| Finding::new(evidence, suspect, &against);
        let mut findings = fitted.into_par_iter().map(finding).collect::<Result<Vec<_>, _>>()?;
        share_odds(&mut findings);
        let (prediction, seed) = (folds.prediction(&base), seed);
        let screened = near.screened.into_iter().map(|look| look.seen_from(&base, &near.place)).collect();
        Ok(Self { screened, ..Self::weighed(evidence, (base, calibration, prediction), (findings, spread), seed) })
    }

    /// Builds the search from a base model with its agreement and prediction, and the effects fitted beside it.
    pub(super) fn weighed(
        evidence: &dyn Evidence,
        (base, calibration, prediction): (Fit, Vec<Agreement>, Prediction),
        (findings, spread): (Vec<Finding>, f64),
        seed: u64,
    ) -> Self {
        let closed = prediction.closed_size(evidence);
        let mut round = Self {
            base,
            calibration,
            evaluation: Vec::new(),
            prediction,
            closed,
            screened: Vec::new(),
            findings,
            none: 1.0,
            spread,
            is_half: false,
            seed,
        };
        round.weigh();
        round
    }

    /// Computes the probabilities of the effects and of none of them. All that are significant compete, of whatever size.
    /// An effect that cannot be the cause counts for "none of them": something acts that no other effect describes. So
    /// does one that is too small to be named.
    fn weigh(&mut self) {
        let probabilities = self.probabilities(Finding::is_significant);
        self.admit(&probabilities[1..]);
        let [none, probabilities @ ..] = &self.no_surer_than_significant(probabilities)[..] else { return };
        self.none = *none;
        for (finding, &probability) in self.findings.iter_mut().zip(probabilities) {
            let is_nameable = finding.is_admissible && finding.may_be_cause();
            finding.probability = match finding.reserve {
                _ if !is_nameable => 0.0,
                Some(_) => probability.min(RESERVED_PROBABILITY),
                None => probability,
            };
            self.none += if is_nameable { 0.0 } else { probability };
        }
        self.findings
            .sort_by(|a, b| b.probability.total_cmp(&a.probability).then(b.delta_chi2.total_cmp(&a.delta_chi2)));
    }

    /// Admits effects that are slightly too small beside one that is large enough.
    fn admit(&mut self, probabilities: &[f64]) {
        let is_large: Vec<bool> = self.findings.iter().map(|finding| finding.is_admissible).collect();
        let admitted = admitted(&is_large, probabilities);
        self.findings.iter_mut().zip(admitted).for_each(|(finding, admitted)| finding.is_admissible = admitted);
    }

    /// Probability of no effect, then of each effect that `lets_in` accepts.
    fn probabilities(&self, lets_in: impl Fn(&Finding) -> bool) -> Vec<f64> {
        let densities = |finding: &Finding| match lets_in(finding) {
            true => finding.prediction.densities.clone(),
            false => vec![f64::NEG_INFINITY; self.prediction.densities.len()],
        };
        let densities: Vec<Vec<f64>> =
            std::iter::once(self.prediction.densities.clone()).chain(self.findings.iter().map(densities)).collect();
        let priors: Vec<f64> = std::iter::once(1.0)
            .chain(self.findings.iter().map(|finding| finding.share * finding.suspect.prior()))
            .collect();
        probabilities(&densities, &priors, self.seed)
    }

    /// Raises the probability of no effect, given before those of the effects, to the least that the most probable
    /// effect's p-value allows.
    fn no_surer_than_significant(&self, mut probabilities: Vec<f64>) -> Vec<f64> {
        let [none, effects @ ..] = &mut probabilities[..] else { return probabilities };
        let most = effects.iter().zip(&self.findings).max_by(|a, b| a.0.total_cmp(b.0));
        let least = most.map_or(0.0, |(_, finding)| finding.least_none);
        if *none < least {
            let share = (1.0 - least) / (1.0 - *none);
            effects.iter_mut().for_each(|probability| *probability *= share);
            *none = least;
        }
        probabilities
    }

    /// Returns the base model as an element of a chain of searches.
    pub fn as_searched(&self) -> Searched {
        let (calibration, evaluation) = (self.calibration.clone(), self.evaluation.clone());
        Searched { calibration, evaluation, closed: self.closed, probability: 1.0 }
    }

    /// Opens the held-out data for the base model and the effect that was found.
    ///
    /// # Errors
    /// If a model cannot be simulated.
    pub(super) fn open_held_out(&mut self, evidence: &dyn Evidence) -> Result<(), EvidenceError> {
        self.evaluation = evidence.agreement(&self.base.model, Split::Evaluation)?;
        let found = self.nameable().map(|found| evidence.agreement(&found.suspect.fit.model, Split::Evaluation));
        if let Some(agreement) = found.transpose()? {
            self.findings[0].evaluation = agreement;
        }
        Ok(())
    }

    /// Errors of the base model.
    pub(super) fn standing(&self) -> Standing<'_> {
        Standing { calibration: &self.calibration, evaluation: &self.evaluation, closed: self.closed }
    }

    /// The most probable admissible effect.
    pub fn best(&self) -> Option<&Finding> {
        self.findings.first().filter(|finding| finding.is_admissible && finding.probability > 0.0)
    }

    /// The most probable effect, if it was taken back because it raises the error of the held-out data.
    pub(super) fn taken_back(&self) -> Option<&Finding> {
        self.findings.first().filter(|first| first.reserve == Some(Reserve::PredictsWorse))
    }

    /// The best effect, unless it is most probable that none of the effects is the cause.
    pub(super) fn nameable(&self) -> Option<&Finding> {
        self.best().filter(|_| self.is_half || self.none < NONE_MOST)
    }

    /// The one effect that is significant and distinguishable but too small to be named.
    pub fn hint(&self) -> Option<&Finding> {
        let probabilities = self.probabilities(Finding::is_significant);
        let shown = self.findings.iter().zip(&probabilities[1..]);
        let is_hint = |(finding, probability): &(&Finding, &f64)| {
            !finding.is_admissible && finding.reserve.is_none() && **probability >= NAMED_PROBABILITY
        };
        shown.into_iter().find(is_hint).map(|(finding, _)| finding)
    }

    /// Effects that are significant but too small to be named, and that the data cannot distinguish from the most probable
    /// of them, which is first. Empty unless it is nine times as probable that one of them acts as that none does.
    pub(super) fn too_small(&self) -> Vec<&Finding> {
        let probabilities = self.no_surer_than_significant(self.probabilities(Finding::is_significant));
        let is_small = |(finding, _): &(&Finding, f64)| !finding.is_admissible && finding.may_be_cause();
        let shown = self.findings.iter().zip(probabilities[1..].iter().copied());
        let mut small: Vec<(&Finding, f64)> = shown.filter(is_small).collect();
        small.sort_by(|a, b| b.1.total_cmp(&a.1));
        let most = small.first().map_or(0.0, |first| first.1);
        let one_acts = small.iter().map(|(_, probability)| probability).sum::<f64>() >= NAMED_PROBABILITY;
        small.retain(|(_, probability)| one_acts && is_near(*probability, most));
        small.into_iter().map(|(finding, _)| finding).collect()
    }

    /// True if the odds of the best effect against this one are at most nine to one: the two are indistinguishable.
    pub(super) fn is_near(&self, finding: &Finding) -> bool {
        let most = self.best().map_or(0.0, |best| best.probability);
        is_near(finding.probability, most)
    }

    /// Effects that the data cannot distinguish from the best.
    pub fn indistinguishable(&self) -> Vec<&Finding> {
        let Some(best) = self.best() else { return Vec::new() };
        let is_other = |finding: &&Finding| finding.suspect.name() != best.suspect.name();
        self.findings.iter().filter(is_other).filter(|finding| self.is_near(finding)).collect()
    }

    /// True for an effect that may be part of a pair: one that represents its family.
    pub(super) fn stands(&self, screened: &Screened) -> bool {
        let Candidate { name, family, .. } = &screened.candidate;
        let form = self.findings.iter().find(|finding| finding.family() == family && finding.share > 0.0);
        form.map_or(name == family, |form| form.suspect.name() == name)
    }

    /// Least size at which an effect beside this model is named, in the data's unit.
    pub fn least_size(&self) -> f64 {
        least_size(&self.calibration)
    }
}
