//! Errors of the laboratory.

use effects::{EffectError, ModelError};
use files::FileError;
use files::input::InputError;
use thiserror::Error;
use trials::trial::TrialError;

use crate::evidence::EvidenceError;

/// The result of work in the laboratory.
pub type Result<T, E = LabError> = std::result::Result<T, E>;

/// Reason for which the laboratory has no result.
#[derive(Debug, Error)]
pub enum LabError {
    /// The library does not know a model.
    #[error(transparent)]
    Model(#[from] ModelError),
    /// A model cannot be compiled.
    #[error(transparent)]
    Effect(#[from] EffectError),
    /// A model cannot be simulated, or the data cannot be used.
    #[error(transparent)]
    Evidence(#[from] EvidenceError),
    /// A campaign or a table is faulty.
    #[error(transparent)]
    Trial(#[from] TrialError),
    /// A file cannot be read or written.
    #[error(transparent)]
    File(#[from] FileError),
    /// A result cannot be written as JSON.
    #[error("the answer cannot be written as JSON")]
    Json(#[from] serde_json::Error),
    /// A folder cannot be listed.
    #[error(transparent)]
    Folder(#[from] walkdir::Error),
    /// The data or the model do not allow a request.
    #[error("{0}")]
    Refused(String),
}

impl From<InputError> for LabError {
    fn from(error: InputError) -> Self {
        Self::File(error.into())
    }
}
