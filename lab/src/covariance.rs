//! Turns what data may differ by without any physics, noise and degrees of freedom, into numbers of variance one.

use nalgebra::{Cholesky, DMatrix, DVector, Dyn};

/// A change that data may show for a reason that is no physics, such as a tilt of the scan.
#[derive(Clone, Debug, PartialEq)]
pub struct Freedom {
    /// Change of each datum by one unit of it, shape [data, degrees of freedom].
    pub columns: DMatrix<f64>,
    /// Values expected.
    pub mean: DVector<f64>,
    /// Covariance of the values.
    pub covariance: DMatrix<f64>,
}

impl Freedom {
    /// Independent degrees of freedom around zero with their standard deviations.
    pub fn around_zero(columns: DMatrix<f64>, sigmas: &[f64]) -> Self {
        let variances: Vec<f64> = sigmas.iter().map(|sigma| sigma * sigma).collect();
        let covariance = DMatrix::from_diagonal(&DVector::from_vec(variances));
        Self { columns, mean: DVector::zeros(sigmas.len()), covariance }
    }

    /// These degrees of freedom and others, independent of them.
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

/// Turns differences into numbers that are independent and of variance one when only noise and degrees of freedom are at work.
///
/// Degrees of freedom with a normal law are noise with covariance `E S Eᵀ` (Kennedy and O'Hagan 2001, section 4): a fit to whitened
/// data is a joint fit of physics and degrees of freedom.
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
    /// `None` where the noise is not positive definite.
    pub fn new(noise: DMatrix<f64>, freedom: Freedom) -> Option<Self> {
        let total = noise + &freedom.columns * &freedom.covariance * freedom.columns.transpose();
        let offset = &freedom.columns * &freedom.mean;
        Some(Self { factor: Cholesky::new(total)?, offset, freedom })
    }

    /// Number of data.
    pub fn len(&self) -> usize {
        self.offset.len()
    }

    /// Whether there are no data.
    pub fn is_empty(&self) -> bool {
        self.offset.is_empty()
    }

    /// Measured minus simulated, whitened.
    pub fn whiten(&self, difference: &[f64]) -> Vec<f64> {
        let mut left = DVector::from_column_slice(difference) - &self.offset;
        self.factor.l_dirty().solve_lower_triangular_mut(&mut left);
        left.as_slice().to_vec()
    }

    /// The change of the data behind a change of whitened data, without what the degrees of freedom take up of it.
    pub fn unwhiten(&self, change: &[f64]) -> Vec<f64> {
        let data = self.factor.l_dirty().lower_triangle() * DVector::from_column_slice(change);
        let degrees_of_freedom = &self.freedom.covariance * self.freedom.columns.tr_mul(&self.factor.solve(&data));
        (data - &self.freedom.columns * degrees_of_freedom).as_slice().to_vec()
    }

    /// A field of the data, whitened: what it adds to whitened data.
    pub fn whitened_field(&self, field: &[f64]) -> Vec<f64> {
        let mut field = DVector::from_column_slice(field);
        self.factor.l_dirty().solve_lower_triangular_mut(&mut field);
        field.as_slice().to_vec()
    }

    /// Measured minus simulated without what the degrees of freedom are expected to add.
    pub fn centred(&self, difference: &[f64]) -> Vec<f64> {
        difference.iter().zip(self.offset.iter()).map(|(d, offset)| d - offset).collect()
    }

    /// Differences, centred, that noise and degrees of freedom make of independent normal numbers.
    pub fn coloured(&self, normals: &[f64]) -> Vec<f64> {
        let factor = self.factor.l_dirty();
        let row = |i: usize| (0..=i).map(|j| factor[(i, j)] * normals[j]).sum();
        (0..normals.len()).map(row).collect()
    }

    /// The degrees of freedom before the data are seen.
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

    /// The degrees of freedom given the data (mean and covariance): what a joint fit gives them.
    pub fn degrees_of_freedom(&self, difference: &[f64]) -> Freedom {
        let left = DVector::from_column_slice(difference) - &self.offset;
        let gain = &self.freedom.covariance * self.freedom.columns.transpose();
        let mean = &self.freedom.mean + &gain * self.factor.solve(&left);
        let covariance = &self.freedom.covariance - &gain * self.factor.solve(&gain.transpose());
        Freedom { columns: self.freedom.columns.clone(), mean, covariance }
    }
}
