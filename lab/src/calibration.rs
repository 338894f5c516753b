//! A model fitted step by step: the base law, then each effect of the model in the order of its file. What each step
//! leaves is the waterfall of a study.

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

/// What the name of a step begins with that adds an effect.
const ADDED: &str = "+ ";

/// In which order parameters are fitted.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum Order {
    /// All parameters and the scans' poses at once.
    #[default]
    Joint,
    /// First the removal rate from what was removed in all, then the rest from the profiles.
    Staged,
}

/// A model fitted to the calibration data.
pub struct Fitted {
    /// What it adds: `base model`, `+ grit-dulling`.
    pub name: String,
    /// The fit; of the staged order, the fit of the second stage.
    pub fit: Fit,
    /// Both stages, where the order was staged.
    pub staged: Option<Staged>,
}

/// A model calibrated, with every step on the way to it.
pub struct Calibration {
    /// The order of the fits.
    pub order: Order,
    /// The model with its fitted values.
    pub model: Model,
    /// The base law before anything was fitted.
    pub start: CompiledModel,
    /// The base law, then each effect; the last is the whole model.
    pub steps: Vec<Fitted>,
}

/// Cost of a fit that goes on after the data were seen better.
const RENEWED: FitOptions = FitOptions { derivatives: RENEWED_FIT_DERIVATIVES, steps: RENEWED_FIT_STEPS };

impl Fitted {
    /// The base law.
    fn law(evidence: &dyn Totals, model: &CompiledModel) -> Result<Self> {
        Ok(Self { name: BASE_STEP.to_owned(), fit: fit_law(evidence, model)?, staged: None })
    }

    /// A model in two stages.
    fn in_stages(evidence: &dyn Totals, name: String, model: &CompiledModel) -> Result<Self> {
        let Some((staged, fit)) = Staged::new(evidence, model)? else {
            return Err(LabError::Refused(
                "--order staged: no free parameter of the model's laws is a removal rate; --order joint needs none"
                    .into(),
            ));
        };
        Ok(Self { name, fit, staged: Some(staged) })
    }

    /// A model that has one effect more than one that is fitted. The fit begins at the fitted values, with the effect once as
    /// the file has it and once at its null, and once with all values of the file but the rate. The best of the three counts; it
    /// never ends worse than the model before.
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
        // Fits that differ by less are one, and the first start counts.
        let lower = |a: Fit, b: Fit| if b.chi2 < a.chi2 - FIT_CONVERGED_DELTA_CHI2 { b } else { a };
        // A fit that is good may still be in the wrong valley: an effect with the wrong sign drives a stiffness far away.
        let best = ends(&[beside, matched, null.clone()]).into_iter().reduce(lower);
        let mut best = best.map_or_else(|| fit_from(&null), Ok)?;
        if best.is_poor() {
            best = ends(&other_starts(evidence, own)).into_iter().fold(best, lower);
        }
        let fit = if best.chi2 <= before.chi2 { best } else { Fit { model: null, ..before.clone() } };
        Ok(Self { name, fit, staged: None })
    }

    /// What the fit says about each parameter.
    pub fn estimates(&self) -> Vec<Estimate> {
        let profiles = self.fit.estimates(spread(&self.fit.residuals));
        self.staged.iter().map(|staged| staged.rate.clone()).chain(profiles).collect()
    }
}

/// A model with the values that a fit of a smaller one has.
pub(super) fn with_values_of(model: &CompiledModel, fit: &Fit) -> CompiledModel {
    let mut model = model.clone();
    let known: BTreeMap<String, f64> =
        fit.model.parameters().iter().map(|slot| slot.name()).zip(fit.model.values().iter().copied()).collect();
    let places: Vec<(usize, f64)> =
        model.parameters().iter().enumerate().filter_map(|(k, slot)| Some((k, *known.get(&slot.name())?))).collect();
    places.into_iter().for_each(|(k, value)| model.set(k, value));
    model
}

/// A model with the sizes of an effect at their null.
pub(super) fn at_null(model: &CompiledModel, effect: &str) -> CompiledModel {
    let mut model = model.clone();
    let own: Vec<(usize, f64)> = (model.parameters().iter().enumerate())
        .filter_map(|(k, slot)| Some((k, slot.null.filter(|_| slot.owner == effect && slot.free)?)))
        .collect();
    own.into_iter().for_each(|(k, null)| model.set(k, null));
    model
}

impl Calibration {
    /// Fits a model: its base law alone, then with one effect after the other, each beginning where the one before ended.
    /// Evaluation data take no part.
    ///
    /// - `start`: the base law with the values that it has before any fit
    /// - `done`: called after each fit with its name
    ///
    /// # Errors
    /// When a model cannot be simulated, or has no removal rate that the staged order needs.
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

    /// The same fits taken further, after the evidence has changed a little.
    ///
    /// # Errors
    /// When a model cannot be simulated any more.
    pub fn renewed(mut self, evidence: &dyn Totals) -> Result<Self> {
        for step in &mut self.steps {
            step.fit = step.fit.clone().seen_anew(evidence)?.finished(evidence, RENEWED);
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

/// A model of the waterfall against all data of a split.
#[derive(Clone, Debug)]
pub struct Judged {
    /// How well each scan is described.
    pub agreement: Vec<Agreement>,
    /// What was removed in all.
    pub totals: Vec<Total>,
}

impl Judged {
    /// Holds a model against a split.
    ///
    /// # Errors
    /// When it cannot be simulated.
    pub fn new(evidence: &dyn Totals, model: &CompiledModel, split: Split) -> Result<Self, EvidenceError> {
        Ok(Self { agreement: evidence.agreement(model, split)?, totals: evidence.totals(model, split)? })
    }
}

/// The base law of a model without its effects, free parameters at the library's values: where every calibration begins.
///
/// # Errors
/// A model that the library does not know.
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
