//! Null distribution of the largest Δχ² over all forms and variables.

use nalgebra::{Cholesky, DMatrix, DVector};
use rayon::prelude::*;

use super::basis::Basis;
use super::form::{Form, KINDS};
use crate::response::Projector;
use crate::significance::NullDraws;

/// All forms over one variable, as directions in data space.
struct Space {
    /// Projected hat functions over the variable, shape [data, knots].
    columns: DMatrix<f64>,
    /// Orthonormal combinations of them, a matrix for each form, shape [knots, sizes].
    forms: Vec<DMatrix<f64>>,
}

/// Draws noise and searches each draw for forms as the data are searched.
///
/// - `left`: whitened residuals of the best model, with the block of each
pub(crate) fn null_forms(projector: &Projector, bases: &[Basis], left: (&[f64], &[usize]), seed: u64) -> NullDraws {
    let spaces: Vec<Space> = bases.par_iter().map(|basis| Space::new(projector, basis)).collect();
    NullDraws::new(left, seed, bases.len(), |drawn| {
        let drawn = projector.project(drawn);
        spaces.iter().map(|space| space.largest(&drawn)).fold(0.0, f64::max)
    })
}

impl Space {
    fn new(projector: &Projector, basis: &Basis) -> Self {
        let mut columns = basis.columns.clone();
        for mut column in columns.column_iter_mut() {
            let seen = projector.project(column.as_slice());
            column.copy_from(&seen);
        }
        let square = columns.tr_mul(&columns);
        let orthonormal = |form: Form| {
            let sums = form.gains_at(&basis.knots);
            let factor = Cholesky::new(sums.tr_mul(&(&square * &sums)))?;
            factor.l().solve_lower_triangular(&sums.transpose()).map(|rows| rows.transpose())
        };
        let forms = KINDS.into_iter().flat_map(|kind| Form::all(kind, basis)).filter_map(orthonormal).collect();
        Self { columns, forms }
    }

    /// Largest Δχ² of a form.
    fn largest(&self, drawn: &DVector<f64>) -> f64 {
        let pull = self.columns.tr_mul(drawn);
        self.forms.iter().map(|form| form.tr_mul(&pull).norm_squared()).fold(0.0, f64::max)
    }
}
