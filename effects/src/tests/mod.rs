//! Tests of the language, its checks, the library and the programs, each against an independent reference.

mod documents;
mod evaluate;
mod files;
mod formulas;
mod library;
mod messages;
mod states;

use super::{CompiledModel, Library, Model, RowCounts};

/// A model of the built-in library, compiled.
fn compiled(model: &Model) -> CompiledModel {
    CompiledModel::new(model, Library::builtin(), RowCounts::default()).unwrap()
}

/// An effect file with one line of `[modify]` and a parameter `amount` [1] with null 0.
fn effect_file(modify: &str, more: &str) -> String {
    format!(
        "name = \"trial\"\ntitle = \"Trial\"\nsource = \"none\"\n\n[parameters.amount]\nunit = \"1\"\nnull = 0.0\n\
         range = [-1.0, 1.0]\n{more}\n[modify]\n{modify}\n"
    )
}
