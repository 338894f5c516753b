//! What the page may ask of a bench.

use serde::Deserialize;

/// A task; its JSON has its name under `task`.
#[derive(Clone, Debug, PartialEq, Deserialize)]
#[serde(tag = "task", rename_all = "kebab-case", deny_unknown_fields)]
pub(crate) enum Task {
    /// Adds an effect of the library to the model and fits all of it.
    Add {
        /// Its name.
        effect: String,
    },
    /// Takes an effect out of the model and fits the rest.
    Remove {
        /// Its name.
        effect: String,
    },
    /// Adds an effect from a formula.
    Formula {
        /// The formula, as `robofin try` takes it.
        line: String,
    },
    /// Holds a parameter at a value; the others follow.
    Hold {
        /// Its name with its owner.
        parameter: String,
        /// In the unit that is shown.
        value: f64,
    },
    /// Makes a model of what is held, and fits the others to the end.
    Keep {
        /// Name of the parameter.
        parameter: String,
        /// In the unit that is shown.
        value: f64,
    },
    /// Searches the library for what the model lacks.
    Search,
    /// Goes to the model before.
    Undo,
    /// Goes to the model after.
    Redo,
    /// Goes to a model.
    GoTo {
        /// Its number.
        number: usize,
    },
    /// Ends what is under way.
    Cancel,
    /// Makes sure that the current model is simulated.
    Renew,
}
