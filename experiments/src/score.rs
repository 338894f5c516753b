//! Expected information of a trial about hypotheses, before it is made.
//!
//! Near its best values the prediction of hypothesis `i` is normal: mean `f_i`, covariance `C_i = 1 + J_i A_i⁻¹ J_iᵀ`
//! of whitened data, with the precision `A_i` of its parameters from all earlier data. Two hypotheses differ by
//!
//! `Δ_ij = d ((C_i + C_j) / 2)⁻¹ d`, `d = f_i − f_j`:
//!
//! the least difference when the parameters of both are refitted, as in the T-criterion (Atkinson and Fedorov 1975).
//! Box and Hill's discrimination is `D = Σ_{i<j} π_i π_j Δ_ij` (Box and Hill 1967; Hunter and Reiner 1965): with equal
//! covariances an upper bound of the expected fall of the entropy of the probabilities π, in nats. It is unbounded, and
//! the entropy is not. A lower bound that never exceeds the entropy is
//!
//! `I = −Σ_i π_i ln Σ_j π_j exp(−Δ_ij / 8)`,
//!
//! because `Δ_ij / 8` is at most the Bhattacharyya distance of two normal laws (Kolchinsky and Tracey 2017, section 4).
//! It ranks the trials.

use nalgebra::{Cholesky, DMatrix, DVector};
use statrs::distribution::{ContinuousCDF, Normal};

/// Prediction of a trial by a hypothesis.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Predicted {
    /// Whitened data.
    pub(super) data: DVector<f64>,
    /// Derivatives of the data, shape [data, coordinates of the fit].
    pub(super) jacobian: DMatrix<f64>,
}

/// Probability of a hypothesis and precision of its parameters.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Belief {
    /// Normalised probability.
    pub(super) probability: f64,
    /// Precision of the parameters, shape [coordinates, coordinates].
    pub(super) precision: DMatrix<f64>,
}

/// Expected information of a trial, or of several together.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Score {
    /// Differences `Δ_ij` of pairs of hypotheses, symmetric.
    pub(super) differences: DMatrix<f64>,
    /// Box and Hill's discrimination [nat].
    pub(super) discrimination: f64,
    /// Lower bound `I` of the expected information [nat].
    pub(super) information: f64,
    /// Lower bound of the expected probability that the most probable hypothesis is right afterwards.
    pub(super) probability_right: f64,
}

impl Predicted {
    /// Joins this prediction and that of another trial.
    pub(super) fn and(&self, other: &Self) -> Self {
        let (own, all) = (self.data.len(), self.data.len() + other.data.len());
        let mut data = self.data.clone().resize_vertically(all, 0.0);
        data.rows_mut(own, other.data.len()).copy_from(&other.data);
        let mut jacobian = self.jacobian.clone().resize_vertically(all, 0.0);
        jacobian.rows_mut(own, other.data.len()).copy_from(&other.jacobian);
        Self { data, jacobian }
    }
}

impl Score {
    /// Scores the predictions of all hypotheses.
    pub(super) fn new(beliefs: &[Belief], predicted: &[Predicted]) -> Self {
        let count = beliefs.len();
        let mut differences = DMatrix::zeros(count, count);
        for (i, j) in (0..count).flat_map(|i| (0..i).map(move |j| (i, j))) {
            let least = difference([&beliefs[i], &beliefs[j]], [&predicted[i], &predicted[j]]);
            (differences[(i, j)], differences[(j, i)]) = (least, least);
        }
        Self::of(beliefs, differences)
    }

    /// Upper bound of the score, as if no parameter could compensate a difference.
    ///
    /// - `data`: whitened data as each hypothesis predicts them
    pub(super) fn bound(beliefs: &[Belief], data: &[DVector<f64>]) -> Self {
        let differences = DMatrix::from_fn(data.len(), data.len(), |i, j| (&data[i] - &data[j]).norm_squared());
        Self::of(beliefs, differences)
    }

    fn of(beliefs: &[Belief], differences: DMatrix<f64>) -> Self {
        let weights: Vec<f64> = beliefs.iter().map(|belief| belief.probability).collect();
        Self {
            discrimination: discrimination(&weights, &differences),
            information: information(&weights, &differences),
            probability_right: probability_right(&weights, &differences),
            differences,
        }
    }
}

/// Least difference of two predictions when the parameters of both are refitted.
fn difference([one, other]: [&Belief; 2], [a, b]: [&Predicted; 2]) -> f64 {
    let (own, all) = (a.jacobian.ncols(), a.jacobian.ncols() + b.jacobian.ncols());
    let mut jacobian = a.jacobian.clone().resize_horizontally(all, 0.0);
    jacobian.columns_mut(own, all - own).copy_from(&b.jacobian);
    let mut precision = DMatrix::zeros(all, all);
    precision.view_mut((0, 0), (own, own)).copy_from(&(2.0 * &one.precision));
    precision.view_mut((own, own), (all - own, all - own)).copy_from(&(2.0 * &other.precision));
    left_after_refit(&(&a.data - &b.data), &jacobian, &precision)
}

/// Remaining sum of squares of a difference of whitened predictions [1] after a refit.
///
/// - `jacobian`: derivatives of the predictions, shape [data, coordinates of the fit]
/// - `precision`: precision of the coordinates, from the data that determine them
pub(super) fn left_after_refit(difference: &DVector<f64>, jacobian: &DMatrix<f64>, precision: &DMatrix<f64>) -> f64 {
    let mut normal = jacobian.tr_mul(jacobian) + precision;
    (0..normal.nrows()).for_each(|k| normal[(k, k)] += 1e-9);
    let pull = jacobian.tr_mul(difference);
    let explained = Cholesky::new(normal).map_or(0.0, |factor| pull.dot(&factor.solve(&pull)));
    (difference.norm_squared() - explained).max(0.0)
}

/// `Σ_{i<j} π_i π_j Δ_ij` (Box and Hill 1967).
fn discrimination(weights: &[f64], differences: &DMatrix<f64>) -> f64 {
    let pairs = (0..weights.len()).flat_map(|i| (0..i).map(move |j| (i, j)));
    pairs.map(|(i, j)| weights[i] * weights[j] * differences[(i, j)]).sum()
}

/// `−Σ_i π_i ln Σ_j π_j exp(−Δ_ij / 8)` (Kolchinsky and Tracey 2017).
fn information(weights: &[f64], differences: &DMatrix<f64>) -> f64 {
    let likeness = |i: usize| (0..weights.len()).map(|j| weights[j] * (-differences[(i, j)] / 8.0).exp()).sum::<f64>();
    let of = |i: usize| if weights[i] > 0.0 { -weights[i] * likeness(i).ln() } else { 0.0 };
    (0..weights.len()).map(of).sum::<f64>().max(0.0)
}

/// One minus the sum of the probabilities that a wrong hypothesis fits better than the right one; at least the present
/// probability of the most probable one.
fn probability_right(weights: &[f64], differences: &DMatrix<f64>) -> f64 {
    let wrong = |i: usize| {
        let others = (0..weights.len()).filter(|&j| j != i);
        others.map(|j| Normal::standard().cdf(-0.5 * differences[(i, j)].sqrt())).sum::<f64>().min(1.0)
    };
    let right = 1.0 - (0..weights.len()).map(|i| weights[i] * wrong(i)).sum::<f64>();
    weights.iter().copied().fold(right, f64::max)
}
