//! Order of the rows in time, from numbers or dates.

use jiff::civil::DateTime;

/// Date formats. A cell that fits two of them is read in the first.
const DATES: [&str; 16] = [
    "%Y-%m-%dT%H:%M:%S",
    "%Y-%m-%dT%H:%M",
    "%Y-%m-%d %H:%M:%S",
    "%Y-%m-%d %H:%M",
    "%Y-%m-%d",
    "%Y/%m/%d",
    "%Y/%m/%d %H:%M",
    "%d.%m.%Y %H:%M:%S",
    "%d.%m.%Y %H:%M",
    "%d.%m.%Y",
    "%d/%m/%Y %H:%M:%S",
    "%d/%m/%Y %H:%M",
    "%d/%m/%Y",
    "%m/%d/%Y %H:%M:%S",
    "%m/%d/%Y %H:%M",
    "%m/%d/%Y",
];

/// Content of the order column.
pub(super) enum Order {
    /// Numbers of any meaning.
    Numbers(Vec<f64>),
    /// Dates, as seconds since 1970, and their format.
    Dates(Vec<f64>, &'static str),
}

impl Order {
    /// Reads all cells in one format.
    ///
    /// # Errors
    /// The index of the first cell that does not fit the format of the first one.
    pub(super) fn of(cells: &[&str]) -> Result<Self, usize> {
        let numbers: Result<Vec<f64>, usize> = all(cells, |cell| cell.replace(',', ".").parse().ok());
        if let Ok(numbers) = numbers {
            return Ok(Self::Numbers(numbers));
        }
        let mut furthest = numbers.err().unwrap_or(0);
        for format in DATES {
            match all(cells, |cell| date(cell, format)) {
                Ok(dates) => return Ok(Self::Dates(dates, format)),
                Err(at) => furthest = furthest.max(at),
            }
        }
        Err(furthest)
    }
}

fn all(cells: &[&str], read: impl Fn(&str) -> Option<f64>) -> Result<Vec<f64>, usize> {
    cells.iter().enumerate().map(|(at, cell)| read(cell).filter(|value| value.is_finite()).ok_or(at)).collect()
}

/// Seconds since 1970.
fn date(cell: &str, format: &str) -> Option<f64> {
    let text = cell.trim_end_matches('Z');
    let moment = if format.contains("%H") {
        DateTime::strptime(format, text).ok()?
    } else {
        jiff::civil::Date::strptime(format, text).ok()?.at(0, 0, 0, 0)
    };
    let since = moment.duration_since(DateTime::constant(1970, 1, 1, 0, 0, 0, 0));
    Some(since.as_secs_f64())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn dates_and_numbers_are_read_in_one_way_for_all_rows() {
        let dates = |cells: &[&str]| match Order::of(cells) {
            Ok(Order::Dates(seconds, format)) => (seconds, format),
            _ => panic!("{cells:?}"),
        };
        assert_eq!(dates(&["1970-01-02", "1970-01-03"]), (vec![86400.0, 172_800.0], "%Y-%m-%d"));
        assert_eq!(dates(&["03.01.1970 01:00"]).0, [2.0 * 86400.0 + 3600.0]);
        assert_eq!(dates(&["01/02/1970", "01/13/1970"]), (vec![86400.0, 12.0 * 86400.0], "%m/%d/%Y"));
        assert_eq!(dates(&["1970-01-01T00:00:05Z"]).0, [5.0]);
        assert!(matches!(Order::of(&["1,5", "2"]), Ok(Order::Numbers(numbers)) if numbers == [1.5, 2.0]));
        assert!(matches!(Order::of(&["2024-01-02", "2024-01-03", "yesterday"]), Err(2)));
    }
}
