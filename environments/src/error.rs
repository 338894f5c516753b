//! Errors of tasks and environments.

use sim::PassError;
use thiserror::Error;

/// Why a task or an environment cannot be made, or cannot go on.
#[derive(Debug, Error)]
pub enum EnvironmentError {
    /// A curve that cannot be followed.
    #[error("the weld's curve has {points} points over {length} mm; at least 2 points over 1 mm are accepted")]
    Curve {
        /// Points found.
        points: usize,
        /// Length found [mm].
        length: f64,
    },
    /// Nothing to finish.
    #[error("{why}; a weld on smooth ground is accepted")]
    Nothing {
        /// Value found.
        why: &'static str,
    },
    /// A parameter to be drawn that the model does not have.
    #[error("the model has no parameter `{0}` to draw; add its effect to the model")]
    Parameter(String),
    /// A range that cannot be drawn from.
    #[error("`{name}` is to be drawn from {low} to {high}; two finite values, the lesser first, are accepted")]
    Range {
        /// The parameter.
        name: String,
        /// Least value [SI].
        low: f64,
        /// Greatest value [SI].
        high: f64,
    },
    /// An array of the wrong size.
    #[error("{name} has {found} values, and {expected} are accepted")]
    Size {
        /// Which array.
        name: &'static str,
        /// Values found.
        found: usize,
        /// Values needed.
        expected: usize,
    },
    /// No task, or no environment.
    #[error("{0}: at least one is accepted")]
    None(&'static str),
    /// The simulation failed.
    #[error("environment {environment}: {error}")]
    Pass {
        /// Its number, from 0.
        environment: usize,
        /// Why.
        error: PassError,
    },
}
