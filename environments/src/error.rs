//! Errors of tasks and environments.

use sim::PassError;
use thiserror::Error;

/// Reason why a task or an environment cannot be made, or cannot continue.
#[derive(Debug, Error)]
pub enum EnvironmentError {
    /// The curve is too short to follow.
    #[error("the weld's curve has {points} points over {length} mm; at least 2 points over 1 mm are accepted")]
    Curve {
        /// Number of points found.
        points: usize,
        /// Length found [mm].
        length: f64,
    },
    /// There is nothing to finish.
    #[error("{why}; a weld on smooth ground is accepted")]
    Nothing {
        /// Reason.
        why: &'static str,
    },
    /// The model lacks a parameter that is to be drawn.
    #[error("the model has no parameter `{0}` to draw; add its effect to the model")]
    Parameter(String),
    /// The range of a parameter is invalid.
    #[error("`{name}` is to be drawn from {low} to {high}; two finite values, the lesser first, are accepted")]
    Range {
        /// Name of the parameter.
        name: String,
        /// Lower bound [SI].
        low: f64,
        /// Upper bound [SI].
        high: f64,
    },
    /// An array has the wrong size.
    #[error("{name} has {found} values, and {expected} are accepted")]
    Size {
        /// Name of the array.
        name: &'static str,
        /// Size found.
        found: usize,
        /// Size expected.
        expected: usize,
    },
    /// There is no task, or no environment.
    #[error("{0}: at least one is accepted")]
    None(&'static str),
    /// The simulation failed.
    #[error("environment {environment}: {error}")]
    Pass {
        /// Number of the environment, from 0.
        environment: usize,
        /// Error of the pass.
        error: PassError,
    },
}
