//! Why a virtual experiment cannot be made.

use effects::RunError;
use sdf_bake::heights::HeightsError;
use sim::{PassError, PathError};
use thiserror::Error;

/// Why an experiment cannot be made.
#[derive(Debug, Error)]
pub enum TruthError {
    /// The surface makes no part.
    #[error("{trial}: the true surface: {error}")]
    Part {
        /// Name of the trial.
        trial: String,
        /// Why.
        error: HeightsError,
    },
    /// The way of the tool makes no path.
    #[error("{trial}, pass {pass}: {error}")]
    Path {
        /// Name of the trial.
        trial: String,
        /// From 1.
        pass: usize,
        /// Why.
        error: PathError,
    },
    /// The tool comes down and meets nothing.
    #[error(
        "{trial}, pass {pass}: the tool does not meet the part: an effect holds it more than half a millimetre off"
    )]
    NoTouch {
        /// Name of the trial.
        trial: String,
        /// From 1.
        pass: usize,
    },
    /// A pass failed.
    #[error("{trial}, pass {pass}: {error}")]
    Pass {
        /// Name of the trial.
        trial: String,
        /// From 1.
        pass: usize,
        /// Why.
        error: PassError,
    },
    /// A formula of the scanner.
    #[error("{trial}, scan after pass {pass}: {error}")]
    Scan {
        /// Name of the trial.
        trial: String,
        /// From 1; 0 for the scan before.
        pass: usize,
        /// Which formula.
        error: RunError,
    },
}
