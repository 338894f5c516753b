//! Verdict of a search, from the errors of its models.

use serde::{Deserialize, Serialize};

use super::detectable::Detectable;
use super::evidence::Agreement;
use crate::criteria::{
    ADEQUATE_NOISE, ADEQUATE_REMOVAL, EFFECT_SIZE_FLOOR, EFFECT_SIZE_SMOOTH, HELD_OUT_NOISE, HELD_OUT_REMOVAL,
    LEFT_CALIBRATION_SHARE, LEFT_HELD_OUT_SHARE, NAMED_PROBABILITY, TESTABLE_SHARE, UNEXPLAINED_NOISE,
    UNEXPLAINED_REMOVAL,
};

/// Verdict on the data.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Verdict {
    /// Effects that no other effect can replace.
    Identified,
    /// One of a class of indistinguishable effects.
    Ambiguous,
    /// Effects were found, and something is still missing.
    Partly,
    /// Something is missing that no effect of the library describes.
    Unknown,
    /// One effect is significant and distinguishable, but too small to be named.
    Hint,
    /// Nothing is missing that these data could show.
    NothingMissing,
    /// These data cannot show most effects.
    NotTestable,
}

impl Verdict {
    /// Word in files and on pages.
    pub fn word(self) -> &'static str {
        match self {
            Self::Identified => "identified",
            Self::Ambiguous => "ambiguous",
            Self::Partly => "partly",
            Self::Unknown => "unknown",
            Self::Hint => "hint",
            Self::NothingMissing => "nothing-missing",
            Self::NotTestable => "not-testable",
        }
    }
}

/// Errors of a model over calibration and held-out data.
#[derive(Clone, Copy, Debug)]
pub(super) struct Standing<'a> {
    /// Agreement with the calibration data.
    pub calibration: &'a [Agreement],
    /// Agreement with the held-out data.
    pub evaluation: &'a [Agreement],
    /// Root mean square of the part that the closure explains of the calibration data beside the model, in their unit.
    pub closed: f64,
}

/// A model of a chain of searches: the first, or one with one effect more than the one before.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub struct Searched {
    /// Agreement with the calibration data.
    pub calibration: Vec<Agreement>,
    /// Agreement with the held-out data.
    pub evaluation: Vec<Agreement>,
    /// Root mean square of the part that the closure explains of the calibration data beside it, in their unit.
    #[serde(default)]
    pub closed: f64,
    /// Probability of the effect; 1 for the first model.
    pub probability: f64,
}

impl Searched {
    /// Its errors, as a verdict reads them.
    pub(super) fn standing(&self) -> Standing<'_> {
        Standing { calibration: &self.calibration, evaluation: &self.evaluation, closed: self.closed }
    }
}

/// End of a search.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum SearchEnd {
    /// No further effect is admissible, or none is needed.
    Exhausted,
    /// An effect is admissible, but cannot be the cause.
    Refused,
    /// The search was cut short; more might be found.
    CutShort,
}

/// Root mean square over scans.
pub(super) fn rms(of: &[Agreement], value: impl Fn(&Agreement) -> f64) -> f64 {
    (of.iter().map(|a| value(a).powi(2)).sum::<f64>() / of.len().max(1) as f64).sqrt()
}

/// Root mean square residual in excess of the noise floor.
pub fn unexplained(of: &[Agreement]) -> f64 {
    (rms(of, |a| a.rms).powi(2) - rms(of, |a| a.noise).powi(2)).max(0.0).sqrt()
}

/// The greater of given multiples of the mean removal and of the noise.
fn of_either(of: &[Agreement], shares: (f64, f64)) -> f64 {
    (shares.0 * rms(of, |a| a.scale)).max(shares.1 * rms(of, |a| a.noise))
}

/// Returns true if the unexplained residual exceeds given multiples of the mean removal and of the noise.
fn exceeds(of: &[Agreement], shares: (f64, f64)) -> bool {
    unexplained(of) > of_either(of, shares)
}

/// Least relevant size of a change of the calibration data, given the agreement of a model with them.
pub(super) fn least_size(of: &[Agreement]) -> f64 {
    (EFFECT_SIZE_SMOOTH * rms(of, |a| a.smooth_error)).max(EFFECT_SIZE_FLOOR * rms(of, |a| a.floor))
}

impl Standing<'_> {
    /// True if the calibration residuals exceed noise, in size or in smooth structure.
    pub(super) fn is_open(&self) -> bool {
        self.closed > least_size(self.calibration)
            || exceeds(self.calibration, (UNEXPLAINED_REMOVAL, UNEXPLAINED_NOISE))
    }

    /// True if the unexplained mean square is at most `share` of that of another model, `before`.
    fn leaves_at_most(&self, share: f64, before: &Self) -> bool {
        let left = |of: &Self| unexplained(of.calibration).max(of.closed).powi(2);
        left(self) <= share * left(before)
    }
}

/// Returns true if a model misses data that it was not fitted to.
pub(super) fn misses(held_out: &[Agreement]) -> bool {
    exceeds(held_out, (HELD_OUT_REMOVAL, HELD_OUT_NOISE))
}

/// Returns true if the unexplained mean square after is at most `share` of that before.
fn leaves_at_most(share: f64, before: &[Agreement], after: &[Agreement]) -> bool {
    unexplained(after).powi(2) <= share * unexplained(before).powi(2)
}

/// Returns true if the error of held-out data, which no fit has used, does not rise: an effect that predicts them worse
/// than the model without it is not what was missing.
pub(super) fn carries_over(before: &[Agreement], after: &[Agreement]) -> bool {
    rms(after, |a| a.rms) <= rms(before, |a| a.rms)
}

impl Verdict {
    /// Verdict of a search, with the held-out data that are opened at its end.
    ///
    /// - `base`: the first model
    /// - `found`: the model with each effect that can be named, and the effect's probability
    /// - `end`: end of the search
    pub(super) fn new(
        base: Standing,
        (found, end): (&[(Standing, f64)], SearchEnd),
        detectable: &[Detectable],
    ) -> Self {
        let Some(&(left, probability)) = found.last() else {
            // An effect that was refused fits noise if the first model is already an adequate fit.
            let is_known = !base.is_open() && (end == SearchEnd::Exhausted || !misses(base.evaluation));
            return if is_known { Self::of_silence(base.evaluation, detectable) } else { Self::Unknown };
        };
        let of_calibration = !left.is_open() || left.leaves_at_most(LEFT_CALIBRATION_SHARE, &base);
        let of_held_out =
            !misses(left.evaluation) || leaves_at_most(LEFT_HELD_OUT_SHARE, base.evaluation, left.evaluation);
        let goes_on = end == SearchEnd::CutShort && left.is_open();
        let is_adequate = goes_on
            || (of_calibration
                && of_held_out
                && carries_over(base.evaluation, left.evaluation)
                && !exceeds(left.calibration, (ADEQUATE_REMOVAL, ADEQUATE_NOISE)));
        match (left.is_open(), probability >= NAMED_PROBABILITY) {
            _ if !is_adequate => Self::Unknown,
            (_, false) if found.len() == 1 => Self::Ambiguous,
            (false, true) => Self::Identified,
            _ => Self::Partly,
        }
    }

    /// Verdict of successive searches, of which the last found nothing more or left nothing.
    ///
    /// - `chain`: the first model, and the model with each effect that was found
    pub fn of_chain(chain: &[Searched]) -> Option<Self> {
        let [first, found @ ..] = chain else { return None };
        let found: Vec<(Standing, f64)> = found.iter().map(|found| (found.standing(), found.probability)).collect();
        (!found.is_empty()).then(|| Self::new(first.standing(), (&found, SearchEnd::Exhausted), &[]))
    }

    /// Verdict where the calibration data show no effect.
    fn of_silence(held_out: &[Agreement], detectable: &[Detectable]) -> Self {
        let testable = detectable.iter().filter(|effect| effect.testable).count();
        let least = TESTABLE_SHARE * detectable.len() as f64;
        if (testable as f64) < least || misses(held_out) { Self::NotTestable } else { Self::NothingMissing }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Errors of one scan with a floor of 3 µm and a removal of 100 µm.
    fn scan(rms_um: f64) -> Vec<Agreement> {
        vec![Agreement {
            about: String::new(),
            rms: 1e-6 * rms_um,
            floor: 3e-6,
            noise: 3e-6,
            scale: 100e-6,
            smooth_error: 0.1e-6,
        }]
    }

    fn standing([calibration, evaluation]: &[Vec<Agreement>; 2], closed: f64) -> Standing<'_> {
        Standing { calibration, evaluation, closed }
    }

    /// Verdict from errors [µm] of calibration and held-out data.
    fn verdict(base: [f64; 2], found: &[([f64; 2], f64)], end: SearchEnd) -> Verdict {
        let base = base.map(scan);
        let found: Vec<([Vec<Agreement>; 2], f64)> = found.iter().map(|&(rms, p)| (rms.map(scan), p)).collect();
        let found: Vec<(Standing, f64)> = found.iter().map(|(errors, p)| (standing(errors, 0.0), *p)).collect();
        Verdict::new(standing(&base, 0.0), (&found, end), &[])
    }

    #[test]
    fn one_verdict_for_each_end_of_a_search() {
        use SearchEnd::{CutShort, Exhausted, Refused};
        assert_eq!(verdict([3.1, 3.2], &[], Exhausted), Verdict::NothingMissing);
        assert_eq!(verdict([3.1, 3.2], &[], Refused), Verdict::NothingMissing, "it does harm where nothing is left");
        assert_eq!(verdict([3.1, 9.0], &[], Refused), Verdict::Unknown);
        assert_eq!(verdict([9.0, 3.2], &[], Refused), Verdict::Unknown);
        assert_eq!(verdict([9.0, 6.2], &[([3.1, 6.3], 1.0)], Exhausted), Verdict::Unknown, "it predicts worse");
        assert_eq!(verdict([3.1, 9.0], &[], Exhausted), Verdict::NotTestable, "the held-out passes say more");
        let ends = |found: &[([f64; 2], f64)]| verdict([20.0, 20.0], found, Exhausted);
        assert_eq!(ends(&[]), Verdict::Unknown);
        assert_eq!(ends(&[([3.1, 3.2], 1.0)]), Verdict::Identified);
        assert_eq!(ends(&[([3.1, 3.2], 0.6)]), Verdict::Ambiguous);
        assert_eq!(ends(&[([6.0, 6.0], 1.0)]), Verdict::Partly);
        assert_eq!(ends(&[([6.0, 6.0], 1.0), ([3.1, 3.2], 0.6)]), Verdict::Partly);
        assert_eq!(ends(&[([15.0, 3.2], 1.0)]), Verdict::Unknown, "most of it is left");
        assert_eq!(verdict([60.0, 60.0], &[([20.0, 10.0], 1.0)], Exhausted), Verdict::Unknown, "far from the floor");
        assert_eq!(ends(&[([15.0, 3.2], 0.6)]), Verdict::Unknown);
        assert_eq!(ends(&[([3.1, 18.0], 1.0)]), Verdict::Unknown, "most of what is held out is left");
        assert_eq!(
            verdict([9.0, 6.2], &[([3.1, 5.3], 1.0)], Exhausted),
            Verdict::Identified,
            "what is left is as much as where nothing is missing"
        );
        assert_eq!(verdict([20.0, 20.0], &[([15.0, 18.0], 1.0)], CutShort), Verdict::Partly, "the search may go on");
    }

    #[test]
    fn a_chain_of_searches_is_judged_against_its_first_model() {
        let link = |rms_um: f64, probability: f64| Searched {
            calibration: scan(rms_um),
            evaluation: scan(rms_um),
            closed: 0.0,
            probability,
        };
        let verdict = |chain: &[Searched]| Verdict::of_chain(chain);
        assert_eq!(verdict(&[]), None);
        assert_eq!(verdict(&[link(20.0, 1.0)]), None, "nothing was found");
        assert_eq!(verdict(&[link(20.0, 1.0), link(3.1, 1.0)]), Some(Verdict::Identified));
        assert_eq!(verdict(&[link(20.0, 1.0), link(6.0, 1.0)]), Some(Verdict::Partly));
        let slow = [link(20.0, 1.0), link(16.0, 1.0), link(15.0, 1.0)];
        assert_eq!(verdict(&slow), Some(Verdict::Unknown), "most of what was missing is left");
        assert_eq!(verdict(&[link(20.0, 1.0), link(6.0, 1.0), link(3.1, 0.6)]), Some(Verdict::Partly));
    }

    #[test]
    fn smooth_structure_that_is_large_enough_to_matter_is_missing() {
        let errors = [20.0, 20.0].map(scan);
        let after = [3.1, 3.2].map(scan);
        let verdict = |closed: f64| {
            Verdict::new(standing(&errors, 18e-6), (&[(standing(&after, closed), 1.0)], SearchEnd::Exhausted), &[])
        };
        assert_eq!(verdict(0.1e-6), Verdict::Identified);
        assert_eq!(verdict(3e-6), Verdict::Partly);
        assert_eq!(verdict(15e-6), Verdict::Unknown, "most of it is left");
        let silent = |closed: f64| Verdict::new(standing(&after, closed), (&[], SearchEnd::Exhausted), &[]);
        assert_eq!(silent(0.1e-6), Verdict::NothingMissing);
        assert_eq!(silent(3e-6), Verdict::Unknown);
    }

    #[test]
    fn an_effect_carries_over_unless_held_out_errors_rise() {
        let carries = |before, after| carries_over(&scan(before), &scan(after));
        assert!(carries(20.0, 3.2) && carries(20.0, 18.0) && carries(3.2, 3.2));
        assert!(!carries(20.0, 33.0) && !carries(3.2, 3.3));
        assert!(carries_over(&[], &[]), "where nothing is held out nothing speaks against it");
    }
}
