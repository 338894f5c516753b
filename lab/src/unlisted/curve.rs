//! Smooth curve of the rate over one variable: a Gaussian process over the knots of its basis. Its strength and length
//! are those that predict the folds of the calibration data best (Rasmussen and Williams 2006, chapters 2 and 5).

use nalgebra::{Cholesky, DMatrix};

use super::form::LEFT_LEAST;
use crate::criteria::{
    CURVE_LENGTH_GREATEST, CURVE_LENGTH_RATIO, CURVE_LENGTHS, CURVE_STRENGTH_LEAST, CURVE_STRENGTH_RATIO,
    CURVE_STRENGTHS,
};
use crate::cross_validation::Beside;

/// Share of the variance that is added to the diagonal, so that the covariance of close knots is positive definite.
const JITTER: f64 = 1e-6;

/// A curve as the relative change of the rate at each knot.
#[derive(Clone, Debug)]
pub(crate) struct Curve {
    /// Cross-validated log density of all folds.
    pub density: f64,
    /// Relative change of the rate at each knot.
    pub change: Vec<f64>,
    /// Standard deviation of the change at each knot.
    pub sigma: Vec<f64>,
}

impl Curve {
    /// The curve over a number of knots that predicts best; `None` if none can be fitted.
    pub(crate) fn best(beside: &Beside, knots: usize) -> Option<Self> {
        let lengths = (0..CURVE_LENGTHS).map(|k| CURVE_LENGTH_GREATEST * CURVE_LENGTH_RATIO.powi(-k));
        let strengths = (0..CURVE_STRENGTHS).map(|k| CURVE_STRENGTH_LEAST * CURVE_STRENGTH_RATIO.powi(k));
        let strengths: Vec<f64> = strengths.collect();
        let all = lengths.flat_map(|length| strengths.iter().map(move |&strength| (length, strength)));
        let tried = all.filter_map(|(length, strength)| {
            let precision = precision(knots, length, strength)?;
            let (densities, _) = beside.densities(&precision, true)?;
            Some((densities.iter().sum::<f64>(), precision))
        });
        let (density, precision) = tried.max_by(|a, b| a.0.total_cmp(&b.0))?;
        let (_, moved) = beside.densities(&precision, true)?;
        let covariance = beside.covariance(&precision)?;
        let own = moved.len() - knots;
        let sigma = (own..moved.len()).map(|k| covariance[(k, k)].max(0.0).sqrt()).collect();
        Some(Self { density, change: moved.rows(own, knots).iter().copied().collect(), sigma })
    }

    /// Converts a curve over the rate of a model with a form to one over the rate of the model without it: where the
    /// curve replaces a form of gain `g`, its change is `g / (1 + g)`.
    pub(crate) fn without_form(mut self) -> Self {
        for (change, sigma) in self.change.iter_mut().zip(&mut self.sigma) {
            let left = (1.0 - *change).max(LEFT_LEAST);
            (*change, *sigma) = (*change / left, *sigma / (left * left));
        }
        self
    }
}

/// Precision of a Gaussian process at evenly spaced knots; the length is a share of the whole range.
fn precision(knots: usize, length: f64, strength: f64) -> Option<DMatrix<f64>> {
    let far = |i: usize, j: usize| (i as f64 - j as f64) / ((knots - 1) as f64 * length);
    let covariance = DMatrix::from_fn(knots, knots, |i, j| {
        strength * strength * ((-0.5 * far(i, j).powi(2)).exp() + if i == j { JITTER } else { 0.0 })
    });
    Some(Cholesky::new(covariance)?.inverse())
}
