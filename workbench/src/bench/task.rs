//! Tasks that the page may send to a bench.

use serde::Deserialize;

/// A task; its JSON has its name under `task`.
#[derive(Clone, Debug, PartialEq, Deserialize)]
#[serde(tag = "task", rename_all = "kebab-case", deny_unknown_fields)]
pub(crate) enum Task {
    /// Adds an effect of the library to the model and fits all parameters.
    Add {
        /// Name of the effect.
        effect: String,
    },
    /// Removes an effect from the model and fits the rest.
    Remove {
        /// Name of the effect.
        effect: String,
    },
    /// Adds an effect from a formula.
    Formula {
        /// Formula in the syntax of `robofin try`.
        line: String,
    },
    /// Fixes a parameter at a value; the others are predicted.
    Hold {
        /// Name of the parameter with its owner.
        parameter: String,
        /// Value in the displayed unit.
        value: f64,
    },
    /// Makes a model with the parameter fixed, and fits the others completely.
    Keep {
        /// Name of the parameter.
        parameter: String,
        /// Value in the displayed unit.
        value: f64,
    },
    /// Searches the library for effects that the model lacks.
    Search,
    /// Goes to the previous model of the undo history.
    Undo,
    /// Goes to the next model of the undo history.
    Redo,
    /// Goes to a model by its number.
    GoTo {
        /// Number of the model.
        number: usize,
    },
    /// Stops the running task.
    Cancel,
    /// Simulates the current model if it is not simulated yet.
    Renew,
}
