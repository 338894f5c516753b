//! A model fitted step by step: the base law, then each effect of the model in the order of its file. What each step
//! leaves is the waterfall of a study.

use effects::{CompiledModel, Library, Model};
use serde::Serialize;

use super::diagnose::spread;
use super::error::{LabError, Result};
use super::evidence::{Agreement, EvidenceError, Split};
use super::fit::{Estimate, Fit};
use super::staged::Staged;
use super::summary::BASE_STEP;
use super::totals::{Total, Totals};
use super::{calibrate, with_values};

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

impl Fitted {
    fn new(evidence: &dyn Totals, (name, model): (String, &Model), library: &Library, order: Order) -> Result<Self> {
        if order == Order::Joint {
            return Ok(Self { name, fit: calibrate(evidence, model, library)?, staged: None });
        }
        let compiled = CompiledModel::new(model, library, evidence.rows())?;
        let Some((staged, fit)) = Staged::new(evidence, &compiled)? else {
            return Err(LabError::Refused(
                "--order staged: no free parameter of the model's laws is a removal rate; --order joint needs none"
                    .into(),
            ));
        };
        Ok(Self { name, fit, staged: Some(staged) })
    }

    /// What the fit says about each parameter.
    pub fn estimates(&self) -> Vec<Estimate> {
        let profiles = self.fit.estimates(spread(&self.fit.residuals));
        self.staged.iter().map(|staged| staged.rate.clone()).chain(profiles).collect()
    }
}

impl Calibration {
    /// Fits a model, and before it the models that it grew from: the base law alone, and with one effect after the other.
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
        let count = model.effects.len();
        let name = |effects: usize| match effects {
            0 => BASE_STEP.to_owned(),
            _ => format!("+ {}", model.effects[effects - 1].name),
        };
        let start = CompiledModel::new(start, library, evidence.rows())?;
        let whole = Fitted::new(evidence, (name(count), model), library, order)?;
        done(&whole.name);
        let model_fitted = with_values(model, &whole.fit);
        let mut steps = Vec::new();
        for effects in 0..count {
            let part = Model { effects: model_fitted.effects[..effects].to_vec(), ..model_fitted.clone() };
            steps.push(Fitted::new(evidence, (name(effects), &part), library, order)?);
            done(&name(effects));
        }
        steps.push(whole);
        Ok(Self { order, model: model_fitted, start, steps })
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
