//! Diagnosis of missing effects: every effect of the library is tried beside the base parameters, the best are fitted,
//! significance and indistinguishable effects are weighed, and one verdict is given.

use std::collections::BTreeMap;

use effects::{Library, Model};
use rayon::prelude::*;

use super::detectable::{Detectable, detectable};
use super::evidence::{Evidence, EvidenceError};
use super::finding::Finding;
use super::fit::Fit;
use super::frame::FrameEstimate;
use super::pair::pair;
use super::reserve::Reserve;
use super::response::{Baseline, Projector};
use super::round::Round;
use super::space_mapping::Surrogate;
use super::verdict::{SearchEnd, Searched, Verdict, carries_over, misses};
use crate::criteria::{MOST_EFFECTS, NAMED_PROBABILITY, SPREAD_CUT_SIGMAS};
use trials::measure::{MAD_TO_SIGMA, median};

/// Reason for an effect that was not weighed because none of its simulations completed.
const TOO_EXPENSIVE: &str = "its simulation fails or takes several times as many steps as the base model's";

/// Result of a diagnosis.
pub struct Diagnosis {
    /// The verdict.
    pub verdict: Verdict,
    /// The searches; each starts from the model with the effect of the one before.
    pub rounds: Vec<Round>,
    /// The model with all effects found.
    pub model: Model,
    /// Fit of that model.
    pub fit: Fit,
    /// Detectable size of each effect.
    pub detectable: Vec<Detectable>,
    /// Effects that these data cannot show, with the reason.
    pub blind: BTreeMap<String, String>,
    /// Frame offset of the logs beside the final model; `None` where no logs were moved.
    pub frame: Option<FrameEstimate>,
    /// Statement that the data do not depend on what a law depends on, if so.
    pub unrelated: Option<String>,
}

/// Progress callback: finished part, its number, and the number of parts.
pub type OnProgress<'a> = &'a (dyn Fn(&str, usize, usize) + Sync);

/// Returns a model with the values of a fit.
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

/// Robust standard deviation of whitened residuals, without gross outliers; at least one.
pub(super) fn spread(residuals: &[f64]) -> f64 {
    let middle = median(residuals.iter().map(|r| r.abs()).collect()).unwrap_or(0.0);
    let most = SPREAD_CUT_SIGMAS * (MAD_TO_SIGMA * middle).max(1.0);
    let squares: f64 = residuals.iter().map(|r| r.abs().min(most).powi(2)).sum();
    (squares / residuals.len().max(1) as f64).sqrt().max(1.0)
}

/// Searches and their result.
struct Search {
    rounds: Vec<Round>,
    model: Model,
    fit: Fit,
    end: SearchEnd,
}

impl Search {
    /// Searches for effects one after the other, each the best beside those before it.
    fn one_by_one(
        evidence: &dyn Evidence,
        (model, base): (&Model, &Fit),
        library: &Library,
        (seed, on_progress): (u64, OnProgress),
        searches: usize,
    ) -> Result<Self, EvidenceError> {
        let (mut grown, mut fit) = (model.clone(), base.clone());
        let mut rounds: Vec<Round> = Vec::new();
        while rounds.len() < searches {
            let round = Round::new(evidence, (&grown, fit.clone()), library, (seed, on_progress))?;
            let found = round.nameable().filter(|found| found.probability >= NAMED_PROBABILITY).cloned();
            rounds.push(round);
            let Some(found) = found else { break };
            grown = with_values(&grown.with(found.suspect.name()), &found.suspect.fit);
            let is_closed = !found.as_searched().standing().is_open();
            fit = found.suspect.fit;
            if is_closed {
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

    /// Result of two effects that were found together, or of the first alone where only one search is allowed.
    fn of_pair(rounds: [Round; 2], model: &Model, searches: usize) -> Self {
        let end = if searches < 2 { SearchEnd::CutShort } else { SearchEnd::Exhausted };
        let rounds: Vec<Round> = rounds.into_iter().take(searches).collect();
        let found: Vec<&Finding> = rounds.iter().filter_map(Round::nameable).collect();
        let fit = found[found.len() - 1].suspect.fit.clone();
        let grown = found.iter().fold(model.clone(), |grown, found| grown.with(found.suspect.name()));
        Self { model: with_values(&grown, &fit), rounds, fit, end }
    }

    /// Takes back effects, the last first, that raise the error of the held-out data; both of a pair.
    fn take_back_what_predicts_worse(&mut self) {
        while let Some(last) = self.rounds.iter().rposition(|round| round.nameable().is_some()) {
            let first = if last > 0 && self.rounds[last - 1].is_half { last - 1 } else { last };
            if carries_over(&self.rounds[first].evaluation, &self.rounds[last].findings[0].evaluation) {
                break;
            }
            for round in &mut self.rounds[first..=last] {
                let finding = &mut round.findings[0];
                (finding.is_admissible, finding.reserve) = (false, Some(Reserve::PredictsWorse));
                self.model.effects.retain(|part| part.name != finding.suspect.name());
            }
            self.fit = self.rounds[first].base.clone();
            self.model = with_values(&self.model, &self.fit);
            self.end = SearchEnd::Refused;
        }
    }

    /// Opens the held-out data for the models that the search has chosen, and returns the verdict.
    fn judged(&mut self, evidence: &dyn Evidence, detectable: &[Detectable]) -> Result<Verdict, EvidenceError> {
        for round in &mut self.rounds {
            round.open_held_out(evidence)?;
        }
        self.take_back_what_predicts_worse();
        let found: Vec<(Searched, f64)> = self
            .rounds
            .iter()
            .filter_map(Round::nameable)
            .map(|found| (found.as_searched(), found.probability))
            .collect();
        let found: Vec<_> = found.iter().map(|(searched, probability)| (searched.standing(), *probability)).collect();
        Ok(Verdict::new(self.rounds[0].standing(), (&found, self.end), detectable))
    }
}

impl Diagnosis {
    /// Fits a model to the calibration data and searches for missing effects.
    ///
    /// # Errors
    /// If the model cannot be simulated.
    pub fn new(
        evidence: &dyn Evidence,
        (model, base): (&Model, Fit),
        library: &Library,
        (seed, on_progress): (u64, OnProgress),
    ) -> Result<Self, EvidenceError> {
        Self::within(evidence, (model, base), library, (seed, on_progress), MOST_EFFECTS)
    }

    /// As [`Diagnosis::new`], with a limited number of searches.
    ///
    /// # Errors
    /// If the model cannot be simulated.
    pub fn within(
        evidence: &dyn Evidence,
        (model, base): (&Model, Fit),
        library: &Library,
        (seed, on_progress): (u64, OnProgress),
        searches: usize,
    ) -> Result<Self, EvidenceError> {
        let mut search = Search::one_by_one(evidence, (model, &base), library, (seed, on_progress), searches)?;
        let detectable = detectable_sizes(evidence, &search.rounds[0]);
        let blind = blind(evidence, library, &search.rounds);
        let mut verdict = search.judged(evidence, &detectable)?;
        if verdict == Verdict::Unknown
            && let Some(pair) = pair(evidence, &search.rounds[0], (model, library), (seed, on_progress))?
        {
            search = Search::of_pair(pair, model, searches);
            verdict = search.judged(evidence, &detectable)?;
        }
        let unrelated = evidence.unrelated();
        if unrelated.is_some() {
            verdict = Verdict::NotTestable;
        }
        if verdict == Verdict::NothingMissing && search.rounds[0].hint().is_some() {
            verdict = Verdict::Hint;
        }
        let (model, fit) = if verdict == Verdict::Unknown { (model.clone(), base) } else { (search.model, search.fit) };
        let frame = evidence.frame(&fit)?;
        let is_silent = matches!(verdict, Verdict::NothingMissing | Verdict::NotTestable | Verdict::Hint);
        if is_silent && frame.is_some_and(|frame| frame.cause.effect().is_some()) {
            verdict = Verdict::Identified;
        }
        Ok(Self { verdict, rounds: search.rounds, model, fit, detectable, blind, frame, unrelated })
    }

    /// The effects found, in order; none if the model with them is not an adequate fit.
    pub fn found(&self) -> Vec<&Finding> {
        let rounds = if self.verdict == Verdict::Unknown { &[][..] } else { &self.rounds[..] };
        rounds.iter().filter_map(Round::nameable).collect()
    }

    /// The effect that is significant but too small to be named, and the size from which it would be named.
    pub fn hint(&self) -> Option<(&Finding, f64)> {
        let round = self.rounds.first().filter(|_| self.verdict == Verdict::Hint)?;
        Some((round.hint()?, round.least_size()))
    }

    /// True if nothing was found although the model misses the held-out data.
    pub fn misses_held_out(&self) -> bool {
        self.found().is_empty() && misses(&self.rounds[0].evaluation)
    }
}

/// Detectable size of each effect beside the model of a search.
fn detectable_sizes(evidence: &dyn Evidence, round: &Round) -> Vec<Detectable> {
    let needed = (round.spread, round.least_size());
    let projector = Projector::new(&round.base);
    let quicker = evidence.quicker();
    let surrogate = quicker.as_deref().and_then(|quicker| Surrogate::around(evidence, quicker, &round.base));
    let quick: Option<&dyn Evidence> = surrogate.as_ref().map(|surrogate| surrogate as _);
    let baseline = Baseline { evidence: quick.unwrap_or(evidence), base: &round.base, projector: &projector };
    let first = round.screened.par_iter().filter(|screened| screened.candidate.name == screened.candidate.family);
    first.flat_map_iter(|screened| detectable(&baseline, screened, needed)).collect()
}

/// Effects that were not weighed, with the reason.
fn blind(evidence: &dyn Evidence, library: &Library, rounds: &[Round]) -> BTreeMap<String, String> {
    let blind = library.effects().iter().filter_map(|e| Some((e.name.clone(), evidence.is_blind_to(e)?)));
    let expensive = rounds.iter().flat_map(|round| &round.screened).filter(|screened| !screened.is_simulated());
    blind.chain(expensive.map(|screened| (screened.candidate.name.clone(), TOO_EXPENSIVE.to_owned()))).collect()
}
