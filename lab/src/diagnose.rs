//! What a model lacks: every effect of the library tried beside the base parameters, the best fitted, chance and
//! look-alikes weighed, and one verdict.

use std::collections::BTreeMap;

use effects::{Library, Model, candidates};
use rayon::prelude::*;

use super::detectable::{Detectable, detectable};
use super::evidence::{Agreement, Evidence, EvidenceError, Split};
use super::fit::Fit;
use super::pair::pair;
use super::probe::Candidate;
use super::reserve::Reserve;
use super::response::{Look, Projector};
use super::screen::Screened;
use super::significance::{NullDraws, null_delta_chi2};
use super::suspect::{Suspect, suspects};
use super::verdict::{SearchEnd, Searched, Verdict, carries_over, is_account, is_open, misses, rms};
use crate::criteria::{
    EFFECT_SIZE_FLOOR, EFFECT_SIZE_REMOVAL, INDISTINGUISHABLE_DELTA_CHI2, MODEL_ERROR_TEMPERING, MOST_EFFECTS,
    NAMED_PROBABILITY, RESERVED_PROBABILITY, SIGNIFICANCE_LEVEL, SPREAD_CUT_SIGMAS,
};
use trials::measure::{MAD_TO_SIGMA, median};

/// Why an effect was not weighed of which no simulation ended.
const TOO_DEAR: &str = "its simulation fails or takes several times as many steps as the base model's";

/// An effect that was found, or might be.
#[derive(Clone)]
pub struct Finding {
    /// The effect fitted.
    pub suspect: Suspect,
    /// Fall of the sum of squares, over the spread of what is left.
    pub delta_chi2: f64,
    /// Chance that the luckiest effect gains as much without being there.
    pub p_value: f64,
    /// Root mean square of what it changes in the calibration data or takes from their errors, whichever is more, in their unit.
    pub size: f64,
    /// Probability among all effects that were fitted.
    pub probability: f64,
    /// How well it describes the calibration data; empty where chance rules it out.
    pub calibration: Vec<Agreement>,
    /// How well it describes held-out data that no fit has seen; empty where it is not sound.
    pub evaluation: Vec<Agreement>,
    /// Whether it is large and sure enough to be named.
    pub is_admissible: bool,
    /// Why it cannot be named alone, however much better than the others it fits.
    pub reserve: Option<Reserve>,
}

/// One search for a missing effect.
#[derive(Clone)]
pub struct Round {
    /// The model searched from, fitted.
    pub base: Fit,
    /// How well it describes the calibration data.
    pub calibration: Vec<Agreement>,
    /// How well it describes the held-out data.
    pub evaluation: Vec<Agreement>,
    /// All effects, by name.
    pub screened: Vec<Screened>,
    /// The effects that were fitted, most probable first.
    pub findings: Vec<Finding>,
    /// Standard deviation of what the best model leaves, whitened.
    pub spread: f64,
    /// Difference of two effects' gains from which they are told apart.
    pub separable: f64,
    /// Whether its best effect was found together with that of the next search: alone it need not be an account.
    pub is_half: bool,
}

/// A diagnosis.
pub struct Diagnosis {
    /// The verdict.
    pub verdict: Verdict,
    /// The searches, each with the effect of the one before.
    pub rounds: Vec<Round>,
    /// The model with all effects that were found.
    pub model: Model,
    /// Its fit.
    pub fit: Fit,
    /// What each effect must be to be seen.
    pub detectable: Vec<Detectable>,
    /// Effects that these data are blind to, and why.
    pub blind: BTreeMap<String, String>,
}

/// Tells how far the work is: what is done, and of how many parts.
pub type OnProgress<'a> = &'a (dyn Fn(&str, usize, usize) + Sync);

/// A model with the values of a fit.
pub fn with_values(model: &Model, fit: &Fit) -> Model {
    let mut values: BTreeMap<(&str, &str), Vec<f64>> = BTreeMap::new();
    for (slot, value) in fit.model.parameters().iter().zip(fit.model.values()) {
        values.entry((&slot.owner, &slot.parameter)).or_default().push(*value);
    }
    let mut model = model.clone();
    for ((owner, parameter), values) in values {
        model.set(owner, parameter, &values);
    }
    model
}

/// Standard deviation of whitened residuals, gross outliers cut; at least one.
pub(super) fn spread(residuals: &[f64]) -> f64 {
    let middle = median(residuals.iter().map(|r| r.abs()).collect()).unwrap_or(0.0);
    let most = SPREAD_CUT_SIGMAS * (MAD_TO_SIGMA * middle).max(1.0);
    let squares: f64 = residuals.iter().map(|r| r.abs().min(most).powi(2)).sum();
    (squares / residuals.len().max(1) as f64).sqrt().max(1.0)
}

/// What an effect must explain to be named, given how well the model without it describes the data.
pub(super) fn least_size(before: &[Agreement]) -> f64 {
    (EFFECT_SIZE_REMOVAL * rms(before, |a| a.scale)).max(EFFECT_SIZE_FLOOR * rms(before, |a| a.floor))
}

impl Round {
    fn new(
        evidence: &dyn Evidence,
        (model, base): (&Model, Fit),
        library: &Library,
        (seed, told): (u64, OnProgress),
    ) -> Result<Self, EvidenceError> {
        let projector = Projector::new(&base);
        let look = Look { evidence, base: &base, projector: &projector };
        let model = with_values(model, &base);
        let tried = candidates(&model, library).into_iter().filter(|effect| evidence.is_blind_to(effect).is_none());
        let tried: Vec<Candidate> =
            tried.filter_map(|effect| Candidate::new(evidence, &model, effect, library).ok()).collect();
        let (count, done) = (tried.len(), std::sync::atomic::AtomicUsize::new(0));
        let screen = |candidate: Candidate| {
            let name = candidate.name.clone();
            let screened = Screened::new(&look, candidate);
            told(&name, 1 + done.fetch_add(1, std::sync::atomic::Ordering::Relaxed), count);
            screened
        };
        let screened: Vec<Screened> = tried.into_par_iter().map(screen).collect();
        let fitted = suspects(evidence, &base, &screened, &|name| told(name, count, count));
        let left = fitted.first().map_or(&base.residuals, |best| &best.fit.residuals);
        let spread = spread(left);
        let chances = null_delta_chi2(&projector, &screened, left, &evidence.blocks(Split::Calibration), seed);
        let [calibration, evaluation] =
            [Split::Calibration, Split::Evaluation].map(|split| evidence.agreement(&base.model, split));
        let (calibration, evaluation) = (calibration?, evaluation?);
        let finding = |suspect: Suspect| Finding::new(evidence, suspect, (&base, &calibration), (&chances, spread));
        let findings: Result<Vec<Finding>, EvidenceError> = fitted.into_par_iter().map(finding).collect();
        Ok(Self::weighed((base, calibration, evaluation), screened, (findings?, spread)))
    }

    /// From a base model and how well it describes the data, and the effects that were fitted beside it.
    pub(super) fn weighed(
        (base, calibration, evaluation): (Fit, Vec<Agreement>, Vec<Agreement>),
        screened: Vec<Screened>,
        (findings, spread): (Vec<Finding>, f64),
    ) -> Self {
        let separable = INDISTINGUISHABLE_DELTA_CHI2;
        let mut round = Self { base, calibration, evaluation, screened, findings, spread, separable, is_half: false };
        round.weigh();
        round
    }

    /// Probabilities of the effects with a significant Δχ² (Schwarz 1978, tempered). Those that cannot be the cause are out
    /// of it where the calibration data cannot tell the best of the others from them, and where one of the others is an account
    /// of all data: what the refused one fits better is then an error of all of them, so that they must be so much farther apart.
    fn weigh(&mut self) {
        let data = (self.base.residuals.len() as f64).ln();
        let cost = |finding: &Finding| match finding.is_admissible {
            true => -finding.delta_chi2 + finding.suspect.degrees_of_freedom() as f64 * data,
            false => f64::INFINITY,
        };
        let costs_of = |is_in: &dyn Fn(&Finding) -> bool| -> Vec<f64> {
            self.findings.iter().map(|f| if is_in(f) { cost(f) } else { f64::INFINITY }).collect()
        };
        let least = |costs: &[f64]| costs.iter().copied().fold(f64::INFINITY, f64::min);
        let is_cause = |finding: &Finding| self.is_half || self.is_cause(finding);
        let [all, causes] = [costs_of(&|_| true), costs_of(&is_cause)];
        let accounts = costs_of(&|f| is_cause(f) && self.is_account(f));
        let ahead = least(&accounts) - least(&all);
        let (weighed, error) = match least(&causes) - least(&all) < INDISTINGUISHABLE_DELTA_CHI2 {
            true => (causes, 1.0),
            false if ahead.is_finite() => (accounts, ahead / INDISTINGUISHABLE_DELTA_CHI2),
            false => (all, 1.0),
        };
        let priors: Vec<f64> = self.findings.iter().map(|finding| finding.suspect.prior()).collect();
        let probabilities = probabilities((&weighed, &priors), error);
        self.separable = INDISTINGUISHABLE_DELTA_CHI2 * error;
        self.findings.iter_mut().zip(probabilities).for_each(|(finding, p)| {
            finding.probability = if finding.reserve.is_some() { p.min(RESERVED_PROBABILITY) } else { p };
        });
        self.findings
            .sort_by(|a, b| b.probability.total_cmp(&a.probability).then(b.delta_chi2.total_cmp(&a.delta_chi2)));
    }

    /// Whether an effect is what is missing.
    fn is_account(&self, finding: &Finding) -> bool {
        is_account([&self.calibration, &self.evaluation], [&finding.calibration, &finding.evaluation])
    }

    /// Whether an effect does no harm to the held-out data and does not want to be larger than it can be.
    fn is_cause(&self, finding: &Finding) -> bool {
        carries_over(&self.evaluation, &finding.evaluation) && !finding.suspect.is_on_bound()
    }

    /// The model searched from, as a link of a chain of searches.
    pub(super) fn as_searched(&self) -> Searched {
        Searched { calibration: self.calibration.clone(), evaluation: self.evaluation.clone(), probability: 1.0 }
    }

    /// The most probable effect that is sound.
    pub fn best(&self) -> Option<&Finding> {
        self.findings.first().filter(|finding| finding.is_admissible)
    }

    /// The best, unless it does harm to the held-out data or wants to be larger than it can be.
    pub(super) fn nameable(&self) -> Option<&Finding> {
        self.best().filter(|best| self.is_half || self.is_cause(best))
    }

    /// The effect that shows and no other like it, where it is too small to be named.
    pub fn hint(&self) -> Option<&Finding> {
        let mut shown: Vec<&Finding> = self.findings.iter().filter(|finding| finding.size > 0.0).collect();
        shown.sort_by(|a, b| b.delta_chi2.total_cmp(&a.delta_chi2));
        let next = shown.get(1).map_or(0.0, |next| next.delta_chi2);
        let is_hint = |f: &&&Finding| {
            !f.is_admissible && f.reserve.is_none() && f.delta_chi2 - next >= INDISTINGUISHABLE_DELTA_CHI2
        };
        shown.first().filter(is_hint).copied()
    }

    /// Effects that the data cannot tell from the best.
    pub fn look_alikes(&self) -> Vec<&Finding> {
        let Some(best) = self.best() else { return Vec::new() };
        let near = |finding: &&Finding| {
            finding.is_admissible && finding.probability > 0.0 && best.delta_chi2 - finding.delta_chi2 < self.separable
        };
        self.findings[1..].iter().filter(near).collect()
    }
}

/// Probabilities of models from their costs, which err by so many times what they should, and their prior odds; none where all
/// costs are infinite.
pub(super) fn probabilities((costs, priors): (&[f64], &[f64]), error: f64) -> Vec<f64> {
    let best = costs.iter().copied().fold(f64::INFINITY, f64::min);
    let weight = |(cost, prior): (&f64, &f64)| {
        if cost.is_finite() { prior * (-(cost - best) / (2.0 * MODEL_ERROR_TEMPERING * error)).exp() } else { 0.0 }
    };
    let weights: Vec<f64> = costs.iter().zip(priors).map(weight).collect();
    let total: f64 = weights.iter().sum();
    weights.iter().map(|weight| if total > 0.0 { weight / total } else { 0.0 }).collect()
}

impl Finding {
    /// The model with it, as a link of a chain of searches.
    pub(super) fn as_searched(&self) -> Searched {
        let (calibration, evaluation) = (self.calibration.clone(), self.evaluation.clone());
        Searched { calibration, evaluation, probability: self.probability }
    }

    pub(super) fn new(
        evidence: &dyn Evidence,
        suspect: Suspect,
        (base, before): (&Fit, &[Agreement]),
        (chances, spread): (&NullDraws, f64),
    ) -> Result<Self, EvidenceError> {
        let delta_chi2 = base.chi2 - suspect.fit.chi2;
        let p_value = chances.p_value(base, &suspect.fit);
        let is_real = p_value < SIGNIFICANCE_LEVEL && !suspect.is_null();
        let calibration =
            if is_real { evidence.agreement(&suspect.fit.model, Split::Calibration)? } else { Vec::new() };
        let change: Vec<f64> = base.residuals.iter().zip(&suspect.fit.residuals).map(|(b, a)| b - a).collect();
        let explained = rms(before, |a| a.rms).powi(2) - rms(&calibration, |a| a.rms).powi(2);
        let size = if is_real { evidence.size(&change).max(explained.max(0.0).sqrt()) } else { 0.0 };
        let is_admissible = is_real && size > least_size(before);
        let evaluation =
            if is_admissible { evidence.agreement(&suspect.fit.model, Split::Evaluation)? } else { Vec::new() };
        let delta_chi2 = delta_chi2 / (spread * spread);
        let conditions = evidence.conditions(&suspect.fit.model)?;
        let reserve = if is_real { Reserve::of(&suspect, spread, conditions) } else { None };
        let probability = 0.0;
        Ok(Self { suspect, delta_chi2, p_value, size, probability, calibration, evaluation, is_admissible, reserve })
    }
}

/// Searches, and what they led to.
struct Search {
    rounds: Vec<Round>,
    model: Model,
    fit: Fit,
    end: SearchEnd,
}

impl Search {
    /// Effects one after the other, each the best beside those before it.
    fn one_by_one(
        evidence: &dyn Evidence,
        (model, base): (&Model, &Fit),
        library: &Library,
        (seed, told): (u64, OnProgress),
        searches: usize,
    ) -> Result<Self, EvidenceError> {
        let (mut grown, mut fit) = (model.clone(), base.clone());
        let mut rounds: Vec<Round> = Vec::new();
        while rounds.len() < searches {
            let round = Round::new(evidence, (&grown, fit.clone()), library, (seed, told))?;
            let found = round.nameable().filter(|found| found.probability >= NAMED_PROBABILITY).cloned();
            rounds.push(round);
            let Some(found) = found else { break };
            grown = with_values(&grown.with(found.suspect.name()), &found.suspect.fit);
            fit = found.suspect.fit;
            if !is_open(&found.calibration) {
                break;
            }
        }
        let end = match rounds.last() {
            Some(last) if last.best().is_some() && last.nameable().is_none() => SearchEnd::Refused,
            _ if searches < MOST_EFFECTS && rounds.len() == searches => SearchEnd::CutShort,
            _ => SearchEnd::Exhausted,
        };
        Ok(Self { rounds, model: grown, fit, end })
    }

    /// Two effects that were found together, or the first of them where only one search is asked for.
    fn of_pair(rounds: [Round; 2], model: &Model, searches: usize) -> Self {
        let end = if searches < 2 { SearchEnd::CutShort } else { SearchEnd::Exhausted };
        let rounds: Vec<Round> = rounds.into_iter().take(searches).collect();
        let found: Vec<&Finding> = rounds.iter().filter_map(Round::nameable).collect();
        let fit = found[found.len() - 1].suspect.fit.clone();
        let grown = found.iter().fold(model.clone(), |grown, found| grown.with(found.suspect.name()));
        Self { model: with_values(&grown, &fit), rounds, fit, end }
    }

    fn verdict(&self, detectable: &[Detectable]) -> Verdict {
        let found = self.rounds.iter().filter_map(Round::nameable);
        let account: Vec<_> = found.map(|f| ([&f.calibration[..], &f.evaluation], f.probability)).collect();
        let base_errors = [&self.rounds[0].calibration[..], &self.rounds[0].evaluation];
        Verdict::new(base_errors, (&account, self.end), detectable)
    }
}

impl Diagnosis {
    /// Fits a model to the calibration data and searches for what it lacks.
    ///
    /// # Errors
    /// When the model cannot be simulated.
    pub fn new(
        evidence: &dyn Evidence,
        (model, base): (&Model, Fit),
        library: &Library,
        (seed, told): (u64, OnProgress),
    ) -> Result<Self, EvidenceError> {
        Self::within(evidence, (model, base), library, (seed, told), MOST_EFFECTS)
    }

    /// As [`Diagnosis::new`], with at most so many searches.
    ///
    /// # Errors
    /// When the model cannot be simulated.
    pub fn within(
        evidence: &dyn Evidence,
        (model, base): (&Model, Fit),
        library: &Library,
        (seed, told): (u64, OnProgress),
        searches: usize,
    ) -> Result<Self, EvidenceError> {
        let mut search = Search::one_by_one(evidence, (model, &base), library, (seed, told), searches)?;
        let detectable = seen(evidence, &search.rounds[0]);
        let blind = blind(evidence, library, &search.rounds);
        let mut verdict = search.verdict(&detectable);
        if verdict == Verdict::Unknown
            && let Some(pair) = pair(evidence, &search.rounds[0], (model, library), (seed, told))?
        {
            search = Search::of_pair(pair, model, searches);
            verdict = search.verdict(&detectable);
        }
        if verdict == Verdict::NothingMissing && search.rounds[0].hint().is_some() {
            verdict = Verdict::Hint;
        }
        let (model, fit) = if verdict == Verdict::Unknown { (model.clone(), base) } else { (search.model, search.fit) };
        Ok(Self { verdict, rounds: search.rounds, model, fit, detectable, blind })
    }

    /// The effects that were found, in order; none where they are no account of what is missing.
    pub fn found(&self) -> Vec<&Finding> {
        let rounds = if self.verdict == Verdict::Unknown { &[][..] } else { &self.rounds[..] };
        rounds.iter().filter_map(Round::nameable).collect()
    }

    /// The effect that shows but is too small to be named, and the size from which it would be.
    pub fn hint(&self) -> Option<(&Finding, f64)> {
        let round = self.rounds.first().filter(|_| self.verdict == Verdict::Hint)?;
        Some((round.hint()?, least_size(&round.calibration)))
    }

    /// Whether nothing was found although the model misses the held-out data.
    pub fn misses_held_out(&self) -> bool {
        self.found().is_empty() && misses(&self.rounds[0].evaluation)
    }
}

/// What each effect must be to be seen beside the first model.
fn seen(evidence: &dyn Evidence, round: &Round) -> Vec<Detectable> {
    let needed = (round.spread, least_size(&round.calibration));
    let projector = Projector::new(&round.base);
    let look = Look { evidence, base: &round.base, projector: &projector };
    round.screened.par_iter().flat_map_iter(|screened| detectable(&look, screened, needed)).collect()
}

/// Effects that were not weighed, and why.
fn blind(evidence: &dyn Evidence, library: &Library, rounds: &[Round]) -> BTreeMap<String, String> {
    let blind = library.effects().iter().filter_map(|e| Some((e.name.clone(), evidence.is_blind_to(e)?)));
    let dear = rounds.iter().flat_map(|round| &round.screened).filter(|screened| !screened.is_simulated());
    blind.chain(dear.map(|screened| (screened.candidate.name.clone(), TOO_DEAR.to_owned()))).collect()
}
