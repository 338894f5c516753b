//! One column of a table: the kind of its cells, and its values.

use std::path::Path;

use super::cells::{Cell, Separator};
use super::layout::Layout;
use super::stamp::{self, DAY, SECOND, Stamp};
use crate::log::{Channels, unit};
use crate::misread::{Misread, Place};

/// Kind of a column's cells.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Kind {
    Number,
    /// `true` and `false`.
    Flag,
    Text,
    Stamp(Stamp),
    /// Integers counting this fraction of a second since 1970.
    Epoch(i128),
}

/// One column.
#[derive(Debug)]
pub(super) struct Column {
    name: String,
    /// True if its header cell is empty.
    is_nameless: bool,
    unit: Option<String>,
    kind: Kind,
    values: Vec<f64>,
    /// First and last time stamp [ns, or fractions of a second].
    span: Option<(i128, i128)>,
    midnights: usize,
    /// True for dates whose time of day is in the next column.
    is_day_of_next: bool,
    /// True for a time of day whose dates are in the previous column.
    has_day: bool,
    /// First rows with a decimal comma and with a decimal point.
    marks: [Option<usize>; 2],
}

/// The content of a cell, and the accepted content.
type Refusal = (String, &'static str);

impl Column {
    /// The columns of a table, without rows.
    pub(super) fn all(layout: &Layout) -> Vec<Self> {
        let mut sample: Vec<Vec<&str>> = vec![Vec::new(); layout.count];
        let mut cells = Vec::new();
        for line in &layout.sample {
            layout.separator.split(line.text, &mut cells);
            for (column, cell) in sample.iter_mut().zip(cells.iter().filter(|_| cells.len() == layout.count)) {
                column.push(*cell);
            }
        }
        let mut columns: Vec<Self> = sample.iter().enumerate().map(|(k, cells)| Self::of(layout, k, cells)).collect();
        for k in 1..columns.len() {
            let is_day = matches!(columns[k - 1].kind, Kind::Stamp(Stamp::Day(_)));
            if is_day && matches!(columns[k].kind, Kind::Stamp(stamp) if stamp.is_clock()) {
                columns[k - 1].is_day_of_next = true;
                columns[k].has_day = true;
            }
        }
        columns
    }

    fn of(layout: &Layout, k: usize, cells: &[&str]) -> Self {
        let named = layout.header.names.get(k).filter(|name| !name.is_empty());
        let name = named.cloned().unwrap_or_else(|| format!("column_{}", k + 1));
        let own = layout.header.units.get(k).cloned().flatten();
        let unit = own.or_else(|| unit::split(&name).1);
        let kind = Kind::of(layout.separator, cells).or_epoch(&name, k == 0, cells);
        Self {
            name,
            is_nameless: named.is_none() && !layout.header.names.is_empty(),
            unit,
            kind,
            values: Vec::new(),
            span: None,
            midnights: 0,
            is_day_of_next: false,
            has_day: false,
            marks: [None; 2],
        }
    }

    /// Adds a row.
    pub(super) fn push(&mut self, cell: &str, separator: Separator) -> Result<(), Refusal> {
        let refuse = |accepted| Err((format!("{} is none", files::input::quoted(cell)), accepted));
        let value = match (self.kind, separator.cell(cell)) {
            (Kind::Text, _) => return Ok(()),
            (_, Cell::Empty) => f64::NAN,
            (Kind::Number, Cell::Number(number)) => {
                self.note_mark(cell);
                number
            }
            (Kind::Number, _) => return refuse("a number, or an empty cell where nothing was measured, is expected"),
            (Kind::Flag, _) => match flag(cell) {
                Some(flag) => f64::from(u8::from(flag)),
                None => return refuse("true or false, as in the rows above, is expected"),
            },
            (Kind::Stamp(stamp), _) => match stamp.read(cell) {
                Some(moment) => self.since_first(moment, stamp.is_clock()) as f64 / SECOND as f64,
                None => return refuse("a time written as in the rows above is expected"),
            },
            (Kind::Epoch(parts), _) => match whole_and_fraction(cell) {
                Some((whole, fraction)) => (self.since_first(whole, false) as f64 + fraction) / parts as f64,
                None => return refuse("a time since 1970 as in the rows above is expected"),
            },
        };
        self.values.push(value);
        Ok(())
    }

    /// Time since the first stamp; a time of day that goes back by half a day has passed midnight.
    fn since_first(&mut self, moment: i128, is_clock: bool) -> i128 {
        let (first, last) = self.span.unwrap_or((moment, moment));
        if is_clock && !self.has_day && last - moment > DAY / 2 {
            self.midnights += 1;
        }
        self.span = Some((first, moment));
        moment - first + self.midnights as i128 * DAY
    }

    fn note_mark(&mut self, cell: &str) {
        let row = self.values.len();
        for (mark, first) in [',', '.'].into_iter().zip(&mut self.marks) {
            if first.is_none() && cell.contains(mark) {
                *first = Some(row);
            }
        }
    }

    /// Adds the column to a log; `days` is the column of dates beside a time of day.
    fn finish(mut self, days: Option<Self>, channels: &mut Channels) {
        // A separator at the end of the lines leaves an empty column.
        if self.is_nameless && self.kind == Kind::Number && self.values.iter().all(|value| value.is_nan()) {
            return;
        }
        if let Some(days) = days {
            self.values.iter_mut().zip(days.values).for_each(|(value, day)| *value += day);
            channels.notes.push(format!("the columns {:?} and {:?} are read as one time", days.name, self.name));
        }
        let since = match self.kind {
            Kind::Text => {
                channels.notes.push(format!("column {:?} holds text and is left out", self.name));
                channels.text.push(self.name);
                return;
            }
            Kind::Stamp(stamp) => Some(stamp.name()),
            Kind::Epoch(1) => Some("seconds since 1970"),
            Kind::Epoch(1_000) => Some("milliseconds since 1970"),
            Kind::Epoch(1_000_000) => Some("microseconds since 1970"),
            Kind::Epoch(_) => Some("nanoseconds since 1970"),
            Kind::Number | Kind::Flag => None,
        };
        if let Some(written) = since {
            let midnights = if self.midnights > 0 {
                format!("; midnight is passed {} times", self.midnights)
            } else {
                String::new()
            };
            channels.notes.push(format!(
                "column {:?} holds {written} and is read as seconds from the first row{midnights}",
                self.name
            ));
            self.unit = Some("s".to_owned());
        }
        channels.push(&self.name, self.unit, self.values);
    }
}

/// Adds a column of nanoseconds to the column of seconds before it, the form of ROS stamps in tables.
fn join_nanoseconds(columns: &mut [Column], channels: &mut Channels) {
    let is_rest = |column: &Column| {
        let name = column.name.to_lowercase();
        column.kind == Kind::Number && ["nsec", "nsecs", "nanosec", "nanosecs"].iter().any(|end| name.ends_with(end))
    };
    for k in 1..columns.len() {
        let (before, rest) = columns.split_at_mut(k);
        let (Some(seconds), Some(rest)) = (before.last_mut(), rest.first()) else { continue };
        if seconds.kind == Kind::Epoch(1) && is_rest(rest) {
            let first = rest.values.first().copied().unwrap_or_default();
            let parts = rest.values.iter().map(|nanoseconds| 1e-9 * (nanoseconds - first));
            seconds.values.iter_mut().zip(parts).for_each(|(value, part)| *value += part);
            channels.notes.push(format!("the columns {:?} and {:?} are read as one time", seconds.name, rest.name));
        }
    }
}

/// Adds the columns to a log.
pub(super) fn finish(mut columns: Vec<Column>, channels: &mut Channels) {
    join_nanoseconds(&mut columns, channels);
    let mut days = None;
    for column in columns {
        if column.is_day_of_next {
            days = Some(column);
        } else {
            column.finish(days.take(), channels);
        }
    }
}

/// Refuses a table that mixes decimal commas and decimal points.
pub(super) fn check_marks(place: (&Path, &[u64]), columns: &[Column], notes: &mut Vec<String>) -> Result<(), Misread> {
    let (file, lines) = place;
    let first = |mark: usize| columns.iter().enumerate().find_map(|(k, column)| column.marks[mark].map(|row| (row, k)));
    match (first(0), first(1)) {
        (Some(comma), Some(point)) => {
            let (row, column) = comma.max(point);
            let line = lines.get(row).copied().unwrap_or_default();
            let found = "decimals are written with commas in some cells and with points in others";
            return Err(Place::cell(file, line, column + 1).bad(found, "one decimal mark is expected"));
        }
        (Some(_), None) => notes.push("decimals are written with commas".to_owned()),
        _ => {}
    }
    Ok(())
}

impl Kind {
    fn of(separator: Separator, cells: &[&str]) -> Self {
        let filled: Vec<&str> = cells.iter().copied().filter(|cell| separator.cell(cell) != Cell::Empty).collect();
        let numbers = filled.iter().filter(|cell| matches!(separator.cell(cell), Cell::Number(_))).count();
        // A few damaged cells do not make a column of text.
        if 10 * numbers >= 9 * filled.len() {
            return Self::Number;
        }
        if filled.iter().all(|cell| flag(cell).is_some()) {
            return Self::Flag;
        }
        let stamps: Vec<&str> = filled.iter().copied().filter(|cell| stamp::may_be(cell)).collect();
        match stamp::of_column(&stamps) {
            Some(stamp) if 10 * stamps.len() >= 9 * filled.len() => Self::Stamp(stamp),
            _ => Self::Text,
        }
    }

    /// Interprets numbers as times since 1970 if they are large enough and the column's name or position suggests a
    /// time.
    fn or_epoch(self, name: &str, is_first: bool, cells: &[&str]) -> Self {
        let name = name.to_lowercase();
        let is_time = is_first || ["time", "stamp", "zeit", "epoch", "sec"].iter().any(|word| name.contains(word));
        let wholes: Option<Vec<i128>> = cells.iter().map(|cell| Some(whole_and_fraction(cell)?.0)).collect();
        let Some(wholes) = wholes.filter(|wholes| self == Self::Number && is_time && !wholes.is_empty()) else {
            return self;
        };
        // The years 2001 to 2100.
        let parts = [1, 1_000, 1_000_000, 1_000_000_000];
        let within =
            |parts: i128| wholes.iter().all(|&whole| (1_000_000_000..4_102_444_800).contains(&(whole / parts)));
        parts.into_iter().find(|&parts| within(parts)).map_or(self, Self::Epoch)
    }
}

fn flag(cell: &str) -> Option<bool> {
    match cell.to_ascii_lowercase().as_str() {
        "true" => Some(true),
        "false" => Some(false),
        _ => None,
    }
}

/// A number without sign and exponent, split into its integer and fractional parts.
fn whole_and_fraction(cell: &str) -> Option<(i128, f64)> {
    let (whole, fraction) = cell.split_once(['.', ',']).unwrap_or((cell, ""));
    let is_digits = |text: &str| text.len() <= 25 && text.bytes().all(|byte| byte.is_ascii_digit());
    if !is_digits(whole) || !is_digits(fraction) {
        return None;
    }
    let rest = if fraction.is_empty() { 0.0 } else { format!("0.{fraction}").parse().ok()? };
    Some((whole.parse().ok()?, rest))
}
