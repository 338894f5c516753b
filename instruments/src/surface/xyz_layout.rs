//! Detection of the columns, units and separators of a list of points from its first lines.

use super::numbers::Numbers;
use super::{Source, unit};

/// Maximum number of header lines.
const MOST_HEADER: usize = 100;
/// Number of point lines for detection.
const SAMPLE: usize = 50;
/// Minimum number of points of a list.
const FEWEST: usize = 4;

/// The separator of the cells of a line.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Separator {
    Byte(u8),
    /// Any number of spaces, also around a comma.
    Blanks,
}

/// Columns, separator and units of a list.
#[derive(Debug)]
pub(super) struct Layout {
    separator: Separator,
    /// True if decimals are written with commas.
    pub(super) decimal_comma: bool,
    /// Columns of x, y and z, from 0.
    pub(super) columns: [usize; 3],
    /// SI value of the units of x, y and z [m], if the header states them.
    pub(super) units: [Option<f64>; 3],
    /// Offset of the first point [bytes], and number of lines before it.
    pub(super) start: usize,
    pub(super) lines_before: u64,
}

impl Layout {
    /// The layout of a file; `None` if it is not a list of points.
    ///
    /// A list has three columns, or a header that names x, y and z, or the extension `.xyz`.
    pub(super) fn of(source: &Source) -> Option<Self> {
        let text = source.bytes.strip_prefix(b"\xef\xbb\xbf").unwrap_or(source.bytes);
        let mark = source.bytes.len() - text.len();
        let (header, start) = header_of(text);
        let sample = || {
            let lines = text.get(start..).unwrap_or_default().split(|&c| c == b'\n').map(<[u8]>::trim_ascii);
            lines.filter(|row| !row.is_empty() && !Self::is_comment(row)).take(SAMPLE)
        };
        let first = sample().next()?;
        let separator = Separator::of(first);
        let width = separator.cells(first).count();
        let is_list = sample().count() >= FEWEST
            && sample().all(|row| separator.is_point(row) && separator.cells(row).count() == width);
        let named = header.iter().rev().find_map(|line| columns_of(line));
        let has_extension = source.file.extension().is_some_and(|own| own.eq_ignore_ascii_case("xyz"));
        let columns = named.or_else(|| (width == 3 || has_extension).then_some([0, 1, 2]))?;
        if !is_list || columns.iter().any(|&column| column >= width) || text[..start.min(text.len())].contains(&0) {
            return None;
        }
        // Most lines have a position; otherwise this is a grid of three columns with empty cells.
        let is_placed = |row: &[u8]| columns[..2].iter().all(|&column| separator.is_finite(row, column));
        if 2 * sample().filter(|row| is_placed(row)).count() < sample().count() {
            return None;
        }
        let decimal_comma =
            separator.has_decimal_commas(first) || sample().any(|row| separator.has_decimal_commas(row));
        let lines_before = header.len() as u64;
        Some(Self { separator, decimal_comma, columns, units: units_of(&header), start: start + mark, lines_before })
    }

    /// True if a line is a comment.
    pub(super) fn is_comment(row: &[u8]) -> bool {
        row.starts_with(b"#") || row.starts_with(b"//") || row.starts_with(b"%") || row.starts_with(b"!")
    }

    /// The cells of a line.
    pub(super) fn cells<'a>(&self, row: &'a [u8]) -> impl Iterator<Item = &'a [u8]> + use<'a> {
        self.separator.cells(row)
    }
}

/// The lines above the first point, and the offset of that point.
fn header_of(text: &[u8]) -> (Vec<String>, usize) {
    let (mut start, mut header) = (0, Vec::<String>::new());
    for line in text.split(|&c| c == b'\n').take(MOST_HEADER) {
        let row = line.trim_ascii();
        if !(row.is_empty() || Layout::is_comment(row)) {
            let is_named = header.last().is_some_and(|line| columns_of(line).is_some());
            if Separator::of(row).is_point(row) && (is_named || !is_count(row)) {
                break;
            }
        }
        header.push(String::from_utf8_lossy(row).into_owned());
        start += line.len() + 1;
    }
    (header, start)
}

impl Separator {
    fn of(row: &[u8]) -> Self {
        let blank_words = row.split(u8::is_ascii_whitespace).filter(|word| !word.is_empty());
        // "1,5 2,5 3,5" has words with a comma inside, "1, 2, 3" has none.
        let is_inside = |word: &[u8]| word.iter().position(|&c| c == b',').is_some_and(|at| at + 1 < word.len());
        if row.contains(&b';') {
            Self::Byte(b';')
        } else if row.contains(&b'\t') {
            Self::Byte(b'\t')
        } else if row.contains(&b',') && !(blank_words.clone().count() >= 3 && blank_words.clone().any(is_inside)) {
            Self::Byte(b',')
        } else {
            Self::Blanks
        }
    }

    fn cells(self, row: &[u8]) -> impl Iterator<Item = &[u8]> + use<'_> {
        let is_between = move |c: &u8| match self {
            Self::Byte(byte) => *c == byte,
            Self::Blanks => *c == b' ',
        };
        let is_kept = move |cell: &&[u8]| self != Self::Blanks || !cell.is_empty();
        row.split(is_between).filter(is_kept).map(unquoted)
    }

    /// True if a line begins with three numbers, or words for missing ones.
    fn is_point(self, row: &[u8]) -> bool {
        let mut numbers = Numbers::new(self.has_decimal_commas(row));
        let mut cells = self.cells(row);
        (0..3).all(|_| cells.next().is_some_and(|cell| numbers.number(cell).is_some()))
    }

    /// True if a cell of a line is a number.
    fn is_finite(self, row: &[u8], column: usize) -> bool {
        let mut numbers = Numbers::new(self.has_decimal_commas(row));
        self.cells(row).nth(column).and_then(|cell| numbers.number(cell)).is_some_and(f64::is_finite)
    }

    fn has_decimal_commas(self, row: &[u8]) -> bool {
        self != Self::Byte(b',') && row.contains(&b',')
    }
}

/// A cell without spaces and quotation marks.
fn unquoted(cell: &[u8]) -> &[u8] {
    let cell = cell.trim_ascii();
    cell.strip_prefix(b"\"").and_then(|cell| cell.strip_suffix(b"\"")).unwrap_or(cell)
}

/// True if a line gives the number of points.
fn is_count(row: &[u8]) -> bool {
    row.iter().all(u8::is_ascii_digit)
}

/// The names in a possible header line, without units in brackets.
fn names(line: &str) -> Vec<String> {
    let line = line.trim_start_matches(['#', '/', '%', '!', ' ']).to_lowercase();
    let mut depth = 0;
    let bare: String = line
        .chars()
        .map(|c| {
            depth += i32::from("([".contains(c));
            let shown = if depth > 0 { ' ' } else { c };
            depth -= i32::from(")]".contains(c));
            shown
        })
        .collect();
    let has_separator = bare.contains([',', ';', '\t']);
    let is_between = |c: char| if has_separator { ",;\t".contains(c) } else { c == ' ' };
    let names = bare.split(is_between).map(|name| name.trim().trim_matches('"').trim().to_owned());
    names.filter(|name| has_separator || !name.is_empty()).collect()
}

/// Columns of x, y and z from their names.
fn columns_of(line: &str) -> Option<[usize; 3]> {
    let names = names(line);
    let column = |wanted: &[&str]| {
        let is_wanted = |name: &String| {
            let stem: String = name.chars().take_while(|c| c.is_alphabetic()).collect();
            wanted.contains(&stem.as_str())
        };
        names.iter().position(is_wanted)
    };
    Some([column(&["x"])?, column(&["y"])?, column(&["z", "height", "h", "hoehe", "höhe"])?])
}

/// Units of x, y and z stated in the header lines.
fn units_of(header: &[String]) -> [Option<f64>; 3] {
    let mut units = [None; 3];
    for line in header {
        if columns_of(line).is_some() {
            let found: Vec<f64> = stated(line).collect();
            match found[..] {
                [all] => units = [Some(all); 3],
                [lateral, height] => units = [Some(lateral), Some(lateral), Some(height)],
                [x, y, z, ..] => units = [Some(x), Some(y), Some(z)],
                [] => {}
            }
            continue;
        }
        let lower = line.to_lowercase();
        let Some((key, _)) = lower.split_once([':', '=']) else { continue };
        let value = line[key.len() + 1..].trim();
        let Some(unit) = unit::metres(value).filter(|_| key.contains("unit")) else { continue };
        let is_height = ["value", "z ", "height"].iter().any(|word| key.contains(word));
        let is_lateral = ["lateral", "xy", "x,y", "x/y"].iter().any(|word| key.contains(word));
        let axes = if is_height {
            2..3
        } else if is_lateral {
            0..2
        } else {
            0..3
        };
        units[axes].fill(Some(unit));
    }
    units
}

/// Units in a line of names: in brackets, or after `_` or a space.
fn stated(line: &str) -> impl Iterator<Item = f64> {
    let is_between = |c: char| "()[],;\t _/#\"".contains(c);
    line.split(is_between).filter(|word| !word.is_empty()).filter_map(unit::metres)
}
