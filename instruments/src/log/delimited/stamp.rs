//! Time stamps: dates and times of day in many formats.

use jiff::Timestamp;
use jiff::civil::{Date, DateTime, Time};

/// Nanoseconds of a day.
pub(super) const DAY: i128 = 86_400 * SECOND;
/// Nanoseconds of a second.
pub(super) const SECOND: i128 = 1_000_000_000;
const EPOCH: DateTime = DateTime::constant(1970, 1, 1, 0, 0, 0, 0);

/// A format of time stamps. The day comes before the month if both orders fit.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Stamp {
    /// ISO 8601 with a zone.
    Instant,
    /// ISO 8601 without a zone.
    Local,
    /// A date and a time of day.
    Moment(&'static str),
    /// A time of day only.
    Clock(&'static str),
    /// A time of day with its milliseconds after a colon.
    ColonClock,
    /// A date only.
    Day(&'static str),
}

const STAMPS: [Stamp; 20] = [
    Stamp::Day("%Y-%m-%d"),
    Stamp::Day("%d.%m.%Y"),
    Stamp::Day("%d/%m/%Y"),
    Stamp::Day("%m/%d/%Y"),
    Stamp::Day("%Y/%m/%d"),
    Stamp::Day("%d-%m-%Y"),
    Stamp::Clock("%H:%M:%S%.f"),
    Stamp::Clock("%I:%M:%S%.f %p"),
    Stamp::ColonClock,
    Stamp::Instant,
    Stamp::Local,
    Stamp::Moment("%d.%m.%Y %H:%M:%S%.f"),
    Stamp::Moment("%d/%m/%Y %H:%M:%S%.f"),
    Stamp::Moment("%m/%d/%Y %H:%M:%S%.f"),
    Stamp::Moment("%Y/%m/%d %H:%M:%S%.f"),
    Stamp::Moment("%d-%m-%Y %H:%M:%S%.f"),
    Stamp::Moment("%m/%d/%Y %I:%M:%S%.f %p"),
    Stamp::Moment("%d.%m.%y %H:%M:%S%.f"),
    Stamp::Moment("%Y/%m/%d-%H:%M:%S%.f"),
    Stamp::Moment("%Y-%m-%d_%H:%M:%S%.f"),
];

/// True for a cell that may be a time stamp; a fast test for many cells.
pub(super) fn may_be(cell: &str) -> bool {
    let count = |wanted: &[u8]| cell.bytes().filter(|byte| wanted.contains(byte)).count();
    let allowed = |byte: u8| byte.is_ascii_digit() || b":-/.,+ TZ_APMapm".contains(&byte);
    let starts = cell.bytes().next().is_some_and(|byte| byte.is_ascii_digit());
    let has_parts = count(b":") >= 2 || [b"-", b"/", b"."].iter().any(|mark| count(*mark) == 2);
    starts && (8..=40).contains(&cell.len()) && has_parts && cell.bytes().all(allowed)
}

/// The format that fits all cells, if any.
pub(super) fn of_column(cells: &[&str]) -> Option<Stamp> {
    STAMPS.into_iter().find(|stamp| !cells.is_empty() && cells.iter().all(|cell| stamp.read(cell).is_some()))
}

impl Stamp {
    /// Parses a time [ns]: since 1970, or since midnight for a time of day.
    pub(super) fn read(self, cell: &str) -> Option<i128> {
        let cell = cell.replace(',', ".");
        let since = |moment: DateTime| moment.duration_since(EPOCH).as_nanos();
        match self {
            Self::Instant => cell.parse::<Timestamp>().ok().map(Timestamp::as_nanosecond),
            Self::Local => cell.parse().ok().map(since),
            Self::Moment(format) => DateTime::strptime(format, &cell).ok().map(since),
            Self::Day(format) => Some(since(Date::strptime(format, &cell).ok()?.at(0, 0, 0, 0))),
            Self::Clock(format) => Time::strptime(format, &cell).ok().map(of_day),
            Self::ColonClock => {
                let (clock, fraction) = cell.rsplit_once(':')?;
                Time::strptime("%H:%M:%S%.f", format!("{clock}.{fraction}")).ok().map(of_day)
            }
        }
    }

    /// Name for messages.
    pub(super) fn name(self) -> &'static str {
        match self {
            Self::Instant => "times in ISO 8601 with a zone",
            Self::Local => "times in ISO 8601",
            Self::Moment(format) | Self::Clock(format) | Self::Day(format) => spelled(format),
            Self::ColonClock => "hour:minute:second:fraction",
        }
    }

    /// True if it restarts at midnight.
    pub(super) fn is_clock(self) -> bool {
        matches!(self, Self::Clock(_) | Self::ColonClock)
    }
}

fn of_day(time: Time) -> i128 {
    time.duration_since(Time::midnight()).as_nanos()
}

/// A format of `STAMPS` in readable form.
fn spelled(format: &str) -> &'static str {
    match format {
        "%Y-%m-%d" => "year-month-day",
        "%d.%m.%Y" => "day.month.year",
        "%d/%m/%Y" => "day/month/year",
        "%m/%d/%Y" => "month/day/year",
        "%Y/%m/%d" => "year/month/day",
        "%d-%m-%Y" => "day-month-year",
        "%H:%M:%S%.f" => "hour:minute:second",
        "%I:%M:%S%.f %p" => "hour:minute:second AM or PM",
        "%d.%m.%Y %H:%M:%S%.f" | "%d.%m.%y %H:%M:%S%.f" => "day.month.year hour:minute:second",
        "%d/%m/%Y %H:%M:%S%.f" => "day/month/year hour:minute:second",
        "%d-%m-%Y %H:%M:%S%.f" => "day-month-year hour:minute:second",
        "%m/%d/%Y %H:%M:%S%.f" | "%m/%d/%Y %I:%M:%S%.f %p" => "month/day/year hour:minute:second",
        _ => "year, month, day and hour:minute:second",
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn stamps_are_read_to_the_nanosecond() {
        let cases = [
            ("1970-01-02T00:00:01.5Z", DAY + 3 * SECOND / 2),
            ("1970-01-02T01:00:01.5+01:00", DAY + 3 * SECOND / 2),
            ("1970-01-02 00:00:01.000000001", DAY + SECOND + 1),
            ("02.01.1970 00:00:01,25", DAY + 5 * SECOND / 4),
            ("01/13/1970 00:00:00", 12 * DAY),
            ("00:00:01.5", 3 * SECOND / 2),
            ("00:00:01:500", 3 * SECOND / 2),
            ("01:00:00 PM", 13 * 3600 * SECOND),
            ("1970-01-02", DAY),
        ];
        for (cell, wanted) in cases {
            assert!(may_be(cell), "{cell}");
            let stamp = of_column(&[cell]).unwrap_or_else(|| panic!("{cell}"));
            assert_eq!(stamp.read(cell), Some(wanted), "{cell} as {stamp:?}");
        }
    }

    #[test]
    fn numbers_and_words_are_no_stamps() {
        assert!(["1.5", "-12", "1e-5", "RUN", "12,5", "2024"].iter().all(|cell| !may_be(cell)));
        assert_eq!(of_column(&["12:00:00", "noon"]), None);
    }
}
