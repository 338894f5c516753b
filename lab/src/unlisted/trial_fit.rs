//! A form added to a model as its effect file, and fitted jointly.

use effects::{CompiledModel, Library, Model};
use nalgebra::DVector;
use rayon::prelude::*;

use super::basis::Basis;
use super::form::{Form, SIZE_MOST};
use super::screen::Expected;
use crate::coordinates::Coordinate;
use crate::criteria::{
    FORM_START_RATIO, FORM_STARTS, LAST_FIT_DERIVATIVES, LAST_FIT_STEPS, QUICK_FIT_DERIVATIVES, QUICK_FIT_STEPS,
    REFINED_FIT_DERIVATIVES, REFINED_FIT_STEPS,
};
use crate::diagnose::with_values;
use crate::evidence::{Evidence, EvidenceError};
use crate::fit::{Fit, FitOptions};
use crate::response::shifted;

/// Finite-difference step of a shape coordinate.
const SHAPE_STEP: f64 = 0.02;

/// A form that was fitted.
#[derive(Clone)]
pub(crate) struct Fitted {
    /// The form, with the fitted shape.
    pub form: Form,
    /// Its sizes.
    pub sizes: Vec<f64>,
    /// The fit of model and form.
    pub fit: Fit,
    /// Log density lost by the choice of its shape; negative or 0.
    pub choice: f64,
    /// The model with the form.
    model: Model,
    /// The library with the form's file.
    pub library: Library,
}

impl Fitted {
    /// Fits a form quickly from the expectation of the first look; `None` if it cannot be simulated.
    pub(crate) fn new(
        evidence: &dyn Evidence,
        (model, base): (&Model, &Fit),
        library: &Library,
        (basis, expected): (&Basis, &Expected),
    ) -> Option<Self> {
        let mut expected = expected.clone();
        while library.find(&expected.form.name()).is_some() {
            expected.form.number += 1;
        }
        let (expected, form) = (&expected, &expected.form);
        let file = (format!("{}.toml", form.name()), form.file(&expected.sizes, "a first look"));
        let library = library.with(&[file]).ok()?;
        let mut with = model.clone().with(&form.name());
        if let Some(free) = &mut with.free {
            let own = form.kind.sizes().iter().copied().chain(form.kind.shape().iter().map(|(name, _)| *name));
            free.extend(own.map(|name| format!("{}.{name}", form.name())));
        }
        let with = evidence.adapted(with, &library);
        let compiled = CompiledModel::new(&with, &library, evidence.rows()).ok()?;
        let mut fit = starts(&compiled, base, expected)
            .par_iter()
            .filter_map(|start| Fit::unfitted(evidence, start, evidence.coordinates(start)).ok())
            .min_by(|a, b| a.chi2.total_cmp(&b.chi2))?;
        let start = fit.model.clone();
        let lent = |coordinate: &Coordinate| match coordinate.slot.owner == form.name() {
            true => slope((basis, expected), coordinate, start.value(coordinate.index)),
            false => base.column(coordinate),
        };
        fit.borrow_derivatives(evidence, lent);
        let quick = FitOptions { derivatives: QUICK_FIT_DERIVATIVES, steps: QUICK_FIT_STEPS };
        Some(
            Self { form: form.clone(), sizes: Vec::new(), fit, choice: expected.choice, model: with, library }
                .refined(evidence, quick),
        )
    }

    /// Continues the fit, and restarts it from the base fit's starting values where it stays poor: the base parameters
    /// may be far off.
    pub(crate) fn fitted_further(self, evidence: &dyn Evidence, base: &Fit) -> Self {
        let end = FitOptions { derivatives: REFINED_FIT_DERIVATIVES, steps: REFINED_FIT_STEPS };
        let fitted = self.refined(evidence, end);
        if !fitted.fit.is_poor() {
            return fitted;
        }
        let last = FitOptions { derivatives: LAST_FIT_DERIVATIVES, steps: LAST_FIT_STEPS };
        match fitted.fit.begun_at(evidence, &fitted.fit.with_beginning_of(base), last) {
            Ok(fit) if fit.chi2 < fitted.fit.chi2 => Self { fit, ..fitted }.read(),
            _ => fitted,
        }
    }

    /// Hat functions over all variables beside this model, and its fit as if it lacked the form: residuals and
    /// derivatives at base parameters that no longer compensate for the form.
    ///
    /// # Errors
    /// If the model cannot be simulated.
    pub(crate) fn without_form(&self, evidence: &dyn Evidence) -> Result<(Vec<Basis>, Fit), EvidenceError> {
        let bases = evidence.bases((&self.model, &self.fit), &self.library)?;
        let mut fit = self.fit.clone();
        if let Some(basis) = bases.iter().find(|basis| self.form.is_over(basis)) {
            let lost = |value: f64| {
                let gain = self.form.change(value, &self.sizes);
                if self.form.action.is_factor() { -gain / (1.0 + gain) } else { -gain }
            };
            fit.residuals.iter_mut().zip(basis.column(lost).iter()).for_each(|(residual, lost)| *residual += lost);
        }
        let own = |k: &usize| self.fit.coordinates[*k].slot.owner != self.form.name();
        let kept: Vec<usize> = (0..fit.coordinates.len()).filter(own).collect();
        let of = |values: &[f64]| kept.iter().map(|&k| values[k]).collect::<Vec<f64>>();
        (fit.at, fit.begun) = (of(&self.fit.at), of(&self.fit.begun));
        fit.coordinates = kept.iter().map(|&k| self.fit.coordinates[k].clone()).collect();
        fit.jacobian = self.fit.jacobian.select_columns(&kept);
        Ok((bases, fit))
    }

    /// The model with the form and all fitted values.
    pub(crate) fn model(&self) -> Model {
        with_values(&self.model, &self.fit)
    }

    fn refined(self, evidence: &dyn Evidence, options: FitOptions) -> Self {
        Self { fit: self.fit.refined(evidence, options), ..self }.read()
    }

    /// Reads sizes and shape from the fit.
    fn read(mut self) -> Self {
        self.sizes = self.form.read(&self.fit.model);
        self
    }
}

/// Starting values of a fit: the form at its expected size and at multiples of it, because a biased base fit hides most
/// of it; each at the base fit's optimum and at its starting values.
fn starts(model: &CompiledModel, base: &Fit, expected: &Expected) -> Vec<CompiledModel> {
    let moved = shifted(model.clone(), base, &expected.shift);
    let back: Vec<f64> = base.begun.iter().zip(&base.at).map(|(begun, at)| begun - at).collect();
    let places = [moved, shifted(model.clone(), base, &back)];
    let name = expected.form.name();
    let typical = expected.form.action.typical();
    let largest = expected.sizes.iter().fold(0.0f64, |most, size| most.max(size.abs()));
    let scales = (0..FORM_STARTS)
        .map(|k| FORM_START_RATIO.powi(k))
        .filter(|scale| scale * largest <= SIZE_MOST || *scale == 1.0);
    let scaled = |scale: f64, place: &CompiledModel| {
        let mut start = place.clone();
        for (own, size) in expected.form.kind.sizes().iter().zip(&expected.sizes) {
            let index = start.index(&format!("{name}.{own}")).expect("the form's own parameter");
            start.set(index, typical * (scale * size).clamp(-SIZE_MOST, SIZE_MOST));
        }
        start
    };
    scales.flat_map(|scale| places.each_ref().map(|place| scaled(scale, place))).collect()
}

/// Derivative of the whitened residuals along a coordinate of a form, from the hat functions over its variable; `None`
/// for a parameter of another owner.
fn slope((basis, expected): (&Basis, &Expected), coordinate: &Coordinate, value: f64) -> Option<DVector<f64>> {
    let (form, name) = (&expected.form, &coordinate.slot.parameter);
    let at = coordinate.clamped(coordinate.from_value(value));
    if let Some(size) = form.kind.sizes().iter().position(|own| own == name) {
        let per_coordinate = (coordinate.value(at + SHAPE_STEP) - coordinate.value(at)) / SHAPE_STEP;
        let typical = form.action.typical();
        return Some(basis.column(|value| form.gains(value)[size] * per_coordinate / typical));
    }
    let place = form.kind.shape().iter().position(|(own, _)| own == name)?;
    let mut moved = form.clone();
    moved.shape[place] = coordinate.value(at + SHAPE_STEP);
    let total = |form: &Form, value: f64| -> f64 {
        form.gains(value).iter().zip(&expected.sizes).map(|(gain, size)| gain * size).sum()
    };
    Some(basis.column(|value| (total(&moved, value) - total(form, value)) / SHAPE_STEP))
}
