//! Summary of a calibration: parameters in the library's units, errors in [`ErrorUnit`].

use effects::{CompiledModel, Library};
use serde::Serialize;

use super::calibration::{Calibration, Judged, Order};
use super::evidence::{ErrorUnit, EvidenceError, Split};
use super::fit::Fit;
use super::summary::{ParameterSummary, WaterfallStep, floor_of, parameter_summary, step};
use super::totals::{Total, Totals};
use super::verdict::rms;
use crate::criteria::{CriterionValues, STRONG_CORRELATION};

/// Correlation of the errors of two parameters.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Correlation {
    /// Names of the parameters.
    pub between: [String; 2],
    /// Correlation; absent where the data do not determine one of them.
    pub value: Option<f64>,
}

/// Error of the total removal up to a scan, after each step of the waterfall.
#[derive(Clone, Debug, Serialize)]
pub struct RemovalError {
    /// Name of the trial and pass, or of the table.
    pub about: String,
    /// True for calibration data, false for held-out data.
    pub is_calibration: bool,
    /// Predicted minus measured, for the base model and after each effect [% of the measured].
    pub error_percent: Vec<f64>,
    /// Standard deviation of the measured value [%].
    pub sigma_percent: f64,
}

/// Summary of a calibration.
#[derive(Clone, Debug, Serialize)]
pub struct CalibrationSummary {
    /// The order of the fits.
    pub order: Order,
    /// Unit of the errors below: metres for scans, shares of the removal for tables.
    pub error_unit: ErrorUnit,
    /// Noise floor of the calibration passes.
    pub noise_floor: f64,
    /// Noise floor of the evaluation passes; absent where none is held out.
    pub evaluation_noise_floor: Option<f64>,
    /// Robust χ² of the whole model: sum of squared whitened residuals, in which outliers count linearly.
    pub chi2: f64,
    /// Number of data minus free parameters; χ² is near it where only noise is left.
    pub degrees_of_freedom: usize,
    /// Errors from the raw data to the whole model.
    pub waterfall: Vec<WaterfallStep>,
    /// Errors of the total removal up to each scan, with fitted pose; empty for a table, whose error is this already.
    pub removal: Vec<RemovalError>,
    /// Estimates of all parameters of the whole model.
    pub parameters: Vec<ParameterSummary>,
    /// Correlations of the parameters.
    pub correlations: Vec<Correlation>,
    /// Remarks on the calibration, one sentence each.
    pub remarks: Vec<String>,
    /// Values of all decision criteria, by name.
    pub criteria: CriterionValues,
}

/// Steps of the waterfall before any fit, and the noise floors of calibration and evaluation passes.
pub type Beginning = (Vec<WaterfallStep>, (f64, Option<f64>));

/// One model compared with both splits.
struct Step {
    name: String,
    calibration: Judged,
    evaluation: Judged,
}

impl CalibrationSummary {
    /// Summarises a calibration; the evaluation data are read here for the first time.
    ///
    /// # Errors
    /// If a model cannot be simulated.
    pub fn new(evidence: &dyn Totals, calibration: &Calibration, library: &Library) -> Result<Self, EvidenceError> {
        let unit = evidence.unit();
        let judge = |name: &str, model| {
            let [calibration, evaluation] =
                [Split::Calibration, Split::Evaluation].map(|s| Judged::new(evidence, model, s));
            Ok(Step { name: name.to_owned(), calibration: calibration?, evaluation: evaluation? })
        };
        let fitted: Vec<Step> =
            calibration.steps.iter().map(|f| judge(&f.name, &f.fit.model)).collect::<Result<_, EvidenceError>>()?;
        let (mut waterfall, _) = beginning(evidence, &calibration.start)?;
        waterfall
            .extend(fitted.iter().map(|s| step(s.name.clone(), &s.calibration.agreement, &s.evaluation.agreement)));
        let last = calibration.last();
        let parameters: Vec<ParameterSummary> = last.estimates().iter().map(parameter_summary).collect();
        let correlations = correlations(&last.fit);
        let floor = fitted.last().map_or(0.0, |s| rms(&s.calibration.agreement, |a| a.floor));
        let evaluation_noise_floor = fitted.last().and_then(|s| floor_of(&s.evaluation.agreement));
        let mut remarks: Vec<String> = parameters.iter().filter_map(remark).collect();
        remarks.extend(correlations.iter().filter_map(in_words));
        remarks.extend(unseen(evidence, calibration, library));
        remarks.extend(evidence.frame(&last.fit)?.and_then(|frame| frame.sentence()));
        remarks.extend(last.staged.iter().map(|staged| lost(&staged.totals)));
        if !last.fit.converged {
            remarks.push("the fit still improved when it was ended: the values may move a little more".to_owned());
        }
        let removal = if unit == ErrorUnit::Metre { removal(&fitted) } else { Vec::new() };
        Ok(Self {
            order: calibration.order,
            error_unit: unit,
            noise_floor: floor,
            evaluation_noise_floor,
            chi2: last.fit.chi2,
            degrees_of_freedom: last.fit.residuals.len().saturating_sub(last.fit.at.len()),
            waterfall,
            removal,
            parameters,
            correlations,
            remarks,
            criteria: CriterionValues,
        })
    }
}

/// Errors of the base law before any fit, with the scans as measured and registered on the untouched surface; and the
/// noise floors of calibration and evaluation passes.
///
/// # Errors
/// If the model cannot be simulated.
pub fn beginning(evidence: &dyn Totals, model: &CompiledModel) -> Result<Beginning, EvidenceError> {
    let mean = |all: &[f64]| {
        (!all.is_empty()).then(|| (all.iter().map(|rms| rms * rms).sum::<f64>() / all.len() as f64).sqrt())
    };
    let mut steps = Vec::new();
    let raw = mean(&evidence.unregistered(model, Split::Calibration)?);
    if let Some(calibration_rms) = raw {
        let evaluation_rms = mean(&evidence.unregistered(model, Split::Evaluation)?);
        steps.push(WaterfallStep { step: "raw".to_owned(), calibration_rms, evaluation_rms });
    }
    let agreement = [Split::Calibration, Split::Evaluation].map(|split| evidence.agreement(model, split));
    let [seen, held_out] = agreement;
    let (seen, held_out) = (seen?, held_out?);
    let name = if raw.is_some() { "registered" } else { "not calibrated" };
    steps.push(step(name.to_owned(), &seen, &held_out));
    Ok((steps, (rms(&seen, |a| a.floor), floor_of(&held_out))))
}

/// Correlations of the errors of a fit's parameters: every pair once; empty if the fit determines none.
pub fn correlations(fit: &Fit) -> Vec<Correlation> {
    let Some(covariance) = fit.covariance(1.0) else { return Vec::new() };
    let names: Vec<String> = fit.coordinates.iter().map(|c| c.slot.name()).collect();
    let pairs = (0..names.len()).flat_map(|i| (0..i).map(move |j| (j, i)));
    let correlation = |(i, j): (usize, usize)| {
        let value = covariance[(i, j)] / (covariance[(i, i)] * covariance[(j, j)]).sqrt();
        Correlation { between: [names[i].clone(), names[j].clone()], value: Some(value).filter(|v| v.is_finite()) }
    };
    pairs.map(correlation).collect()
}

fn remark(parameter: &ParameterSummary) -> Option<String> {
    let note = parameter.state.words()?;
    Some(match parameter.interval {
        None => format!("{} is {note}: any value of its range fits about equally well", parameter.name),
        Some(_) => {
            format!("{} is {note}, {} {}: the best fit may lie beyond", parameter.name, parameter.value, parameter.unit)
        }
    })
}

fn in_words(correlation: &Correlation) -> Option<String> {
    let (value, [one, other]) =
        (correlation.value.filter(|value| value.abs() >= STRONG_CORRELATION)?, &correlation.between);
    Some(format!(
        "{one} and {other} are correlated ({value:+.2}): the data determine one combination of them far better than \
         either"
    ))
}

/// Sentences on effects of the model that these data cannot show.
fn unseen(evidence: &dyn Totals, calibration: &Calibration, library: &Library) -> Vec<String> {
    let blind = |name: &String| Some(format!("{name} cannot show: {}", evidence.is_blind_to(library.find(name)?)?));
    calibration.model.effects.iter().map(|part| &part.name).filter_map(blind).collect()
}

/// Sentence on the error of the total removal after each of the two stages of the staged order.
fn lost(totals: &[Vec<Total>; 2]) -> String {
    let [first, second] = totals.each_ref().map(|totals| {
        let (predicted, measured) = totals.iter().fold((0.0, 0.0), |(p, m), t| (p + t.predicted, m + t.measured));
        100.0 * (predicted / measured - 1.0)
    });
    format!(
        "staged order: the total removal was off by {first:+.2} % after the fit of the rate, and is off by \
         {second:+.2} % after the other parameters were fitted to the profiles"
    )
}

fn removal(steps: &[Step]) -> Vec<RemovalError> {
    let mut all = Vec::new();
    for is_calibration in [true, false] {
        let of = |step: &Step| if is_calibration { &step.calibration } else { &step.evaluation }.totals.clone();
        let last = steps.last().map(of).unwrap_or_default();
        for (k, total) in last.iter().enumerate() {
            let error = |step: &Step| 100.0 * of(step)[k].error().0;
            let error_percent = steps.iter().map(error).collect();
            let sigma_percent = 100.0 * total.error().1;
            all.push(RemovalError { about: total.about.clone(), is_calibration, error_percent, sigma_percent });
        }
    }
    all
}
