//! Baselines that any study must beat.

use std::collections::BTreeMap;

use lab::{Diagnosis, Evidence, Verdict};

use super::answer::{CaseAnswer, ExpectedAnswer};
use super::cases::Case;

/// Ratio of the error to the noise floor up to which the baseline takes the model for complete.
const NEAR_FLOOR: f64 = 1.1;

/// Residual regression: names the effect whose simulated change has the greatest correlation with the base model's
/// residual, in the data's own unit, neither whitened nor fitted together with the base parameters. It names none if
/// the base model is near the floor.
pub(super) fn regression(evidence: &dyn Evidence, diagnosis: &Diagnosis, [rms, floor]: [f64; 2]) -> CaseAnswer {
    let round = &diagnosis.rounds[0];
    let left = &round.base.residuals;
    let responses =
        round.screened.iter().flat_map(|effect| effect.responses.iter().flatten().map(move |r| (effect, r)));
    let correlated = responses.map(|(effect, response)| {
        (effect.candidate.name.as_str(), correlation(&|data| evidence.size(data), left, &response.raw).abs())
    });
    let best = correlated.filter(|(_, c)| c.is_finite()).max_by(|a, b| a.1.total_cmp(&b.1));
    match best {
        Some((name, _)) if rms > NEAR_FLOOR * floor => CaseAnswer::sure(Verdict::Identified, Some(name)),
        _ => CaseAnswer::sure(Verdict::NothingMissing, None),
    }
}

/// Correlation of two changes, computed from norms alone by the polarisation identity (Jordan and von Neumann 1935).
fn correlation(norm: &dyn Fn(&[f64]) -> f64, a: &[f64], b: &[f64]) -> f64 {
    let of = |sign: f64| norm(&a.iter().zip(b).map(|(a, b)| a + sign * b).collect::<Vec<_>>());
    (of(1.0).powi(2) - of(-1.0).powi(2)) / (4.0 * norm(a) * norm(b))
}

/// Names for every case the effect that is hidden most often; of equally frequent ones the first by name.
pub(super) fn most_common(cases: &[&Case]) -> CaseAnswer {
    let mut counts: BTreeMap<&str, usize> = BTreeMap::new();
    for case in cases.iter().filter(|case| case.asked() == ExpectedAnswer::Names) {
        *counts.entry(case.hidden[0].as_str()).or_default() += 1;
    }
    let most = counts.iter().rev().max_by_key(|(_, count)| **count);
    match most {
        Some((name, _)) => CaseAnswer::sure(Verdict::Identified, Some(name)),
        None => CaseAnswer::sure(Verdict::NothingMissing, None),
    }
}

#[cfg(test)]
mod tests {
    use effects::Library;

    use super::super::cases::{Family, cases};
    use super::*;

    #[test]
    fn a_correlation_follows_from_lengths_alone() {
        let norm = |data: &[f64]| data.iter().map(|x| x * x).sum::<f64>().sqrt();
        assert!((correlation(&norm, &[1.0, 0.0], &[1.0, 1.0]) - 0.5f64.sqrt()).abs() < 1e-12);
        assert!((correlation(&norm, &[3.0, 4.0], &[-6.0, -8.0]) + 1.0).abs() < 1e-12);
        assert!(correlation(&norm, &[1.0, 2.0], &[2.0, -1.0]).abs() < 1e-12);
    }

    #[test]
    fn the_most_common_effect_is_counted_over_cases_that_ask_for_names() {
        let all = cases(&[Family::W, Family::U], 12, 1, Library::builtin());
        let all: Vec<&Case> = all.iter().collect();
        // In twelve cases over five effects the first two occur three times, and pad-loading is first by name.
        assert_eq!(most_common(&all).named[0].name, "pad-loading");
        assert!(most_common(&[]).named.is_empty());
    }
}
