//! Derivatives of whitened residuals from noisy simulations: long finite differences, updates from earlier steps.

use nalgebra::{DMatrix, DVector};
use rayon::prelude::*;

use super::coordinates::{Coordinate, moved};
use super::evidence::{Evidence, Split};
use super::fit::{Fit, Place, weights};
use crate::criteria::{
    DERIVATIVE_CHANGE_AIM, DERIVATIVE_CHANGE_LEAST, DERIVATIVE_CHANGE_MOST, DERIVATIVE_CHANGE_SHARE,
    DERIVATIVE_LONGEST_STEP,
};

/// Factor on a step's length from which the minimum along its line is also tried: a step of two thirds of the best
/// length achieves eight ninths of the possible fall.
const ABOUT_AS_FAR: f64 = 1.5;

/// Factor that scales a step to the longest finite difference.
fn longest_factor(way: &[f64]) -> f64 {
    DERIVATIVE_LONGEST_STEP / way.iter().fold(f64::MIN_POSITIVE, |most, way| most.max(way.abs()))
}

/// Elementwise difference `b - a`.
pub(super) fn difference(b: &[f64], a: &[f64]) -> DVector<f64> {
    DVector::from_iterator(b.len(), b.iter().zip(a).map(|(b, a)| b - a))
}

/// Step between a pair of places [coordinates].
fn way([a, b]: [&Place; 2]) -> DVector<f64> {
    difference(&b.at, &a.at)
}

/// Least-squares slope of data with `changes` between pairs of places, shape [data, coordinates]; `None` without pairs.
pub(super) fn slope(pairs: &[[Place; 2]], changes: &[DVector<f64>]) -> Option<DMatrix<f64>> {
    let ways: Vec<DVector<f64>> = pairs.iter().map(|[a, b]| way([a, b])).collect();
    let ways = (!ways.is_empty()).then(|| DMatrix::from_columns(&ways))?;
    let inverse = ways.clone().pseudo_inverse(1e-6 * ways.amax()).ok()?;
    Some(DMatrix::from_columns(changes) * inverse)
}

impl Fit {
    /// Broyden's update: makes the derivatives along the step to a tried place agree with the observed change. A step
    /// that changes the data by no more than the simulation's numerical noise is ignored.
    pub(super) fn update_jacobian(&mut self, tried: &Place) {
        let way = difference(&tried.at, &self.at);
        let seen = difference(&tried.residuals, &self.residuals);
        if seen.norm() < DERIVATIVE_CHANGE_LEAST {
            return;
        }
        let missing = (seen - &self.jacobian * &way) / way.norm_squared();
        self.jacobian += missing * way.transpose();
    }

    /// Minimum of χ² on the line from here through a tried place, estimated from the residuals at both and limited to
    /// the longest finite difference; `None` where it is about as far as the tried place.
    pub(super) fn along_line(&self, tried: &Place) -> Option<Vec<f64>> {
        let weights = weights(&self.residuals);
        let weighted = |residuals: &[f64]| DVector::from_column_slice(residuals).component_mul(&weights);
        let from = weighted(&self.residuals);
        let change = weighted(&tried.residuals) - &from;
        let square = change.norm_squared().max(f64::MIN_POSITIVE);
        let way: Vec<f64> = tried.at.iter().zip(&self.at).map(|(b, a)| b - a).collect();
        let sound = longest_factor(&way).min(DERIVATIVE_CHANGE_AIM / square.sqrt()).max(1.0);
        let lowest = (-from.dot(&change) / square).min(sound);
        let is_elsewhere = lowest > 0.0 && !(ABOUT_AS_FAR.recip()..ABOUT_AS_FAR).contains(&lowest);
        is_elsewhere.then(|| self.along(&way, lowest))
    }

    /// Coordinates at a multiple of a step from here, clamped to the bounds.
    fn along(&self, way: &[f64], factor: f64) -> Vec<f64> {
        let moved = self.at.iter().zip(way).map(|(at, way)| at + factor * way);
        moved.zip(&self.coordinates).map(|(at, coordinate)| coordinate.clamped(at)).collect()
    }

    /// Takes known derivatives as a start; the missing ones are computed by finite differences.
    pub fn borrow_derivatives(&mut self, evidence: &dyn Evidence, lent: impl Fn(&Coordinate) -> Option<DVector<f64>>) {
        let columns: Vec<Option<DVector<f64>>> = self.coordinates.iter().map(lent).collect();
        let missing: Vec<usize> = (0..columns.len()).filter(|&k| columns[k].is_none()).collect();
        for (k, column) in columns.iter().enumerate() {
            column.iter().for_each(|column| self.jacobian.set_column(k, column));
        }
        self.differentiate(evidence, &missing);
    }

    /// Recomputes all derivatives: along the coordinates where none is known yet, else by central differences along the
    /// principal directions of the known ones, with steps long enough to exceed the numerical noise. So weakly
    /// determined directions are known as well as strongly determined ones (multisecant update; Eyert 1996), and a
    /// curved valley does not look steeper than it is.
    pub(super) fn renew_derivatives(&mut self, evidence: &dyn Evidence) {
        if self.jacobian.column_iter().any(|column| column.amax() == 0.0) {
            return self.differentiate(evidence, &(0..self.at.len()).collect::<Vec<_>>());
        }
        let pairs: Vec<([Place; 2], usize)> = self
            .principal_steps(0.5 * DERIVATIVE_CHANGE_AIM, 0.5 * DERIVATIVE_LONGEST_STEP)
            .into_par_iter()
            .map(|way| self.distinct_ends(evidence, &way))
            .collect();
        self.runs += pairs.iter().map(|(_, runs)| runs).sum::<usize>();
        let places: Vec<[Place; 2]> = pairs.into_iter().map(|(places, _)| places).collect();
        let change = |[a, b]: &[Place; 2]| difference(&b.residuals, &a.residuals) - &self.jacobian * way([a, b]);
        if let Some(missing) = slope(&places, &places.iter().map(change).collect::<Vec<_>>()) {
            self.jacobian += missing;
        }
        let best = places.into_iter().flatten().min_by(|a, b| a.chi2.total_cmp(&b.chi2));
        if let Some(best) = best.filter(|best| best.chi2 < self.chi2) {
            self.go_to(best);
        }
    }

    /// Places on both sides along a step, and the number of simulations. The step is lengthened where the two differ by
    /// less than the required change: overestimated derivatives make steps too short, and numerical noise would then
    /// keep them large.
    fn distinct_ends(&self, evidence: &dyn Evidence, way: &[f64]) -> ([Place; 2], usize) {
        let near = self.ends(evidence, way);
        let change = near[0].distance(&near[1]);
        let factor = (DERIVATIVE_CHANGE_AIM / change.max(1.0)).min(0.5 * longest_factor(way));
        if change >= DERIVATIVE_CHANGE_LEAST || factor <= 1.0 {
            return (near, 2);
        }
        let farther: Vec<f64> = way.iter().map(|way| factor * way).collect();
        (self.ends(evidence, &farther), 4)
    }

    /// Places at a step and its opposite; this place instead of one that cannot be simulated.
    fn ends(&self, evidence: &dyn Evidence, way: &[f64]) -> [Place; 2] {
        [-1.0, 1.0].map(|side| self.place(evidence, self.along(way, side)).unwrap_or_else(|| self.here()))
    }

    /// Pairs of places on both sides along each principal direction; each place changes the data by about `change` [σ] but
    /// is no farther away than the longest finite difference.
    pub(super) fn pairs_around(&self, evidence: &dyn Evidence, change: f64) -> Vec<[Place; 2]> {
        let steps = self.principal_steps(change, DERIVATIVE_LONGEST_STEP);
        steps.into_par_iter().map(|step| self.ends(evidence, &step)).collect()
    }

    /// A step along each principal direction that changes the data by `change` [σ], at most `longest` [coordinates].
    fn principal_steps(&self, change: f64, longest: f64) -> Vec<Vec<f64>> {
        let directions = self.jacobian.tr_mul(&self.jacobian).symmetric_eigen();
        let way = |k: usize| -> Vec<f64> {
            let way = directions.eigenvectors.column(k);
            let sound = change / directions.eigenvalues[k].max(1e-12).sqrt();
            let length = sound.min(longest / way.amax());
            way.iter().map(|way| length * way).collect()
        };
        (0..self.at.len()).map(way).collect()
    }

    /// Recomputes the derivatives along some coordinates.
    pub(super) fn differentiate(&mut self, evidence: &dyn Evidence, along: &[usize]) {
        let columns: Vec<(Vec<f64>, usize)> = along.par_iter().map(|&k| self.derivative(evidence, k)).collect();
        for (&k, (column, runs)) in along.iter().zip(columns) {
            self.jacobian.set_column(k, &DVector::from_vec(column));
            self.runs += runs;
        }
    }

    /// Derivative of the residuals along a coordinate, over a step that changes them by more than the simulation's
    /// numerical noise, and the number of simulations; zero where no step does.
    fn derivative(&self, evidence: &dyn Evidence, k: usize) -> (Vec<f64>, usize) {
        let (coordinate, here) = (&self.coordinates[k], self.at[k]);
        let mut step = coordinate.step();
        let mut runs = 0;
        let mut best = vec![0.0; self.residuals.len()];
        for _ in 0..3 {
            let forward = coordinate.clamped(here + step);
            let there = if (forward - here).abs() > 0.5 * step { forward } else { coordinate.clamped(here - step) };
            let mut at = self.at.clone();
            at[k] = there;
            runs += 1;
            let Ok(moved) = evidence.residuals(&moved(&self.model, &self.coordinates, &at), Split::Calibration) else {
                step *= 0.3;
                continue;
            };
            best = moved.iter().zip(&self.residuals).map(|(b, a)| (b - a) / (there - here)).collect();
            let change = best.iter().map(|d| d * d).sum::<f64>().sqrt() * (there - here).abs();
            let most = DERIVATIVE_CHANGE_MOST.max(DERIVATIVE_CHANGE_SHARE * self.chi2.sqrt());
            if (DERIVATIVE_CHANGE_LEAST..most).contains(&change)
                || (step >= DERIVATIVE_LONGEST_STEP && change < DERIVATIVE_CHANGE_LEAST)
            {
                break;
            }
            step = (step * (DERIVATIVE_CHANGE_AIM / change.max(1e-3)).clamp(0.03, 30.0)).min(DERIVATIVE_LONGEST_STEP);
        }
        (best, runs)
    }
}
