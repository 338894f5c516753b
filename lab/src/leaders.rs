//! Completed fits of the models that predict best. A fit that was left early is judged beside the closure by a linear
//! step that it has not made, so it may seem to predict better or worse than it does; none is named before its fit has
//! ended.

use rayon::prelude::*;

use super::cross_validation::CrossValidation;
use super::evidence::Evidence;
use super::fit::Fit;
use super::model_weights::{is_near, probabilities};
use super::space_mapping::Lattices;
use super::suspect::Suspect;

/// A model that was fitted to find the effects it lacks: one effect, or two.
pub(super) trait Contender: Clone + Send + Sync {
    /// The effect that was fitted last, with the joint fit.
    fn suspect(&self) -> &Suspect;

    /// Continues the fit until its end.
    fn completed(self, lattices: Lattices, base: &Fit) -> Self;
}

/// Completes the fits of the models that predict best: of all with odds of more than one to nine against the best one.
/// Completed fits change the odds, so this is repeated.
///
/// - `base`: fit of the model without the effects
/// - `seed`: seed of the folds' weights
pub(super) fn with_leaders_completed<C: Contender>(
    lattices: Lattices,
    base: &Fit,
    mut contenders: Vec<C>,
    seed: u64,
) -> Vec<C> {
    loop {
        let open = unfinished_leaders(lattices.usual, base, &contenders, seed);
        if open.is_empty() {
            return contenders;
        }
        let completed = |k: usize| contenders[k].clone().completed(lattices, base);
        let completed: Vec<C> = open.par_iter().map(|&k| completed(k)).collect();
        open.into_iter().zip(completed).for_each(|(k, contender)| contenders[k] = contender);
    }
}

/// Indices of the models with odds of more than one to nine against the best whose fits have not ended. An effect that
/// explains nothing is no measure of the others.
fn unfinished_leaders<C: Contender>(evidence: &dyn Evidence, base: &Fit, contenders: &[C], seed: u64) -> Vec<usize> {
    if contenders.iter().all(|contender| contender.suspect().is_completed) {
        return Vec::new();
    }
    let explaining: Vec<usize> = (0..contenders.len()).filter(|&k| contenders[k].suspect().explains()).collect();
    let fits = || explaining.iter().map(|&k| &contenders[k].suspect().fit);
    let best = fits().min_by(|a, b| a.chi2.total_cmp(&b.chi2)).unwrap_or(base);
    let folds = CrossValidation::new(evidence, best);
    let fits: Vec<&Fit> = std::iter::once(base).chain(fits()).collect();
    let densities: Vec<Vec<f64>> = fits.into_par_iter().map(|fit| folds.prediction(fit).densities).collect();
    let priors = explaining.iter().map(|&k| contenders[k].suspect().prior());
    let weights = probabilities(&densities, &std::iter::once(1.0).chain(priors).collect::<Vec<_>>(), seed);
    let most = weights[1..].iter().copied().fold(0.0, f64::max);
    let near = explaining.into_iter().zip(&weights[1..]).filter(|(_, weight)| is_near(**weight, most));
    near.map(|(k, _)| k).filter(|&k| !contenders[k].suspect().is_completed).collect()
}
