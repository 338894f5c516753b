//! The rows of a table as data: what each removed against what a model predicts of it.

use effects::{CompiledModel, Effect, Process, RowCounts};
use nalgebra::{DMatrix, DVector};

use super::coordinates::Coordinate;
use super::covariance::{Freedom, Whitener};
use super::evidence::{Agreement, ErrorUnit, Evidence, EvidenceError, Split};
use super::pass_trend::{PassTrend, trend_of_rows};
use super::table_noise::row_noise;
use super::table_reach::silenced;
use super::table_steps::Rows;
use crate::criteria::{GROUP_GAIN_SIGMA, OUTLIER_SIGMAS, PREDICTION_LEAST_SHARE, ROW_BLOCK_LENGTH};
use trials::measure::median;
use trials::table::Table;
use trials::trial::Role;

/// Rows of a split that share a gain.
#[derive(Clone, Debug)]
struct Group {
    /// Places among the split's rows.
    members: Vec<usize>,
    /// Place among the table's groups.
    group: usize,
}

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
    /// What was assumed, one sentence each.
    pub notes: Vec<String>,
    /// Rows with a removal, by split.
    calibration: Vec<usize>,
    evaluation: Vec<usize>,
    /// Median removal rate of the calibration rows.
    middle: f64,
}

impl<'a> RowEvidence<'a> {
    /// Makes the rows of a table data. What evaluation rows removed is looked at only for their own residuals.
    ///
    /// # Errors
    /// A table without rows that calibrate.
    pub fn new(table: &'a Table) -> Result<Self, EvidenceError> {
        let of = |role: Role| -> Vec<usize> {
            let takes = |&at: &usize| table.rows[at].role == role && table.rows[at].removal_rate.is_some();
            (0..table.rows.len()).filter(takes).collect()
        };
        let (calibration, evaluation) = (of(Role::Calibration), of(Role::Evaluation));
        let rates = calibration.iter().filter_map(|&at| table.rows[at].removal_rate).collect();
        let middle =
            median(rates).ok_or_else(|| EvidenceError::NoData(format!("{}: no row calibrates", table.name)))?;
        let (noise, how) = row_noise(table, &calibration);
        let mut evidence = Self { table, noise, notes: vec![how], calibration, evaluation, middle };
        evidence.notes.extend(evidence.assumptions());
        Ok(evidence)
    }

    /// Places among [`Table::rows`] of a split's residuals.
    pub fn of(&self, split: Split) -> &[usize] {
        match split {
            Split::Calibration => &self.calibration,
            Split::Evaluation => &self.evaluation,
        }
    }

    /// Predicted removal rate of every row of the table, as [`trials::table::Row::removal_rate`]. Effects that rows cannot
    /// show are left out.
    ///
    /// # Errors
    /// A formula that gives no finite number.
    pub fn predicted(&self, model: &CompiledModel) -> Result<Vec<f64>, EvidenceError> {
        let model = silenced(self.table, model);
        Rows::new(self.table, &model).predicted().map_err(|error| EvidenceError::NoData(error.to_string()))
    }

    /// The rows of a split whose residuals are far beyond noise: a fit's robust sum keeps them from leading it.
    pub fn outliers(&self, residuals: &[f64], split: Split) -> Vec<Outlier> {
        let row = |(&at, &residual): (&usize, &f64)| Outlier { line: self.table.rows[at].line, residual };
        self.of(split).iter().zip(residuals).map(row).filter(|row| row.residual.abs() > OUTLIER_SIGMAS).collect()
    }

    /// Logarithm of measured over predicted for the rows of a split.
    fn differences(&self, predicted: &[f64], split: Split) -> Vec<f64> {
        let least = PREDICTION_LEAST_SHARE * self.middle;
        let difference = |&at: &usize| {
            let measured = self.table.rows[at].removal_rate.expect("rows of a split have a removal");
            (measured / predicted[at].max(least)).ln()
        };
        self.of(split).iter().map(difference).collect()
    }

    fn groups(&self, split: Split) -> Vec<Group> {
        let rows = self.of(split);
        let group = |group: usize| {
            let members = (0..rows.len()).filter(|&k| self.table.rows[rows[k]].group == group).collect();
            Group { members, group }
        };
        (0..self.table.groups.len()).map(group).collect()
    }

    /// The gain that each group has of its own before any row is seen.
    fn free_gain(&self) -> Freedom {
        let free = self.table.groups.len() > 1;
        let sigmas: &[f64] = if free { &[GROUP_GAIN_SIGMA] } else { &[] };
        Freedom::around_zero(DMatrix::zeros(0, sigmas.len()), sigmas)
    }

    /// Whitens differences of `rows` rows with a gain; `None` of no rows.
    fn whitener(&self, rows: usize, gain: &Freedom) -> Whitener {
        let columns = DMatrix::from_element(rows, gain.mean.len(), 1.0);
        let noise = DMatrix::from_diagonal(&DVector::from_element(rows, self.noise * self.noise));
        let freedom = Freedom { columns, mean: gain.mean.clone(), covariance: gain.covariance.clone() };
        Whitener::new(noise, freedom).expect("the noise is above zero")
    }

    /// The gain of a group given what its calibration rows differ by.
    fn known_gain(&self, group: usize, differences: &[f64]) -> Freedom {
        let members = &self.groups(Split::Calibration)[group].members;
        let own: Vec<f64> = members.iter().map(|&k| differences[k]).collect();
        let gain = self.free_gain();
        if own.is_empty() { gain } else { self.whitener(own.len(), &gain).degrees_of_freedom(&own) }
    }
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
        let differences = self.differences(&predicted, split);
        let one_gain = self.table.groups.len() < 2;
        if one_gain {
            return Ok(differences.iter().map(|difference| difference / self.noise).collect());
        }
        let calibration = self.differences(&predicted, Split::Calibration);
        let mut residuals = vec![0.0; differences.len()];
        for Group { members, group } in self.groups(split).into_iter().filter(|group| !group.members.is_empty()) {
            let gain = match split {
                Split::Calibration => self.free_gain(),
                Split::Evaluation => self.known_gain(group, &calibration),
            };
            let own: Vec<f64> = members.iter().map(|&k| differences[k]).collect();
            let whitened = self.whitener(own.len(), &gain).whiten(&own);
            members.iter().zip(whitened).for_each(|(&k, residual)| residuals[k] = residual);
        }
        Ok(residuals)
    }

    fn coordinates(&self, model: &CompiledModel) -> Vec<Coordinate> {
        Self::coordinates(self, model).map(|(coordinates, _)| coordinates).unwrap_or_default()
    }

    fn agreement(&self, model: &CompiledModel, split: Split) -> Result<Vec<Agreement>, EvidenceError> {
        let residuals = self.residuals(model, split)?;
        let squares = residuals.iter().map(|r| r.clamp(-OUTLIER_SIGMAS, OUTLIER_SIGMAS).powi(2)).sum::<f64>();
        let rms = self.noise * (squares / residuals.len().max(1) as f64).sqrt();
        let about = self.table.name.clone();
        let agreement = Agreement { about, rms, floor: self.noise, noise: self.noise, scale: 1.0 };
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

    fn unit(&self) -> ErrorUnit {
        ErrorUnit::Percent
    }

    fn blocks(&self, split: Split) -> Vec<usize> {
        self.of(split).iter().map(|at| at / ROW_BLOCK_LENGTH).collect()
    }
}
