//! The identity of a model among the inputs of a result.

use std::collections::BTreeMap;

use effects::CompiledModel;
use effects::page::EffectAnswer;
use files::sha256;
use serde::Serialize;

/// All inputs of a result: each by name, with its value or its SHA-256.
pub type Origin = BTreeMap<String, String>;

/// SHA-256 of a value's canonical JSON.
///
/// # Panics
/// If the value cannot be written as JSON, which is a bug of its type.
pub fn identity(value: &impl Serialize) -> String {
    sha256(&serde_json::to_vec(value).expect("a value with a form in JSON"))
}

/// The inputs that a model contributes: its process, every parameter, and the formulas of every law and effect.
pub fn model_origin(model: &CompiledModel) -> Origin {
    let mut origin = Origin::from([("process".to_owned(), model.process().name().to_owned())]);
    for (slot, value) in model.parameters().iter().zip(model.values()) {
        origin.insert(format!("model parameter {}", slot.name()), format!("{value:?} (SI)"));
    }
    for effect in model.effects() {
        origin.insert(format!("formulas of {}", effect.name), identity(&EffectAnswer::new(effect)));
    }
    origin
}
