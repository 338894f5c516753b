//! Largest Δχ² that noise alone would give the luckiest of all forms over all variables.

use nalgebra::{Cholesky, DMatrix, DVector};
use rayon::prelude::*;

use super::basis::Basis;
use super::form::{Form, KINDS};
use crate::criteria::SIGN_FLIP_DRAWS;
use crate::response::Projector;
use random::Stream;

/// Falls of χ² of the luckiest form in draws of noise, rising.
pub(crate) struct Chance(Vec<f64>);

/// What the forms over one variable may explain of data.
struct Space {
    /// Hats over the variable without what the base parameters can explain, shape [data, knots].
    columns: DMatrix<f64>,
    /// Orthonormal sums of them, a matrix for each form, shape [knots, sizes].
    forms: Vec<DMatrix<f64>>,
}

impl Chance {
    /// Flips the signs of whole blocks of what the best model leaves (wild bootstrap, Wu 1986), and searches each draw as the
    /// data are searched (Westfall and Young 1993).
    pub(crate) fn new(projector: &Projector, bases: &[Basis], (left, blocks): (&[f64], &[usize]), seed: u64) -> Self {
        let spaces: Vec<Space> = bases.par_iter().map(|basis| Space::new(projector, basis)).collect();
        let count = blocks.iter().max().map_or(0, |most| most + 1);
        let draw = |number: u64| {
            let mut stream = Stream::of(seed, &format!("signs of forms {number}"));
            let signs: Vec<f64> = (0..count).map(|_| if stream.happens(0.5) { 1.0 } else { -1.0 }).collect();
            let drawn: Vec<f64> = left.iter().zip(blocks).map(|(r, block)| r * signs[*block]).collect();
            let drawn = projector.project(&drawn);
            spaces.iter().map(|space| space.most(&drawn)).fold(0.0, f64::max)
        };
        let mut falls: Vec<f64> = (0..SIGN_FLIP_DRAWS).into_par_iter().map(draw).collect();
        falls.sort_by(f64::total_cmp);
        Self(falls)
    }

    /// Probability of such a fall where nothing depends on anything.
    pub(crate) fn p_value(&self, delta_chi2: f64) -> f64 {
        let more = self.0.len() - self.0.partition_point(|drawn| *drawn < delta_chi2);
        (more + 1) as f64 / (self.0.len() + 1) as f64
    }
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
            let gains: Vec<Vec<f64>> = basis.knots.iter().map(|&value| form.gains(value)).collect();
            let sums = DMatrix::from_fn(basis.knots.len(), gains[0].len(), |knot, size| gains[knot][size]);
            let factor = Cholesky::new(sums.tr_mul(&(&square * &sums)))?;
            factor.l().solve_lower_triangular(&sums.transpose()).map(|rows| rows.transpose())
        };
        let forms = KINDS.into_iter().flat_map(|kind| Form::all(kind, basis)).filter_map(orthonormal).collect();
        Self { columns, forms }
    }

    /// Most that a form explains.
    fn most(&self, drawn: &DVector<f64>) -> f64 {
        let pull = self.columns.tr_mul(drawn);
        self.forms.iter().map(|form| form.tr_mul(&pull).norm_squared()).fold(0.0, f64::max)
    }
}
