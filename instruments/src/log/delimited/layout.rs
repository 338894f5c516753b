//! Layout of a text: the separator of its cells, and the positions of its header and its first row.

use std::path::Path;

use super::cells::{Cell, Separator};
use super::{header, stamp};
use crate::log::text::lines;
use crate::misread::{Misread, Place};

/// Maximum number of lines for detection.
const SNIFFED: usize = 2000;
/// Maximum number of bytes of these lines.
const SNIFFED_BYTES: usize = 1 << 22;
/// Number of rows from which the kinds of the columns are detected.
const SAMPLED_ROWS: usize = 200;

/// A line that is not empty.
#[derive(Clone, Copy)]
pub(super) struct Line<'a> {
    /// Line number, from 1.
    pub(super) number: u64,
    pub(super) text: &'a str,
}

/// Layout of a text.
pub(super) struct Layout<'a> {
    pub(super) separator: Separator,
    /// Number of cells in a row.
    pub(super) count: usize,
    /// Line of the first row, from 1.
    pub(super) first: u64,
    /// Some rows, from the first on, for detecting the kinds of the columns.
    pub(super) sample: Vec<Line<'a>>,
    /// Names of the columns, and units from a line of their own.
    pub(super) header: header::Header,
}

/// Result of a trial separator: share of numbers among the cells.
struct Fit {
    separator: Separator,
    count: usize,
    score: f64,
}

/// True for a comment; a line beginning with `;` is a comment unless semicolons separate cells.
pub(super) fn is_comment(line: &str, separator: Separator) -> bool {
    let line = line.trim_start();
    let is_semicolon = separator != Separator::Semicolon && line.starts_with(';');
    line.starts_with('#') || line.starts_with('%') || line.starts_with("//") || is_semicolon
}

/// Detects the layout from the first lines of a text.
pub(super) fn sniff<'a>(file: &Path, text: &'a str) -> Result<Layout<'a>, Misread> {
    let all = lines(text).map(|(number, text)| Line { number, text });
    let mut bytes = 0;
    let fits = |line: &Line| {
        let is_first = bytes == 0;
        bytes += line.text.len();
        is_first || bytes <= SNIFFED_BYTES
    };
    let sample: Vec<Line> = all.filter(|line| !line.text.trim().is_empty()).take(SNIFFED).take_while(fits).collect();
    let fits = Separator::ALL.into_iter().map(|separator| fit(separator, &sample));
    let best = fits.reduce(|best, next| if next.score > best.score { next } else { best });
    let nothing = || {
        Place::file(file).bad::<Misread>("no row of numbers", "a table of numbers with or without a header is expected")
    };
    let Fit { separator, count, .. } = best.filter(|fit| fit.score > 0.0).ok_or_else(nothing)?;
    let first = first_row(separator, count, &sample).ok_or_else(nothing)?;
    let header = header::find(file, (separator, count), &sample[..first], &sample[first..])?;
    let is_row = |line: &&Line| !is_comment(line.text, separator);
    let rows = sample[first..].iter().filter(is_row).take(SAMPLED_ROWS).copied().collect();
    Ok(Layout { separator, count, first: sample[first].number, sample: rows, header })
}

/// Number of non-empty cells of a line, and number of those that are a number or a time.
pub(super) fn tally(separator: Separator, cells: &[&str]) -> (usize, usize) {
    let kinds = || cells.iter().map(|cell| (separator.cell(cell), cell));
    let filled = kinds().filter(|(kind, _)| *kind != Cell::Empty).count();
    let is_data = |(kind, cell): &(Cell, &&str)| matches!(kind, Cell::Number(_)) || stamp::may_be(cell);
    (filled, kinds().filter(is_data).count())
}

/// Number of cells per row that gives the most numbers with this separator.
fn fit(separator: Separator, sample: &[Line]) -> Fit {
    let mut scores: Vec<(usize, f64)> = Vec::new();
    let mut cells = Vec::new();
    for line in sample.iter().filter(|line| !is_comment(line.text, separator)) {
        separator.split(line.text, &mut cells);
        let (filled, data) = tally(separator, &cells);
        let score = if filled == 0 { 0.0 } else { (data * data) as f64 / filled as f64 };
        match scores.iter_mut().find(|(count, _)| *count == cells.len()) {
            Some((_, sum)) => *sum += score,
            None => scores.push((cells.len(), score)),
        }
    }
    let best = scores.into_iter().reduce(|best, next| if next.1 > best.1 { next } else { best });
    let (count, score) = best.unwrap_or((0, 0.0));
    Fit { separator, count, score }
}

/// Index of the first line with as many numbers as most rows have.
fn first_row(separator: Separator, count: usize, sample: &[Line]) -> Option<usize> {
    let mut cells = Vec::new();
    let mut rows = Vec::new();
    for (at, line) in sample.iter().enumerate().filter(|(_, line)| !is_comment(line.text, separator)) {
        separator.split(line.text, &mut cells);
        let (filled, data) = tally(separator, &cells);
        if cells.len() == count && data > 0 {
            rows.push((at, data, count - filled));
        }
    }
    let mut numbers: Vec<usize> = rows.iter().map(|(_, data, empty)| data + empty).collect();
    numbers.sort_unstable();
    let typical = *numbers.get(numbers.len() / 2)?;
    rows.into_iter().find(|(_, data, empty)| data + empty >= typical).map(|(at, ..)| at)
}
