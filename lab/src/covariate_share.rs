//! Dependence of removal residuals on covariates, which are quantities that the simulator knows at each place.
//!
//! The share explained by a spline of one covariate refers to the excess variance over noise. Its p-value comes from a
//! permutation test that shifts the residual maps around a torus, scan by scan, and exchanges scans; both preserve
//! spatial correlation (Fortin and Jacquez 2000).

use nalgebra::{Cholesky, DMatrix, DVector, QR};
use rayon::prelude::*;
use serde::Serialize;

use super::spline::spline_columns;
use crate::criteria::{
    COVARIATE_BAND_DRAWS, COVARIATE_BAND_HIGH, COVARIATE_BAND_LOW, COVARIATE_BIN_LEAST, COVARIATE_BINS,
    COVARIATE_DATA_LEAST, COVARIATE_DRAWS, COVARIATE_RIDGE, ROW_PIECE_LENGTH,
};
use random::Stream;

/// Residuals of one scan, or of one table, with the covariates of their places.
#[derive(Clone, Debug, Default)]
pub struct CovariateField {
    /// Grid size along x, of the grid that contains the tiles.
    pub nx: usize,
    /// Cell of each tile in the grid, x running fastest.
    pub cells: Vec<usize>,
    /// Relative residual of each tile: (measured − simulated) / simulated.
    pub residuals: Vec<f64>,
    /// Standard deviation of each residual from noise.
    pub sigmas: Vec<f64>,
    /// Block number of each tile; tiles of a block are neighbours that may be correlated.
    pub blocks: Vec<usize>,
    /// Values of each covariate at each tile.
    pub values: Vec<Vec<f64>>,
}

/// Mean residual in a bin of the covariate.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct CovariateBin {
    /// Mean of the covariate [SI].
    pub covariate: f64,
    /// Mean of the relative residual.
    pub residual: f64,
    /// 95 % band of the mean, from the block bootstrap.
    pub band: [f64; 2],
}

/// Share of the residual variance that one covariate explains.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct CovariateShare {
    /// Index among the covariates.
    pub covariate: usize,
    /// Share of the excess variance that a spline of the covariate explains.
    pub share: f64,
    /// Fall of [`CovariateStudy::joint_share`] when this covariate is left out.
    pub drop: f64,
    /// P-value of the share where residuals do not depend on the covariate.
    pub p_value: f64,
    /// P-value that the largest share of any covariate reaches this one where none matters.
    pub p_value_of_all: f64,
    /// Binned means.
    pub bins: Vec<CovariateBin>,
}

/// Shares of the residual variance that the covariates explain.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub struct CovariateStudy {
    /// Share of the excess variance that all covariates explain together.
    pub joint_share: f64,
    /// Covariates that vary, in their order.
    pub covariates: Vec<CovariateShare>,
}

/// Spline basis of a covariate that varies.
struct Smooth {
    covariate: usize,
    /// Orthonormal basis of the weighted constant and spline columns.
    space: DMatrix<f64>,
    /// Weighted columns of the spline.
    columns: DMatrix<f64>,
}

/// All fields concatenated.
struct Pooled<'a> {
    fields: &'a [CovariateField],
    weights: DVector<f64>,
    /// Residuals divided by their noise.
    residuals: DVector<f64>,
    /// Unit vector of a constant relative residual.
    constant: DVector<f64>,
    /// Variance of relative residuals in excess of noise.
    excess: f64,
}

/// Studies the dependence of residuals on covariates.
///
/// - `noise`: variance of a residual over its sigma where the model is right: 1, or 0 where sigmas are unknown
pub fn covariate_study(fields: &[CovariateField], noise: f64, seed: u64) -> CovariateStudy {
    let count = fields.first().map_or(0, |field| field.values.len());
    let pooled = Pooled::new(fields, noise);
    let smooths: Vec<Smooth> = (0..count).filter_map(|covariate| pooled.smooth(covariate)).collect();
    if smooths.is_empty() || pooled.residuals.len() < COVARIATE_DATA_LEAST {
        return CovariateStudy::default();
    }
    let total = pooled.about_mean(&pooled.residuals).norm_squared();
    let excess = total - noise * (pooled.residuals.len() - 1) as f64;
    let share = |explained: f64, columns: usize| {
        let explained = explained - noise * columns as f64;
        if excess > 0.0 { (explained / excess).clamp(0.0, 1.0) } else { 0.0 }
    };
    let found: Vec<f64> = smooths.iter().map(|smooth| pooled.explained(smooth, &pooled.residuals) / total).collect();
    let drawn = |draw: usize| -> Vec<f64> {
        let residuals = pooled.shifted(&mut Stream::of(seed, &format!("torus {draw}")));
        let total = pooled.about_mean(&residuals).norm_squared();
        smooths.iter().map(|smooth| pooled.explained(smooth, &residuals) / total).collect()
    };
    let draws: Vec<Vec<f64>> = (0..COVARIATE_DRAWS).into_par_iter().map(drawn).collect();
    let all: Vec<usize> = (0..smooths.len()).collect();
    let width = |among: &[usize]| among.iter().map(|&k| smooths[k].columns.ncols()).sum::<usize>();
    let joint = |among: &[usize]| share(pooled.ridge(&smooths, among), width(among));
    let joint_share = joint(&all);
    let one = |(k, smooth): (usize, &Smooth)| {
        let p_value = |reaches: &dyn Fn(&Vec<f64>) -> bool| {
            (draws.iter().filter(|draw| reaches(draw)).count() + 1) as f64 / (COVARIATE_DRAWS + 1) as f64
        };
        let others: Vec<usize> = all.iter().copied().filter(|&other| other != k).collect();
        CovariateShare {
            covariate: smooth.covariate,
            share: share(found[k] * total, smooth.columns.ncols()),
            drop: (joint_share - joint(&others)).max(0.0),
            p_value: p_value(&|draw| draw[k] >= found[k]),
            p_value_of_all: p_value(&|draw| draw.iter().any(|share| *share >= found[k])),
            bins: pooled.bins(smooth.covariate, seed),
        }
    };
    CovariateStudy { joint_share, covariates: smooths.par_iter().enumerate().map(one).collect() }
}

impl<'a> Pooled<'a> {
    fn new(fields: &'a [CovariateField], noise: f64) -> Self {
        let all = |of: fn(&CovariateField) -> &Vec<f64>| fields.iter().flat_map(of).copied().collect::<Vec<f64>>();
        let weights = DVector::from_vec(all(|field| &field.sigmas)).map(|sigma| 1.0 / sigma);
        let residuals = DVector::from_vec(all(|field| &field.residuals)).component_mul(&weights);
        let constant = if weights.is_empty() { weights.clone() } else { weights.normalize() };
        let mut pooled = Self { fields, weights, residuals, constant, excess: 0.0 };
        let beyond = pooled.about_mean(&pooled.residuals).norm_squared() - noise * pooled.residuals.len() as f64;
        pooled.excess = (beyond / pooled.weights.norm_squared().max(f64::MIN_POSITIVE)).max(0.0);
        pooled
    }

    fn values(&self, covariate: usize) -> Vec<f64> {
        self.fields.iter().flat_map(|field| &field.values[covariate]).copied().collect()
    }

    fn smooth(&self, covariate: usize) -> Option<Smooth> {
        let columns = spline_columns(&self.values(covariate));
        if columns.is_empty() {
            return None;
        }
        let columns = columns.into_iter().map(|column| DVector::from_vec(column).component_mul(&self.weights));
        let columns: Vec<DVector<f64>> = columns.map(|column| self.about_mean(&column).normalize()).collect();
        let columns = DMatrix::from_columns(&columns);
        Some(Smooth { covariate, space: QR::new(columns.clone()).q(), columns })
    }

    /// Weighted values without the part of a constant relative residual.
    fn about_mean(&self, values: &DVector<f64>) -> DVector<f64> {
        values - &self.constant * self.constant.dot(values)
    }

    /// Sum of squares that a spline explains beyond a constant.
    fn explained(&self, smooth: &Smooth, residuals: &DVector<f64>) -> f64 {
        smooth.space.tr_mul(&self.about_mean(residuals)).norm_squared()
    }

    /// Sum of squares that the splines of several covariates explain together, in a ridge regression.
    fn ridge(&self, smooths: &[Smooth], among: &[usize]) -> f64 {
        let columns: Vec<_> = among.iter().flat_map(|&k| smooths[k].columns.column_iter()).collect();
        if columns.is_empty() {
            return 0.0;
        }
        let matrix = DMatrix::from_columns(&columns);
        let goal = self.about_mean(&self.residuals);
        let mut normal = matrix.tr_mul(&matrix);
        (0..normal.nrows()).for_each(|k| normal[(k, k)] += COVARIATE_RIDGE);
        let Some(factor) = Cholesky::new(normal) else { return 0.0 };
        let found = factor.solve(&matrix.tr_mul(&goal));
        goal.norm_squared() - (&goal - matrix * found).norm_squared()
    }

    /// Returns residuals with each scan's map shifted around the torus and the scans' means exchanged. The shifted
    /// quantity is the relative residual over its own total spread, so that deep and shallow places may be exchanged.
    fn shifted(&self, stream: &mut Stream) -> DVector<f64> {
        let mut places: Vec<usize> = (0..self.fields.len()).collect();
        (1..places.len()).rev().for_each(|k| places.swap(k, stream.below(k + 1)));
        let means: Vec<f64> = self.fields.iter().map(CovariateField::mean).collect();
        let mut all = Vec::with_capacity(self.residuals.len());
        for (k, field) in self.fields.iter().enumerate() {
            let spreads: Vec<f64> = field.sigmas.iter().map(|sigma| (sigma * sigma + self.excess).sqrt()).collect();
            let own = field.residuals.iter().zip(&spreads).map(|(residual, spread)| (residual - means[k]) / spread);
            let moved = field.shifted(&own.collect::<Vec<f64>>(), stream);
            all.extend(moved.iter().zip(&spreads).map(|(residual, spread)| means[places[k]] + residual * spread));
        }
        DVector::from_vec(all).component_mul(&self.weights)
    }

    fn bins(&self, covariate: usize, seed: u64) -> Vec<CovariateBin> {
        let values = self.values(covariate);
        let bins = binned(&values);
        let mut blocks = Vec::new();
        for (k, field) in self.fields.iter().enumerate() {
            blocks.extend(field.blocks.iter().map(|&block| (k, block)));
        }
        let mut names = blocks.clone();
        names.sort_unstable();
        names.dedup();
        let block_of: Vec<usize> = blocks.iter().filter_map(|block| names.binary_search(block).ok()).collect();
        let mut stream = Stream::of(seed, &format!("blocks {covariate}"));
        let mut draws = vec![vec![1.0; names.len()]];
        for _ in 0..COVARIATE_BAND_DRAWS {
            let mut times = vec![0.0; names.len()];
            (0..names.len()).for_each(|_| times[stream.below(names.len())] += 1.0);
            draws.push(times);
        }
        let bin = |members: &Vec<usize>| {
            let mean = |times: &Vec<f64>| {
                let (mut sum, mut weight) = (0.0, 0.0);
                for &at in members {
                    let own = times[block_of[at]] * self.weights[at];
                    sum += own * self.residuals[at];
                    weight += own * self.weights[at];
                }
                sum / weight
            };
            let mut means: Vec<f64> = draws[1..].iter().map(mean).filter(|mean| mean.is_finite()).collect();
            means.sort_by(f64::total_cmp);
            let end = |share: f64| means.get((share * (means.len() - 1) as f64).round() as usize).copied();
            let residual = mean(&draws[0]);
            CovariateBin {
                covariate: members.iter().map(|&at| values[at]).sum::<f64>() / members.len() as f64,
                residual,
                band: [COVARIATE_BAND_LOW, COVARIATE_BAND_HIGH]
                    .map(|share| if means.is_empty() { residual } else { end(share).unwrap_or(residual) }),
            }
        };
        bins.iter().map(bin).collect()
    }
}

/// Members of each bin, in ascending order of the covariate: one bin per value where there are few values, else equal
/// counts.
fn binned(values: &[f64]) -> Vec<Vec<usize>> {
    let mut order: Vec<usize> = (0..values.len()).collect();
    order.sort_by(|&a, &b| values[a].total_cmp(&values[b]));
    let mut groups: Vec<Vec<usize>> = Vec::new();
    for &at in &order {
        match groups.last_mut() {
            Some(group) if values[group[0]] == values[at] => group.push(at),
            _ => groups.push(vec![at]),
        }
    }
    let count = (order.len() / COVARIATE_BIN_LEAST).clamp(3, COVARIATE_BINS);
    if groups.len() <= count {
        return groups;
    }
    (0..count).map(|k| order[k * order.len() / count..(k + 1) * order.len() / count].to_vec()).collect()
}

impl CovariateField {
    /// Mean residual, weighted by noise.
    fn mean(&self) -> f64 {
        let sum =
            |of: &dyn Fn(usize) -> f64| (0..self.sigmas.len()).map(|k| of(k) / self.sigmas[k].powi(2)).sum::<f64>();
        sum(&|k| self.residuals[k]) / sum(&|_| 1.0).max(f64::MIN_POSITIVE)
    }

    /// Shifts tile values by a random displacement around the torus of the tiles' bounding box; where it has no tile,
    /// the next one along x is taken.
    fn shifted(&self, values: &[f64], stream: &mut Stream) -> Vec<f64> {
        let (column, row) = (|cell: usize| cell % self.nx, |cell: usize| cell / self.nx);
        let ends = |of: &dyn Fn(usize) -> usize| {
            let all = self.cells.iter().map(|&cell| of(cell));
            (all.clone().min().unwrap_or(0), all.max().unwrap_or(0))
        };
        let ((west, east), (south, north)) = (ends(&column), ends(&row));
        let (width, height) = (east - west + 1, north - south + 1);
        if height == 1 {
            return in_pieces(values, stream);
        }
        let mut map = vec![f64::NAN; width * height];
        let place = |cell: usize| (row(cell) - south) * width + column(cell) - west;
        self.cells.iter().zip(values).for_each(|(&cell, &value)| map[place(cell)] = value);
        let shift = stream.below(width) + width * stream.below(height);
        let next = |cell: usize| {
            let (i, j) = (column(cell) - west + shift % width, row(cell) - south + shift / width);
            let start = j % height * width + i % width;
            (0..map.len()).map(|step| map[(start + step) % map.len()]).find(|value| value.is_finite())
        };
        self.cells.iter().map(|&cell| next(cell).unwrap_or(0.0)).collect()
    }
}

/// Cuts a sequence at random into pieces and permutes them: a periodic plan that is only shifted would match itself.
fn in_pieces(values: &[f64], stream: &mut Stream) -> Vec<f64> {
    let mut pieces: Vec<Vec<f64>> = vec![Vec::new()];
    for &value in values {
        if stream.happens(1.0 / ROW_PIECE_LENGTH) {
            pieces.push(Vec::new());
        }
        pieces.last_mut().expect("there is one").push(value);
    }
    (1..pieces.len()).rev().for_each(|k| pieces.swap(k, stream.below(k + 1)));
    pieces.concat()
}
