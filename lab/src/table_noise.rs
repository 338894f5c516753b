//! How well rows of a table repeat, without any model: from rows with the same settings, else from neighbours in time.

use nalgebra::{DMatrix, DVector};

use crate::criteria::{
    REPEATS_LEAST, ROW_NOISE_CUT_MEAN_SQUARE, ROW_NOISE_CUT_SIGMAS, ROW_NOISE_LEAST, ROW_REGRESSION_CUT, SAME_SETTING,
};
use trials::measure::{MAD_TO_SIGMA, median};
use trials::table::{Row, Table};

/// Rounds of a robust regression and of a robust scale.
const ROUNDS: usize = 20;

/// What two rows that follow each other in time differ by.
struct Pair {
    /// Logarithm of the removal rate.
    removal: f64,
    /// Logarithms of pressure, speed and duration.
    settings: [f64; 3],
    /// Rows from one to the other.
    gap: f64,
}

/// Standard deviation of the logarithm of a row's removal, and how it was found, from the rows named: only theirs are
/// looked at.
pub(super) fn row_noise(table: &Table, rows: &[usize]) -> (f64, String) {
    let repeats = pairs(table, rows, true);
    let (pairs, how) = if repeats.len() >= REPEATS_LEAST {
        let how = format!("{} pairs of rows with the same settings", repeats.len());
        (repeats, how)
    } else {
        let all = pairs(table, rows, false);
        let how =
            format!("{} pairs of rows that follow each other, less what powers of their settings explain", all.len());
        (all, how)
    };
    let sigma = (scale(&unexplained(&pairs)) / std::f64::consts::SQRT_2).max(ROW_NOISE_LEAST);
    (sigma, format!("noise of a row: {:.2} %, from {how}", 100.0 * sigma))
}

/// Standard deviation with outliers cut (Huber 1964, proposal 2), beginning from the median deviation.
fn scale(deviations: &[f64]) -> f64 {
    let first = median(deviations.iter().map(|deviation| deviation.abs()).collect()).unwrap_or(0.0);
    (0..ROUNDS).fold(MAD_TO_SIGMA * first, |sigma, _| {
        let square = |deviation: &f64| deviation.abs().min(ROW_NOISE_CUT_SIGMAS * sigma).powi(2);
        (deviations.iter().map(square).sum::<f64>() / (ROW_NOISE_CUT_MEAN_SQUARE * deviations.len().max(1) as f64))
            .sqrt()
    })
}

fn logarithms(row: &Row) -> [f64; 3] {
    [row.pressure.or(row.force), row.speed, row.duration].map(|value| value.map_or(0.0, f64::ln))
}

/// Each row with the next one of its group and tool; of `same` settings if asked.
fn pairs(table: &Table, rows: &[usize], same: bool) -> Vec<Pair> {
    let mut pairs = Vec::new();
    for (at, &a) in rows.iter().enumerate() {
        let first = &table.rows[a];
        let here = logarithms(first);
        let pair = |&b: &usize| {
            let next = &table.rows[b];
            let there = logarithms(next);
            let alike = here.iter().zip(there).all(|(a, b)| (a - b).abs() < SAME_SETTING);
            let fits = next.group == first.group && next.tool == first.tool && (alike || !same);
            fits.then(|| Pair {
                removal: (next.removal_rate.unwrap_or(1.0) / first.removal_rate.unwrap_or(1.0)).ln(),
                settings: std::array::from_fn(|k| there[k] - here[k]),
                gap: (b - a) as f64,
            })
        };
        pairs.extend(rows[at + 1..].iter().find_map(pair));
    }
    pairs
}

/// What a robust regression on drift and settings leaves of the pairs.
fn unexplained(pairs: &[Pair]) -> Vec<f64> {
    let removal: Vec<f64> = pairs.iter().map(|pair| pair.removal).collect();
    let columns: [&dyn Fn(&Pair) -> f64; 4] =
        [&|pair| pair.gap, &|pair| pair.settings[0], &|pair| pair.settings[1], &|pair| pair.settings[2]];
    let varies = |column: &&&dyn Fn(&Pair) -> f64| pairs.iter().any(|pair| column(pair).abs() > SAME_SETTING);
    let columns: Vec<_> = columns.iter().filter(varies).collect();
    if pairs.len() < 2 * columns.len() + 2 {
        return removal;
    }
    let design = DMatrix::from_fn(pairs.len(), columns.len(), |row, column| columns[column](&pairs[row]));
    let target = DVector::from_vec(removal.clone());
    let mut left = target.clone();
    for _ in 0..ROUNDS {
        let scale = median(left.iter().map(|left| left.abs()).collect()).unwrap_or(0.0).max(1e-12);
        let weights = left.map(|left| (ROW_REGRESSION_CUT * scale / left.abs().max(1e-12)).min(1.0).sqrt());
        let weighted =
            DMatrix::from_fn(design.nrows(), design.ncols(), |row, column| design[(row, column)] * weights[row]);
        let Ok(found) = weighted.svd(true, true).solve(&target.component_mul(&weights), 1e-9) else { return removal };
        left = &target - &design * found;
    }
    let lost = (pairs.len() as f64 / (pairs.len() - columns.len()) as f64).sqrt();
    left.iter().map(|left| left * lost).collect()
}
