//! Posterior probabilities of models from their cross-validated predictions.
//!
//! The sum of a model's log densities is uncertain, because other folds might have been measured. So the folds are
//! weighted at random (the Bayesian bootstrap, Rubin 1981), the models' weights follow from each draw, and their means
//! are the probabilities (pseudo-BMA+; Yao, Vehtari, Simpson and Gelman 2018).

use random::Stream;

use crate::criteria::{FOLD_WEIGHT_DRAWS, NAMED_PROBABILITY};

/// Probability of each model.
///
/// - `densities`: log density of each fold, by model; −∞ everywhere rules a model out
/// - `priors`: prior odds
pub(super) fn probabilities(densities: &[Vec<f64>], priors: &[f64], seed: u64) -> Vec<f64> {
    let is_in: Vec<bool> = densities.iter().map(|of| of.iter().all(|density| density.is_finite())).collect();
    let folds = densities.first().map_or(0, Vec::len);
    let mut sums = vec![0.0; densities.len()];
    let mut stream = Stream::of(seed, "weights of folds");
    for _ in 0..FOLD_WEIGHT_DRAWS {
        let draws: Vec<f64> = (0..folds).map(|_| -(1.0 - stream.between([0.0, 1.0])).ln()).collect();
        let scale = folds as f64 / draws.iter().sum::<f64>();
        let total = |of: &Vec<f64>| scale * of.iter().zip(&draws).map(|(density, draw)| density * draw).sum::<f64>();
        let totals: Vec<f64> = densities
            .iter()
            .zip(&is_in)
            .map(|(of, is_in)| if *is_in { total(of) } else { f64::NEG_INFINITY })
            .collect();
        let best = totals.iter().copied().fold(f64::NEG_INFINITY, f64::max);
        let weights: Vec<f64> = totals.iter().zip(priors).map(|(total, prior)| prior * (total - best).exp()).collect();
        let all: f64 = weights.iter().sum();
        if best.is_finite() && all > 0.0 {
            sums.iter_mut().zip(weights).for_each(|(sum, weight)| *sum += weight / all);
        }
    }
    sums.into_iter().map(|sum| sum / FOLD_WEIGHT_DRAWS as f64).collect()
}

/// True if the odds of the most probable model against one of this probability are at most nine to one.
pub(super) fn is_near(probability: f64, most: f64) -> bool {
    probability * NAMED_PROBABILITY >= most * (1.0 - NAMED_PROBABILITY) && probability > 0.0
}

/// Models that are admitted: those that are large enough, and, where the data cannot distinguish one of them from the most
/// probable model, all that are near it. They explain the same difference, and it is large enough.
pub(super) fn admitted(is_large: &[bool], probabilities: &[f64]) -> Vec<bool> {
    let most = probabilities.iter().copied().fold(0.0, f64::max);
    let one_matters = is_large.iter().zip(probabilities).any(|(is_large, &own)| *is_large && is_near(own, most));
    let is_admitted = |(is_large, own): (&bool, &f64)| *is_large || (one_matters && is_near(*own, most));
    is_large.iter().zip(probabilities).map(is_admitted).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_model_that_is_better_in_every_fold_is_certain_and_one_that_is_better_in_one_is_not() {
        let even = vec![-10.0; 12];
        let better: Vec<f64> = even.iter().map(|density| density + 1.0).collect();
        let mut lucky = even.clone();
        lucky[3] += 12.0;
        let first = |other: &Vec<f64>| probabilities(&[other.clone(), even.clone()], &[1.0, 1.0], 1)[0];
        assert!(first(&better) > 0.99, "{}", first(&better));
        assert!((0.6..0.97).contains(&first(&lucky)), "{}", first(&lucky));
        assert!((first(&even) - 0.5).abs() < 1e-12);
    }

    #[test]
    fn a_model_that_cannot_be_is_out_and_priors_count() {
        let (even, out) = (vec![-1.0; 4], vec![f64::NEG_INFINITY; 4]);
        let found = probabilities(&[even.clone(), out.clone(), even], &[1.0, 1.0, 3.0], 1);
        assert!((found[0] - 0.25).abs() < 1e-12 && found[1] == 0.0 && (found[2] - 0.75).abs() < 1e-12);
        assert_eq!(probabilities(&[out.clone(), out], &[1.0, 1.0], 1), [0.0, 0.0]);
    }

    #[test]
    fn a_size_does_not_choose_among_equal_explanations() {
        let probabilities = [0.5, 0.3, 0.15, 0.05];
        assert_eq!(admitted(&[false, true, false, false], &probabilities), [true, true, true, false]);
        assert_eq!(admitted(&[false, false, false, true], &probabilities), [false, false, false, true]);
        assert_eq!(admitted(&[false; 4], &probabilities), [false; 4]);
        assert_eq!(admitted(&[false, true], &[0.0, 0.0]), [false, true]);
    }
}
