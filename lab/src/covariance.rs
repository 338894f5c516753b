//! Whitening: scales differences by the covariance of noise and nuisance parameters, to unit variance.

use nalgebra::{Cholesky, DMatrix, DVector, Dyn};

/// Nuisance degrees of freedom of data, such as the tilt of a scan, with a normal prior.
#[derive(Clone, Debug, PartialEq)]
pub struct Freedom {
    /// Change of each datum per unit of each, shape [data, degrees of freedom].
    pub columns: DMatrix<f64>,
    /// Prior mean of the values.
    pub mean: DVector<f64>,
    /// Prior covariance of the values.
    pub covariance: DMatrix<f64>,
}

impl Freedom {
    /// Independent degrees of freedom with mean zero and given standard deviations.
    pub fn around_zero(columns: DMatrix<f64>, sigmas: &[f64]) -> Self {
        let variances: Vec<f64> = sigmas.iter().map(|sigma| sigma * sigma).collect();
        let covariance = DMatrix::from_diagonal(&DVector::from_vec(variances));
        Self { columns, mean: DVector::zeros(sigmas.len()), covariance }
    }

    /// Joins these degrees of freedom and others, independent of them.
    pub fn and(self, other: Self) -> Self {
        let (few, all) = (self.mean.len(), self.mean.len() + other.mean.len());
        let mut joint = Self {
            columns: DMatrix::zeros(self.columns.nrows(), all),
            mean: DVector::zeros(all),
            covariance: DMatrix::zeros(all, all),
        };
        for (first, part) in [(0, &self), (few, &other)] {
            let count = part.mean.len();
            joint.columns.columns_mut(first, count).copy_from(&part.columns);
            joint.mean.rows_mut(first, count).copy_from(&part.mean);
            joint.covariance.view_mut((first, first), (count, count)).copy_from(&part.covariance);
        }
        joint
    }
}

/// Whitens differences: the result is independent with variance one where only noise and nuisance degrees of freedom
/// act.
///
/// Degrees of freedom with a normal prior are noise with covariance `E S Eᵀ` (Kennedy and O'Hagan 2001, section 4): a
/// fit to whitened data is a joint fit of physics and degrees of freedom.
#[derive(Clone, Debug)]
pub struct Whitener {
    factor: Cholesky<f64, Dyn>,
    /// Expected difference.
    offset: DVector<f64>,
    freedom: Freedom,
}

impl Whitener {
    /// - `noise`: covariance of the data, shape [data, data]
    ///
    /// Returns `None` if the noise is not positive definite.
    pub fn new(noise: DMatrix<f64>, freedom: Freedom) -> Option<Self> {
        let total = noise + &freedom.columns * &freedom.covariance * freedom.columns.transpose();
        let offset = &freedom.columns * &freedom.mean;
        Some(Self { factor: Cholesky::new(total)?, offset, freedom })
    }

    /// Number of data.
    pub fn len(&self) -> usize {
        self.offset.len()
    }

    /// True if there are no data.
    pub fn is_empty(&self) -> bool {
        self.offset.is_empty()
    }

    /// Whitens measured minus simulated.
    pub fn whiten(&self, difference: &[f64]) -> Vec<f64> {
        let mut left = DVector::from_column_slice(difference) - &self.offset;
        self.factor.l_dirty().solve_lower_triangular_mut(&mut left);
        left.as_slice().to_vec()
    }

    /// Change of the data for a given change of whitened data, without the part that the degrees of freedom absorb.
    pub fn unwhiten(&self, change: &[f64]) -> Vec<f64> {
        let data = self.factor.l_dirty().lower_triangle() * DVector::from_column_slice(change);
        let degrees_of_freedom = &self.freedom.covariance * self.freedom.columns.tr_mul(&self.factor.solve(&data));
        (data - &self.freedom.columns * degrees_of_freedom).as_slice().to_vec()
    }

    /// Whitens a field of the data that is added to the differences.
    pub fn whitened_field(&self, field: &[f64]) -> Vec<f64> {
        let mut field = DVector::from_column_slice(field);
        self.factor.l_dirty().solve_lower_triangular_mut(&mut field);
        field.as_slice().to_vec()
    }

    /// Measured minus simulated, less the expected contribution of the degrees of freedom.
    pub fn centred(&self, difference: &[f64]) -> Vec<f64> {
        difference.iter().zip(self.offset.iter()).map(|(d, offset)| d - offset).collect()
    }

    /// Colours independent normal numbers: returns centred differences with the covariance of noise and degrees of
    /// freedom.
    pub fn coloured(&self, normals: &[f64]) -> Vec<f64> {
        let factor = self.factor.l_dirty();
        let row = |i: usize| (0..=i).map(|j| factor[(i, j)] * normals[j]).sum();
        (0..normals.len()).map(row).collect()
    }

    /// Prior of the degrees of freedom.
    pub fn expected(&self) -> &Freedom {
        &self.freedom
    }

    /// As [`Whitener::sigma_of_sum`], with another covariance of the degrees of freedom.
    pub fn sigma_of_sum_given(&self, weights: &[f64], covariance: &DMatrix<f64>) -> f64 {
        let arms = self.freedom.columns.tr_mul(&DVector::from_column_slice(weights));
        let change = arms.dot(&((covariance - &self.freedom.covariance) * &arms));
        (self.sigma_of_sum(weights).powi(2) + change).max(0.0).sqrt()
    }

    /// Standard deviation that noise and degrees of freedom give to a weighted sum of the data.
    pub fn sigma_of_sum(&self, weights: &[f64]) -> f64 {
        self.factor.l_dirty().lower_triangle().tr_mul(&DVector::from_column_slice(weights)).norm()
    }

    /// Posterior mean and covariance of the degrees of freedom given the data, as in a joint fit.
    pub fn degrees_of_freedom(&self, difference: &[f64]) -> Freedom {
        let left = DVector::from_column_slice(difference) - &self.offset;
        let gain = &self.freedom.covariance * self.freedom.columns.transpose();
        let mean = &self.freedom.mean + &gain * self.factor.solve(&left);
        let covariance = &self.freedom.covariance - &gain * self.factor.solve(&gain.transpose());
        Freedom { columns: self.freedom.columns.clone(), mean, covariance }
    }
}
