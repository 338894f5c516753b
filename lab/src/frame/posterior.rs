//! Posterior of frame and clock in a linear model with normal priors, and the marginal likelihood of each set of free
//! quantities.

use nalgebra::{Cholesky, DMatrix, DVector, Dyn};
use trials::measure::{MAD_TO_SIGMA, median};

use super::{FrameValues, QUANTITIES};
use crate::criteria::HUBER_CONSTANT;

/// Linear model of the residuals near a frame offset.
#[derive(Clone)]
pub(super) struct Linear {
    /// Measured minus predicted, each scan whitened separately.
    pub(super) residuals: DVector<f64>,
    /// Change of the residuals per prior standard deviation of each quantity, shape [data, 4].
    pub(super) columns: DMatrix<f64>,
    /// Change of the residuals per prior standard deviation of each other term, shape [data, terms].
    pub(super) beside: DMatrix<f64>,
}

/// Posterior of the free quantities, in prior standard deviations.
#[derive(Clone, Copy, Debug)]
pub(super) struct Posterior {
    /// Mean of each quantity; zero if it is held.
    pub(super) mean: FrameValues,
    /// Standard deviation of each; zero if it is held.
    pub(super) sigma: FrameValues,
    /// Logarithm of the marginal likelihood, up to a constant that depends on the data only.
    pub(super) log_evidence: f64,
}

impl Linear {
    /// Standard deviation of the residuals of the full model, at least 1, and the weights of the robust sum (Huber
    /// 1964).
    fn spread_and_weights(&self) -> (f64, DVector<f64>) {
        let design = self.design(&[true; QUANTITIES]);
        let left = &self.residuals + &design * solution(&precision(&design), &design, &self.residuals);
        let middle = median(left.iter().map(|left| left.abs()).collect()).unwrap_or(0.0);
        let spread = (MAD_TO_SIGMA * middle).max(1.0);
        (spread, left.map(|left| (HUBER_CONSTANT * spread / left.abs()).min(1.0).sqrt()))
    }

    /// The same model with further terms.
    pub(super) fn beside_also(&self, more: &DMatrix<f64>) -> Self {
        let all: Vec<_> =
            self.beside.column_iter().chain(more.column_iter()).map(|column| column.into_owned()).collect();
        Self { residuals: self.residuals.clone(), columns: self.columns.clone(), beside: DMatrix::from_columns(&all) }
    }

    /// Posterior for each set of free quantities; the others are held at zero.
    pub(super) fn posteriors<const CHOICES: usize>(
        &self,
        choices: [[bool; QUANTITIES]; CHOICES],
    ) -> [Posterior; CHOICES] {
        let (spread, weights) = self.spread_and_weights();
        let weights = weights / spread;
        let residuals = self.residuals.component_mul(&weights);
        let of_noise = -0.5 * residuals.norm_squared() - residuals.len() as f64 * spread.ln();
        choices.map(|free| {
            let mut design = self.design(&free);
            design.column_iter_mut().for_each(|mut column| column.component_mul_assign(&weights));
            let posterior = Posterior::of(&design, &residuals, &free);
            Posterior { log_evidence: posterior.log_evidence + of_noise, ..posterior }
        })
    }

    /// Design matrix: columns of the free quantities, then of all other terms.
    fn design(&self, free: &[bool; QUANTITIES]) -> DMatrix<f64> {
        let own = (0..QUANTITIES).filter(|&k| free[k]).map(|k| self.columns.column(k).into_owned());
        let beside = self.beside.column_iter().map(|column| column.into_owned());
        let all: Vec<DVector<f64>> = own.chain(beside).collect();
        if all.is_empty() { DMatrix::zeros(self.residuals.len(), 0) } else { DMatrix::from_columns(&all) }
    }
}

impl Posterior {
    fn of(design: &DMatrix<f64>, residuals: &DVector<f64>, free: &[bool; QUANTITIES]) -> Self {
        let precision = precision(design);
        let best = solution(&precision, design, residuals);
        let explained = -design.tr_mul(residuals).dot(&best);
        let log_determinant = 2.0 * precision.l_dirty().diagonal().iter().map(|d| d.ln()).sum::<f64>();
        let covariance = precision.inverse();
        let (mut mean, mut sigma) = ([0.0; QUANTITIES], [0.0; QUANTITIES]);
        for (column, quantity) in (0..QUANTITIES).filter(|&k| free[k]).enumerate() {
            (mean[quantity], sigma[quantity]) = (best[column], covariance[(column, column)].sqrt());
        }
        Self { mean, sigma, log_evidence: 0.5 * (explained - log_determinant) }
    }
}

/// Normal matrix plus the identity of the unit priors.
fn precision(design: &DMatrix<f64>) -> Cholesky<f64, Dyn> {
    let count = design.ncols();
    // A product with the transpose is several times faster than `tr_mul`.
    Cholesky::new(design.transpose() * design + DMatrix::identity(count, count)).expect("ones on the diagonal")
}

/// Maximum a posteriori terms.
fn solution(precision: &Cholesky<f64, Dyn>, design: &DMatrix<f64>, residuals: &DVector<f64>) -> DVector<f64> {
    -precision.solve(&design.tr_mul(residuals))
}

#[cfg(test)]
mod tests {
    use super::*;

    const NONE: [bool; QUANTITIES] = [false; QUANTITIES];

    /// Residuals of 200 data with noise and a shift along x of two standard deviations.
    fn shifted() -> Linear {
        let wave = |row: usize, k: usize| ((row * (k + 2)) as f64 * 0.37).sin();
        let columns = DMatrix::from_fn(200, QUANTITIES, |row, k| if k == 1 { 0.0 } else { 4.0 * wave(row, k) });
        let noise = DVector::from_fn(200, |row, _| 1.4 * ((row * 31) as f64 * 1.7).sin());
        Linear { residuals: noise - columns.column(0) * 2.0, columns, beside: DMatrix::zeros(200, 0) }
    }

    #[test]
    fn a_shift_is_found_and_what_does_not_show_keeps_its_prior() {
        let [all, none] = shifted().posteriors([[true; QUANTITIES], NONE]);
        assert!((all.mean[0] - 2.0).abs() < 3.0 * all.sigma[0] && all.sigma[0] < 0.05, "{all:?}");
        assert_eq!((all.mean[1], all.sigma[1]), (0.0, 1.0));
        assert!(all.log_evidence > none.log_evidence + 100.0);
    }

    #[test]
    fn what_a_rival_explains_as_well_is_no_shift() {
        let shifted = shifted();
        let rival = DMatrix::from_columns(&[shifted.columns.column(0) * 50.0]);
        let [all, none] = shifted.beside_also(&rival).posteriors([[true; QUANTITIES], NONE]);
        assert!(all.log_evidence < none.log_evidence, "{} {}", all.log_evidence, none.log_evidence);
        let other = DMatrix::from_columns(&[shifted.columns.column(2) * 50.0]);
        let [all, none] = shifted.beside_also(&other).posteriors([[true; QUANTITIES], NONE]);
        assert!(all.log_evidence > none.log_evidence + 100.0 && (all.mean[0] - 2.0).abs() < 0.1, "{all:?}");
    }

    #[test]
    fn quantities_that_explain_nothing_lose_evidence() {
        let mut still = shifted();
        still.residuals += still.columns.column(0) * 2.0;
        let [all, none] = still.posteriors([[true; QUANTITIES], NONE]);
        assert!(all.log_evidence < none.log_evidence - 3.0, "{} {}", all.log_evidence, none.log_evidence);
    }
}
