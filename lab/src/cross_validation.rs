//! Cross-validation: prediction of each fold of the calibration data from the others, without a fit for each fold.
//!
//! With whitened residuals `r`, derivatives `J` and prior precision `P`, a fit to all folds but `f` differs from the
//! fit to all by `A_f⁻¹ J_fᵀ r_f`, where `A_f = JᵀJ + P − J_fᵀJ_f`. It predicts fold `f` with covariance `V = 1 + J_f
//! A_f⁻¹ J_fᵀ` and residual `V r_f`, so that the log density of the fold is, up to a constant,
//!
//! `−(r_fᵀ V r_f + ln |V|) / 2` with `|V| = |JᵀJ + P| / |A_f|`
//!
//! (Stone 1974; Geisser and Eddy 1979). A parameter that only the fold itself determines makes the prediction wide and
//! not wrong.
//!
//! Every model is fitted together with the closure: a smooth relative change of the removal over the part and over each
//! pass, whose strength is the one that predicts best. It stands for any effect that the library lacks. A complete
//! model needs none of it, and an effect counts only for what the closure cannot explain (Kennedy and O'Hagan 2001).

use nalgebra::{Cholesky, DMatrix, DVector, Dyn};

use super::coordinates::Coordinate;
use super::diagnose::spread;
use super::evidence::Evidence;
use super::fit::{Fit, weights};
use crate::criteria::{CLOSURE_STRENGTH_LEAST, CLOSURE_STRENGTH_RATIO, CLOSURE_STRENGTHS, INTERVAL_SIGMAS};

/// Cross-validated prediction by a model together with the closure.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Prediction {
    /// Log density of each fold given the others.
    pub densities: Vec<f64>,
    /// Standard deviation of the closure, as a share of the removal; 0 where the model alone predicts best.
    pub closure: f64,
    /// Part of the whitened residuals that the closure explains, one value per datum; empty where the closure is 0.
    pub closed: Vec<f64>,
}

impl Prediction {
    /// Root mean square of the part that the closure explains, in the data's unit.
    pub(super) fn closed_size(&self, evidence: &dyn Evidence) -> f64 {
        if self.closed.is_empty() { 0.0 } else { evidence.size(&self.closed) }
    }

    /// Sum of the log densities of all folds.
    pub fn total(&self) -> f64 {
        self.densities.iter().sum()
    }
}

/// Calibration data cut into folds, with their closure.
pub(super) struct CrossValidation {
    folds: Vec<usize>,
    /// Change of the whitened residuals per unit of each closure term, shape [data, columns].
    closure: DMatrix<f64>,
    /// Standard deviation of whitened residuals that is attributed to noise.
    spread: f64,
}

impl CrossValidation {
    /// Cuts calibration data into folds.
    ///
    /// - `best`: the fit of least χ²; its residuals beside the closure count as noise
    pub(super) fn new(evidence: &dyn Evidence, best: &Fit) -> Self {
        Self::in_folds(evidence, evidence.folds(), best)
    }

    /// As [`Self::new`], with whole passes as folds where there are several: an effect of one pass predicts no other.
    pub(super) fn by_pass(evidence: &dyn Evidence, best: &Fit) -> Self {
        Self::in_folds(evidence, evidence.pass_folds(), best)
    }

    fn in_folds(evidence: &dyn Evidence, folds: Vec<usize>, best: &Fit) -> Self {
        let data = Self { folds, closure: evidence.closure(), spread: 1.0 };
        let closed = data.prediction(best).closed;
        let left: Vec<f64> = match closed.is_empty() {
            true => best.residuals.clone(),
            false => best.residuals.iter().zip(closed).map(|(residual, closed)| residual - closed).collect(),
        };
        Self { spread: spread(&left), ..data }
    }

    /// Predicts each fold with a fit, at the closure strength that predicts best.
    pub(super) fn prediction(&self, fit: &Fit) -> Prediction {
        let none = DMatrix::zeros(self.folds.len(), 0);
        let alone = self.beside(fit, &none).densities(&DMatrix::zeros(0, 0), false).map(|(densities, _)| densities);
        let densities =
            alone.unwrap_or_else(|| vec![f64::NEG_INFINITY; self.folds.iter().max().map_or(0, |most| most + 1)]);
        let mut best = Prediction { densities, closure: 0.0, closed: Vec::new() };
        let columns = self.closure.ncols();
        if columns == 0 {
            return best;
        }
        let joint = self.beside(fit, &self.closure);
        for strength in (0..CLOSURE_STRENGTHS).map(|k| CLOSURE_STRENGTH_LEAST * CLOSURE_STRENGTH_RATIO.powi(k)) {
            let precision = DMatrix::from_diagonal_element(columns, columns, strength.powi(-2));
            let Some((densities, moved)) = joint.densities(&precision, true) else { continue };
            if densities.iter().sum::<f64>() > best.total() {
                let closed = -(&self.closure * moved.rows(joint.own.len(), columns));
                best = Prediction { densities, closure: strength, closed: closed.as_slice().to_vec() };
            }
        }
        best
    }

    /// Products of all folds for a fit with additional columns.
    ///
    /// - `columns`: change of the whitened residuals per unit of each, shape [data, columns]
    pub(super) fn beside(&self, fit: &Fit, columns: &DMatrix<f64>) -> Beside {
        let weights = weights(&fit.residuals) / self.spread;
        let residuals = DVector::from_column_slice(&fit.residuals).component_mul(&weights);
        let own = fit.jacobian.ncols();
        let mut slopes = DMatrix::zeros(residuals.len(), own + columns.ncols());
        slopes.columns_mut(0, own).copy_from(&fit.jacobian);
        slopes.columns_mut(own, columns.ncols()).copy_from(columns);
        slopes.column_iter_mut().for_each(|mut column| column.component_mul_assign(&weights));
        Beside { folds: Folds::new(&self.folds, &residuals, &slopes), own: prior(&fit.coordinates) }
    }
}

/// Products of all folds for a fit and additional columns.
pub(super) struct Beside {
    folds: Folds,
    /// Prior precision of the fit's own coordinates.
    own: DVector<f64>,
}

impl Beside {
    /// Log density of each fold, and the step of the fit's coordinates and of the columns to their optimum; `None`
    /// where the data do not determine them.
    ///
    /// - `precision`: prior precision of the columns
    /// - `is_open`: true if that step is still to be made; else the residuals are at the optimum
    pub(super) fn densities(&self, precision: &DMatrix<f64>, is_open: bool) -> Option<(Vec<f64>, DVector<f64>)> {
        self.folds.densities(&self.prior(precision), is_open)
    }

    /// Posterior covariance of the fit's coordinates and of the columns; `None` as in [`Self::densities`].
    pub(super) fn covariance(&self, precision: &DMatrix<f64>) -> Option<DMatrix<f64>> {
        let all = self.folds.0.iter().fold(self.prior(precision), |sum, Fold(square, ..)| sum + square);
        Some(Cholesky::new(all)?.inverse())
    }

    /// The same with linear combinations of the columns in their place, shape [columns, combinations].
    pub(super) fn summed(&self, sums: &DMatrix<f64>) -> Self {
        let own = self.own.len();
        let mut all = DMatrix::identity(own + sums.nrows(), own + sums.ncols());
        all.view_mut((own, own), sums.shape()).copy_from(sums);
        let fold = |Fold(square, pull, sum): &Fold| Fold(all.tr_mul(&(square * &all)), all.tr_mul(pull), *sum);
        Self { folds: Folds(self.folds.0.iter().map(fold).collect()), own: self.own.clone() }
    }

    fn prior(&self, precision: &DMatrix<f64>) -> DMatrix<f64> {
        let own = self.own.len();
        let mut prior = DMatrix::zeros(own + precision.nrows(), own + precision.nrows());
        prior.view_mut((0, 0), (own, own)).copy_from(&DMatrix::from_diagonal(&self.own));
        prior.view_mut((own, own), precision.shape()).copy_from(precision);
        prior
    }
}

/// Normal-equation products of a fold: JᵀJ, Jᵀr and rᵀr.
struct Fold(DMatrix<f64>, DVector<f64>, f64);

/// Normal-equation products of all folds.
struct Folds(Vec<Fold>);

impl Folds {
    fn new(folds: &[usize], residuals: &DVector<f64>, slopes: &DMatrix<f64>) -> Self {
        let count = folds.iter().max().map_or(0, |most| most + 1);
        let fold = |number: usize| {
            let rows: Vec<usize> = (0..folds.len()).filter(|&row| folds[row] == number).collect();
            let (residuals, slopes) = (residuals.select_rows(&rows), slopes.select_rows(&rows));
            Fold(slopes.tr_mul(&slopes), slopes.tr_mul(&residuals), residuals.norm_squared())
        };
        Self((0..count).map(fold).collect())
    }

    /// Log density of each fold, and the step of the parameters from the residuals' place to the optimum; `None` where
    /// the data do not determine them.
    ///
    /// - `is_open`: true if that step is still to be made; else the residuals are at the optimum
    fn densities(&self, prior: &DMatrix<f64>, is_open: bool) -> Option<(Vec<f64>, DVector<f64>)> {
        let all = self.0.iter().fold(prior.clone(), |sum, Fold(square, ..)| sum + square);
        let factor = Cholesky::new(all.clone())?;
        let pull: DVector<f64> = self.0.iter().map(|Fold(_, pull, _)| pull).sum();
        let moved = if is_open { -factor.solve(&pull) } else { DVector::zeros(pull.len()) };
        let whole = log_determinant(&factor);
        let density = |Fold(square, pull, sum): &Fold| {
            let others = Cholesky::new(&all - square)?;
            let bent = square * &moved;
            let left = sum + 2.0 * moved.dot(pull) + moved.dot(&bent);
            let pull = pull + bent;
            Some(-0.5 * (left + pull.dot(&others.solve(&pull)) + whole - log_determinant(&others)))
        };
        Some((self.0.iter().map(density).collect::<Option<_>>()?, moved))
    }
}

fn log_determinant(factor: &Cholesky<f64, Dyn>) -> f64 {
    2.0 * factor.l_dirty().diagonal().iter().map(|entry| entry.ln()).sum::<f64>()
}

/// Prior precision of coordinates: the library's range is a 95 % interval.
pub fn prior(coordinates: &[Coordinate]) -> DVector<f64> {
    let precision = |coordinate: &Coordinate| {
        let [least, greatest] = coordinate.listed();
        (2.0 * INTERVAL_SIGMAS / (greatest - least)).powi(2)
    };
    DVector::from_iterator(coordinates.len(), coordinates.iter().map(precision))
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Ten data in three folds, two parameters.
    fn data() -> (Vec<usize>, DVector<f64>, DMatrix<f64>) {
        let folds = vec![0, 0, 0, 1, 1, 1, 1, 2, 2, 2];
        let residuals = DVector::from_fn(10, |row, _| (1.7 * row as f64).sin());
        let slopes = DMatrix::from_fn(10, 2, |row, k| ((row + 1) as f64).powi(k as i32) / 3.0);
        (folds, residuals, slopes)
    }

    #[test]
    fn a_fold_has_the_density_that_a_fit_to_the_others_gives_it() {
        let (folds, residuals, slopes) = data();
        let prior = DMatrix::from_diagonal(&DVector::from_vec(vec![0.3, 0.7]));
        let (densities, _) = Folds::new(&folds, &residuals, &slopes).densities(&prior, true).unwrap();
        for (number, density) in densities.iter().enumerate() {
            let of = |is_in: bool| (0..10).filter(|&row| (folds[row] == number) == is_in).collect::<Vec<usize>>();
            let (own, others) = (of(true), of(false));
            let [(r, j), (r_others, j_others)] =
                [&own, &others].map(|rows| (residuals.select_rows(rows), slopes.select_rows(rows)));
            let covariance = (&prior + j_others.tr_mul(&j_others)).try_inverse().unwrap();
            let missed = &r - &j * &covariance * j_others.tr_mul(&r_others);
            let spread = DMatrix::identity(own.len(), own.len()) + &j * covariance * j.transpose();
            let square = missed.dot(&(spread.clone().try_inverse().unwrap() * &missed));
            assert!((density + 0.5 * (square + spread.determinant().ln())).abs() < 1e-10);
        }
    }

    #[test]
    fn a_parameter_that_one_fold_alone_determines_makes_its_prediction_wide_and_not_wrong() {
        let (folds, residuals, _) = data();
        let lifted = |by: f64| residuals.map_with_location(|row, _, r| if folds[row] == 1 { r + by } else { r });
        let slopes = DMatrix::from_fn(10, 1, |row, _| f64::from(u8::from(folds[row] == 1)));
        let density = |residuals: &DVector<f64>, precision: f64| {
            let prior = DMatrix::from_element(1, 1, precision);
            Folds::new(&folds, residuals, &slopes).densities(&prior, true).unwrap().0[1]
        };
        assert!((density(&lifted(0.0), 1e-4) - density(&lifted(3.0), 1e-4)).abs() < 0.05, "the prior is wide");
        assert!(density(&lifted(0.0), 1e4) - density(&lifted(3.0), 1e4) > 10.0, "the prior is narrow");
    }
}
