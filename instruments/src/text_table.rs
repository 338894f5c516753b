//! Text tables of programs and people, with detection of separator, decimal mark and line ends.

use std::borrow::Cow;
use std::path::{Path, PathBuf};

use files::input::{self, MOST_TABLE_BYTES, quoted};

use crate::misread::{Misread, Place};

/// Number of lines from which the separator is detected.
const SNIFFED_LINES: usize = 50;

/// A table's text and its detected format.
pub struct TextTable<'a> {
    file: PathBuf,
    text: Cow<'a, [u8]>,
    separator: u8,
    decimal_comma: bool,
    /// Notes on the interpretation of unusual files, in sentences.
    pub notes: Vec<String>,
}

/// One row of cells.
pub struct TextRow<'a> {
    table: &'a TextTable<'a>,
    record: &'a csv::ByteRecord,
    /// Line in the file, from 1.
    pub line: u64,
}

impl TextTable<'static> {
    /// Reads a file that must hold text.
    ///
    /// # Errors
    /// [`Misread`] if it is not a text.
    pub fn read(file: &Path) -> Result<Self, Misread> {
        let bytes = input::read(file, MOST_TABLE_BYTES)?;
        Self::parse(file, bytes.into())
    }
}

impl<'a> TextTable<'a> {
    /// Detects the format of a file's bytes.
    ///
    /// # Errors
    /// [`Misread`] if they are not a text.
    pub fn parse(file: &Path, mut text: Cow<'a, [u8]>) -> Result<Self, Misread> {
        const ACCEPTED: &str = "a table in UTF-8 or ASCII is expected";
        if text.starts_with(&[0xff, 0xfe]) || text.starts_with(&[0xfe, 0xff]) {
            return Err(Place::file(file).bad("the text is UTF-16", ACCEPTED));
        }
        let mut notes = Vec::new();
        if text.starts_with(&[0xef, 0xbb, 0xbf]) {
            text = without_mark(text);
        }
        if text.trim_ascii().is_empty() {
            return Err(Place::file(file).bad("the file is empty", ACCEPTED));
        }
        if let Some(at) = text.iter().position(|&c| c == 0) {
            return Err(Place::file(file).bad(format!("byte {at} is zero, which text cannot contain"), ACCEPTED));
        }
        let (separator, decimal_comma) = sniff(&text);
        match separator {
            b';' => notes.push("cells are separated by semicolons".to_owned()),
            b'\t' => notes.push("cells are separated by tabs".to_owned()),
            _ => {}
        }
        if decimal_comma {
            notes.push("decimals are written with commas".to_owned());
        }
        Ok(Self { file: file.to_owned(), text, separator, decimal_comma, notes })
    }

    /// The file it came from.
    pub fn file(&self) -> &Path {
        &self.file
    }

    /// Returns true if the last line is not terminated, as after an interrupted write.
    pub fn ends_within_a_line(&self) -> bool {
        !self.text.ends_with(b"\n") && !self.text.ends_with(b"\r")
    }

    /// Calls `each` with every non-empty row, in order, until it returns false.
    ///
    /// # Errors
    /// [`Misread`] if the text cannot be split into rows, and the errors of `each`.
    pub fn rows<E: From<Misread>>(&self, mut each: impl FnMut(&TextRow) -> Result<bool, E>) -> Result<(), E> {
        let mut reader = csv::ReaderBuilder::new()
            .delimiter(self.separator)
            .has_headers(false)
            .flexible(true)
            .from_reader(&*self.text);
        let mut record = csv::ByteRecord::new();
        loop {
            let more = reader
                .read_byte_record(&mut record)
                .map_err(|error| Place::file(&self.file).bad::<E>(error.to_string(), "a table of cells is expected"))?;
            if !more {
                return Ok(());
            }
            let line = record.position().map_or(0, |position| self.line_of(position));
            if !each(&TextRow { table: self, record: &record, line })? {
                return Ok(());
            }
        }
    }
}

impl TextTable<'_> {
    /// Line number of a row. A reader that stopped between CR and LF is still before the following line ends.
    fn line_of(&self, position: &csv::Position) -> u64 {
        let rest = &self.text[(position.byte() as usize).min(self.text.len())..];
        let ends = rest.iter().take_while(|c| b"\r\n".contains(c)).filter(|&&c| c == b'\n').count();
        position.line() + ends as u64
    }
}

/// The text without a UTF-8 byte-order mark.
fn without_mark(text: Cow<[u8]>) -> Cow<[u8]> {
    match text {
        Cow::Borrowed(text) => Cow::Borrowed(&text[3..]),
        Cow::Owned(mut text) => {
            text.drain(..3);
            Cow::Owned(text)
        }
    }
}

/// Separator, and true if decimals are written with commas.
fn sniff(text: &[u8]) -> (u8, bool) {
    let lines = || text.split(|&c| c == b'\n').filter(|line| !line.trim_ascii().is_empty()).take(SNIFFED_LINES);
    let count = |wanted: u8| -> usize {
        let unquoted = |line: &[u8]| {
            let mut quoted = false;
            let counts = |&&c: &&u8| {
                quoted ^= c == b'"';
                c == wanted && !quoted
            };
            line.iter().filter(counts).count()
        };
        lines().map(unquoted).sum()
    };
    let separator = match (count(b';'), count(b'\t')) {
        (0, 0) => b',',
        (semicolons, tabs) if semicolons >= tabs => b';',
        _ => b'\t',
    };
    let comma_between_digits =
        |line: &[u8]| line.windows(3).any(|w| w[0].is_ascii_digit() && w[1] == b',' && w[2].is_ascii_digit());
    (separator, separator != b',' && lines().any(comma_between_digits))
}

impl TextRow<'_> {
    /// Number of cells.
    pub fn len(&self) -> usize {
        self.record.len()
    }

    /// True if there is no cell.
    pub fn is_empty(&self) -> bool {
        self.record.is_empty()
    }

    /// A cell's bytes without surrounding white space; empty beyond the row.
    pub fn cell(&self, column: usize) -> &[u8] {
        self.record.get(column).unwrap_or_default().trim_ascii()
    }

    /// A cell as shortened text for messages.
    pub fn text(&self, column: usize) -> String {
        String::from_utf8_lossy(self.cell(column)).chars().take(40).collect()
    }

    /// The part of a cell that an error may repeat.
    pub fn shown(&self, column: usize) -> String {
        quoted(&String::from_utf8_lossy(self.cell(column)))
    }

    /// The number in a cell, `None` if the cell is empty. Words for "not a number" give NaN.
    pub fn number(&self, column: usize) -> Result<Option<f64>, Misread> {
        let cell = self.cell(column);
        if cell.is_empty() {
            return Ok(None);
        }
        let parsed = match std::str::from_utf8(cell) {
            Ok(text) if self.table.decimal_comma || cell.contains(&b',') => text.replace(',', ".").parse(),
            Ok(text) => text.parse(),
            Err(_) => "?".parse(),
        };
        parsed.map(Some).map_err(|_| {
            let found = format!("{} is not a number", self.shown(column));
            self.place(column).bad(found, "a number with a decimal point, or an empty cell where nothing was measured")
        })
    }

    /// Place of a cell.
    pub fn place(&self, column: usize) -> Place {
        Place::cell(&self.table.file, self.line, column + 1)
    }
}
