//! Errors of files.

use std::io;
use std::path::{Path, PathBuf};

use thiserror::Error;

use crate::input::InputError;

/// The program was called wrongly: exit code 2, where failed work is exit code 1.
#[derive(Debug, Error)]
#[error("{0}")]
pub struct WrongUse(pub String);

/// The reason why a file or folder cannot be read or written.
#[derive(Debug, Error)]
pub enum FileError {
    /// The place asked for is taken, or can hold no output.
    #[error("{0}")]
    WrongUse(#[from] WrongUse),
    /// The file system refuses.
    #[error("{}: {action}", place.display())]
    Io {
        /// The file or folder.
        place: PathBuf,
        /// In words, such as `cannot write this file`.
        action: &'static str,
        /// The error of the operating system.
        source: io::Error,
    },
    /// The place has no name, or another run writes it.
    #[error("{}: {reason}", place.display())]
    Refused {
        /// The file or folder.
        place: PathBuf,
        /// In words.
        reason: &'static str,
    },
    /// The input cannot be read.
    #[error(transparent)]
    Input(#[from] InputError),
    /// The content is not what it should be.
    #[error("{}: not {what}: {found}", place.display())]
    Content {
        /// The file.
        place: PathBuf,
        /// In words, such as `the record of an image`.
        what: String,
        /// The type and place of what was found, without its content.
        found: String,
    },
    /// A value has no form in the file's format.
    #[error("{}: cannot be written as text", place.display())]
    Encoding {
        /// The file.
        place: PathBuf,
        /// The error of the writer.
        source: Box<dyn std::error::Error + Send + Sync>,
    },
}

impl FileError {
    /// Makes an error of the file system from its source.
    pub fn at(place: &Path, action: &'static str) -> impl FnOnce(io::Error) -> Self {
        let place = place.to_owned();
        move |source| Self::Io { place, action, source }
    }

    /// Makes an error of a value that has no form in the file's format.
    pub fn encoding<E: std::error::Error + Send + Sync + 'static>(place: &Path) -> impl FnOnce(E) -> Self {
        let place = place.to_owned();
        move |source| Self::Encoding { place, source: source.into() }
    }

    pub(crate) fn refused(place: &Path, reason: &'static str) -> Self {
        Self::Refused { place: place.to_owned(), reason }
    }
}

/// Wrong use, in these words.
pub(crate) fn wrong_use(message: String) -> FileError {
    WrongUse(message).into()
}
