//! Quantities of a trial for the formulas of effects, besides pose, force and speed: further columns of its logs, its
//! temperature, and the values of `[columns]`.

use std::ops::Range;
use std::path::PathBuf;

use effects::{Dimension, Variable};
use files::input::{quoted_names, quoted_near};
use toml::Spanned;

use super::Pass;
use super::error::{Place, TrialError};
use super::log::{Log, TEMPERATURE_COLUMN};
use super::manifest::{ColumnEntry, Manifest, Source, nearest};
use crate::column_unit::{ColumnUnit, named_unit, split};

/// Maximum number of columns that formulas may read.
const MOST_COLUMNS: usize = 200;
/// Name of the temperature in formulas.
const TEMPERATURE: &str = "temperature";
/// Accepted forms of an entry of `[columns]`.
const ENTRY: &str = "the unit of a column, such as \"%\", or a value with its unit, such as \"45 %\", is expected";

/// A quantity for formulas: a state of the tool with the same name and no dynamics of its own follows it.
#[derive(Clone, Debug, PartialEq)]
pub struct TrialColumn {
    /// Name in formulas.
    pub name: String,
    /// Unit as written in the files, `1` for a plain number.
    pub unit: String,
    /// Dimension of the unit.
    pub dimension: Dimension,
    /// SI value of one unit, and of the file's zero.
    pub scale: (f64, f64),
    /// Source of the values in the files.
    pub given: QuantitySource,
    /// Place of its name or its unit in the files.
    pub place: Place,
    /// The first place without a number, and the text there. Formulas cannot read such a column.
    pub hole: Option<(Place, String)>,
}

/// Source of a quantity in the files.
#[derive(Clone, Debug, PartialEq)]
pub enum QuantitySource {
    /// One value for the trial [SI].
    Trial(f64),
    /// The column with this name in its logs.
    Logs(String),
    /// The temperature in its logs.
    Temperature,
}

impl TrialColumn {
    /// Values in a pass [SI]: one for each row of its log, or a single one for all. NaN for a temperature that was not
    /// measured in a row.
    pub fn values(&self, log: &Log) -> Vec<f64> {
        let (unit, zero) = self.scale;
        let si = |values: &[f64]| values.iter().map(|value| value * unit + zero).collect();
        match &self.given {
            QuantitySource::Trial(value) => vec![*value],
            QuantitySource::Temperature => si(&log.temperature),
            QuantitySource::Logs(header) => {
                let own = log.covariates.iter().find(|covariate| covariate.name == *header);
                own.map_or_else(Vec::new, |covariate| si(&covariate.values))
            }
        }
    }
}

/// The columns of a trial, and notes on them.
pub(super) struct Found {
    pub(super) columns: Vec<TrialColumn>,
    pub(super) notes: Vec<String>,
}

/// A trial's passes with the files of their logs.
pub(super) struct Logs<'a> {
    pub(super) passes: &'a [Pass],
    pub(super) files: Vec<PathBuf>,
}

impl Found {
    /// Finds the columns of a trial.
    ///
    /// # Errors
    /// An entry of `[columns]` that is neither a unit nor a value, or an unknown unit.
    pub(super) fn new(source: &Source, manifest: &Manifest, logs: &Logs) -> Result<Self, TrialError> {
        let headers = logs.headers();
        let mut all: Vec<TrialColumn> = logs.temperature().into_iter().collect();
        for (header, pass) in &headers {
            let unit = manifest.columns.get(header).map(|entry| logged_unit(source, header, entry)).transpose()?;
            all.push(logs.column(header, unit, *pass));
        }
        let known: Vec<String> = headers.into_iter().map(|(header, _)| header).collect();
        for (name, entry) in manifest.columns.iter().filter(|(name, _)| !known.contains(name)).take(MOST_COLUMNS) {
            all.push(value(source, (name, entry), &known)?);
        }
        let mut found = Self { columns: Vec::new(), notes: Vec::new() };
        all.into_iter().for_each(|column| found.add(column));
        Ok(found)
    }

    /// Adds a column if a state can have its name.
    fn add(&mut self, column: TrialColumn) {
        let name = &column.name;
        let is_variable = Variable::ALL.iter().any(|variable| variable.name() == name);
        let why = match () {
            () if name.is_empty() => "has no letter in its name",
            () if is_variable => "has the name of a variable of the formulas",
            () if self.columns.iter().any(|other| other.name == *name) => "has the name of another column",
            () => return self.columns.push(column),
        };
        self.notes.push(format!("column {} {why}, and no effect can read it", shown(&column)));
    }
}

fn shown(column: &TrialColumn) -> String {
    match &column.given {
        QuantitySource::Logs(header) => format!("{header:?}"),
        _ => format!("{:?}", column.name),
    }
}

impl Logs<'_> {
    /// Names of further columns, in the order of the logs, each with the first pass that has it; at most
    /// [`MOST_COLUMNS`].
    fn headers(&self) -> Vec<(String, usize)> {
        let mut headers: Vec<(String, usize)> = Vec::new();
        for (pass, Pass { log, .. }) in self.passes.iter().enumerate() {
            for covariate in &log.covariates {
                if headers.len() < MOST_COLUMNS && headers.iter().all(|(known, _)| *known != covariate.name) {
                    headers.push((covariate.name.clone(), pass));
                }
            }
        }
        headers
    }

    /// A column of the logs.
    ///
    /// - `unit`: from `trial.toml`; otherwise the suffix of the name
    fn column(&self, header: &str, unit: Option<Unit>, first: usize) -> TrialColumn {
        let place = Place::line(&self.files[first], 1);
        let (stem, end) = named_unit(header);
        let unit = unit.unwrap_or_else(|| Unit::new(end, place).expect("a unit that names end with"));
        let name = if unit.text == end { stem } else { header };
        let Unit { text, unit, place } = unit;
        TrialColumn {
            name: formula_name(name),
            unit: text,
            dimension: unit.dimension(),
            scale: unit.scale(),
            given: QuantitySource::Logs(header.to_owned()),
            place,
            hole: self.hole(header),
        }
    }

    /// Place of the first row in which a column has no number.
    fn hole(&self, header: &str) -> Option<(Place, String)> {
        self.passes.iter().zip(&self.files).find_map(|(pass, file)| {
            match pass.log.covariates.iter().find(|covariate| covariate.name == header) {
                None => Some((Place::line(file, 1), "no column of numbers of that name".to_owned())),
                Some(covariate) => {
                    covariate.hole.map(|line| (Place::line(file, line), "no finite number in that column".to_owned()))
                }
            }
        })
    }

    /// The temperature, if any log has it.
    fn temperature(&self) -> Option<TrialColumn> {
        let first = self.passes.iter().position(|pass| !pass.log.temperature.is_empty())?;
        let unit = Unit::new("degC", Place::line(&self.files[first], 1)).expect("a unit");
        let is_measured = |pass: &Pass| pass.log.temperature.iter().any(|value| value.is_finite());
        let missing = self.passes.iter().position(|pass| !is_measured(pass));
        let hole = |pass: usize| (Place::file(&self.files[pass]), format!("no number in {TEMPERATURE_COLUMN}"));
        Some(TrialColumn {
            name: TEMPERATURE.to_owned(),
            unit: unit.text,
            dimension: unit.unit.dimension(),
            scale: unit.unit.scale(),
            given: QuantitySource::Temperature,
            place: unit.place,
            hole: missing.map(hole),
        })
    }
}

/// A unit, with its text and its place in the file.
struct Unit {
    text: String,
    unit: ColumnUnit,
    place: Place,
}

impl Unit {
    fn new(text: &str, place: Place) -> Result<Self, String> {
        Ok(Self { text: text.to_owned(), unit: ColumnUnit::parse(text)?, place })
    }
}

/// The unit in `trial.toml` for a column of the logs.
fn logged_unit(source: &Source, header: &str, entry: &Spanned<ColumnEntry>) -> Result<Unit, TrialError> {
    let (at, text) = text_of(entry);
    if split(&text).is_some() && text.trim() != "1" {
        let found = format!("a value for {}, which is a column of the logs", quoted_near(header, []));
        return Err(source.bad(at, found, "its unit alone, or another name, is expected"));
    }
    let place = Place::of_byte(&source.file, &source.text, at.start);
    Unit::new(text.trim(), place).map_err(|error| source.bad(at, format!("the unit of a column: {error}"), ENTRY))
}

/// A value of the whole trial.
fn value(
    source: &Source,
    (name, entry): (&str, &Spanned<ColumnEntry>),
    known: &[String],
) -> Result<TrialColumn, TrialError> {
    let (at, text) = text_of(entry);
    let Some((number, unit)) = split(&text) else {
        if ColumnUnit::parse(text.trim()).is_err() {
            return Err(source.bad(at, "neither a value nor a unit", ENTRY));
        }
        let near = nearest(name, known.iter().map(String::as_str));
        let hint = near.map_or(String::new(), |near| format!("did you mean {near:?}? "));
        let found = format!("a unit for {}, and no log has such a column of numbers", quoted_near(name, []));
        let names = quoted_names(known, []);
        return Err(source.bad(at, found, format!("{hint}The logs have further columns {names}; {ENTRY}")));
    };
    let unit = ColumnUnit::parse(unit);
    let unit = unit.map_err(|error| source.bad(at.clone(), format!("the unit of a value: {error}"), ENTRY))?;
    if !unit.to_si(number).is_finite() {
        return Err(source.bad(at, "a value that is not finite", ENTRY));
    }
    Ok(TrialColumn {
        name: formula_name(name),
        unit: split(&text).map_or_else(String::new, |(_, unit)| unit.to_owned()),
        dimension: unit.dimension(),
        scale: unit.scale(),
        given: QuantitySource::Trial(unit.to_si(number)),
        place: Place::of_byte(&source.file, &source.text, at.start),
        hole: None,
    })
}

/// An entry as text; a number has the unit of a plain number.
fn text_of(entry: &Spanned<ColumnEntry>) -> (Range<usize>, String) {
    let text = match entry.get_ref() {
        ColumnEntry::Text(text) => text.clone(),
        ColumnEntry::Number(number) => number.to_string(),
    };
    (entry.span(), text)
}

/// Longest name in formulas.
const LONGEST_NAME: usize = 60;

/// Converts a name to one that formulas accept: lower-case letters, digits and single underscores; it begins with a
/// letter.
fn formula_name(name: &str) -> String {
    let letters = name.chars().take(LONGEST_NAME);
    let plain: String = letters.map(|c| if c.is_ascii_alphanumeric() { c.to_ascii_lowercase() } else { '_' }).collect();
    let parts: Vec<&str> = plain.split('_').filter(|part| !part.is_empty()).collect();
    let name = parts.join("_");
    match name.chars().next() {
        Some(first) if first.is_ascii_digit() => format!("column_{name}"),
        _ => name,
    }
}
