//! Errors of making a virtual experiment.

use effects::RunError;
use sdf_bake::heights::HeightsError;
use sim::{PassError, PathError};
use thiserror::Error;

/// Reason for which an experiment cannot be made.
#[derive(Debug, Error)]
pub enum ExperimentError {
    /// The surface makes no part.
    #[error("{trial}: the true surface: {error}")]
    Part {
        /// Name of the trial.
        trial: String,
        /// Cause.
        error: HeightsError,
    },
    /// The route of the tool makes no path.
    #[error("{trial}, pass {pass}: {error}")]
    Path {
        /// Name of the trial.
        trial: String,
        /// Number of the pass, from 1.
        pass: usize,
        /// Cause.
        error: PathError,
    },
    /// The tool descends and meets nothing.
    #[error(
        "{trial}, pass {pass}: the tool does not meet the part: an effect holds it more than half a millimetre off"
    )]
    NoTouch {
        /// Name of the trial.
        trial: String,
        /// Number of the pass, from 1.
        pass: usize,
    },
    /// A pass failed.
    #[error("{trial}, pass {pass}: {error}")]
    Pass {
        /// Name of the trial.
        trial: String,
        /// Number of the pass, from 1.
        pass: usize,
        /// Cause.
        error: PassError,
    },
    /// A formula of the scanner failed.
    #[error("{trial}, scan after pass {pass}: {error}")]
    Scan {
        /// Name of the trial.
        trial: String,
        /// Number of the pass, from 1; 0 for the scan before.
        pass: usize,
        /// Cause, with the formula.
        error: RunError,
    },
}
