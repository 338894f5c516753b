//! Conversion of CSV cells to rows.

use std::path::Path;

use instruments::text_table::{TextRow, TextTable};

use super::columns::{Columns, Load, Motion, Numbers};
use super::manifest::Manifest;
use super::missing::Marks;
use super::{Row, Table, Usage, plausible};
use crate::trial::{Covariate, Place, Role, TrialError};

/// Minimum number of calibration rows with a removal.
pub(super) const LEAST_ROWS: usize = 4;
/// Maximum number of lines that a note names.
const NAMED_LINES: usize = 8;
/// Rows in progress, with the data that determine their order.
pub(super) struct Reading<'a> {
    manifest: &'a Manifest,
    marks: Marks,
    pub(super) columns: Columns,
    pub(super) rows: Vec<Row>,
    /// Text in the order column of each row.
    pub(super) order: Vec<String>,
    /// Split of each row, if a column gives it.
    pub(super) roles: Vec<Role>,
    pub(super) others: Vec<Vec<f64>>,
    text: Vec<bool>,
    groups: Vec<String>,
    tools: Vec<String>,
    /// Reasons for omitted rows, and for omitted removals.
    bad_rows: Vec<(Place, String)>,
    bad_removals: Vec<(Place, String)>,
    /// A row with too few cells: accepted only as the last one.
    short: Option<(Place, usize)>,
}

pub(super) fn read(folder: &Path) -> Result<Table, TrialError> {
    let manifest = Manifest::read(folder)?;
    let file = manifest.source.named(folder, &manifest.csv)?;
    let text = TextTable::read(&file)?;
    let mut marks = Some(Marks::find(&text)?);
    let mut reading: Option<Reading> = None;
    text.rows(|row| {
        match &mut reading {
            None => reading = Some(Reading::new(&manifest, row, marks.take().expect("one header"))?),
            Some(reading) => reading.push(row)?,
        }
        Ok::<_, TrialError>(true)
    })?;
    let reading =
        reading.ok_or_else(|| Place::file(&file).bad::<TrialError>("no row", "a header and rows are expected"))?;
    reading.finish(folder, &text)
}

impl<'a> Reading<'a> {
    fn new(manifest: &'a Manifest, header: &TextRow, marks: Marks) -> Result<Self, TrialError> {
        let columns = Columns::find(manifest, header)?;
        let others = columns.others.len();
        Ok(Self {
            manifest,
            marks,
            columns,
            rows: Vec::new(),
            order: Vec::new(),
            roles: Vec::new(),
            others: vec![Vec::new(); others],
            text: vec![false; others],
            groups: Vec::new(),
            tools: Vec::new(),
            bad_rows: Vec::new(),
            bad_removals: Vec::new(),
            short: None,
        })
    }

    fn push(&mut self, row: &TextRow) -> Result<(), TrialError> {
        if let Some((place, found)) = self.short.take() {
            return Err(self.wrong_count(place, found));
        }
        if row.len() > self.columns.count {
            return Err(self.wrong_count(row.place(self.columns.count), row.len()));
        }
        if row.len() < self.columns.count {
            self.short = Some((row.place(0), row.len()));
            return Ok(());
        }
        match self.row(row)? {
            Ok(read) => self.keep(read, row),
            Err((column, why)) => {
                self.bad_rows.push((row.place(column), why));
                Ok(())
            }
        }
    }

    fn wrong_count(&self, place: Place, found: usize) -> TrialError {
        let hint = if found > self.columns.count { "; are decimals written with commas?" } else { "" };
        place.bad(
            format!("{found} cells where the header has {}{hint}", self.columns.count),
            "as many cells as the header has are expected",
        )
    }

    /// The row, or the column and the reason why it cannot be used.
    fn row(&mut self, row: &TextRow) -> Result<Result<Row, (usize, String)>, TrialError> {
        let mut settings = Vec::new();
        for numbers in self.columns.settings() {
            match setting(numbers, row, &self.marks) {
                Ok(value) => settings.push(value),
                Err(why) => return Ok(Err((numbers.at, why))),
            }
        }
        if let Some(at) = self.columns.order.filter(|&at| row.cell(at).is_empty()) {
            return Ok(Err((at, "the cell of the order is empty".to_owned())));
        }
        let mut settings = settings.into_iter();
        let load = settings.next().unwrap_or_default();
        let motion = self.columns.motion.as_ref().and_then(|_| settings.next());
        let duration = self.columns.duration.as_ref().and_then(|_| settings.next());
        let (force, pressure) = self.load(load);
        Ok(Ok(Row {
            line: row.line,
            began: None,
            force,
            pressure,
            speed: self.speed(motion),
            duration,
            removal_rate: self.removal_rate(row, duration),
            group: named(&mut self.groups, self.columns.group.map(|at| row.text(at))),
            tool: named(&mut self.tools, self.columns.tool.map(|at| row.text(at))),
            fresh: self.columns.fresh.map_or(Ok(false), |at| fresh(row, at))?,
            role: Role::Calibration,
            usage: settings.collect(),
        }))
    }

    /// Force [N] and pressure [Pa], as far as they are known.
    fn load(&self, load: f64) -> (Option<f64>, Option<f64>) {
        let area = self.manifest.area;
        match self.columns.load.0 {
            Load::Force => (Some(load), area.map(|area| load / area)),
            Load::Pressure => (area.map(|area| load * area), Some(load)),
        }
    }

    /// Sliding speed [m/s].
    fn speed(&self, motion: Option<f64>) -> Option<f64> {
        match self.columns.motion.as_ref()?.0 {
            Motion::Speed => motion,
            Motion::Spindle => Some(motion?.abs() * self.manifest.radius?),
        }
    }

    fn removal_rate(&mut self, row: &TextRow, duration: Option<f64>) -> Option<f64> {
        let Columns { removed, removal: (_, per_time), per_mass, .. } = &self.columns;
        let why = match number(removed, row, &self.marks) {
            Ok(value) if value > 0.0 => {
                let total = value * per_mass;
                return Some(if *per_time { total } else { total / duration? });
            }
            Ok(_) => format!("{} is {}, which has no logarithm", removed.name, plain(row, removed.at)),
            Err(why) => why,
        };
        let place = row.place(removed.at);
        self.bad_removals.push((place, why));
        None
    }

    fn keep(&mut self, read: Row, row: &TextRow) -> Result<(), TrialError> {
        self.rows.push(read);
        self.order.extend(self.columns.order.map(|at| row.text(at)));
        if let Some(at) = self.columns.role {
            self.roles.push(role(row, at)?);
        }
        for (k, (column, _)) in self.columns.others.iter().enumerate() {
            let value = row.number(*column);
            self.text[k] |= value.is_err();
            let value = value.ok().flatten().filter(|value| !self.marks.has(*column, *value));
            self.others[k].push(value.unwrap_or(f64::NAN));
        }
        Ok(())
    }

    fn finish(mut self, folder: &Path, text: &TextTable) -> Result<Table, TrialError> {
        let mut notes = text.notes.clone();
        notes.extend(self.short_row(text)?);
        self.check_losses(text.file())?;
        plausible::check(&self.columns, &self.rows, self.manifest.radius, text.file())?;
        notes.extend(self.sort(text.file())?);
        let (in_time, note) = self.is_in_time();
        notes.extend(note);
        notes.extend(self.set_roles(text.file())?);
        for (bad, what) in [
            (&self.bad_rows, "left out"),
            (&self.bad_removals, "without a removal that can be compared, but the tool works in them"),
        ] {
            notes.extend(losses(bad, what));
        }
        let covariates = self.covariates(&mut notes);
        let columns = &self.columns;
        let usage = |numbers: &Numbers| Usage {
            key: numbers.key.clone(),
            name: numbers.name.clone(),
            dimension: numbers.unit.dimension(),
            unit: numbers.unit_text.clone(),
            scale: numbers.unit.scale(),
        };
        let mut table = Table {
            folder: folder.to_owned(),
            name: self.manifest.name.clone(),
            process: self.manifest.process,
            area: self.manifest.area,
            radius: self.manifest.radius,
            coating: self.manifest.coating,
            removed: columns.removal.0,
            groups: self.groups,
            tools: self.tools,
            usage: columns.usage.iter().map(usage).collect(),
            rows: self.rows,
            in_time,
            noise: self.manifest.noise,
            covariates,
            notes: Vec::new(),
        };
        notes.splice(0..0, understood(self.manifest, columns, &table));
        table.notes = notes;
        Ok(table)
    }

    fn short_row(&mut self, text: &TextTable) -> Result<Option<String>, TrialError> {
        let Some((place, found)) = self.short.take() else { return Ok(None) };
        if !text.ends_within_a_line() {
            return Err(self.wrong_count(place, found));
        }
        let line = place.line.unwrap_or_default();
        Ok(Some(format!("line {line}, the last one, is cut short after {found} cells and left out")))
    }

    /// Refuses a table that loses most of its rows, at the first fault.
    fn check_losses(&self, file: &Path) -> Result<(), TrialError> {
        let lost = self.bad_rows.len() + self.bad_removals.len();
        let known = self.rows.iter().filter(|row| row.removal_rate.is_some()).count();
        let first = self.bad_rows.iter().chain(&self.bad_removals).min_by_key(|(place, _)| place.line);
        match first {
            Some((place, why)) if lost > known => Err(place.clone().bad(
                format!("{why}, and {} of {} rows cannot be used", lost, lost + known),
                "a column of numbers in the stated unit is expected",
            )),
            _ if known < LEAST_ROWS => Err(Place::file(file)
                .bad(format!("{known} rows with a removal"), format!("at least {LEAST_ROWS} are expected"))),
            _ => Ok(()),
        }
    }

    fn covariates(&mut self, notes: &mut Vec<String>) -> Vec<Covariate> {
        let mut covariates = Vec::new();
        for ((values, (_, name)), text) in self.others.drain(..).zip(&self.columns.others).zip(&self.text) {
            if *text {
                notes.push(format!("column {name:?} holds text and is left out"));
            } else {
                covariates.push(Covariate { name: name.clone(), values, hole: None });
            }
        }
        if !covariates.is_empty() {
            let names: Vec<&str> = covariates.iter().map(|covariate| covariate.name.as_str()).collect();
            notes.push(format!("further columns kept as covariates: {}", names.join(", ")));
        }
        covariates
    }
}

/// A finite number [SI], or the reason why the cell has none.
fn number(numbers: &Numbers, row: &TextRow, marks: &Marks) -> Result<f64, String> {
    match row.number(numbers.at) {
        Ok(Some(value)) if marks.has(numbers.at, value) => {
            Err(format!("{} is {}, a mark of a missing value", numbers.name, plain(row, numbers.at)))
        }
        Ok(Some(value)) if value.is_finite() => Ok(numbers.unit.to_si(value)),
        Ok(None) => Err(format!("{} is empty", numbers.name)),
        _ => Err(format!("{} is {}, not a number", numbers.name, row.shown(numbers.at))),
    }
}

/// A number as written in the file.
fn plain(row: &TextRow, at: usize) -> String {
    row.shown(at).trim_matches('"').to_owned()
}

/// As [`number`], and positive if the quantity must be.
fn setting(numbers: &Numbers, row: &TextRow, marks: &Marks) -> Result<f64, String> {
    let value = number(numbers, row, marks)?;
    let has_sign = match numbers.key.as_str() {
        "force" | "pressure" | "speed" | "duration" => false,
        "spindle_rpm" => value != 0.0,
        _ => true,
    };
    let fits = has_sign || value > 0.0;
    if fits { Ok(value) } else { Err(format!("{} is {}, not above zero", numbers.name, plain(row, numbers.at))) }
}

/// Index of a name in a list; a new name is appended.
fn named(list: &mut Vec<String>, name: Option<String>) -> usize {
    let name = name.unwrap_or_default();
    list.iter().position(|known| *known == name).unwrap_or_else(|| {
        list.push(name);
        list.len() - 1
    })
}

fn fresh(row: &TextRow, at: usize) -> Result<bool, TrialError> {
    match row.text(at).to_lowercase().as_str() {
        "true" | "yes" | "1" => Ok(true),
        "false" | "no" | "0" | "" => Ok(false),
        _ => Err(row.place(at).bad(row.shown(at), "true or false, yes or no, 1 or 0 is expected")),
    }
}

fn role(row: &TextRow, at: usize) -> Result<Role, TrialError> {
    match row.text(at).to_lowercase().as_str() {
        "calibration" => Ok(Role::Calibration),
        "evaluation" => Ok(Role::Evaluation),
        _ => Err(row.place(at).bad(row.shown(at), "calibration or evaluation is expected")),
    }
}

/// A sentence about omitted rows.
fn losses(bad: &[(Place, String)], what: &str) -> Option<String> {
    let line = |(place, why): &(Place, String)| format!("line {} ({why})", place.line.unwrap_or_default());
    let named: Vec<String> = bad.iter().take(NAMED_LINES).map(line).collect();
    let more = if bad.len() > NAMED_LINES { " and more" } else { "" };
    (!bad.is_empty()).then(|| format!("{} rows are {what}: {}{more}", bad.len(), named.join(", ")))
}

/// Description of the table, in sentences.
fn understood(manifest: &Manifest, columns: &Columns, table: &Table) -> Vec<String> {
    let of = |numbers: &Numbers| format!("{} from {:?}", numbers.key, numbers.name);
    let given: Vec<String> = columns.settings().chain([&columns.removed]).map(of).collect();
    let evaluates = table.rows.iter().filter(|row| row.role == Role::Evaluation).count();
    let mut notes = vec![format!(
        "{} rows, of which {evaluates} evaluate, in {} groups; {}",
        table.rows.len(),
        table.groups.len(),
        given.join(", ")
    )];
    if manifest.polishes {
        notes.push("polishing is read as sanding: removal by pressure, speed and time (Preston 1927)".to_owned());
    }
    if columns.duration.is_none() {
        notes.push("no column gives a duration: what a tool remembers does not move between rows".to_owned());
    }
    notes
}
