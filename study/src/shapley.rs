//! Shapley shares of two effects in a fall of χ², averaged over both orders of adding.

use lab::criteria::SHAPLEY_OVERLAP;
use lab::{Diagnosis, DiagnosisSummary};

/// Shares of a fall of χ².
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SharedFall {
    /// Share of the fall that either effect explains alone.
    pub overlap: f64,
    /// Shapley values of the first and the second effect, as shares.
    pub of: [f64; 2],
}

impl SharedFall {
    /// Computes the shares from the falls with the first effect alone, with the second alone and with both (Shapley
    /// 1953).
    pub fn new([first, second, both]: [f64; 3]) -> Self {
        let shapley = |own: f64, other: f64| 0.5 * (own + both - other) / both;
        Self { overlap: (first + second - both) / both, of: [shapley(first, second), shapley(second, first)] }
    }
}

/// The shares of the first two effects of a diagnosis, if they overlap by more than a fifth and the second was also
/// fitted alone.
fn shared_fall(diagnosis: &Diagnosis) -> Option<SharedFall> {
    let (one, found) = (&diagnosis.rounds[0], diagnosis.found());
    let [first, second, ..] = &found[..] else { return None };
    let alone = one.findings.iter().find(|finding| finding.suspect.name() == second.suspect.name())?;
    let fall = |chi2: f64| one.base.chi2 - chi2;
    let falls = [first.suspect.fit.chi2, alone.suspect.fit.chi2, second.suspect.fit.chi2].map(fall);
    let shares = SharedFall::new(falls);
    (shares.overlap > SHAPLEY_OVERLAP).then_some(shares)
}

/// Sentence on the shares of two effects that overlap.
pub(super) fn overlap(diagnosis: &Diagnosis, summary: &DiagnosisSummary) -> Option<String> {
    let shares = shared_fall(diagnosis)?;
    let [one, other] = [0, 1].map(|k| summary.effects.get(k).map_or("", |effect| effect.name.as_str()));
    Some(format!(
        "{one} and {other} explain the same in part ({:.0} % of the fall): in any order, {one} accounts for {:.0} % of it and {other} for {:.0} % (Shapley 1953).",
        100.0 * shares.overlap,
        100.0 * shares.of[0],
        100.0 * shares.of[1],
    ))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn shares_do_not_depend_on_the_order() {
        let shares = SharedFall::new([80.0, 60.0, 100.0]);
        assert!((shares.overlap - 0.4).abs() < 1e-12);
        assert!((shares.of[0] - 0.6).abs() < 1e-12 && (shares.of[1] - 0.4).abs() < 1e-12);
        assert_eq!(SharedFall::new([30.0, 70.0, 100.0]).overlap, 0.0);
    }
}
