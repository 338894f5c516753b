//! Delimited text: rows of cells below a header, as written by programs and spreadsheets.
//!
//! One line is one row; line breaks within quotes are not supported.

mod cells;
mod column;
mod header;
mod layout;
mod stamp;

use std::path::Path;

use self::cells::Separator;
use self::column::Column;
use self::layout::{Layout, is_comment, sniff};
use super::text::{check_lines, decode, lines};
use super::{Channels, Format, check_size};
use crate::misread::{Misread, Place};

/// Delimited text.
pub(super) struct Delimited;

impl Format for Delimited {
    fn name(&self) -> &'static str {
        "delimited text"
    }

    fn recognises(&self, _bytes: &[u8]) -> bool {
        true
    }

    fn read(&self, file: &Path, bytes: &[u8]) -> Result<Channels, Misread> {
        let (text, notes) = decode(file, bytes)?;
        read(file, &text, notes)
    }
}

/// Reads a text; `notes` are those on its encoding.
pub(super) fn read(file: &Path, text: &str, mut notes: Vec<String>) -> Result<Channels, Misread> {
    check_lines(file, text)?;
    let layout = sniff(file, text)?;
    if layout.separator != Separator::Comma {
        notes.push(format!("cells are separated by {}", layout.separator.name()));
    }
    notes.extend(layout.header.notes.iter().cloned());
    let mut rows = Rows::new(file, &layout)?;
    rows.notes = notes;
    rows.read(text, &layout)?;
    rows.finish()
}

/// State of the rows while they are read.
struct Rows<'a> {
    file: &'a Path,
    columns: Vec<Column>,
    lines: Vec<u64>,
    /// Line and number of cells of a truncated row.
    cut: Option<(u64, usize)>,
    comments: usize,
    notes: Vec<String>,
}

impl<'a> Rows<'a> {
    fn new(file: &'a Path, layout: &Layout) -> Result<Self, Misread> {
        check_size(Place::line(file, layout.first), layout.count, 1)?;
        let columns = Column::all(layout);
        Ok(Self { file, columns, lines: Vec::new(), cut: None, comments: 0, notes: Vec::new() })
    }

    fn read(&mut self, text: &str, layout: &Layout) -> Result<(), Misread> {
        let mut cells = Vec::new();
        let below = lines(text).skip_while(|(number, _)| *number < layout.first);
        for (number, line) in below.filter(|(_, line)| !line.trim().is_empty()) {
            if is_comment(line, layout.separator) {
                self.comments += 1;
                continue;
            }
            layout.separator.split(line, &mut cells);
            // A separator may close the line.
            if cells.len() == self.columns.len() + 1 && cells.last() == Some(&"") {
                cells.pop();
            }
            self.push(number, &cells, layout.separator)?;
        }
        match self.cut {
            Some((line, found)) if text.ends_with(['\n', '\r']) => Err(self.wrong_count(line, found)),
            Some((line, found)) => {
                self.notes.push(format!("line {line} is cut short after {found} cells and left out"));
                Ok(())
            }
            None => Ok(()),
        }
    }

    fn push(&mut self, line: u64, cells: &[&str], separator: Separator) -> Result<(), Misread> {
        if let Some((line, found)) = self.cut {
            return Err(self.wrong_count(line, found));
        }
        if cells.len() > self.columns.len() {
            return Err(self.wrong_count(line, cells.len()));
        }
        if cells.len() < self.columns.len() {
            self.cut = Some((line, cells.len()));
            return Ok(());
        }
        check_size(Place::line(self.file, line), self.columns.len(), self.lines.len() + 1)?;
        for (k, (column, cell)) in self.columns.iter_mut().zip(cells).enumerate() {
            let place = || Place::cell(self.file, line, k + 1);
            column.push(cell, separator).map_err(|(found, accepted)| place().bad::<Misread>(found, accepted))?;
        }
        self.lines.push(line);
        Ok(())
    }

    fn wrong_count(&self, line: u64, found: usize) -> Misread {
        let count = self.columns.len();
        Place::line(self.file, line)
            .bad(format!("{found} cells where the other rows have {count}"), "as many cells in every row are expected")
    }

    fn finish(mut self) -> Result<Channels, Misread> {
        if self.comments > 0 {
            self.notes.push(format!("{} comments among the rows are left out", self.comments));
        }
        column::check_marks((self.file, &self.lines), &self.columns, &mut self.notes)?;
        let mut channels =
            Channels { format: Delimited.name(), lines: self.lines, notes: self.notes, ..Channels::default() };
        column::finish(self.columns, &mut channels);
        if channels.names.is_empty() {
            return Err(Place::file(self.file).bad("no column of numbers", "a log with columns of numbers is expected"));
        }
        Ok(channels)
    }
}
