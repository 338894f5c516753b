//! Stepwise fit of a model: the base law, then each effect in the order of the model file. The residuals after each
//! step form the waterfall of a study.

use std::collections::BTreeMap;

use effects::{CompiledModel, Library, Model};
use rayon::prelude::*;
use serde::Serialize;

use super::begin::{other_starts, with_matched_rate};
use super::calibrate::fit_law;
use super::diagnose::spread;
use super::error::{LabError, Result};
use super::evidence::{Agreement, EvidenceError, Split};
use super::fit::{Estimate, Fit, FitOptions};
use super::staged::Staged;
use super::summary::BASE_STEP;
use super::totals::{Total, Totals};
use super::with_values;
use crate::criteria::{FIT_CONVERGED_DELTA_CHI2, RENEWED_FIT_DERIVATIVES, RENEWED_FIT_STEPS};

/// Prefix of the name of a step that adds an effect.
const ADDED: &str = "+ ";

/// Order in which parameters are fitted.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum Order {
    /// All parameters and the scans' poses together.
    #[default]
    Joint,
    /// First the removal rate from the total removal, then the other parameters from the profiles.
    Staged,
}

/// A model fitted to the calibration data.
pub struct Fitted {
    /// Name of the step: `base model`, `+ grit-dulling`.
    pub name: String,
    /// The fit; in staged order, that of the second stage.
    pub fit: Fit,
    /// Both stages, in staged order.
    pub staged: Option<Staged>,
}

/// A calibrated model with every step on the way to it.
pub struct Calibration {
    /// The order of the fits.
    pub order: Order,
    /// The model with its fitted values.
    pub model: Model,
    /// The base law before any fit.
    pub start: CompiledModel,
    /// The base law, then each effect; the last step is the whole model.
    pub steps: Vec<Fitted>,
}

/// Cost of a fit that continues after the data have been refined.
const RENEWED: FitOptions = FitOptions { derivatives: RENEWED_FIT_DERIVATIVES, steps: RENEWED_FIT_STEPS };

impl Fitted {
    /// Fits the base law.
    fn law(evidence: &dyn Totals, model: &CompiledModel) -> Result<Self> {
        Ok(Self { name: BASE_STEP.to_owned(), fit: fit_law(evidence, model)?, staged: None })
    }

    /// Fits a model in two stages.
    fn in_stages(evidence: &dyn Totals, name: String, model: &CompiledModel) -> Result<Self> {
        let Some((staged, fit)) = Staged::new(evidence, model)? else {
            return Err(LabError::Refused(
                "--order staged: no free parameter of the model's laws is a removal rate; --order joint needs none"
                    .into(),
            ));
        };
        Ok(Self { name, fit, staged: Some(staged) })
    }

    /// Fits a model with one effect more than a fitted one. There are three starts: the fitted values with the effect
    /// at its values in the file; the fitted values with the effect at its null; and all values of the file but the
    /// rate. The best result is kept; it is never worse than the smaller model.
    fn grown(evidence: &dyn Totals, (before, own): (&Fit, &CompiledModel), name: String) -> Result<Self> {
        let effect = name.trim_start_matches(ADDED);
        let coordinates = evidence.coordinates(own);
        let beside = with_values_of(own, before);
        let null = at_null(&beside, effect);
        let matched = with_matched_rate(evidence, own).unwrap_or_else(|_| own.clone());
        let fit_from = |start: &CompiledModel| Fit::new(evidence, start, coordinates.clone(), FitOptions::default());
        let ends = |starts: &[CompiledModel]| -> Vec<Fit> {
            starts.par_iter().filter_map(|start| fit_from(start).ok()).collect()
        };
        // Fits that differ by less count as equal, and the earlier start is kept.
        let lower = |a: Fit, b: Fit| if b.chi2 < a.chi2 - FIT_CONVERGED_DELTA_CHI2 { b } else { a };
        // A good fit may still be in the wrong minimum: an effect of the wrong sign drives the stiffness far off.
        let best = ends(&[beside, matched, null.clone()]).into_iter().reduce(lower);
        let mut best = best.map_or_else(|| fit_from(&null), Ok)?;
        if best.is_poor() {
            best = ends(&other_starts(evidence, own)).into_iter().fold(best, lower);
        }
        let fit = if best.chi2 <= before.chi2 { best } else { Fit { model: null, ..before.clone() } };
        Ok(Self { name, fit, staged: None })
    }

    /// Estimate of each parameter.
    pub fn estimates(&self) -> Vec<Estimate> {
        let profiles = self.fit.estimates(spread(&self.fit.residuals));
        self.staged.iter().map(|staged| staged.rate.clone()).chain(profiles).collect()
    }
}

/// Returns a model with the values of a fit of a smaller one.
pub(super) fn with_values_of(model: &CompiledModel, fit: &Fit) -> CompiledModel {
    let mut model = model.clone();
    let known: BTreeMap<String, f64> =
        fit.model.parameters().iter().map(|slot| slot.name()).zip(fit.model.values().iter().copied()).collect();
    let places: Vec<(usize, f64)> =
        model.parameters().iter().enumerate().filter_map(|(k, slot)| Some((k, *known.get(&slot.name())?))).collect();
    places.into_iter().for_each(|(k, value)| model.set(k, value));
    model
}

/// Returns a model with the sizes of an effect at their null.
pub(super) fn at_null(model: &CompiledModel, effect: &str) -> CompiledModel {
    let mut model = model.clone();
    let own: Vec<(usize, f64)> = (model.parameters().iter().enumerate())
        .filter_map(|(k, slot)| Some((k, slot.null.filter(|_| slot.owner == effect && slot.free)?)))
        .collect();
    own.into_iter().for_each(|(k, null)| model.set(k, null));
    model
}

impl Calibration {
    /// Fits a model stepwise: first its base law, then with one effect after the other. Each fit starts from the result
    /// of the one before. Evaluation data take no part.
    ///
    /// - `start`: the base law with its values before any fit
    /// - `done`: called after each fit with its name
    ///
    /// # Errors
    /// If a model cannot be simulated, or has no removal rate that the staged order needs.
    pub fn new(
        evidence: &dyn Totals,
        (model, start): (&Model, &Model),
        library: &Library,
        (order, done): (Order, &dyn Fn(&str)),
    ) -> Result<Self> {
        let start = CompiledModel::new(start, library, evidence.rows())?;
        let mut steps: Vec<Fitted> = Vec::new();
        for effects in 0..=model.effects.len() {
            let part = Model { effects: model.effects[..effects].to_vec(), ..model.clone() };
            let part = CompiledModel::new(&part, library, evidence.rows())?;
            let name = effects.checked_sub(1).map(|last| format!("{ADDED}{}", model.effects[last].name));
            let step = match (order, steps.last(), name) {
                (Order::Joint, Some(before), Some(name)) => Fitted::grown(evidence, (&before.fit, &part), name)?,
                (Order::Joint, ..) => Fitted::law(evidence, &part)?,
                (Order::Staged, _, name) => {
                    Fitted::in_stages(evidence, name.unwrap_or_else(|| BASE_STEP.to_owned()), &part)?
                }
            };
            done(&step.name);
            steps.push(step);
        }
        let fitted = with_values(model, &steps.last().expect("the base law is a step").fit);
        Ok(Self { order, model: fitted, start, steps })
    }

    /// Continues the same fits after the evidence has changed slightly.
    ///
    /// # Errors
    /// If a model can no longer be simulated.
    pub fn renewed(mut self, evidence: &dyn Totals) -> Result<Self> {
        for step in &mut self.steps {
            step.fit = step.fit.clone().reevaluated(evidence)?.finished(evidence, RENEWED);
        }
        for k in 1..self.steps.len() {
            if self.steps[k].fit.chi2 > self.steps[k - 1].fit.chi2 {
                let before = &self.steps[k - 1].fit;
                let effect = self.steps[k].name.trim_start_matches(ADDED);
                let model = at_null(&with_values_of(&self.steps[k].fit.model, before), effect);
                self.steps[k].fit = Fit { model, ..before.clone() };
            }
        }
        self.model = with_values(&self.model, &self.last().fit);
        Ok(self)
    }

    /// The fit of the whole model.
    pub fn last(&self) -> &Fitted {
        self.steps.last().expect("the whole model is a step")
    }
}

/// A model of the waterfall compared with all data of a split.
#[derive(Clone, Debug)]
pub struct Judged {
    /// Agreement of the model with each scan.
    pub agreement: Vec<Agreement>,
    /// Measured and predicted total removals.
    pub totals: Vec<Total>,
}

impl Judged {
    /// Compares a model with a split.
    ///
    /// # Errors
    /// If it cannot be simulated.
    pub fn new(evidence: &dyn Totals, model: &CompiledModel, split: Split) -> Result<Self, EvidenceError> {
        Ok(Self { agreement: evidence.agreement(model, split)?, totals: evidence.totals(model, split)? })
    }
}

/// Returns the base law of a model without effects, free parameters at the library's values: the start of every
/// calibration.
///
/// # Errors
/// If the library does not know the model.
pub fn uncalibrated(model: &Model, library: &Library, evidence: &dyn Totals) -> Result<Model> {
    let mut base = Model { effects: Vec::new(), ..model.clone() };
    let compiled = CompiledModel::new(&base, library, evidence.rows())?;
    let is_free = |owner: &str, name: &str| {
        compiled.parameters().iter().any(|slot| slot.free && slot.owner == owner && slot.parameter == name)
    };
    for law in &mut base.laws {
        law.values.retain(|(name, _)| !is_free(&law.name, name));
    }
    Ok(base)
}
