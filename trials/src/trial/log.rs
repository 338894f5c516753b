//! The log of a pass: readings of robot, force sensor and drive, row by row.

use files::input::quoted_names;
use std::path::Path;

use glam::DVec3;
use instruments::text_table::{TextRow, TextTable};
use robot::LogRow;
use serde::Serialize;

use super::error::{Place, TrialError};
use super::scan::Read;

/// Columns that every log has.
pub const REQUIRED_COLUMNS: [&str; 6] = ["t_s", "x_mm", "y_mm", "z_mm", "force_n", "spindle_rpm"];
/// Columns of the approach axis, if it is not +z.
pub const APPROACH_COLUMNS: [&str; 3] = ["nx", "ny", "nz"];
/// Column of a pyrometer.
pub const TEMPERATURE_COLUMN: &str = "temperature_c";
/// All columns with a meaning.
const KNOWN_COLUMNS: [&str; 10] =
    ["t_s", "x_mm", "y_mm", "z_mm", "force_n", "spindle_rpm", "nx", "ny", "nz", TEMPERATURE_COLUMN];
/// Radians per second in one revolution per minute.
pub const RPM: f64 = std::f64::consts::TAU / 60.0;

/// A column unknown to the format, kept as a covariate.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Covariate {
    /// Name in the file's header.
    pub name: String,
    /// One value per row, NaN where the cell is empty.
    pub values: Vec<f64>,
    /// Line of the first row without a finite number, from 1.
    #[serde(skip)]
    pub hole: Option<u64>,
}

/// A complete log; times increase strictly.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub struct Log {
    /// Rows in order of time.
    pub rows: Vec<LogRow>,
    /// True if the file gives the approach axis; otherwise it is +z.
    pub has_approach: bool,
    /// Temperature [°C] per row, NaN if not measured; empty without a pyrometer.
    pub temperature: Vec<f64>,
    /// Other columns, in the order of the file.
    pub covariates: Vec<Covariate>,
}

impl Log {
    /// The rows between two times [s], both included.
    pub(super) fn between(&self, [from, to]: [f64; 2]) -> Self {
        let first = self.rows.partition_point(|row| row.time < from);
        let range = first..self.rows.partition_point(|row| row.time <= to).max(first);
        let covariates = self.covariates.iter().map(|covariate| {
            let values = covariate.values[range.clone()].to_vec();
            let hole = covariate.hole.filter(|_| values.iter().any(|value| value.is_nan()));
            Covariate { name: covariate.name.clone(), values, hole }
        });
        Self {
            rows: self.rows[range.clone()].to_vec(),
            has_approach: self.has_approach,
            temperature: if self.temperature.is_empty() {
                Vec::new()
            } else {
                self.temperature[range.clone()].to_vec()
            },
            covariates: covariates.collect(),
        }
    }
}

/// Index of each column in the file.
struct Columns {
    count: usize,
    required: [usize; 6],
    approach: Option<[usize; 3]>,
    temperature: Option<usize>,
    others: Vec<(usize, String)>,
}

/// Contents of a log's rows while reading.
struct Reading {
    columns: Columns,
    log: Log,
    others: Vec<Covariate>,
    /// True for columns that contain text.
    text: Vec<bool>,
    repeated: usize,
    cut: Option<(u64, usize)>,
}

/// Reads a log.
///
/// # Errors
/// [`TrialError`] with line and column: a missing column, a cell that is not a number, a clock that runs backwards.
pub fn read_log(file: &Path) -> Result<Read<Log>, TrialError> {
    let table = TextTable::read(file)?;
    let mut reading: Option<Reading> = None;
    table.rows(|row| {
        match &mut reading {
            None => reading = Some(Reading::of(Columns::of(row)?)),
            Some(reading) => reading.push(row)?,
        }
        Ok::<_, TrialError>(true)
    })?;
    let reading =
        reading.ok_or_else(|| Place::file(file).bad::<TrialError>("no row", "a header and rows are expected"))?;
    reading.finish(&table)
}

/// The finite number in a cell.
fn finite(row: &TextRow, column: usize) -> Result<f64, TrialError> {
    match row.number(column)? {
        Some(value) if value.is_finite() => Ok(value),
        _ => Err(row.place(column).bad(row.shown(column), "a finite number is expected")),
    }
}

impl Columns {
    fn of(header: &TextRow) -> Result<Self, TrialError> {
        let names: Vec<String> = (0..header.len()).map(|k| header.text(k).trim_matches('"').to_owned()).collect();
        let find = |wanted: &str| names.iter().position(|name| name.eq_ignore_ascii_case(wanted));
        let need = |wanted: &str| {
            find(wanted).ok_or_else(|| {
                let near = super::manifest::nearest(wanted, names.iter().map(String::as_str));
                let hint = near.map_or(String::new(), |near| format!(" (the nearest is {near:?})"));
                let found = format!("no column {wanted}{hint} in the header {}", quoted_names(&names, KNOWN_COLUMNS));
                header
                    .place(0)
                    .bad::<TrialError>(found, format!("the columns {} are expected", REQUIRED_COLUMNS.join(",")))
            })
        };
        let mut required = [0; 6];
        for (place, wanted) in required.iter_mut().zip(REQUIRED_COLUMNS) {
            *place = need(wanted)?;
        }
        let axis = APPROACH_COLUMNS.map(find);
        let approach = match axis {
            [Some(x), Some(y), Some(z)] => Some([x, y, z]),
            [None, None, None] => None,
            _ => return Err(header.place(0).bad("some of nx, ny, nz", "all three or none are expected")),
        };
        let temperature = find(TEMPERATURE_COLUMN);
        let known = |k: &usize| {
            required.contains(k) || approach.is_some_and(|axis| axis.contains(k)) || temperature == Some(*k)
        };
        let others = (0..names.len()).filter(|k| !known(k)).map(|k| (k, names[k].clone())).collect();
        Ok(Self { count: names.len(), required, approach, temperature, others })
    }
}

impl Reading {
    fn of(columns: Columns) -> Self {
        let covariate = |(_, name): &(usize, String)| Covariate { name: name.clone(), values: Vec::new(), hole: None };
        let others = columns.others.iter().map(covariate).collect();
        let text = vec![false; columns.others.len()];
        let log = Log { has_approach: columns.approach.is_some(), ..Log::default() };
        Self { columns, log, others, text, repeated: 0, cut: None }
    }

    fn push(&mut self, row: &TextRow) -> Result<(), TrialError> {
        if let Some((line, found)) = self.cut {
            return Err(self.wrong_count(row.place(0).at_line(line), found));
        }
        if row.len() > self.columns.count {
            return Err(self.wrong_count(row.place(self.columns.count), row.len()));
        }
        if row.len() < self.columns.count {
            self.cut = Some((row.line, row.len()));
            return Ok(());
        }
        let [time, x, y, z, force, rpm] = self.columns.required;
        let time = finite(row, time)?;
        if let Some(last) = self.log.rows.last() {
            if time == last.time {
                self.repeated += 1;
                return Ok(());
            }
            if time < last.time {
                let found = format!("the clock runs backwards, from {} s to {time} s", last.time);
                return Err(row.place(self.columns.required[0]).bad(found, "times that increase are expected"));
            }
        }
        let approach = self.approach(row)?;
        let position = DVec3::new(finite(row, x)?, finite(row, y)?, finite(row, z)?) * 1e-3;
        let (force, spindle_speed) = (finite(row, force)?, finite(row, rpm)? * RPM);
        self.log.rows.push(LogRow { time, position, force, spindle_speed, approach });
        self.push_others(row)
    }

    fn approach(&self, row: &TextRow) -> Result<DVec3, TrialError> {
        let Some([x, y, z]) = self.columns.approach else { return Ok(DVec3::Z) };
        let axis = DVec3::new(finite(row, x)?, finite(row, y)?, finite(row, z)?);
        // A tenth is far beyond rounding: such columns hold something else.
        if (axis.length() - 1.0).abs() > 0.1 {
            return Err(row.place(x).bad(format!("an approach axis {axis}"), "a unit vector is expected"));
        }
        Ok(axis.normalize())
    }

    fn push_others(&mut self, row: &TextRow) -> Result<(), TrialError> {
        if let Some(column) = self.columns.temperature {
            self.log.temperature.push(row.number(column)?.unwrap_or(f64::NAN));
        }
        for (k, (column, _)) in self.columns.others.iter().enumerate() {
            let value = row.number(*column);
            self.text[k] |= value.is_err();
            let value = value.ok().flatten().unwrap_or(f64::NAN);
            if !value.is_finite() {
                self.others[k].hole.get_or_insert(row.line);
            }
            self.others[k].values.push(value);
        }
        Ok(())
    }

    fn wrong_count(&self, place: Place, found: usize) -> TrialError {
        let count = self.columns.count;
        let hint = if found > count { "; are decimals written with commas?" } else { "" };
        place.bad(
            format!("{found} cells where the header has {count}{hint}"),
            "as many cells as the header has, and decimal points, are expected",
        )
    }

    fn finish(mut self, table: &TextTable) -> Result<Read<Log>, TrialError> {
        let mut notes = table.notes.clone();
        if let Some((line, found)) = self.cut {
            if !table.ends_within_a_line() {
                return Err(self.wrong_count(Place::line(table.file(), line), found));
            }
            notes.push(format!("line {line} is cut short after {found} cells and left out"));
        }
        if self.log.rows.len() < 2 {
            return Err(Place::file(table.file())
                .bad(format!("{} rows below the header", self.log.rows.len()), "at least 2 rows are expected"));
        }
        if self.repeated > 0 {
            notes.push(format!("{} rows repeat the time of the row before and are left out", self.repeated));
        }
        for (covariate, text) in self.others.drain(..).zip(&self.text) {
            if *text {
                notes.push(format!("column {:?} holds text and is left out", covariate.name));
            } else {
                self.log.covariates.push(covariate);
            }
        }
        if !self.log.covariates.is_empty() {
            let names: Vec<&str> = self.log.covariates.iter().map(|covariate| covariate.name.as_str()).collect();
            notes.push(format!("unknown columns kept as covariates: {}", names.join(", ")));
        }
        Ok(Read { content: self.log, notes })
    }
}
