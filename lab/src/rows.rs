//! Rows of a table as data: measured removals compared with predictions.

use effects::{CompiledModel, Effect, Library, Model, Process, RowCounts};

use super::coordinates::Coordinate;
use super::evidence::{Agreement, ErrorUnit, Evidence, EvidenceError, Split};
use super::pass_trend::{PassTrend, trend_of_rows};
use super::summary::EffectSummary;
use super::table_library::{column_effect, column_of};
use super::table_noise::{RowNoise, row_noise};
use super::table_reads::silenced;
use super::table_relation::unrelated;
use super::table_steps::Rows;
use crate::criteria::{
    GROSS_RESIDUAL_SIGMAS, GROUP_GAIN_SIGMA, HUBER_CONSTANT, OUTLIER_SIGMAS, PREDICTION_LEAST_SHARE, ROW_BLOCK_LENGTH,
    ROW_BLOCKS_LEAST, SAME_SETTING, SMOOTH_ERROR_REMOVAL,
};
use trials::measure::{centre_and_sigma, median};
use trials::table::Table;
use trials::trial::Role;

/// Most iterations for the gain of a group.
const LOCATION_ROUNDS: usize = 30;

/// A row that does not fit the others.
#[derive(Clone, Debug, PartialEq)]
pub struct Outlier {
    /// Line in the CSV, from 1.
    pub line: u64,
    /// Whitened residual.
    pub residual: f64,
}

/// The rows of a table as data.
pub struct RowEvidence<'a> {
    /// The table.
    pub table: &'a Table,
    /// Standard deviation of the logarithm of a row's removal.
    pub noise: f64,
    /// The same with the uncertainty of the noise: upper limit of the calibration residual of a complete model.
    noise_limit: f64,
    /// Assumptions, one sentence each.
    pub notes: Vec<String>,
    /// Statement that the removals do not depend on the settings, if so.
    unrelated: Option<String>,
    /// Rows with a removal, by split.
    calibration: Vec<usize>,
    evaluation: Vec<usize>,
    /// Median removal rate of the calibration rows.
    middle: f64,
}

impl<'a> RowEvidence<'a> {
    /// Converts the rows of a table to data. Removals of evaluation rows are used only for their own residuals.
    ///
    /// # Errors
    /// If the table has no calibration rows.
    pub fn new(table: &'a Table) -> Result<Self, EvidenceError> {
        let of = |role: Role| -> Vec<usize> {
            let takes = |&at: &usize| table.rows[at].role == role && table.rows[at].removal_rate.is_some();
            (0..table.rows.len()).filter(takes).collect()
        };
        let (calibration, evaluation) = (of(Role::Calibration), of(Role::Evaluation));
        let rates = calibration.iter().filter_map(|&at| table.rows[at].removal_rate).collect();
        let middle =
            median(rates).ok_or_else(|| EvidenceError::NoData(format!("{}: no row calibrates", table.name)))?;
        let RowNoise { sigma: noise, limit: noise_limit, how } = row_noise(table, &calibration);
        let unrelated = unrelated(table, &calibration);
        let mut evidence =
            Self { table, noise, noise_limit, notes: vec![how], unrelated, calibration, evaluation, middle };
        evidence.notes.extend(evidence.assumptions());
        evidence.notes.extend(evidence.unrelated.clone());
        Ok(evidence)
    }

    /// Indices in [`Table::rows`] of a split's residuals.
    pub fn of(&self, split: Split) -> &[usize] {
        match split {
            Split::Calibration => &self.calibration,
            Split::Evaluation => &self.evaluation,
        }
    }

    /// Predicted removal rate of every row of the table, as [`trials::table::Row::removal_rate`]. Effects that rows
    /// cannot show are left out.
    ///
    /// # Errors
    /// If a formula gives no finite number.
    pub fn predicted(&self, model: &CompiledModel) -> Result<Vec<f64>, EvidenceError> {
        let model = silenced(self.table, model);
        Rows::new(self.table, &model).predicted().map_err(|error| EvidenceError::NoData(error.to_string()))
    }

    /// The rows of a split whose residuals far exceed noise; the robust sum of a fit limits their influence.
    pub fn outliers(&self, residuals: &[f64], split: Split) -> Vec<Outlier> {
        let row = |(&at, &residual): (&usize, &f64)| Outlier { line: self.table.rows[at].line, residual };
        self.of(split).iter().zip(residuals).map(row).filter(|row| row.residual.abs() > OUTLIER_SIGMAS).collect()
    }

    /// Log ratio of measured to predicted removal for the rows of a split.
    fn differences(&self, predicted: &[f64], split: Split) -> Vec<f64> {
        let least = PREDICTION_LEAST_SHARE * self.middle;
        let difference = |&at: &usize| {
            let measured = self.table.rows[at].removal_rate.expect("rows of a split have a removal");
            (measured / predicted[at].max(least)).ln()
        };
        self.of(split).iter().map(difference).collect()
    }

    /// Log gain of each group from calibration rows; for a group without any, from its own rows of the split.
    fn gains(&self, (predicted, split): (&[f64], Split)) -> Vec<f64> {
        if self.table.groups.len() < 2 {
            return vec![0.0; self.table.groups.len()];
        }
        let known = self.differences(predicted, Split::Calibration);
        let own = self.differences(predicted, split);
        let of = |differences: &[f64], split: Split, group: usize| -> Vec<f64> {
            let rows = differences.iter().zip(self.of(split));
            rows.filter(|(_, at)| self.table.rows[**at].group == group).map(|(difference, _)| *difference).collect()
        };
        let gain = |group: usize| {
            let calibration = of(&known, Split::Calibration, group);
            let rows = if calibration.is_empty() { of(&own, split, group) } else { calibration };
            location(&rows, HUBER_CONSTANT * self.noise)
        };
        (0..self.table.groups.len()).map(gain).collect()
    }

    /// Contribution of the prior of each group's gain to each whitened residual of its calibration rows. It is a
    /// constant over the group, orthogonal to the residuals after the gain, with the prior's sum of squares.
    fn priors(&self, gains: &[f64], split: Split) -> Vec<f64> {
        let rows = |group: usize| self.calibration.iter().filter(|at| self.table.rows[**at].group == group).count();
        let own = |(group, gain): (usize, &f64)| match split {
            Split::Calibration => gain / GROUP_GAIN_SIGMA / (rows(group).max(1) as f64).sqrt(),
            Split::Evaluation => 0.0,
        };
        gains.iter().enumerate().map(own).collect()
    }
}

/// Huber's estimate of location: values beyond a cut count linearly (Huber 1964).
fn location(values: &[f64], cut: f64) -> f64 {
    let first = median(values.to_vec()).unwrap_or(0.0);
    (0..LOCATION_ROUNDS).fold(first, |at, _| {
        let weight = |value: &f64| (cut / (value - at).abs().max(f64::MIN_POSITIVE)).min(1.0);
        let total: f64 = values.iter().map(weight).sum();
        if total > 0.0 { values.iter().map(|value| weight(value) * value).sum::<f64>() / total } else { at }
    })
}

/// Whitened residuals without gross outliers, which far exceed both the noise and all other residuals. Where a model is
/// wrong all residuals are large, and none of them is an outlier.
fn without_outliers(residuals: &[f64]) -> Vec<f64> {
    let (middle, spread) = centre_and_sigma(residuals).unwrap_or_default();
    let is_outlier = |r: f64| r.abs() > OUTLIER_SIGMAS && (r - middle).abs() > GROSS_RESIDUAL_SIGMAS * spread;
    residuals.iter().copied().filter(|&r| !is_outlier(r)).collect()
}

impl Evidence for RowEvidence<'_> {
    fn process(&self) -> Process {
        self.table.process
    }

    fn rows(&self) -> RowCounts {
        RowCounts::default()
    }

    fn residuals(&self, model: &CompiledModel, split: Split) -> Result<Vec<f64>, EvidenceError> {
        let predicted = self.predicted(model)?;
        let gains = self.gains((&predicted, split));
        let priors = self.priors(&gains, split);
        let group = |at: &usize| self.table.rows[*at].group;
        let residual =
            |(difference, at): (f64, &usize)| (difference - gains[group(at)]) / self.noise + priors[group(at)];
        Ok(self.differences(&predicted, split).into_iter().zip(self.of(split)).map(residual).collect())
    }

    fn adapted(&self, model: Model, library: &Library) -> Model {
        self.scaled(model.clone(), library).unwrap_or(model)
    }

    fn coordinates(&self, model: &CompiledModel) -> Vec<Coordinate> {
        Self::coordinates(self, model).map(|(coordinates, _)| coordinates).unwrap_or_default()
    }

    fn agreement(&self, model: &CompiledModel, split: Split) -> Result<Vec<Agreement>, EvidenceError> {
        let residuals = self.residuals(model, split)?;
        let kept = without_outliers(&residuals);
        let rms = self.noise * (kept.iter().map(|r| r * r).sum::<f64>() / kept.len().max(1) as f64).sqrt();
        let about = self.table.name.clone();
        let noise = if split == Split::Calibration { self.noise_limit } else { self.noise };
        let agreement =
            Agreement { about, rms, floor: self.noise, noise, scale: 1.0, smooth_error: SMOOTH_ERROR_REMOVAL };
        Ok(if residuals.is_empty() { Vec::new() } else { vec![agreement] })
    }

    fn size(&self, change: &[f64]) -> f64 {
        self.noise * (change.iter().map(|c| c * c).sum::<f64>() / change.len().max(1) as f64).sqrt()
    }

    fn trend(&self, model: &CompiledModel) -> Result<Option<PassTrend>, EvidenceError> {
        trend_of_rows(self, model)
    }

    fn is_blind_to(&self, effect: &Effect) -> Option<String> {
        self.acts(effect).err()
    }

    fn unrelated(&self) -> Option<String> {
        self.unrelated.clone()
    }

    fn family(&self, effect: &str) -> String {
        column_of(self.table, effect).map_or(effect.to_owned(), |(usage, _)| column_effect(self.table, usage))
    }

    fn unit(&self) -> ErrorUnit {
        ErrorUnit::Share
    }

    fn words(&self, effect: &EffectSummary) -> Option<String> {
        self.column_words(effect)
    }

    fn conditions(&self, model: &CompiledModel) -> Result<usize, EvidenceError> {
        let predicted = self.predicted(model)?;
        let mut each: Vec<(usize, f64)> =
            self.calibration.iter().map(|&at| (self.table.rows[at].group, predicted[at])).collect();
        each.sort_by(|a, b| a.0.cmp(&b.0).then(a.1.total_cmp(&b.1)));
        let is_same = |a: &(usize, f64), b: &(usize, f64)| a.0 == b.0 && (b.1 - a.1) <= SAME_SETTING * a.1.abs();
        let conditions = each.chunk_by(is_same).count();
        let gains = each.chunk_by(|a, b| a.0 == b.0).count().saturating_sub(1);
        Ok(conditions - gains)
    }

    fn blocks(&self, split: Split) -> Vec<usize> {
        let rows = self.of(split);
        let longest = if self.table.in_time { ROW_BLOCK_LENGTH } else { 1 };
        let length = (rows.len() / ROW_BLOCKS_LEAST).clamp(1, longest);
        rows.iter().map(|at| at / length).collect()
    }
}
