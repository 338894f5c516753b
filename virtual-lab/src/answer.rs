//! Answer to a virtual experiment: the true law, the hidden effects, and the true results.

use std::collections::BTreeMap;

use effects::{CompiledModel, Kind, Library, ParameterSlot};
use serde::{Deserialize, Serialize};

/// Value of the answer's `format` key.
pub const ANSWER_FORMAT: &str = "robofin-answer/1";

/// A parameter with one value, or one for each pass or scan of the campaign.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Quantity {
    /// Values in `unit`, as text because JSON cannot hold all of them.
    pub values: Vec<String>,
    /// Unit.
    pub unit: String,
}

/// A hidden effect.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct HiddenEffect {
    /// Its name.
    pub name: String,
    /// True if the built-in library contains it, so that a diagnosis could name it.
    pub in_library: bool,
    /// Its parameters by name.
    pub parameters: BTreeMap<String, Quantity>,
}

/// True results of a trial.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct TrueTrial {
    /// Volume that Eq. (1) removes in each pass [mm³]; empty when sanding. Older answers call it `removed_mm3`.
    #[serde(default, alias = "removed_mm3", skip_serializing_if = "Vec::is_empty")]
    pub removed_by_law_mm3: Vec<f64>,
    /// Share of the scanned area whose coating is gone after each pass; empty when grinding.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub exposed_share: Vec<f64>,
}

/// The answer to a virtual experiment.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Answer {
    /// [`ANSWER_FORMAT`].
    pub format: String,
    /// Version of the program that made it.
    pub version: String,
    /// Seed of the experiment.
    pub seed: u64,
    /// The base law by `law.parameter`.
    pub base: BTreeMap<String, Quantity>,
    /// The hidden effects in the order in which they act; empty if nothing is missing.
    pub effects: Vec<HiddenEffect>,
    /// The true model as the text of a model file.
    pub model: String,
    /// True results, by trial.
    pub trials: BTreeMap<String, TrueTrial>,
}

impl Answer {
    /// The answer for a true model.
    pub(super) fn of(model: &CompiledModel, seed: u64, trials: BTreeMap<String, TrueTrial>) -> Self {
        let laws = model.parameters().iter().filter(|slot| slot.is_law);
        let base = laws.map(|slot| (format!("{}.{}", slot.owner, slot.parameter), quantity(model, slot))).collect();
        Self {
            format: ANSWER_FORMAT.to_owned(),
            version: env!("CARGO_PKG_VERSION").to_owned(),
            seed,
            base,
            effects: hidden(model),
            model: model_text(model),
            trials,
        }
    }
}

/// The effects of a model in the order in which they act.
pub(super) fn hidden(model: &CompiledModel) -> Vec<HiddenEffect> {
    let effects = model.effects().filter(|effect| effect.kind == Kind::Effect);
    let hidden = effects.map(|effect| {
        let own = model.parameters().iter().filter(|slot| slot.owner == effect.name);
        HiddenEffect {
            name: effect.name.clone(),
            in_library: Library::builtin().find(&effect.name).is_some(),
            parameters: own.map(|slot| (slot.parameter.clone(), quantity(model, slot))).collect(),
        }
    });
    hidden.collect()
}

/// All values of a parameter, given by any of its slots.
fn quantity(model: &CompiledModel, slot: &ParameterSlot) -> Quantity {
    let same = |other: &ParameterSlot| (&other.owner, &other.parameter) == (&slot.owner, &slot.parameter);
    let all = model.parameters().iter().zip(model.values()).filter(|(other, _)| same(other));
    let values = all.map(|(other, &value)| significant(other.unit.from_si(value)).to_string()).collect();
    Quantity { values, unit: slot.unit_text.clone() }
}

/// Rounds to twelve digits, which survive the conversion to SI units and back.
fn significant(value: f64) -> f64 {
    format!("{value:.11e}").parse().unwrap_or(value)
}

/// Text of a model file with every parameter.
fn model_text(model: &CompiledModel) -> String {
    let mut text = format!("process = \"{}\"\n", model.process().name());
    let mut section = String::new();
    for slot in model.parameters().iter().filter(|slot| slot.row.is_none_or(|row| row == 0)) {
        let kind = if slot.is_law { "law" } else { "effect" };
        let head = format!("\n[{kind}.{}]\n", slot.owner);
        if head != section {
            text += &head;
            section = head;
        }
        let Quantity { values, unit } = quantity(model, slot);
        let value = |value: &String| match (value.as_str(), unit.as_str()) {
            ("inf" | "-inf" | "0", _) | (_, "1") => value.clone(),
            _ => format!("\"{value} {unit}\""),
        };
        let values: Vec<String> = values.iter().map(value).collect();
        text += &match (slot.row, values.as_slice()) {
            (None, [one]) => format!("{} = {one}\n", slot.parameter),
            _ => format!("{} = [{}]\n", slot.parameter, values.join(", ")),
        };
    }
    text
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_older_answer_keeps_its_volumes() {
        let read: TrueTrial = serde_json::from_str("{\"removed_mm3\": [1.5, 2.0]}").expect("an answer");
        assert_eq!(read.removed_by_law_mm3, [1.5, 2.0]);
    }
}
