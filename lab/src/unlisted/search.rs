//! Search for a form: a first look, fits of the best forms, a second look beside the best fit, and fits of new forms.
//!
//! The base parameters are biased by the missing effect, which distorts the residuals. The second look linearises at a
//! model that lacks little.

use std::collections::BTreeSet;

use effects::{Library, Model};
use rayon::prelude::*;

use super::action::Action;
use super::basis::Basis;
use super::form::Kind;
use super::screen::{Expected, ScreenedBasis, screen_bases};
use super::trial_fit::Fitted;
use crate::criteria::{FORMS_FITTED, FORMS_PER_VARIABLE, FORMS_REFINED};
use crate::cross_validation::CrossValidation;
use crate::evidence::{Evidence, EvidenceError};
use crate::fit::Fit;

/// All forms that were fitted, and the basis of the first look.
pub(crate) struct Search {
    /// Forms, the one with the least χ² first.
    pub fitted: Vec<Fitted>,
    /// Hat functions over all variables, linearised at the base fit.
    pub bases: Vec<Basis>,
}

impl Search {
    /// Searches beside a fitted model.
    ///
    /// # Errors
    /// If the model cannot be simulated.
    pub(crate) fn new(
        evidence: &dyn Evidence,
        (model, base): (&Model, &Fit),
        library: &Library,
    ) -> Result<Self, EvidenceError> {
        let screened =
            screen_bases(&CrossValidation::by_pass(evidence, base), base, evidence.bases((model, base), library)?);
        let mut first = chosen(&screened, None);
        first.extend(lines(&screened, &first));
        let mut fitted = fitted(evidence, (model, base), library, &first);
        let bases = screened.into_iter().map(|screened| screened.basis).collect();
        if let Some(best) = fitted.first() {
            let (again, without) = again(evidence, best)?;
            let known = best.form.name();
            fitted.extend(self::fitted(evidence, (model, &without), library, &chosen(&again, Some(&known))));
            sort(&mut fitted);
            // If a form was fitted after both looks, the better fit is kept.
            let mut names = BTreeSet::new();
            fitted.retain(|fitted| names.insert(fitted.form.name()));
        }
        Ok(Self { fitted, bases })
    }
}

/// Takes a look beside a model with a form, as if it lacked the form; also returns the fit without it.
///
/// # Errors
/// If the model cannot be simulated.
pub(crate) fn again(evidence: &dyn Evidence, best: &Fitted) -> Result<(Vec<ScreenedBasis>, Fit), EvidenceError> {
    let (bases, without) = best.without_form(evidence)?;
    Ok((screen_bases(&CrossValidation::by_pass(evidence, &best.fit), &without, bases), without))
}

/// Fits forms, the best until convergence. Least χ² first.
fn fitted(
    evidence: &dyn Evidence,
    (model, base): (&Model, &Fit),
    library: &Library,
    chosen: &[(&Basis, &Expected)],
) -> Vec<Fitted> {
    let quick = chosen.par_iter().filter_map(|&expected| Fitted::new(evidence, (model, base), library, expected));
    let mut fitted: Vec<Fitted> = quick.collect();
    sort(&mut fitted);
    let rest = fitted.split_off(FORMS_REFINED.min(fitted.len()));
    let mut fitted: Vec<Fitted> = fitted.into_par_iter().map(|fitted| fitted.fitted_further(evidence, base)).collect();
    fitted.extend(rest);
    sort(&mut fitted);
    fitted
}

fn sort(fitted: &mut [Fitted]) {
    fitted.sort_by(|a, b| a.fit.chi2.total_cmp(&b.fit.chi2).then_with(|| a.form.name().cmp(&b.form.name())));
}

/// A line of the rate over each variable without a chosen form: with biased base parameters the first look may rank the
/// true variable low.
fn lines<'a>(screened: &'a [ScreenedBasis], chosen: &[(&Basis, &Expected)]) -> Vec<(&'a Basis, &'a Expected)> {
    let is_new = |one: &&ScreenedBasis| {
        one.basis.action == Action::Rate && chosen.iter().all(|(basis, _)| basis.variable != one.basis.variable)
    };
    let line = |one: &'a ScreenedBasis| Some((&one.basis, one.forms.iter().find(|form| form.form.kind == Kind::Line)?));
    screened.iter().filter(is_new).filter_map(line).collect()
}

/// The forms that are expected to predict best, a few for each variable, without the known one.
fn chosen<'a>(screened: &'a [ScreenedBasis], known: Option<&str>) -> Vec<(&'a Basis, &'a Expected)> {
    let mut all: Vec<(&Basis, &Expected)> = Vec::new();
    for one in screened {
        let forms = one.forms.iter().take(FORMS_PER_VARIABLE);
        all.extend(forms.map(|form| (&one.basis, form)));
    }
    all.sort_by(|a, b| b.1.score.total_cmp(&a.1.score));
    all.truncate(FORMS_FITTED);
    all.retain(|(_, expected)| known != Some(expected.form.name().as_str()));
    all
}
