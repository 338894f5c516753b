//! Reasons against fitted effects, and the effects that are still in play.

use super::diagnose::Diagnosis;
use super::evidence::ErrorUnit;
use super::finding::Finding;
use super::reserve::Reserve;
use super::round::Round;
use crate::criteria::{NAMED_PROBABILITY, SIGNIFICANCE_LEVEL};

impl Round {
    /// Reason against a fitted effect, in words; `None` for the best one and for those that the data cannot distinguish
    /// from it.
    pub fn ruled_out(&self, finding: &Finding, unit: ErrorUnit) -> Option<String> {
        let reasons = if finding.is_admissible {
            self.beaten(finding).into_iter().collect()
        } else {
            self.inadmissible(finding, unit)
        };
        (!reasons.is_empty()).then(|| reasons.join("; "))
    }

    /// Reasons for which an effect is not admissible.
    fn inadmissible(&self, finding: &Finding, unit: ErrorUnit) -> Vec<String> {
        if let Some(reserve) = finding.reserve.filter(|reserve| *reserve == Reserve::PredictsWorse) {
            return vec![reserve.words().to_owned()];
        }
        let mut reasons = Vec::new();
        if finding.suspect.is_null() {
            reasons.push("it ended at its null, where it changes nothing".to_owned());
        }
        if finding.p_value >= SIGNIFICANCE_LEVEL {
            reasons.push(format!("p-value {:.3}: not significant, {SIGNIFICANCE_LEVEL} is the level", finding.p_value));
        }
        if reasons.is_empty() && finding.size > self.least_size() {
            reasons.push("the data do not depend on what every law depends on".to_owned());
        } else if reasons.is_empty() {
            let [size, least] = [finding.size, self.least_size()].map(|size| unit.shown(size));
            reasons.push(format!("too small to matter: {size}, and {least} count"));
        }
        reasons
    }

    /// Reason for which an admissible effect is not the one named.
    fn beaten(&self, finding: &Finding) -> Option<String> {
        if finding.suspect.is_on_bound() && !self.is_half {
            return Some("its best size lies beyond its range".to_owned());
        }
        if let Some(reserve) = finding.reserve.filter(|_| !finding.may_be_cause()) {
            return Some(reserve.words().to_owned());
        }
        if let Some(first) = self.taken_back() {
            return Some(format!("{}, which is more probable, was taken back", first.suspect.name()));
        }
        let Some(best) = self.best() else {
            return Some("it predicts data left out of the fit no better than the model without it".to_owned());
        };
        let name = best.suspect.name();
        if name == finding.suspect.name() || self.is_near(finding) {
            return None;
        }
        if self.is_half {
            return Some(format!("{name} and a second effect together explain more"));
        }
        let behind = best.prediction.total() - finding.prediction.total();
        Some(format!("it predicts data left out of the fit worse than {name}: their log density is {behind:.1} less"))
    }

    /// The best effect and the most probable one that no verdict rules out beside it.
    fn in_play(&self) -> Option<[&Finding; 2]> {
        let best = self.best().filter(|best| best.probability < NAMED_PROBABILITY)?;
        let second = self.indistinguishable().into_iter().next()?;
        Some([best, second])
    }
}

impl Diagnosis {
    /// The two most probable effects of the last search that found any, where both are still in play.
    pub fn rivals(&self) -> Option<[&Finding; 2]> {
        self.rounds.iter().rev().find(|round| round.best().is_some())?.in_play()
    }

    /// The last search that found an effect, and this effect.
    pub fn last_found(&self) -> Option<(&Round, &Finding)> {
        let found = *self.found().last()?;
        let is_its = |round: &&Round| round.nameable().is_some_and(|own| std::ptr::eq(own, found));
        Some((self.rounds.iter().find(is_its)?, found))
    }
}
