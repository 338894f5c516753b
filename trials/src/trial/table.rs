//! Text tables as programs and people write them: the separator, the decimal mark and the line ends are sniffed.

use files::input::{self, MOST_TABLE_BYTES, quoted};
use std::path::{Path, PathBuf};

use super::error::{Place, TrialError};

/// Lines looked at to tell what separates cells.
const SNIFFED_LINES: usize = 50;

/// A table's text and what was understood of it.
pub(crate) struct Table {
    file: PathBuf,
    text: Vec<u8>,
    separator: u8,
    decimal_comma: bool,
    /// What was understood, in sentences, where it is not the plain case.
    pub(crate) notes: Vec<String>,
}

/// One row of cells.
pub(crate) struct Row<'a> {
    table: &'a Table,
    record: &'a csv::ByteRecord,
    /// Line in the file, from 1.
    pub(crate) line: u64,
}

impl Table {
    /// Reads a file that must hold text.
    pub(crate) fn read(file: &Path) -> Result<Self, TrialError> {
        let bytes = input::read(file, MOST_TABLE_BYTES)?;
        Self::parse(file, bytes)
    }

    /// Understands the bytes of a file.
    pub(crate) fn parse(file: &Path, mut text: Vec<u8>) -> Result<Self, TrialError> {
        const ACCEPTED: &str = "a table in UTF-8 or ASCII is expected";
        if text.starts_with(&[0xff, 0xfe]) || text.starts_with(&[0xfe, 0xff]) {
            return Err(Place::file(file).bad("the text is UTF-16", ACCEPTED));
        }
        let mut notes = Vec::new();
        if text.starts_with(&[0xef, 0xbb, 0xbf]) {
            text.drain(..3);
        }
        if text.trim_ascii().is_empty() {
            return Err(Place::file(file).bad("the file is empty", ACCEPTED));
        }
        if let Some(at) = text.iter().position(|&c| c == 0) {
            return Err(Place::file(file).bad(format!("byte {at} is zero, which no text has"), ACCEPTED));
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
    pub(crate) fn file(&self) -> &Path {
        &self.file
    }

    /// Whether the last line is not ended, as where writing was cut short.
    pub(crate) fn ends_within_a_line(&self) -> bool {
        !self.text.ends_with(b"\n") && !self.text.ends_with(b"\r")
    }

    /// Calls `each` with every row that is not empty, in order, until it answers false.
    pub(crate) fn rows(&self, mut each: impl FnMut(&Row) -> Result<bool, TrialError>) -> Result<(), TrialError> {
        let mut reader = csv::ReaderBuilder::new()
            .delimiter(self.separator)
            .has_headers(false)
            .flexible(true)
            .from_reader(self.text.as_slice());
        let mut record = csv::ByteRecord::new();
        loop {
            let more = reader
                .read_byte_record(&mut record)
                .map_err(|error| Place::file(&self.file).bad(error.to_string(), "a table of cells is expected"))?;
            if !more {
                return Ok(());
            }
            let line = record.position().map_or(0, |position| self.line_of(position));
            if !each(&Row { table: self, record: &record, line })? {
                return Ok(());
            }
        }
    }
}

impl Table {
    /// The line of a row: a reader that was left between CR and LF stands before the ends of lines that come first.
    fn line_of(&self, position: &csv::Position) -> u64 {
        let rest = &self.text[(position.byte() as usize).min(self.text.len())..];
        let ends = rest.iter().take_while(|c| b"\r\n".contains(c)).filter(|&&c| c == b'\n').count();
        position.line() + ends as u64
    }
}

/// Separator, and whether decimals are written with commas.
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

impl Row<'_> {
    /// Number of cells.
    pub(crate) fn len(&self) -> usize {
        self.record.len()
    }

    /// A cell's bytes without blanks around them; empty beyond the row.
    pub(crate) fn cell(&self, column: usize) -> &[u8] {
        self.record.get(column).unwrap_or_default().trim_ascii()
    }

    /// A cell as text for people, shortened.
    pub(crate) fn text(&self, column: usize) -> String {
        String::from_utf8_lossy(self.cell(column)).chars().take(40).collect()
    }

    /// As much of a cell as an error may repeat.
    pub(crate) fn shown(&self, column: usize) -> String {
        quoted(&String::from_utf8_lossy(self.cell(column)))
    }

    /// The number in a cell, `None` if the cell is empty. Words for "not a number" give NaN.
    pub(crate) fn number(&self, column: usize) -> Result<Option<f64>, TrialError> {
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
            let found = format!("{} is no number", self.shown(column));
            self.place(column).bad(found, "a number with a decimal point, or an empty cell where nothing was measured")
        })
    }

    /// Place of a cell.
    pub(crate) fn place(&self, column: usize) -> Place {
        Place::cell(&self.table.file, self.line, column + 1)
    }
}
