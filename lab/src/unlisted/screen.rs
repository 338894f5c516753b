//! First look at all variables and forms: curves and forms fitted to the linearised data, without a simulation.

use nalgebra::{DMatrix, DVector};
use rayon::prelude::*;

use super::basis::Basis;
use super::curve::Curve;
use super::form::{Form, KINDS};
use crate::criteria::FORM_SIZE_SIGMA;
use crate::cross_validation::{Beside, CrossValidation};
use crate::fit::Fit;

/// Expected fit of a form.
#[derive(Clone, Debug)]
pub(crate) struct Expected {
    /// The form.
    pub form: Form,
    /// Its sizes.
    pub sizes: Vec<f64>,
    /// Shift of the model's own coordinates.
    pub shift: Vec<f64>,
    /// Log density of all folds, averaged over all shapes of its kind.
    pub score: f64,
    /// Logarithm of the mean density over all shapes relative to this shape; negative or 0.
    pub choice: f64,
}

/// A variable with its curve and forms, best first.
pub(crate) struct ScreenedBasis {
    /// Hat functions over the variable.
    pub basis: Basis,
    /// The curve that predicts best.
    pub curve: Curve,
    /// Forms, one of each kind.
    pub forms: Vec<Expected>,
}

/// Takes a first look at all variables; those whose curve predicts best come first.
pub(crate) fn screen_bases(folds: &CrossValidation, fit: &Fit, bases: Vec<Basis>) -> Vec<ScreenedBasis> {
    let one = |basis: Basis| -> Option<ScreenedBasis> {
        let beside = folds.beside(fit, &basis.columns);
        let curve = Curve::best(&beside, basis.knots.len())?;
        let best = |kind| {
            best(Form::all(kind, &basis).into_iter().filter_map(|form| expected(&beside, &basis, form)).collect())
        };
        let mut forms: Vec<Expected> = KINDS.into_iter().filter_map(best).collect();
        forms.sort_by(|a, b| b.score.total_cmp(&a.score));
        Some(ScreenedBasis { basis, curve, forms })
    };
    let mut screened: Vec<ScreenedBasis> = bases.into_par_iter().filter_map(one).collect();
    screened.sort_by(|a, b| b.curve.density.total_cmp(&a.curve.density));
    screened
}

/// The form of a kind whose shape predicts best. All shapes are equally likely a priori, so that the kind has the mean
/// likelihood of its shapes: a good fit at one shape of many counts less than one without a choice of shape.
fn best(forms: Vec<Expected>) -> Option<Expected> {
    let most = forms.iter().map(|form| form.score).fold(f64::NEG_INFINITY, f64::max);
    let mean = forms.iter().map(|form| (form.score - most).exp()).sum::<f64>() / forms.len() as f64;
    let best = forms.into_iter().find(|form| form.score == most)?;
    Some(Expected { score: most + mean.ln(), choice: mean.ln(), ..best })
}

/// Best-fitting sizes of a form.
fn expected(beside: &Beside, basis: &Basis, form: Form) -> Option<Expected> {
    let sums = form.gains_at(&basis.knots);
    let count = sums.ncols();
    let prior = DMatrix::from_diagonal(&DVector::from_element(count, FORM_SIZE_SIGMA.powi(-2)));
    let (densities, moved) = beside.summed(&sums).densities(&prior, true)?;
    let own = moved.len() - count;
    let score = densities.iter().sum::<f64>();
    let of = |range: std::ops::Range<usize>| range.map(|k| moved[k]).collect::<Vec<f64>>();
    Some(Expected { form, sizes: of(own..moved.len()), shift: of(0..own), score, choice: 0.0 })
}
