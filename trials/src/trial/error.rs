//! Why a trial cannot be read, and where in which file.

use std::path::PathBuf;

use files::input::InputError;
use instruments::Misread;
use thiserror::Error;

pub use instruments::Place;

/// The check that a file's content alone fails.
const CONTENT: &str = "content";

/// Why a file of a trial cannot be used.
#[derive(Debug, Error)]
pub enum TrialError {
    /// The file system refuses.
    #[error("{}: cannot be read", file.display())]
    Unreadable {
        /// The file or folder.
        file: PathBuf,
        /// What the file system said.
        source: std::io::Error,
    },
    /// No regular file, or one that is too large.
    #[error(transparent)]
    Input(#[from] InputError),
    /// The content is not what the format says.
    #[error("{place}: {found}; {accepted}")]
    Bad {
        /// Which check found it.
        check: &'static str,
        /// Where.
        place: Place,
        /// The content at that place, quoted as far as an error may.
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
    /// The same as found by a check.
    pub(super) fn by(self, name: &'static str) -> Self {
        match self {
            Self::Bad { place, found, accepted, .. } => Self::Bad { check: name, place, found, accepted },
            other => other,
        }
    }
}
