//! Derivatives of whitened residuals from simulations that are a little uneven: long enough steps, and what earlier steps
//! have shown.

use nalgebra::{DMatrix, DVector};
use rayon::prelude::*;

use super::coordinates::{Coordinate, moved};
use super::evidence::{Evidence, Split};
use super::fit::{Fit, robust_sum};
use crate::criteria::{
    DERIVATIVE_CHANGE_AIM, DERIVATIVE_CHANGE_LEAST, DERIVATIVE_CHANGE_MOST, DERIVATIVE_CHANGE_SHARE,
    DERIVATIVE_LONGEST_STEP,
};

impl Fit {
    /// Broyden's update: the derivatives along the last step are those that were seen. A step that changes the data by no
    /// more than the simulation's own unevenness is ignored.
    pub(super) fn update_jacobian(&mut self, at: &[f64], residuals: &[f64]) {
        let way = DVector::from_iterator(at.len(), self.at.iter().zip(at).map(|(b, a)| b - a));
        let seen = DVector::from_iterator(residuals.len(), self.residuals.iter().zip(residuals).map(|(b, a)| b - a));
        if seen.norm() < DERIVATIVE_CHANGE_AIM {
            return;
        }
        let missing = (seen - &self.jacobian * &way) / way.norm_squared();
        self.jacobian += missing * way.transpose();
    }

    /// Takes derivatives that are known from elsewhere as a start; the others are made here.
    pub fn borrow_derivatives(&mut self, evidence: &dyn Evidence, lent: impl Fn(&Coordinate) -> Option<DVector<f64>>) {
        let columns: Vec<Option<DVector<f64>>> = self.coordinates.iter().map(lent).collect();
        let missing: Vec<usize> = (0..columns.len()).filter(|&k| columns[k].is_none()).collect();
        for (k, column) in columns.iter().enumerate() {
            column.iter().for_each(|column| self.jacobian.set_column(k, column));
        }
        self.differentiate(evidence, &missing);
    }

    /// Renews all derivatives: along the coordinates where none is known yet, else along the principal directions of what
    /// is known, downhill, each as far as it takes to change the data soundly. So the soft directions of a valley are
    /// as well known as the stiff ones (multisecant update; Eyert 1996).
    pub(super) fn renew_derivatives(&mut self, evidence: &dyn Evidence) {
        if self.jacobian.column_iter().any(|column| column.amax() == 0.0) {
            return self.differentiate(evidence, &(0..self.at.len()).collect::<Vec<_>>());
        }
        let there =
            |at: &Vec<f64>| evidence.residuals(&moved(&self.model, &self.coordinates, at), Split::Calibration).ok();
        let step = |place: Vec<f64>| {
            let seen = there(&place)?;
            match self.farther(&place, &seen) {
                Some(farther) => Some((2, farther.clone(), there(&farther)?)),
                None => Some((1, place, seen)),
            }
        };
        let steps: Vec<(usize, Vec<f64>, Vec<f64>)> = self.principal_steps().into_par_iter().filter_map(step).collect();
        self.runs += steps.iter().map(|(runs, ..)| runs).sum::<usize>();
        let pairs: Vec<(&Vec<f64>, &Vec<f64>)> = steps.iter().map(|(_, at, seen)| (at, seen)).collect();
        let ways = DMatrix::from_fn(self.at.len(), pairs.len(), |k, i| pairs[i].0[k] - self.at[k]);
        let changes = DMatrix::from_fn(self.residuals.len(), pairs.len(), |n, i| pairs[i].1[n] - self.residuals[n]);
        let missing = changes - &self.jacobian * &ways;
        let least = 1e-6 * ways.amax();
        if let Ok(inverse) = ways.pseudo_inverse(least) {
            self.jacobian += missing * inverse;
        }
        for (at, residuals) in pairs {
            let chi2 = robust_sum(residuals);
            if chi2 < self.chi2 {
                (self.at, self.residuals, self.chi2) = (at.clone(), residuals.clone(), chi2);
            }
        }
        self.model = moved(&self.model, &self.coordinates, &self.at);
    }

    /// A place farther off than one that changes the residuals less than soundly: derivatives that are too large make
    /// steps too short, on which the simulation's unevenness would keep them large.
    fn farther(&self, place: &[f64], seen: &[f64]) -> Option<Vec<f64>> {
        let change = seen.iter().zip(&self.residuals).map(|(b, a)| (b - a).powi(2)).sum::<f64>().sqrt();
        let way: Vec<f64> = place.iter().zip(&self.at).map(|(b, a)| b - a).collect();
        let longest = DERIVATIVE_LONGEST_STEP / way.iter().fold(f64::MIN_POSITIVE, |most, way| most.max(way.abs()));
        let factor = (DERIVATIVE_CHANGE_AIM / change.max(1.0)).min(longest);
        (change < DERIVATIVE_CHANGE_LEAST && factor > 1.0).then(|| {
            let moved = self.at.iter().zip(&way).map(|(at, way)| at + factor * way);
            moved.zip(&self.coordinates).map(|(at, coordinate)| coordinate.clamped(at)).collect()
        })
    }

    /// Places at a sound distance along each principal direction, kept within the bounds.
    fn principal_steps(&self) -> Vec<Vec<f64>> {
        let directions = self.jacobian.tr_mul(&self.jacobian).symmetric_eigen();
        let slope = self.jacobian.tr_mul(&DVector::from_column_slice(&self.residuals));
        let place = |k: usize| -> Vec<f64> {
            let way = directions.eigenvectors.column(k);
            let length = (DERIVATIVE_CHANGE_AIM / directions.eigenvalues[k].max(1e-12).sqrt())
                .min(DERIVATIVE_LONGEST_STEP / way.amax());
            let downhill = if way.dot(&slope) > 0.0 { -length } else { length };
            let at = |length: f64| -> Vec<f64> {
                let moved = self.at.iter().zip(way.iter()).map(|(at, way)| at + length * way);
                moved.zip(&self.coordinates).map(|(at, coordinate)| coordinate.clamped(at)).collect()
            };
            let moved = |place: &[f64]| place.iter().zip(&self.at).map(|(a, b)| (a - b).powi(2)).sum::<f64>();
            let (there, back) = (at(downhill), at(-downhill));
            if moved(&there) >= 0.25 * moved(&back) { there } else { back }
        };
        (0..self.at.len()).map(place).collect()
    }

    /// Renews the derivatives along some coordinates.
    pub(super) fn differentiate(&mut self, evidence: &dyn Evidence, along: &[usize]) {
        let columns: Vec<(Vec<f64>, usize)> = along.par_iter().map(|&k| self.derivative(evidence, k)).collect();
        for (&k, (column, runs)) in along.iter().zip(columns) {
            self.jacobian.set_column(k, &DVector::from_vec(column));
            self.runs += runs;
        }
    }

    /// Derivative of the residuals along a coordinate, over a way that changes them by more than the simulation's own
    /// unevenness; zero where no way does.
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
