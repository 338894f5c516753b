//! Errors of files.

use std::io;
use std::path::{Path, PathBuf};

use thiserror::Error;

use crate::input::InputError;

/// Wrong usage of the program: exit code 2; failed work is exit code 1.
#[derive(Debug, Error)]
#[error("{0}")]
pub struct WrongUse(pub String);

/// Error of reading or writing a file or folder.
#[derive(Debug, Error)]
pub enum FileError {
    /// The requested path is occupied, or can hold no output.
    #[error("{0}")]
    WrongUse(#[from] WrongUse),
    /// An operation of the file system failed.
    #[error("{}: {action}", place.display())]
    Io {
        /// The file or folder.
        place: PathBuf,
        /// The operation in words, such as `cannot write this file`.
        action: &'static str,
        /// The error of the operating system.
        source: io::Error,
    },
    /// The path has no name, or another run is writing it.
    #[error("{}: {reason}", place.display())]
    Refused {
        /// The file or folder.
        place: PathBuf,
        /// The reason in words.
        reason: &'static str,
    },
    /// The input cannot be read.
    #[error(transparent)]
    Input(#[from] InputError),
    /// The content is not of the expected type.
    #[error("{}: not {what}: {found}", place.display())]
    Content {
        /// The file.
        place: PathBuf,
        /// Expected content in words, such as `the record of an image`.
        what: String,
        /// Type and place of the content found, without repeating it.
        found: String,
    },
    /// A value cannot be represented in the file's format.
    #[error("{}: cannot be written as text", place.display())]
    Encoding {
        /// The file.
        place: PathBuf,
        /// The error of the writer.
        source: Box<dyn std::error::Error + Send + Sync>,
    },
}

impl FileError {
    /// Wraps an error of the operating system.
    pub fn at(place: &Path, action: &'static str) -> impl FnOnce(io::Error) -> Self {
        let place = place.to_owned();
        move |source| Self::Io { place, action, source }
    }

    /// Wraps an error of a value that cannot be represented in the file's format.
    pub fn encoding<E: std::error::Error + Send + Sync + 'static>(place: &Path) -> impl FnOnce(E) -> Self {
        let place = place.to_owned();
        move |source| Self::Encoding { place, source: source.into() }
    }

    pub(crate) fn refused(place: &Path, reason: &'static str) -> Self {
        Self::Refused { place: place.to_owned(), reason }
    }
}

/// An error of wrong usage with this message.
pub(crate) fn wrong_use(message: String) -> FileError {
    WrongUse(message).into()
}
