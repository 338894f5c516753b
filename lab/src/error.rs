//! Errors of the laboratory.

use effects::{EffectError, ModelError};
use files::FileError;
use files::input::InputError;
use thiserror::Error;
use trials::trial::TrialError;

use crate::evidence::EvidenceError;

/// The result of work in the laboratory.
pub type Result<T, E = LabError> = std::result::Result<T, E>;

/// The reason why the laboratory has no answer.
#[derive(Debug, Error)]
pub enum LabError {
    /// A model that the library does not know.
    #[error(transparent)]
    Model(#[from] ModelError),
    /// A model that cannot be compiled.
    #[error(transparent)]
    Effect(#[from] EffectError),
    /// A model that cannot be simulated, or data without use.
    #[error(transparent)]
    Evidence(#[from] EvidenceError),
    /// A fault in a campaign or a table.
    #[error(transparent)]
    Trial(#[from] TrialError),
    /// A file that cannot be read or written.
    #[error(transparent)]
    File(#[from] FileError),
    /// An answer that cannot be written as JSON.
    #[error("the answer cannot be written as JSON")]
    Json(#[from] serde_json::Error),
    /// A folder that cannot be listed.
    #[error(transparent)]
    Folder(#[from] walkdir::Error),
    /// A request that the data or the model do not allow.
    #[error("{0}")]
    Refused(String),
}

impl From<InputError> for LabError {
    fn from(error: InputError) -> Self {
        Self::File(error.into())
    }
}
