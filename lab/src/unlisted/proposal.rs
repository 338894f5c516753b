//! Effect files that are proposed where no effect of the library describes the data.

use effects::{Library, Model};
use rayon::prelude::*;
use serde::Serialize;

use super::curve_file::curve_file;
use super::null_forms::null_forms;
use super::search::{Search, again};
use super::trial_fit::Fitted;
use crate::criteria::{FORM_TERMS, INTERVAL_SIGMAS, SIGNIFICANCE_LEVEL};
use crate::cross_validation::{CrossValidation, Prediction};
use crate::evidence::{Agreement, ErrorUnit, Evidence, EvidenceError, Split};
use crate::fit::Fit;
use crate::response::Projector;
use crate::summary::{ParameterSummary, WaterfallStep, parameter_summary};
use crate::verdict::{Standing, least_size, rms, unexplained};

/// One point of a curve.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct CurvePoint {
    /// Value of the variable, in its unit.
    pub at: f64,
    /// Change of the form's quantity, in [`ProposedForm::acts_on`]'s unit.
    pub change: f64,
    /// Its 95 % band.
    pub band: [f64; 2],
    /// Change by the form.
    pub form: f64,
}

/// A form that was fitted.
#[derive(Clone, Debug, Serialize)]
pub struct FittedForm {
    /// Name of its effect: `form-band-of-place-along-x`.
    pub name: String,
    /// The form in a sentence.
    pub summary: String,
    /// Fall of χ².
    pub delta_chi2: f64,
    /// Cross-validated log density, minus that of the model without it.
    pub predicts_better_by: f64,
    /// P-value: probability that noise alone gives the best form over any variable such a Δχ².
    pub p_value: f64,
}

/// A form that is part of a proposal.
#[derive(Clone, Debug, Serialize)]
pub struct ProposedForm {
    /// Name of its effect.
    pub name: String,
    /// The form in a sentence.
    pub summary: String,
    /// Quantity that it changes, in words, and the unit of a change.
    pub acts_on: [String; 2],
    /// The variable, in words, and its unit.
    pub variable: [String; 2],
    /// The curve over the variable.
    pub curve: Vec<CurvePoint>,
    /// All forms that were fitted, the one that predicts best first.
    pub fitted: Vec<FittedForm>,
}

/// Forms that are significant, and describe the held-out data no worse than the model without them.
#[derive(Clone, Debug, Serialize)]
pub struct Proposal {
    /// The forms, in the order in which they were found.
    pub forms: Vec<ProposedForm>,
    /// Effect files by name: each form, and its curve.
    #[serde(skip)]
    pub files: Vec<(String, String)>,
    /// Model file with the forms; it needs their files.
    #[serde(skip)]
    pub model: String,
    /// Fitted parameters, including those of the laws.
    pub parameters: Vec<ParameterSummary>,
    /// Unit of the errors.
    pub error_unit: ErrorUnit,
    /// Errors without the forms, then with each.
    pub errors: Vec<WaterfallStep>,
    /// Fall of χ².
    pub delta_chi2: f64,
}

/// A fitted form with its cross-validated prediction.
struct Weighed {
    fitted: Fitted,
    prediction: Prediction,
    p_value: f64,
}

/// An accepted form.
struct Term {
    fitted: Fitted,
    curve: Vec<CurvePoint>,
    all: Vec<FittedForm>,
    /// Agreement with the calibration and the held-out data.
    agreement: [Vec<Agreement>; 2],
    /// True if the residual beside it exceeds noise.
    is_open: bool,
}

/// Finds the forms that describe the residual of a fitted model best; `None` if the best is not significant, too small
/// to be named as an effect, or raises the error of the held-out data.
///
/// # Errors
/// If the model cannot be simulated.
pub fn propose(
    evidence: &dyn Evidence,
    (model, fit): (&Model, &Fit),
    library: &Library,
    seed: u64,
) -> Result<Option<Proposal>, EvidenceError> {
    let agreement = |split| evidence.agreement(&fit.model, split);
    let mut before = [agreement(Split::Calibration)?, agreement(Split::Evaluation)?];
    let mut errors = vec![error("without it", &before)];
    let mut terms: Vec<Term> = Vec::new();
    while terms.len() < FORM_TERMS {
        let term = match terms.last() {
            None => term(evidence, (model, fit), library, (&before, seed))?,
            Some(Term { fitted, .. }) => {
                term(evidence, (&fitted.model(), &fitted.fit), &fitted.library, (&before, seed))?
            }
        };
        let Some(term) = term else { break };
        errors.push(error(&format!("+ {}", term.fitted.form.name()), &term.agreement));
        before.clone_from(&term.agreement);
        let is_open = term.is_open;
        terms.push(term);
        if !is_open {
            break;
        }
    }
    Ok((!terms.is_empty()).then(|| proposal(evidence, fit, terms, errors)))
}

/// The form that predicts best, if it is significant and the held-out data agree.
fn term(
    evidence: &dyn Evidence,
    (model, fit): (&Model, &Fit),
    library: &Library,
    ([seen, held_out], seed): (&[Vec<Agreement>; 2], u64),
) -> Result<Option<Term>, EvidenceError> {
    let search = Search::new(evidence, (model, fit), library)?;
    let (weighed, without) = weighed(evidence, fit, search, seed);
    let all = weighed.iter().map(|weighed| weighed.listed(fit, without)).collect();
    let is_real = |weighed: &Weighed| weighed.p_value < SIGNIFICANCE_LEVEL && weighed.density() > without;
    let Some(Weighed { fitted, prediction, .. }) = weighed.into_iter().find(is_real) else { return Ok(None) };
    let change: Vec<f64> = fit.residuals.iter().zip(&fitted.fit.residuals).map(|(b, a)| b - a).collect();
    if evidence.size(&change) <= least_size(seen) {
        return Ok(None);
    }
    let after = evidence.agreement(&fitted.fit.model, Split::Evaluation)?;
    if unexplained(&after) > unexplained(held_out) {
        return Ok(None);
    }
    let calibration = evidence.agreement(&fitted.fit.model, Split::Calibration)?;
    let closed = prediction.closed_size(evidence);
    let is_open = Standing { calibration: &calibration, evaluation: &after, closed }.is_open();
    Ok(Some(Term { curve: points(evidence, &fitted)?, fitted, all, agreement: [calibration, after], is_open }))
}

/// All fitted forms, the one that predicts best first; and the log density of the data without any.
fn weighed(evidence: &dyn Evidence, fit: &Fit, search: Search, seed: u64) -> (Vec<Weighed>, f64) {
    let Search { fitted, bases } = search;
    let Some(best) = fitted.first() else { return (Vec::new(), 0.0) };
    let left = (&best.fit.residuals[..], &evidence.blocks(Split::Calibration)[..]);
    let draws = null_forms(&Projector::new(fit), &bases, left, seed);
    let folds = CrossValidation::by_pass(evidence, &best.fit);
    let weighed = |fitted: Fitted| Weighed {
        prediction: folds.prediction(&fitted.fit),
        p_value: draws.p_value(fit, &fitted.fit),
        fitted,
    };
    let without = folds.prediction(fit).total();
    let mut weighed: Vec<Weighed> = fitted.into_par_iter().map(weighed).collect();
    weighed.sort_by(|a, b| b.density().total_cmp(&a.density()));
    (weighed, without)
}

impl Weighed {
    /// Cross-validated log density, averaged over the shapes among which it was chosen.
    fn density(&self) -> f64 {
        self.prediction.total() + self.fitted.choice
    }

    fn listed(&self, base: &Fit, without: f64) -> FittedForm {
        FittedForm {
            name: self.fitted.form.name(),
            summary: self.fitted.form.words(&self.fitted.sizes),
            delta_chi2: base.chi2 - self.fitted.fit.chi2,
            predicts_better_by: self.density() - without,
            p_value: self.p_value,
        }
    }
}

/// Proposal of all terms, with the values of the last fit.
fn proposal(evidence: &dyn Evidence, base: &Fit, terms: Vec<Term>, errors: Vec<WaterfallStep>) -> Proposal {
    let last = &terms[terms.len() - 1].fitted;
    let (fit, model) = (last.fit.clone(), last.model().to_text(&last.library));
    let known = fall_of_error(evidence.unit(), &errors);
    let (mut forms, mut files) = (Vec::new(), Vec::new());
    for Term { fitted, curve, all, .. } in terms {
        let mut form = fitted.form;
        let sizes = form.read(&fit.model);
        let (name, summary, variable) = (form.name(), form.words(&sizes), form.variable.clone());
        let source = format!("found in data: {summary}; {known}. Give it a name and a cause");
        files.push((format!("{name}.toml"), form.file(&sizes, &source)));
        files.push(curve_file((form.action, &variable), &curve, &source));
        let (unit, _) = form.action.shown();
        forms.push(ProposedForm {
            name,
            summary,
            acts_on: [form.action.about(), unit].map(str::to_owned),
            variable: [&variable.about, &variable.unit].map(|text| text.to_string()),
            curve,
            fitted: all,
        });
    }
    Proposal {
        forms,
        files,
        model,
        parameters: fit.estimates(1.0).iter().map(parameter_summary).collect(),
        error_unit: evidence.unit(),
        errors,
        delta_chi2: base.chi2 - fit.chi2,
    }
}

/// Errors of a model, as a step of the waterfall.
fn error(step: &str, [seen, held_out]: &[Vec<Agreement>; 2]) -> WaterfallStep {
    let mean = |of: &[Agreement]| rms(of, |a| a.rms);
    WaterfallStep {
        step: step.to_owned(),
        calibration_rms: mean(seen),
        evaluation_rms: (!held_out.is_empty()).then(|| mean(held_out)),
    }
}

/// The fall of the error, in words.
fn fall_of_error(unit: ErrorUnit, errors: &[WaterfallStep]) -> String {
    let (before, after) = (&errors[0], &errors[errors.len() - 1]);
    match (before.evaluation_rms, after.evaluation_rms) {
        (Some(before), Some(after)) => format!("held out {}, then {}", unit.shown(before), unit.shown(after)),
        _ => format!("error {}, then {}", unit.shown(before.calibration_rms), unit.shown(after.calibration_rms)),
    }
}

/// Points of the curve of the rate over the form's variable, with the form's own values.
fn points(evidence: &dyn Evidence, fitted: &Fitted) -> Result<Vec<CurvePoint>, EvidenceError> {
    let (screened, _) = again(evidence, fitted)?;
    let Some(own) = screened.into_iter().find(|screened| fitted.form.is_over(&screened.basis)) else {
        return Ok(Vec::new());
    };
    let curve = if fitted.form.action.is_factor() { own.curve.without_form() } else { own.curve };
    let (si, (_, scale)) = (fitted.form.variable.si(), fitted.form.action.shown());
    let point = |((knot, change), sigma): ((&f64, &f64), &f64)| CurvePoint {
        at: knot / si,
        change: scale * change,
        band: [-1.0, 1.0].map(|side| scale * (change + side * INTERVAL_SIGMAS * sigma)),
        form: scale * fitted.form.change(*knot, &fitted.sizes),
    };
    Ok(own.basis.knots.iter().zip(&curve.change).zip(&curve.sigma).map(point).collect())
}
