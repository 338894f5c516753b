//! Order of a table's rows in time, and selection of the held-out rows.

use std::path::Path;

use super::Row;
use super::columns::Ordering;
use super::held_out::held_out;
use super::order::Order;
use super::read::{LEAST_ROWS, Reading};
use crate::trial::{Place, Role, TrialError};
use files::input::quoted;

/// Seed of the draw of held-out rows.
const SEED: u64 = 1;
/// Relative difference below which two settings are the same.
const SAME: f64 = 1e-9;
/// p-value, for rows in random order, below which they count as sorted on purpose.
const SORTED_P_VALUE: f64 = 0.01;

/// A setting's name, and the function that reads it from a row.
type Setting = (&'static str, fn(&Row) -> Option<f64>);
/// Settings by which a file may be sorted.
const SETTINGS: [Setting; 4] = [
    ("force", |row| row.force),
    ("pressure", |row| row.pressure),
    ("speed", |row| row.speed),
    ("duration", |row| row.duration),
];

impl Reading<'_> {
    /// Puts all rows in the order of time.
    pub(super) fn sort(&mut self, file: &Path) -> Result<Option<String>, TrialError> {
        let Some(column) = self.columns.order else { return Ok(None) };
        let cells: Vec<&str> = self.order.iter().map(String::as_str).collect();
        let order = Order::of(&cells).map_err(|at| {
            let found = format!("{} is neither a number nor a date as in the rows before", quoted(&self.order[at]));
            Place::cell(file, self.rows[at].line, column + 1).bad::<TrialError>(
                found,
                "numbers, or dates such as 2024-03-31, 2024-03-31 14:05 or 31.03.2024, are expected",
            )
        })?;
        let (keys, how) = match &order {
            Order::Numbers(keys) => (keys, "by number".to_owned()),
            Order::Dates(keys, format) => {
                let first = keys.iter().copied().fold(f64::INFINITY, f64::min);
                self.rows.iter_mut().zip(keys).for_each(|(row, key)| row.began = Some(key - first));
                (keys, format!("by date, read as {format}"))
            }
        };
        let mut places: Vec<usize> = (0..keys.len()).collect();
        places.sort_by(|&a, &b| keys[a].total_cmp(&keys[b]));
        let moved = places.iter().enumerate().filter(|(at, place)| at != *place).count();
        self.rows = places.iter().map(|&at| self.rows[at].clone()).collect();
        self.roles = places.iter().filter_map(|&at| self.roles.get(at).copied()).collect();
        for values in &mut self.others {
            *values = places.iter().map(|&at| values[at]).collect();
        }
        Ok(Some(format!("rows are ordered {how}; {moved} are elsewhere in the file")))
    }

    /// True if the order of the rows is that of time, with a note on it. If the manifest does not say, a file sorted by
    /// a setting is not in time: designed experiments are listed like that. If the tool is fresh in some rows and not
    /// in others, the file is in time, because it records the tool's history.
    pub(super) fn is_in_time(&self) -> (bool, Option<String>) {
        match self.columns.ordering {
            _ if self.columns.order.is_some() => return (true, None),
            Some(Ordering::File) => return (true, None),
            Some(Ordering::None) => return (false, Some("the order of the rows says nothing about time".to_owned())),
            None => {}
        }
        let fresh = self.rows.iter().filter(|row| row.fresh).count();
        if fresh > 0 && fresh < self.rows.len() {
            return (true, None);
        }
        let sorted = SETTINGS.into_iter().find(|(_, value)| is_sorted(&self.rows, *value));
        let Some((setting, _)) = sorted else { return (true, None) };
        let note = format!(
            "the rows are sorted by {setting}, so their order is not taken for time: neither drift nor tool history \
             from row to row is searched for. State order = \"file\" if they were done in this order, or order = \
             \"none\""
        );
        (false, Some(note))
    }

    pub(super) fn set_roles(&mut self, file: &Path) -> Result<Option<String>, TrialError> {
        let is_measured = |row: &Row| row.removal_rate.is_some();
        let measured: Vec<usize> = (0..self.rows.len()).filter(|&at| is_measured(&self.rows[at])).collect();
        let is_stated = !self.roles.is_empty();
        let held = if is_stated { Vec::new() } else { held_out((&self.rows, &measured), LEAST_ROWS, SEED) };
        let drawn = |at: usize| if held.contains(&at) { Role::Evaluation } else { Role::Calibration };
        for (at, row) in self.rows.iter_mut().enumerate() {
            row.role = self.roles.get(at).copied().unwrap_or_else(|| drawn(at));
        }
        let calibrates = |row: &&Row| row.role == Role::Calibration && is_measured(row);
        let known = self.rows.iter().filter(calibrates).count();
        if known < LEAST_ROWS {
            let found = format!("{known} rows with a removal calibrate");
            return Err(Place::file(file).bad(found, format!("at least {LEAST_ROWS} are expected")));
        }
        Ok((!is_stated).then(|| match held.len() {
            0 => format!("no column says which rows evaluate, and {} rows are too few: all calibrate", measured.len()),
            count => format!(
                "no column says which rows evaluate: {count} of {} are drawn at random (seed {SEED}), balanced over the \
                 levels of every setting",
                measured.len()
            ),
        }))
    }
}

/// True if rows are sorted by a setting more than random order would be: monotonic throughout, or each of at least
/// three levels is contiguous.
fn is_sorted(rows: &[Row], value: fn(&Row) -> Option<f64>) -> bool {
    let Some(values) = rows.iter().map(value).collect::<Option<Vec<f64>>>() else { return false };
    let is_same = |a: f64, b: f64| (a - b).abs() <= SAME * a.abs().max(b.abs());
    let runs = 1 + values.windows(2).filter(|pair| !is_same(pair[0], pair[1])).count();
    let mut sorted = values.clone();
    sorted.sort_by(f64::total_cmp);
    let levels: Vec<usize> = sorted.chunk_by(|a, b| is_same(*a, *b)).map(<[f64]>::len).collect();
    if levels.len() < 3 || runs != levels.len() {
        return false;
    }
    let is_monotone = values.is_sorted() || values.iter().rev().is_sorted();
    let ln_factorial = |count: usize| (1..=count).map(|k| (k as f64).ln()).sum::<f64>();
    let orders = if is_monotone { 2.0f64.ln() } else { ln_factorial(levels.len()) };
    let chance = orders + levels.iter().map(|&count| ln_factorial(count)).sum::<f64>() - ln_factorial(rows.len());
    chance < SORTED_P_VALUE.ln()
}
