//! Noise of table rows, without a model of the process: the residual of a regression of the rows on everything that the
//! table declares, and of a regression of differences between neighbouring rows.
//!
//! Each residual contains noise and the regression's misfit, so the smallest one is used.

use nalgebra::{DMatrix, DVector};
use statrs::distribution::{ContinuousCDF, FisherSnedecor, StudentsT};

use crate::criteria::{
    REPEATS_LEAST, ROW_NOISE_LEAST, ROW_NOISE_ROBUST_LEAST, ROW_REGRESSION_CUT, ROW_SQUARE_LEVELS_LEAST,
    ROW_SQUARES_LEAST, SAME_SETTING, SIGNIFICANCE_LEVEL,
};
use trials::measure::{MAD_TO_SIGMA, median};
use trials::table::{Row, Table};

/// Most iterations of a robust regression and of a robust scale.
const ROUNDS: usize = 20;
/// Share of the largest singular value below which columns of a regression are linearly dependent.
pub(super) const DEPENDENT: f64 = 1e-9;

/// Estimates the noise of a table from the named rows only. A noise that the table states is taken as it is.
pub(super) fn row_noise(table: &Table, rows: &[usize]) -> RowNoise {
    if let Some(sigma) = table.noise {
        let how = format!("noise of a row: {:.2} %, as the table states", 100.0 * sigma);
        return RowNoise { sigma, limit: sigma, how };
    }
    let declared = Declared::new(table, rows);
    let mut found = vec![declared.of_rows()];
    for same in [true, false] {
        let pairs = declared.pairs(same);
        if pairs.len() >= REPEATS_LEAST && (same || table.in_time) {
            found.push(declared.of_pairs(&pairs, same));
        }
    }
    let least = found.into_iter().flatten().min_by(|a, b| a.0.sigma.total_cmp(&b.0.sigma));
    let (found, how) =
        least.unwrap_or_else(|| (declared.scatter(), "the scatter of all rows, as too few repeat".to_owned()));
    let sigma = found.sigma.max(ROW_NOISE_LEAST);
    let limit = sigma * found.limit(rows.len());
    RowNoise { sigma, limit, how: format!("noise of a row: {:.2} %, from {how}", 100.0 * sigma) }
}

/// Noise of the rows of a table.
pub(super) struct RowNoise {
    /// Standard deviation of the logarithm of a row's removal.
    pub(super) sigma: f64,
    /// Upper limit of the residual of a complete model, with the uncertainty of the noise.
    pub(super) limit: f64,
    /// Method of the estimate, one sentence.
    pub(super) how: String,
}

/// Residual of a regression.
struct Left {
    /// Standard deviation.
    sigma: f64,
    /// Degrees of freedom, and number of columns of the regression.
    freedom: usize,
    columns: usize,
}

impl Left {
    /// Greatest ratio of the residual of so many rows without the columns to the noise at which an F test does not
    /// reject that the columns explain nothing.
    fn limit(&self, rows: usize) -> f64 {
        let (freedom, columns) = (self.freedom as f64, self.columns as f64);
        let law = FisherSnedecor::new(columns, freedom).ok();
        let most = law.map_or(0.0, |law| law.inverse_cdf(1.0 - SIGNIFICANCE_LEVEL));
        (freedom / rows.max(1) as f64 * (1.0 + columns / freedom * most)).sqrt().max(1.0)
    }
}

/// Returns true if the time was measured at equal removals: every row removes the same, and takes its own time.
pub(super) fn is_timed(table: &Table) -> bool {
    let amounts = table.rows.iter().filter_map(|row| Some((row.removal_rate? * row.duration?).ln()));
    let times = table.rows.iter().filter_map(|row| Some(row.duration?.ln()));
    range(amounts).is_some_and(|amounts| amounts < SAME_SETTING) && range(times).is_some_and(|r| r > SAME_SETTING)
}

/// Number of distinct values.
fn levels(values: &[f64]) -> usize {
    let mut sorted = values.to_vec();
    sorted.sort_by(f64::total_cmp);
    sorted.dedup_by(|a, b| (*a - *b).abs() < SAME_SETTING * SAME_SETTING);
    sorted.len()
}

/// Greatest minus least value; `None` if empty.
fn range(values: impl Iterator<Item = f64>) -> Option<f64> {
    let (low, high) = values.fold((f64::INFINITY, f64::NEG_INFINITY), |(l, h), v| (l.min(v), h.max(v)));
    (high >= low).then_some(high - low)
}

/// All declared values of the rows of a table.
pub(super) struct Declared<'a> {
    table: &'a Table,
    rows: &'a [usize],
    /// Logarithm of the removal rate of each row.
    removal: Vec<f64>,
    /// Settings, measured states, use and time of each row, each divided by its range; constant ones are left out.
    values: Vec<Vec<f64>>,
    /// Number of settings among them, and of settings and measured states, which are equal in equal rows.
    logarithms: usize,
    settings: usize,
}

impl<'a> Declared<'a> {
    pub(super) fn new(table: &'a Table, rows: &'a [usize]) -> Self {
        let of = |value: &dyn Fn(usize) -> f64| rows.iter().map(|&at| value(at)).collect::<Vec<f64>>();
        let ln = |value: Option<f64>| value.map_or(0.0, f64::ln);
        let timed = is_timed(table);
        let row = |at: usize| -> &Row { &table.rows[at] };
        let mut values = vec![of(&|at| ln(row(at).pressure.or(row(at).force))), of(&|at| ln(row(at).speed))];
        values.push(of(&|at| if timed { 0.0 } else { ln(row(at).duration) }));
        let is_constant = |values: &Vec<f64>, least: f64| range(values.iter().copied()).is_none_or(|r| r <= least);
        values.retain(|values| !is_constant(values, SAME_SETTING));
        let logarithms = values.len();
        values.extend((0..table.usage.len()).map(|k| of(&|at| row(at).usage[k])));
        values.retain(|values| !is_constant(values, 0.0));
        let settings = values.len();
        if table.in_time {
            let used = used(table);
            values.extend([of(&|at| at as f64), of(&|at| used[at])]);
            values.retain(|values| !is_constant(values, 0.0));
        }
        for (k, values) in values.iter_mut().enumerate() {
            let width = range(values.iter().copied()).filter(|width| *width > 0.0).unwrap_or(1.0);
            let middle = median(values.clone()).unwrap_or(0.0);
            let width = if k < logarithms { 1.0 } else { width };
            values.iter_mut().for_each(|value| *value = (*value - middle) / width);
        }
        let removal = of(&|at| ln(row(at).removal_rate));
        Self { table, rows, removal, values, logarithms, settings }
    }

    fn group(&self, k: usize) -> usize {
        self.table.rows[self.rows[k]].group
    }

    /// A column for each group: 1 in its rows, 0 in the others.
    fn groups(&self) -> Vec<Vec<f64>> {
        let mut groups: Vec<usize> = (0..self.rows.len()).map(|k| self.group(k)).collect();
        groups.sort_unstable();
        groups.dedup();
        let is_of = |group: usize| (0..self.rows.len()).map(move |k| f64::from(u8::from(self.group(k) == group)));
        groups.into_iter().map(|group| is_of(group).collect()).collect()
    }

    /// Columns of groups and measured states, and of use and time where a tool is used in more than one row: all but the
    /// settings.
    pub(super) fn beside_settings(&self) -> Vec<Vec<f64>> {
        let wears = self.rows.iter().any(|&at| !self.table.rows[at].fresh);
        let values = &self.values[self.logarithms..if wears { self.values.len() } else { self.settings }];
        self.groups().into_iter().chain(values.iter().cloned()).collect()
    }

    /// Residual of a regression of the rows on all declared values, with squares if there are enough rows, and its
    /// description.
    fn of_rows(&self) -> Option<(Left, String)> {
        let groups = self.groups();
        let mut columns = groups.clone();
        columns.extend(self.values.iter().cloned());
        let squared = self.values[..self.settings].iter().filter(|values| levels(values) >= ROW_SQUARE_LEVELS_LEAST);
        let squares: Vec<Vec<f64>> = squared.map(|v| v.iter().map(|v| v * v).collect()).collect();
        if self.rows.len() >= ROW_SQUARES_LEAST * (columns.len() + squares.len()) {
            columns.extend(squares);
        }
        let left = regression(&columns, &self.removal)?;
        let how = format!("what a regression on all declared columns leaves, {} degrees of freedom", left.freedom);
        Some((Left { columns: left.columns.saturating_sub(groups.len()), ..left }, how))
    }

    /// Each row with the next one of its group and tool; only pairs of equal settings if `same`.
    fn pairs(&self, same: bool) -> Vec<(usize, usize)> {
        let alike =
            |a: usize, b: usize| self.values[..self.settings].iter().all(|v| (v[a] - v[b]).abs() < SAME_SETTING);
        let tool = |k: usize| self.table.rows[self.rows[k]].tool;
        let next = |a: usize| {
            let fits = |b: &usize| self.group(a) == self.group(*b) && tool(a) == tool(*b) && (!same || alike(a, *b));
            (a + 1..self.rows.len()).find(fits).map(|b| (a, b))
        };
        (0..self.rows.len()).filter_map(next).collect()
    }

    /// Residual of a regression of differences within pairs of rows on the differences of all declared values, and its
    /// description.
    fn of_pairs(&self, pairs: &[(usize, usize)], same: bool) -> Option<(Left, String)> {
        let difference = |values: &Vec<f64>| pairs.iter().map(|&(a, b)| values[b] - values[a]).collect::<Vec<f64>>();
        let columns: Vec<Vec<f64>> = self.values.iter().map(difference).collect();
        let left = regression(&columns, &difference(&self.removal))?;
        let which = if same { "with the same settings" } else { "that follow each other" };
        let how = format!("{} pairs of rows {which}, less what all declared columns explain", pairs.len());
        Some((Left { sigma: left.sigma / std::f64::consts::SQRT_2, ..left }, how))
    }

    /// Standard deviation of all removals, for tables without a possible regression.
    fn scatter(&self) -> Left {
        let mean = self.removal.iter().sum::<f64>() / self.removal.len().max(1) as f64;
        let squares: f64 = self.removal.iter().map(|removal| (removal - mean).powi(2)).sum();
        let freedom = self.removal.len().max(2) - 1;
        Left { sigma: (squares / freedom as f64).sqrt(), freedom, columns: 0 }
    }
}

/// Use of the tool since it was fresh, at the middle of each row: load times speed times duration.
fn used(table: &Table) -> Vec<f64> {
    let mut used = vec![0.0; table.tools.len()];
    let one = |row: &Row| {
        let load = row.pressure.or(row.force).unwrap_or(1.0);
        let own = load * row.speed.unwrap_or(1.0) * row.duration.unwrap_or(1.0);
        let before = if row.fresh { 0.0 } else { used[row.tool] };
        used[row.tool] = before + own;
        before + 0.5 * own
    };
    table.rows.iter().map(one).collect()
}

/// Residual of a robust regression; `None` without a degree of freedom.
///
/// Huber's weights (1964) indicate outliers: rows that a t test rejects, corrected for their number. The rest is fitted
/// by least squares. With few degrees of freedom a median of deviations is no scale, and least squares alone are used.
fn regression(columns: &[Vec<f64>], target: &[f64]) -> Option<Left> {
    let rows = target.len();
    let design = DMatrix::from_fn(rows, columns.len(), |row, column| columns[column][row]);
    let target = DVector::from_column_slice(target);
    let rank = design.clone().svd(false, false).rank(DEPENDENT * design.norm().max(f64::MIN_POSITIVE));
    let all = rows.checked_sub(rank).filter(|left| *left > 0)?;
    let mut weights = DVector::from_element(rows, 1.0);
    let mut left = residuals(&design, &target, &weights)?;
    if all < ROW_NOISE_ROBUST_LEAST {
        let sigma = (left.norm_squared() / all as f64).sqrt();
        return Some(Left { sigma, freedom: all, columns: rank });
    }
    let scale = |left: &DVector<f64>| {
        let middle = median(left.iter().map(|left| left.abs()).collect()).unwrap_or(0.0);
        (MAD_TO_SIGMA * middle * (rows as f64 / all as f64).sqrt()).max(f64::MIN_POSITIVE)
    };
    for _ in 0..ROUNDS {
        let cut = ROW_REGRESSION_CUT * scale(&left);
        weights = left.map(|left| (cut / left.abs().max(f64::MIN_POSITIVE)).min(1.0).sqrt());
        left = residuals(&design, &target, &weights)?;
    }
    let cut = StudentsT::new(0.0, 1.0, all as f64).ok()?.inverse_cdf(1.0 - 0.5 * SIGNIFICANCE_LEVEL / rows as f64);
    let mut sigma = scale(&left);
    let mut kept = rows;
    for _ in 0..ROUNDS {
        weights = left.map(|left| f64::from(u8::from(left.abs() <= cut * sigma)));
        left = residuals(&design, &target, &weights)?;
        kept = weights.iter().filter(|weight| **weight > 0.0).count();
        let squares: f64 = left.iter().zip(weights.iter()).map(|(left, weight)| (left * weight).powi(2)).sum();
        sigma = (squares / kept.saturating_sub(rank).max(1) as f64).sqrt().max(f64::MIN_POSITIVE);
    }
    Some(Left { sigma, freedom: kept.saturating_sub(rank).max(1), columns: rank })
}

/// Residuals of weighted least squares; the weights multiply residuals, not their squares.
fn residuals(design: &DMatrix<f64>, target: &DVector<f64>, weights: &DVector<f64>) -> Option<DVector<f64>> {
    let weighted = DMatrix::from_fn(design.nrows(), design.ncols(), |row, column| design[(row, column)] * weights[row]);
    let least = DEPENDENT * weighted.norm().max(f64::MIN_POSITIVE);
    let found = weighted.svd(true, true).solve(&target.component_mul(weights), least).ok()?;
    Some(target - design * found)
}

#[cfg(test)]
mod tests {
    use super::*;
    use random::Stream;

    #[test]
    fn gross_outliers_do_not_widen_the_scale() {
        for seed in 0..10 {
            let mut stream = Stream::of(seed, "rows");
            let line: Vec<f64> = (0..100).map(|k| f64::from(k) / 50.0 - 1.0).collect();
            let noisy = |x: &f64| 0.7 * x + 0.03 * stream.normal();
            let mut removal: Vec<f64> = line.iter().map(noisy).collect();
            removal.iter_mut().step_by(16).for_each(|removal| *removal += 8.0f64.ln());
            let sigma = regression(&[vec![1.0; 100], line], &removal).unwrap().sigma;
            assert!((0.75..1.3).contains(&(sigma / 0.03)), "{sigma}");
        }
    }

    #[test]
    fn few_rows_lose_their_trend_too() {
        let line = vec![0.0, 1.0, 2.0, 3.0, 4.0];
        let removal: Vec<f64> = line.iter().zip([0.1, -0.1, 0.0, 0.1, -0.1]).map(|(x, e)| 0.9 * x + e).collect();
        let left = regression(&[vec![1.0; 5], line], &removal).unwrap();
        assert!(left.freedom == 3 && left.sigma < 0.15, "{}", left.sigma);
        assert!(regression(&[vec![1.0; 2], vec![0.0, 1.0]], &[0.0, 1.0]).is_none());
    }
}
