//! Splitting of a line into cells, and parsing of numbers in them.

/// The separator between cells.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Separator {
    Tab,
    Semicolon,
    Comma,
    /// Any number of spaces or tabs.
    Blanks,
}

/// Content of a cell.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Cell {
    /// Empty, or a word for a missing value.
    Empty,
    Number(f64),
    Other,
}

/// Words for a missing value, in lower case.
const MISSING: [&str; 11] = ["nan", "n/a", "na", "#n/a", "null", "none", "-", "--", "1.#qnan", "-1.#ind", "nan(ind)"];

impl Separator {
    /// In order of preference among equally good ones.
    pub(super) const ALL: [Self; 4] = [Self::Tab, Self::Semicolon, Self::Comma, Self::Blanks];

    /// Name for messages.
    pub(super) fn name(self) -> &'static str {
        match self {
            Self::Tab => "tabs",
            Self::Semicolon => "semicolons",
            Self::Comma => "commas",
            Self::Blanks => "blanks",
        }
    }

    fn cuts(self, byte: u8) -> bool {
        match self {
            Self::Tab => byte == b'\t',
            Self::Semicolon => byte == b';',
            Self::Comma => byte == b',',
            Self::Blanks => byte == b' ' || byte == b'\t',
        }
    }

    /// Splits a line into `cells`, without spaces and quotes around them.
    pub(super) fn split<'a>(self, line: &'a str, cells: &mut Vec<&'a str>) {
        cells.clear();
        let (mut quoted, mut start) = (false, 0);
        let mut push = |cell: &'a str| {
            let cell = cell.trim();
            if !(cell.is_empty() && self == Self::Blanks) {
                cells.push(unquoted(cell));
            }
        };
        for (at, byte) in line.bytes().enumerate() {
            quoted ^= byte == b'"';
            if !quoted && self.cuts(byte) {
                push(&line[start..at]);
                start = at + 1;
            }
        }
        push(&line[start..]);
    }

    /// Content of a cell; a comma may be a decimal mark only if commas are not the separator.
    pub(super) fn cell(self, cell: &str) -> Cell {
        if cell.is_empty() {
            return Cell::Empty;
        }
        if let Ok(number) = cell.parse::<f64>() {
            return if number.is_finite() { Cell::Number(number) } else { Cell::Empty };
        }
        match decimal_comma(cell) {
            Some(number) if self != Self::Comma => Cell::Number(number),
            _ if MISSING.contains(&cell.to_ascii_lowercase().as_str()) => Cell::Empty,
            _ => Cell::Other,
        }
    }
}

fn unquoted(cell: &str) -> &str {
    match cell.strip_prefix('"').and_then(|cell| cell.strip_suffix('"')) {
        Some(inner) => inner.trim(),
        None => cell,
    }
}

/// The finite number in a cell with one comma between digits and no point.
fn decimal_comma(cell: &str) -> Option<f64> {
    let (whole, rest) = cell.split_once(',')?;
    let is_mark = rest.starts_with(|c: char| c.is_ascii_digit()) && !rest.contains(',') && !cell.contains('.');
    let number: f64 = is_mark.then(|| format!("{whole}.{rest}").parse().ok())??;
    number.is_finite().then_some(number)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn cells_are_cut_outside_quotes() {
        let mut cells = Vec::new();
        Separator::Comma.split("1, \"a, b\" ,,3", &mut cells);
        assert_eq!(cells, ["1", "a, b", "", "3"]);
        Separator::Blanks.split("  1 \t 2  ", &mut cells);
        assert_eq!(cells, ["1", "2"]);
    }

    #[test]
    fn numbers_may_have_decimal_commas_where_commas_do_not_separate() {
        assert_eq!(Separator::Semicolon.cell("-1,5e3"), Cell::Number(-1500.0));
        assert_eq!(Separator::Comma.cell("1,5"), Cell::Other);
        assert_eq!(Separator::Tab.cell("1.234,5"), Cell::Other);
        assert_eq!(Separator::Tab.cell("1,"), Cell::Other);
        assert_eq!(Separator::Tab.cell("NaN"), Cell::Empty);
        assert_eq!(Separator::Tab.cell("inf"), Cell::Empty);
    }
}
