//! Uncertainty of fitted parameters: from the noise that whitening assumes, from the variation between blocks of the
//! data, and from the lattice error and the smooth error of the simulation.

use nalgebra::{Cholesky, DMatrix, DVector};

use super::fit::{Fit, weights};
use super::simulation_errors::{SHARE_SPREAD, with_lattice_error};

/// Contributions to the covariance of a fit's parameters beside the curvature of χ².
#[derive(Clone, Debug, Default, PartialEq)]
pub struct ErrorTerms {
    /// Sum over blocks of the outer products of their scores, shape [coordinates, coordinates].
    scores: DMatrix<f64>,
    /// Change of the coordinates where the share of the lattice error in the data is off by [`SHARE_SPREAD`].
    lattice_shift: DVector<f64>,
    /// Change of the coordinates by each term of the simulation's smooth error, shape [coordinates, terms].
    smooth_shifts: DMatrix<f64>,
}

impl ErrorTerms {
    /// Computes the contributions for a fit.
    ///
    /// - `blocks`: block number of each residual
    /// - `lattice`: see [`Evidence::lattice_field`](super::evidence::Evidence::lattice_field)
    /// - `smooth`: see [`Evidence::smooth_errors`](super::evidence::Evidence::smooth_errors)
    pub(super) fn of(fit: &Fit, blocks: &[usize], (lattice, smooth): (&[f64], &DMatrix<f64>)) -> Self {
        Self {
            scores: scores(fit, blocks),
            lattice_shift: lattice_shift(&fit.jacobian, lattice),
            smooth_shifts: smooth_shifts(&fit.jacobian, smooth),
        }
    }
}

/// Sum of outer products of the blocks' scores, with the small-sample factor for few blocks (Liang and Zeger 1986).
fn scores(fit: &Fit, blocks: &[usize]) -> DMatrix<f64> {
    let count = blocks.iter().max().map_or(0, |most| most + 1);
    let mut scores = DMatrix::zeros(fit.at.len(), count);
    let weights = weights(&fit.residuals);
    for (row, &block) in blocks.iter().enumerate() {
        let pull = fit.residuals[row] * weights[row] * weights[row];
        for k in 0..fit.at.len() {
            scores[(k, block)] += pull * fit.jacobian[(row, k)];
        }
    }
    let factor = count as f64 / (count as f64 - 1.0).max(1.0);
    factor * &scores * scores.transpose()
}

/// Step of a fit when the share of the lattice error is off by [`SHARE_SPREAD`]. As a degree of freedom of the data it
/// would absorb all of that; here it is not one.
fn lattice_shift(jacobian: &DMatrix<f64>, field: &[f64]) -> DVector<f64> {
    if field.is_empty() {
        return DVector::zeros(jacobian.ncols());
    }
    let columns: Vec<DVector<f64>> = (jacobian.column_iter())
        .map(|column| DVector::from_vec(with_lattice_error(column.as_slice(), field)))
        .collect();
    let jacobian = DMatrix::from_columns(&columns);
    let pull = SHARE_SPREAD * jacobian.tr_mul(&DVector::from_column_slice(field));
    Cholesky::new(jacobian.tr_mul(&jacobian))
        .map_or_else(|| DVector::zeros(jacobian.ncols()), |normal| normal.solve(&pull))
}

/// Step of a fit for each term of the smooth error in the data, shape [coordinates, terms] (Kennedy and O'Hagan 2001: a
/// model discrepancy of known covariance).
fn smooth_shifts(jacobian: &DMatrix<f64>, smooth: &DMatrix<f64>) -> DMatrix<f64> {
    if smooth.ncols() == 0 {
        return DMatrix::zeros(jacobian.ncols(), 0);
    }
    let pull = jacobian.tr_mul(smooth);
    Cholesky::new(jacobian.tr_mul(jacobian))
        .map_or_else(|| DMatrix::zeros(pull.nrows(), 0), |normal| normal.solve(&pull))
}

impl Fit {
    /// Covariance of the coordinates, infinite for those that change nothing; `None` if the data do not determine the
    /// others. Of the standard deviations from the curvature, times `spread`, and from the blocks' scores (Huber 1967;
    /// Liang and Zeger 1986) the larger is used. The lattice error is added as one term, the smooth error term by term.
    pub fn covariance(&self, spread: f64) -> Option<DMatrix<f64>> {
        let informed: Vec<usize> = (0..self.at.len()).filter(|&k| self.jacobian.column(k).norm() > 0.0).collect();
        let jacobian = self.jacobian.select_columns(&informed);
        let inverse = Cholesky::new(jacobian.tr_mul(&jacobian))?.inverse();
        let mut widening = DVector::from_element(informed.len(), spread);
        let mut shift = DVector::zeros(informed.len());
        let mut smooth = DMatrix::zeros(informed.len(), informed.len());
        if let Some(error_terms) = &self.error_terms {
            let scores = error_terms.scores.select_columns(&informed).select_rows(&informed);
            let sandwich = &inverse * scores * &inverse;
            for (k, &place) in informed.iter().enumerate() {
                widening[k] = spread.max((sandwich[(k, k)] / inverse[(k, k)]).max(0.0).sqrt());
                shift[k] = error_terms.lattice_shift[place];
            }
            let shifts = error_terms.smooth_shifts.select_rows(&informed);
            smooth = &shifts * shifts.transpose();
        }
        let mut covariance = DMatrix::from_diagonal_element(self.at.len(), self.at.len(), f64::INFINITY);
        for (i, &a) in informed.iter().enumerate() {
            for (j, &b) in informed.iter().enumerate() {
                covariance[(a, b)] = widening[i] * widening[j] * inverse[(i, j)] + shift[i] * shift[j] + smooth[(i, j)];
            }
        }
        Some(covariance)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::simulation_errors::without_lattice_error;

    #[test]
    fn a_fit_of_the_mean_moves_by_what_the_lattice_lifts() {
        // Heights in units of their noise; the lattice raises all of them by 3, and one height is fitted to them.
        let (field, lifted) = ([3.0; 40], [-1.0; 40]);
        let [still, moved] = [[0.0; 40], lifted].map(|residuals| without_lattice_error(&residuals, &field));
        let column: Vec<f64> = moved.iter().zip(&still).map(|(moved, still)| moved - still).collect();
        let shift = lattice_shift(&DMatrix::from_vec(40, 1, column), &field);
        // Measured minus simulated falls by the amount added to the simulation, and so does the fitted height.
        assert!((shift[0] + 3.0 * SHARE_SPREAD).abs() < 1e-12, "{shift}");
    }

    #[test]
    fn a_mean_is_as_uncertain_as_the_smooth_errors_of_its_data() {
        // Forty heights in units of their noise; a smooth error of standard deviation 2 raises half of them.
        let smooth = DMatrix::from_fn(40, 1, |row, _| if row < 20 { 2.0 } else { 0.0 });
        let shifts = smooth_shifts(&DMatrix::from_element(40, 1, 1.0), &smooth);
        assert!((shifts[(0, 0)] - 1.0).abs() < 1e-12, "{shifts}");
        assert_eq!(smooth_shifts(&DMatrix::from_element(40, 1, 1.0), &DMatrix::zeros(40, 0)).ncols(), 0);
    }

    #[test]
    fn without_a_lattice_error_nothing_moves() {
        let jacobian = DMatrix::from_element(5, 2, 1.0);
        assert_eq!(lattice_shift(&jacobian, &[]), DVector::zeros(2));
    }
}
