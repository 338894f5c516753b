//! Errors of reading a trial, with their place in the file.

use std::path::PathBuf;

use files::input::InputError;
use instruments::Misread;
use thiserror::Error;

pub use instruments::Place;

/// Check name for errors in a single file's content.
const CONTENT: &str = "content";

/// Error of a file of a trial that cannot be used.
#[derive(Debug, Error)]
pub enum TrialError {
    /// The file or folder cannot be read.
    #[error("{}: cannot be read", file.display())]
    Unreadable {
        /// The file or folder.
        file: PathBuf,
        /// The error of the file system.
        source: std::io::Error,
    },
    /// Not a regular file, or too large.
    #[error(transparent)]
    Input(#[from] InputError),
    /// The content does not follow the format.
    #[error("{place}: {found}; {accepted}")]
    Bad {
        /// Name of the check that found it.
        check: &'static str,
        /// Place in the file.
        place: Place,
        /// The content at that place, quoted as far as an error message allows.
        found: String,
        /// The content that is accepted.
        accepted: String,
    },
}

impl From<Misread> for TrialError {
    fn from(error: Misread) -> Self {
        match error {
            Misread::Input(error) => Self::Input(error),
            Misread::Bad { place, found, accepted } => Self::Bad { check: CONTENT, place, found, accepted },
        }
    }
}

impl TrialError {
    /// The same error, attributed to a check.
    pub(super) fn by(self, name: &'static str) -> Self {
        match self {
            Self::Bad { place, found, accepted, .. } => Self::Bad { check: name, place, found, accepted },
            other => other,
        }
    }
}
