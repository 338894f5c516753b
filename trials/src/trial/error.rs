//! Why a trial cannot be read, and where in which file.

use std::fmt;
use std::path::{Path, PathBuf};

use files::input::InputError;
use thiserror::Error;

/// The check that a file's content alone fails.
const CONTENT: &str = "content";

/// A place in a file.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Place {
    /// The file.
    pub file: PathBuf,
    /// Line, from 1.
    pub line: Option<u64>,
    /// Column, from 1: of cells in a table, of characters elsewhere.
    pub column: Option<u64>,
}

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
        /// What was found there.
        found: String,
        /// What would do.
        accepted: String,
    },
}

impl Place {
    /// A whole file.
    pub fn file(file: &Path) -> Self {
        Self { file: file.to_owned(), ..Self::default() }
    }

    /// A line of a file, from 1.
    pub fn line(file: &Path, line: u64) -> Self {
        Self { line: Some(line), ..Self::file(file) }
    }

    /// A column of a line, both from 1.
    pub fn cell(file: &Path, line: u64, column: usize) -> Self {
        Self { column: Some(column as u64), ..Self::line(file, line) }
    }

    /// The place of a byte of a file's text.
    pub fn of_byte(file: &Path, text: &str, byte: usize) -> Self {
        let before = &text.as_bytes()[..byte.min(text.len())];
        let line = 1 + before.iter().filter(|&&c| c == b'\n').count();
        let start = before.iter().rposition(|&c| c == b'\n').map_or(0, |at| at + 1);
        Self::cell(file, line as u64, 1 + String::from_utf8_lossy(&before[start..]).chars().count())
    }

    /// The same file at another line.
    pub fn at_line(self, line: u64) -> Self {
        Self { line: Some(line), column: None, ..self }
    }

    /// The error that something else was expected here.
    pub fn bad(self, found: impl Into<String>, accepted: impl Into<String>) -> TrialError {
        TrialError::Bad { check: CONTENT, place: self, found: found.into(), accepted: accepted.into() }
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

impl fmt::Display for Place {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}", self.file.display())?;
        if let Some(line) = self.line {
            write!(f, ", line {line}")?;
        }
        if let Some(column) = self.column {
            write!(f, ", column {column}")?;
        }
        Ok(())
    }
}
