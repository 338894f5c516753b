//! Errors of reading a file, with their place.

use std::fmt;
use std::path::{Path, PathBuf};

use files::input::InputError;
use thiserror::Error;

/// A place in a file.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Place {
    /// The file.
    pub file: PathBuf,
    /// Line, from 1.
    pub line: Option<u64>,
    /// Column, from 1: a cell in tables, a character elsewhere.
    pub column: Option<u64>,
}

/// Error of a file that cannot be read.
#[derive(Debug, Error)]
pub enum Misread {
    /// Not a regular file, or too large.
    #[error(transparent)]
    Input(#[from] InputError),
    /// The content does not follow the format.
    #[error("{place}: {found}; {accepted}")]
    Bad {
        /// Place in the file.
        place: Place,
        /// The content at that place, quoted as far as an error message allows.
        found: String,
        /// The content that is accepted.
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

    /// An error at this place, as the caller's error type: the content found and the content accepted.
    pub fn bad<E: From<Misread>>(self, found: impl Into<String>, accepted: impl Into<String>) -> E {
        Misread::Bad { place: self, found: found.into(), accepted: accepted.into() }.into()
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
