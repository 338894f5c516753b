//! The identity of a model among the inputs of a result.

use std::collections::BTreeMap;

use effects::CompiledModel;
use files::sha256;

/// All that a result depends on: each input by name, with its value or its SHA-256.
pub type Origin = BTreeMap<String, String>;

/// The inputs that a model contributes: its process, every parameter, and the formulas of every law and effect.
pub fn model_origin(model: &CompiledModel) -> Origin {
    let mut origin = Origin::from([("process".to_owned(), model.process().name().to_owned())]);
    for (slot, value) in model.parameters().iter().zip(model.values()) {
        origin.insert(format!("model parameter {}", slot.name()), format!("{value:?} (SI)"));
    }
    for effect in model.effects() {
        origin.insert(format!("formulas of {}", effect.name), sha256(format!("{effect:?}").as_bytes()));
    }
    origin
}
