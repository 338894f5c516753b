//! Linear response of the data to any change over one variable: hat functions over it, and the change of the whitened
//! data by each. A form enters by its values at their knots.

use std::sync::Arc;

use nalgebra::{DMatrix, DVector};
use rayon::prelude::*;

use super::action::{ACTIONS, Action};
use super::exposure::{Exposures, PassExposure, distribution};
use super::variables::Variable;
use crate::criteria::CURVE_KNOTS;
use crate::evidence::{Evidence, EvidenceError, Split};
use crate::scans::{ScanEvidence, ScanView};

/// Least distance of two knots over the range of the variable.
const APART: f64 = 2e-3;

/// Hat functions over one variable with their responses.
#[derive(Clone, Debug)]
pub struct Basis {
    /// The quantity that changes.
    pub(crate) action: Action,
    /// The variable.
    pub(crate) variable: Arc<Variable>,
    /// Knots: values of the variable at the peaks [SI], ascending; about equal shares of the removal lie between them.
    pub(crate) knots: Vec<f64>,
    /// Change of the whitened calibration residuals per typical size at a knot, shape [data, knots].
    pub(crate) columns: DMatrix<f64>,
}

impl Basis {
    /// Bases of all actions over all variables that vary.
    ///
    /// # Errors
    /// If the scanner's formulas fail.
    pub(crate) fn all(evidence: &ScanEvidence, exposures: &Exposures) -> Result<Vec<Self>, EvidenceError> {
        let variables = &exposures.variables;
        let basis = |(action, variable): (usize, usize)| -> Result<Option<Self>, EvidenceError> {
            let knots = knots(&distribution(evidence, exposures, variable));
            if knots.len() < 2 {
                return Ok(None);
            }
            let columns = columns(evidence, exposures, &Over { action, variable, knots: &knots })?;
            Ok(Some(Self { action: ACTIONS[action], variable: variables[variable].clone(), knots, columns }))
        };
        let process = evidence.process();
        let takes = |&(action, variable): &(usize, usize)| ACTIONS[action].takes(process, &variables[variable]);
        let all = (0..ACTIONS.len()).flat_map(|action| (0..variables.len()).map(move |variable| (action, variable)));
        let pairs: Vec<(usize, usize)> = all.filter(takes).collect();
        let all: Result<Vec<Option<Self>>, EvidenceError> = pairs.into_par_iter().map(basis).collect();
        Ok(all?.into_iter().flatten().collect())
    }

    /// Change of the whitened residuals by `gain`, a function of the variable [SI] in typical sizes.
    pub(crate) fn column(&self, gain: impl Fn(f64) -> f64) -> DVector<f64> {
        &self.columns * DVector::from_iterator(self.knots.len(), self.knots.iter().map(|&value| gain(value)))
    }

    /// First and last knot [SI].
    pub(crate) fn ends(&self) -> [f64; 2] {
        [self.knots[0], self.knots[self.knots.len() - 1]]
    }
}

/// Hat functions over a variable, for an action, both by index.
struct Over<'a> {
    action: usize,
    variable: usize,
    knots: &'a [f64],
}

/// Knots between which about equal shares of the removal lie, from the least to the greatest value.
fn knots(distribution: &[(f64, f64)]) -> Vec<f64> {
    let total: f64 = distribution.iter().map(|(_, removed)| removed).sum();
    let (Some(first), Some(last)) = (distribution.first(), distribution.last()) else { return Vec::new() };
    let least = APART * (last.0 - first.0) + 1e-9 * first.0.abs().max(last.0.abs());
    let (mut knots, mut sum) = (vec![first.0], 0.0);
    for (value, removed) in distribution {
        sum += removed;
        let due = sum >= total * knots.len() as f64 / (CURVE_KNOTS - 1) as f64;
        if due && value - knots[knots.len() - 1] > least {
            knots.push(*value);
        }
    }
    // The last knot is the greatest value.
    match knots.len() {
        1 if last.0 - first.0 > least => knots.push(last.0),
        1 => {}
        count => knots[count - 1] = last.0,
    }
    knots
}

/// The two hat functions around a value: index of the lower one, and weight of the upper one.
fn between(knots: &[f64], value: f64) -> (usize, f64) {
    let upper = knots.partition_point(|knot| *knot <= value).clamp(1, knots.len() - 1);
    let share = (value - knots[upper - 1]) / (knots[upper] - knots[upper - 1]);
    (upper - 1, share.clamp(0.0, 1.0))
}

fn columns(evidence: &ScanEvidence, exposures: &Exposures, over: &Over) -> Result<DMatrix<f64>, EvidenceError> {
    let views: Vec<&ScanView> = evidence.of(Split::Calibration).collect();
    let scan = |view: &&ScanView| scan_columns(exposures, view, over);
    let scans: Vec<DMatrix<f64>> = views.par_iter().map(scan).collect::<Result<_, _>>()?;
    let rows: Vec<_> = scans.iter().flat_map(DMatrix::row_iter).collect();
    let mut columns = DMatrix::from_rows(&rows);
    let field = evidence.lattice_field_of(Split::Calibration);
    for mut column in columns.column_iter_mut() {
        let seen = evidence.change_seen(column.as_slice(), &field);
        column.copy_from_slice(&seen);
    }
    Ok(columns)
}

/// Columns of one scan, shape [tiles, knots].
fn scan_columns(exposures: &Exposures, view: &ScanView, over: &Over) -> Result<DMatrix<f64>, EvidenceError> {
    // An error of the scanner appears in its own scan only; a change of depth stays in all later scans.
    let first = if ACTIONS[over.action] == Action::Height { view.pass } else { 0 };
    let changes = changes(&exposures.passes[view.trial][first..=view.pass], over);
    let predicted = exposures.simulated.predicted(view);
    let columns: Vec<Vec<f64>> = changes.iter().map(|change| view.data.response(predicted, change)).collect();
    Ok(DMatrix::from_fn(view.data.tiles().len(), over.knots.len(), |tile, knot| columns[knot][tile]))
}

/// Depth removed from each pixel times each hat function, summed over passes, shape [knots, pixels].
fn changes(passes: &[PassExposure], &Over { action, variable, knots }: &Over) -> Vec<Vec<f64>> {
    let pixels = passes.first().map_or(0, |pass| pass.removed[action].len());
    let mut changes = vec![vec![0.0; pixels]; knots.len()];
    for pass in passes {
        for (at, (value, removed)) in pass.means[variable].iter().zip(&pass.removed[action]).enumerate() {
            if value.is_finite() && *removed != 0.0 {
                let (lower, share) = between(knots, *value);
                changes[lower][at] += (1.0 - share) * removed;
                changes[lower + 1][at] += share * removed;
            }
        }
    }
    changes
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn knots_cut_the_removal_into_about_equal_shares_and_end_where_it_ends() {
        let even: Vec<(f64, f64)> = (0..=1000).map(|k| (k as f64, 1.0)).collect();
        let found = knots(&even);
        assert_eq!(found.len(), CURVE_KNOTS);
        assert_eq!((found[0], found[CURVE_KNOTS - 1]), (0.0, 1000.0));
        assert!(found.windows(2).all(|pair| (pair[1] - pair[0] - 1000.0 / (CURVE_KNOTS - 1) as f64).abs() < 2.0));
        let two: Vec<(f64, f64)> = [0.0, 0.0, 5.0, 5.0, 5.0].map(|value| (value, 1.0)).to_vec();
        assert_eq!(knots(&two), [0.0, 5.0]);
        assert_eq!(knots(&[(3.0, 1.0), (3.0, 2.0)]), [3.0]);
    }

    #[test]
    fn a_value_is_between_its_hats() {
        assert_eq!(between(&[0.0, 1.0, 3.0], 2.0), (1, 0.5));
        assert_eq!(between(&[0.0, 1.0, 3.0], -1.0), (0, 0.0));
        assert_eq!(between(&[0.0, 1.0, 3.0], 9.0), (1, 1.0));
    }
}
