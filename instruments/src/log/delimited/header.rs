//! The lines above the rows: names of columns, their units, and key lines that are ignored.

use std::path::Path;

use super::cells::Separator;
use super::layout::{Line, is_comment, tally};
use crate::log::unit;
use crate::misread::{Misread, Place};

/// Names and units of columns.
#[derive(Default)]
pub(super) struct Header {
    /// Empty if the text has none.
    pub(super) names: Vec<String>,
    /// Units from a line of their own; empty without one.
    pub(super) units: Vec<Option<String>>,
    pub(super) notes: Vec<String>,
}

/// Separator of the cells, and number of cells in a row.
type Shape = (Separator, usize);

/// Finds the names in the lines above the rows.
pub(super) fn find(file: &Path, shape: Shape, above: &[Line], rows: &[Line]) -> Result<Header, Misread> {
    let mut header = Header::default();
    let mut rest = above;
    let nearest = |lines: &[Line]| lines.last().and_then(|line| names(shape, line.text, rows));
    if let [before @ .., last] = above
        && let Some(cells) = names(shape, last.text, rows)
        && cells.iter().all(|cell| unit::is_unit_cell(cell))
        && nearest(before).is_some_and(|names| are_names(shape, &names))
    {
        header.units = cells.iter().map(|cell| unit::of_cell(cell)).collect();
        rest = before;
    }
    if let [before @ .., last] = rest {
        match names(shape, last.text, rows).filter(|names| are_names(shape, names)) {
            Some(names) => {
                header.names = names;
                rest = before;
                if is_comment(last.text, shape.0) {
                    header.notes.push(format!("the header is the comment in line {}", last.number));
                }
            }
            None => refuse_wrong_count(file, shape, last)?,
        }
    }
    header.note_others(shape, rest);
    Ok(header)
}

impl Header {
    fn note_others(&mut self, (separator, _): Shape, lines: &[Line]) {
        let keys = lines.iter().filter(|line| !is_comment(line.text, separator)).count();
        if keys > 0 {
            self.notes.push(format!("{keys} lines above the header are left out"));
        }
        if self.names.is_empty() {
            self.notes.push("there is no header: the columns are named by their number".to_owned());
        }
    }
}

/// The cells of a line, if there are as many as in a row.
fn names(shape: Shape, line: &str, rows: &[Line]) -> Option<Vec<String>> {
    let (own, count) = shape;
    let line = match is_comment(line, own) {
        true => line.trim_start().trim_start_matches(['#', '%', ';', '/']),
        false => line,
    };
    let mut cells = Vec::new();
    for separator in [own].into_iter().chain(Separator::ALL) {
        separator.split(line, &mut cells);
        if separator == Separator::Blanks && cells.len() > count {
            join_units(&mut cells, line);
        }
        if cells.len() == count + 1 && cells.last() == Some(&"") {
            cells.pop();
        }
        if cells.len() + 1 == count && ends_empty(own, rows) {
            cells.push("");
        }
        if cells.len() == count {
            return Some(cells.into_iter().map(str::to_owned).collect());
        }
    }
    None
}

/// Joins bracketed units with the names before them, as in `Fz (N)`.
fn join_units<'a>(cells: &mut Vec<&'a str>, line: &'a str) {
    let mut joined: Vec<&str> = Vec::with_capacity(cells.len());
    for &cell in cells.iter() {
        match joined.last_mut() {
            Some(last) if cell.starts_with(['[', '(']) => *last = spanning(line, last, cell),
            _ => joined.push(cell),
        }
    }
    *cells = joined;
}

/// The part of a line from the start of one cell to the end of another.
fn spanning<'a>(line: &'a str, first: &str, last: &str) -> &'a str {
    let offset = |part: &str| part.as_ptr() as usize - line.as_ptr() as usize;
    &line[offset(first)..offset(last) + last.len()]
}

/// True if every row ends with an empty cell, because a separator closes the lines.
fn ends_empty(separator: Separator, rows: &[Line]) -> bool {
    let mut cells = Vec::new();
    rows.iter().take(50).all(|row| {
        separator.split(row.text, &mut cells);
        cells.last() == Some(&"")
    })
}

/// True for names: most cells are non-empty, and only a few are numbers.
fn are_names((separator, count): Shape, names: &[String]) -> bool {
    let cells: Vec<&str> = names.iter().map(String::as_str).collect();
    let (filled, data) = tally(separator, &cells);
    2 * filled > count.min(names.len()) && 4 * data <= filled
}

/// Refuses a line of names directly above the rows with almost, but not exactly, their number of cells.
fn refuse_wrong_count(file: &Path, (separator, count): Shape, line: &Line) -> Result<(), Misread> {
    let mut cells = Vec::new();
    separator.split(line.text, &mut cells);
    let (filled, data) = tally(separator, &cells);
    let looks_like_names = data == 0 && filled > 1 && filled == cells.len() && !line.text.contains([':', '=']);
    if count > 2 && looks_like_names && cells.len().abs_diff(count) <= 2 && !is_comment(line.text, separator) {
        let found = format!("a header of {} names above rows of {count} cells", cells.len());
        return Err(Place::line(file, line.number).bad(found, "one name for each cell is expected"));
    }
    Ok(())
}
