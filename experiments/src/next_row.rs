//! The most informative next row of a table: the last sequence of rows is repeated with one new row, which is chosen to
//! distinguish two rivals.

use nalgebra::{DMatrix, DVector};
use statrs::distribution::{ContinuousCDF, Normal};

use super::as_test;
use super::score::left_after_refit;
use lab::{Diagnosis, Evidence, EvidenceError, Fit, NextTrial, RowEvidence, Split, moved};
use trials::measure::median;
use trials::table::{Row, Table};
use trials::trial::{RPM, Role};

/// Most rows of the sequence that are repeated before the new one.
const MOST_ROWS: usize = 6;

/// Setting that the new row changes.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Change {
    Nothing,
    Dressed,
    Force(f64),
    Speed(f64),
    Duration(f64),
}

const CHANGES: [Change; 8] = [
    Change::Nothing,
    Change::Dressed,
    Change::Force(0.6),
    Change::Force(1.6),
    Change::Speed(0.6),
    Change::Speed(1.4),
    Change::Duration(0.5),
    Change::Duration(3.0),
];

/// The row on which the effect that was found last changes the prediction most, as a test of the effect; `None` where
/// nothing was found.
///
/// # Errors
/// If a model cannot be evaluated.
pub fn testing_row(evidence: &RowEvidence, diagnosis: &Diagnosis) -> Result<Option<NextTrial>, EvidenceError> {
    let Some((round, found)) = diagnosis.last_found() else { return Ok(None) };
    let with = (found.suspect.name(), &found.suspect.fit);
    Ok(next_row(evidence, (with, ("without it", &round.base)))?.map(as_test))
}

/// The row that distinguishes the two rivals of a diagnosis; `None` unless two are still in play.
///
/// # Errors
/// If a rival cannot be evaluated.
pub fn separating_row(evidence: &RowEvidence, diagnosis: &Diagnosis) -> Result<Option<NextTrial>, EvidenceError> {
    let Some([one, other]) = diagnosis.rivals().map(|rivals| rivals.map(|rival| &rival.suspect)) else {
        return Ok(None);
    };
    next_row(evidence, ((one.name(), &one.fit), (other.name(), &other.fit)))
}

/// The row that best distinguishes two fitted rivals after the last sequence of rows is repeated, even if their other
/// parameters are refitted (Atkinson and Fedorov 1975); `None` for an empty table.
///
/// # Errors
/// If a rival cannot be evaluated.
pub fn next_row(
    evidence: &RowEvidence,
    (first, second): ((&str, &Fit), (&str, &Fit)),
) -> Result<Option<NextTrial>, EvidenceError> {
    let Some(work) = last_work(evidence.table) else { return Ok(None) };
    let mut best: Option<NextTrial> = None;
    for change in CHANGES {
        let Some(row) = work.last().and_then(|row| changed(row, change)) else { continue };
        let rows: Vec<Row> = work.iter().cloned().chain([row]).collect();
        let delta_chi2 = separation(evidence, &rows, first.1, second.1)?;
        if best.as_ref().is_none_or(|best| delta_chi2 > best.expected_delta_chi2) {
            best = Some(stated(evidence.table, &rows, change, [first.0, second.0], delta_chi2));
        }
    }
    Ok(best)
}

/// The rows since the tool was last fresh, or the last row alone; `None` for an empty table.
fn last_work(table: &Table) -> Option<Vec<Row>> {
    let start = table.rows.iter().rposition(|row| row.fresh).unwrap_or(table.rows.len().checked_sub(1)?);
    Some(table.rows[start..].iter().take(MOST_ROWS).cloned().collect())
}

/// The row that follows another with one setting changed; `None` where the table lacks that setting.
fn changed(row: &Row, change: Change) -> Option<Row> {
    let mut next = Row { fresh: false, began: None, ..row.clone() };
    let scale = |value: &mut Option<f64>, factor: f64| value.as_mut().map(|value| *value *= factor);
    match change {
        Change::Nothing => {}
        Change::Dressed => next.fresh = true,
        Change::Force(factor) => {
            let force = scale(&mut next.force, factor);
            scale(&mut next.pressure, factor).or(force)?;
        }
        Change::Speed(factor) => scale(&mut next.speed, factor)?,
        Change::Duration(factor) => scale(&mut next.duration, factor)?,
    }
    Some(next)
}

/// Least squared difference of two rivals' predictions of new rows, over all changes of the second's parameters that
/// the old rows allow.
fn separation(evidence: &RowEvidence, rows: &[Row], first: &Fit, second: &Fit) -> Result<f64, EvidenceError> {
    let usual = median(evidence.table.rows.iter().filter_map(|row| row.removal_rate).collect());
    let mut table = evidence.table.clone();
    table.covariates.clear();
    let new = |row: &Row| Row { role: Role::Calibration, removal_rate: usual, ..row.clone() };
    table.rows.extend(rows.iter().map(new));
    let mut there = RowEvidence::new(&table)?;
    there.noise = evidence.noise;
    let of = |model: &effects::CompiledModel| -> Result<DVector<f64>, EvidenceError> {
        let all = there.residuals(model, Split::Calibration)?;
        Ok(DVector::from_column_slice(&all[all.len() - rows.len()..]))
    };
    let (a, b) = (of(&first.model)?, of(&second.model)?);
    let difference = &b - a;
    let mut columns = Vec::new();
    for (k, coordinate) in second.coordinates.iter().enumerate() {
        let mut at = second.at.clone();
        at[k] = coordinate.clamped(at[k] + coordinate.step());
        let step = at[k] - second.at[k];
        let moved = of(&moved(&second.model, &second.coordinates, &at))?;
        columns.push(if step == 0.0 { DVector::zeros(b.len()) } else { (moved - &b) / step });
    }
    let precision = second.jacobian.tr_mul(&second.jacobian);
    Ok(left_after_refit(&difference, &DMatrix::from_columns(&columns), &precision))
}

fn stated(table: &Table, rows: &[Row], change: Change, separates: [&str; 2], delta_chi2: f64) -> NextTrial {
    let passes = match rows.len() - 1 {
        1 => "the last row once more".to_owned(),
        count => format!("the last {count} rows once more"),
    };
    let then = match change {
        Change::Nothing => "a further equal row without dressing the tool",
        Change::Dressed => "the tool dressed and an equal row",
        Change::Force(factor) if factor < 1.0 => "a row at 0.6 times the force",
        Change::Force(_) => "a row at 1.6 times the force",
        Change::Speed(factor) if factor < 1.0 => "a row at 0.6 times the speed",
        Change::Speed(_) => "a row at 1.4 times the speed",
        Change::Duration(factor) if factor < 1.0 => "a row of half the duration",
        Change::Duration(_) => "a row of three times the duration",
    };
    let force = |row: &Row| row.force.or(Some(row.pressure? * table.area?));
    let turns = |row: &Row| Some(row.speed? / table.radius? / RPM);
    NextTrial {
        summary: format!("Repeat {passes} on a new workpiece, then {then}."),
        force_n: rows.iter().filter_map(force).collect(),
        feed_mm_s: Vec::new(),
        spindle_rpm: rows.iter().filter_map(turns).collect(),
        separates: separates.map(str::to_owned).to_vec(),
        expected_delta_chi2: delta_chi2,
        probability_right: Normal::standard().cdf(0.5 * delta_chi2.sqrt()),
        choice: None,
    }
}
