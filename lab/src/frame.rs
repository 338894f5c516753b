//! The robot's frame and clock as degrees of freedom that all calibration scans share: offset of the logged paths in
//! the frame of the scans, and delay of the logged poses. If logs were moved because they were far off, every fit
//! leaves both free, with the priors of the trials.

mod alignment;
mod estimate;
mod posterior;
mod rivals;
mod words;

pub use alignment::aligned;
pub use estimate::{FrameCause, FrameEstimate, FrameQuantity};

use effects::CompiledModel;
use files::sha256;
use glam::DVec2;
use nalgebra::DMatrix;
use rayon::prelude::*;
use trial_simulation::{SimulatedPass, Variation};
use trials::trial::{FrameErrors, FrameOffset, Trial};

use super::evidence::{EvidenceError, Split};
use super::nuisances::{ModelPasses, Nuisances};
use super::scans::{ScanEvidence, ScanView};
use super::simulation_errors::difference;
use crate::criteria::DERIVATIVE_CHANGE_LEAST;

/// Number of quantities: shift along x and y, yaw, lag.
pub(super) const QUANTITIES: usize = 4;
/// Shift along x and y [m], yaw [rad], lag [s].
pub type FrameValues = [f64; QUANTITIES];
/// Steps of the finite differences.
const STEPS: FrameValues = [0.1e-3, 0.1e-3, 2e-3, 0.01];
/// Least share of the residuals that a direction must absorb, relative to the largest; less is rounding.
const ROUNDING: f64 = 1e-9;

/// Frame and clock as degrees of freedom of the calibration residuals.
#[derive(Clone, Debug)]
pub struct FrameFreedom {
    /// Change of the residuals, each scan whitened separately, per prior standard deviation of each quantity, shape
    /// [data, 4]; zeros for one that the scans do not show.
    pub(super) columns: DMatrix<f64>,
    /// Change of a simulated height map by the same [m], by trial and pass; for each quantity one value per pixel.
    heights: Vec<Vec<[Vec<f64>; QUANTITIES]>>,
    /// Orthonormal directions that the columns span, shape [data, directions].
    directions: DMatrix<f64>,
    /// Share of a residual along each direction that frame and clock absorb.
    taken_up: Vec<f64>,
}

/// Change of all scans by one prior standard deviation of a quantity.
struct Change {
    /// Change of the calibration residuals, each scan whitened separately.
    column: Vec<f64>,
    /// Change of the height maps [m], by trial and pass.
    heights: Vec<Vec<Vec<f64>>>,
}

impl FrameFreedom {
    /// Frame and clock of a campaign whose logs were moved; `None` if its logs are close enough for the lateral shift
    /// of each part to absorb their error.
    ///
    /// # Errors
    /// If the model cannot be simulated.
    pub(super) fn of_moved(evidence: &ScanEvidence, model: &CompiledModel) -> Result<Option<Self>, EvidenceError> {
        let is_moved = evidence.logs_moved() != [0.0; QUANTITIES];
        is_moved.then(|| Self::new(evidence, model)).transpose()
    }

    /// Simulates the change of the scans with frame and clock.
    ///
    /// # Errors
    /// If the model cannot be simulated.
    pub(super) fn new(evidence: &ScanEvidence, model: &CompiledModel) -> Result<Self, EvidenceError> {
        let usual = evidence.simulation.run(model)?;
        let change = |k: usize| Change::of(evidence, (&usual, model), k);
        let changes: Vec<Change> = (0..QUANTITIES).into_par_iter().map(change).collect::<Result<_, _>>()?;
        let columns = DMatrix::from_fn(changes[0].column.len(), QUANTITIES, |row, k| changes[k].column[row]);
        let pass = |trial: usize, pass: usize| std::array::from_fn(|k| changes[k].heights[trial][pass].clone());
        let trial = |number: usize| (0..usual[number].len()).map(|at| pass(number, at)).collect();
        let heights = (0..usual.len()).map(trial).collect();
        Ok(Self { heights, ..Self::of(columns) })
    }

    /// Computes directions and shares from known columns.
    fn of(columns: DMatrix<f64>) -> Self {
        let among = columns.tr_mul(&columns).symmetric_eigen();
        let most = among.eigenvalues.amax();
        let kept: Vec<usize> = (0..QUANTITIES).filter(|&k| among.eigenvalues[k] > ROUNDING * most).collect();
        let direction = |&k: &usize| &columns * among.eigenvectors.column(k) / among.eigenvalues[k].sqrt();
        let directions: Vec<_> = kept.iter().map(direction).collect();
        let directions = match directions.is_empty() {
            true => DMatrix::zeros(columns.nrows(), 0),
            false => DMatrix::from_columns(&directions),
        };
        let taken_up = kept.iter().map(|&k| 1.0 - (1.0 + among.eigenvalues[k]).sqrt().recip()).collect();
        Self { columns, heights: Vec::new(), directions, taken_up }
    }

    /// SHA-256 of the columns.
    pub(super) fn identity(&self) -> String {
        sha256(&self.columns.iter().flat_map(|value| value.to_le_bytes()).collect::<Vec<u8>>())
    }

    /// Whitens residuals, or a change of them, where frame and clock act in addition to the noise: multiplies by `(1 +
    /// F Fᵀ)^(-1/2)`, which is the identity outside the span of the columns `F`.
    pub(super) fn whiten(&self, residuals: &mut [f64]) {
        for (direction, share) in self.directions.column_iter().zip(&self.taken_up) {
            let along: f64 = direction.iter().zip(residuals.iter()).map(|(d, r)| d * r).sum();
            residuals.iter_mut().zip(direction.iter()).for_each(|(r, d)| *r -= share * along * d);
        }
    }

    /// Inverse of [`Self::whiten`].
    fn unwhiten(&self, residuals: &mut [f64]) {
        for (direction, share) in self.directions.column_iter().zip(&self.taken_up) {
            let along: f64 = direction.iter().zip(residuals.iter()).map(|(d, r)| d * r).sum();
            let back = share / (1.0 - share) * along;
            residuals.iter_mut().zip(direction.iter()).for_each(|(r, d)| *r += back * d);
        }
    }
}

impl FrameFreedom {
    /// Most probable quantities given residuals, each scan whitened separately [prior standard deviations].
    pub(super) fn most_likely(&self, residuals: &[f64]) -> FrameValues {
        let mut left = residuals.to_vec();
        self.whiten(&mut left);
        self.whiten(&mut left);
        // Normal equations of the columns with unit priors: (1 + FᵀF)⁻¹ Fᵀ = Fᵀ (1 + F Fᵀ)⁻¹.
        std::array::from_fn(|k| -self.columns.column(k).iter().zip(&left).map(|(f, r)| f * r).sum::<f64>())
    }

    /// Adds the change by given quantities [prior standard deviations] to a simulated height map.
    pub(super) fn add_to(&self, heights: &mut [f64], (trial, pass): (usize, usize), values: FrameValues) {
        for (change, value) in self.heights[trial][pass].iter().zip(values).filter(|(_, value)| *value != 0.0) {
            heights.iter_mut().zip(change).for_each(|(height, change)| *height += value * change);
        }
    }
}

impl Change {
    /// Change by one quantity, over a step that changes the residuals by more than the simulation's numerical noise;
    /// zero where none does.
    fn of(evidence: &ScanEvidence, (usual, model): ModelPasses, quantity: usize) -> Result<Self, EvidenceError> {
        let simulations = evidence.simulation.trials();
        let scale = priors(simulations[0].trial.frame_errors)[quantity];
        let about = middle(simulations[0].trial);
        for step in [STEPS[quantity].min(scale), scale].into_iter().filter(|step| *step > 0.0) {
            let mut values = [0.0; QUANTITIES];
            values[quantity] = step;
            let frame_offset = frame_offset(values, about);
            let moved =
                evidence.simulation.varied(|_| Variation { frame_offset, ..Variation::default() })?.run(model)?;
            let change = Self::between((evidence, model), usual, &moved, scale / step)?;
            let size = change.column.iter().map(|c| c * c).sum::<f64>().sqrt() * step / scale;
            if size > DERIVATIVE_CHANGE_LEAST {
                return Ok(change);
            }
        }
        Self::between((evidence, model), usual, usual, 0.0)
    }

    /// The difference between two simulations, times a factor.
    fn between(
        (evidence, model): (&ScanEvidence, &CompiledModel),
        usual: &[Vec<SimulatedPass>],
        moved: &[Vec<SimulatedPass>],
        factor: f64,
    ) -> Result<Self, EvidenceError> {
        let pass = |(usual, moved): (&SimulatedPass, &SimulatedPass)| -> Vec<f64> {
            difference(&usual.scan, &moved.scan).into_iter().map(|change| factor * change).collect()
        };
        let trial = |(usual, moved): (&Vec<SimulatedPass>, &Vec<SimulatedPass>)| -> Vec<Vec<f64>> {
            usual.iter().zip(moved).map(pass).collect()
        };
        let heights: Vec<Vec<Vec<f64>>> = usual.iter().zip(moved).map(trial).collect();
        let scan = |view: &ScanView| -> Result<Vec<f64>, EvidenceError> {
            let predicted = |passes| evidence.predicted(view, (passes, model), Nuisances::default());
            Ok(view.data.difference_of(&predicted(usual)?, &predicted(moved)?, factor))
        };
        let scans: Vec<Vec<f64>> = evidence.of(Split::Calibration).map(scan).collect::<Result<_, _>>()?;
        Ok(Self { column: scans.concat(), heights })
    }
}

impl ScanEvidence<'_> {
    /// Measured minus simulated calibration tiles, each scan whitened separately.
    fn as_logged(&self, model: &CompiledModel) -> Result<Vec<f64>, EvidenceError> {
        let passes = self.simulate(model, Split::Calibration)?;
        self.whitened_alone((&passes, model), Split::Calibration, self.blur_of((&passes, model))?)
    }
}

/// Prior standard deviations.
pub(super) fn priors(errors: FrameErrors) -> FrameValues {
    [errors.shift, errors.shift, errors.yaw, errors.lag]
}

/// The frame offset with these values.
pub(super) fn frame_offset([x, y, yaw, lag]: FrameValues, about: DVec2) -> FrameOffset {
    FrameOffset { shift: DVec2::new(x, y), yaw, about, lag }
}

/// Centre of a trial's scans [m].
pub(super) fn middle(trial: &Trial) -> DVec2 {
    let pixels = &trial.scans.before.pixels;
    0.5 * (pixels.origin + pixels.position(pixels.nx - 1, pixels.ny - 1))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_left_has_the_likelihood_of_the_joint_covariance() {
        let columns = DMatrix::from_fn(6, QUANTITIES, |row, k| match k {
            3 => 0.0,
            _ => ((row * 7 + k * 3) % 5) as f64 - 1.7,
        });
        let residuals = nalgebra::DVector::from_fn(6, |row, _| (row as f64 - 2.2).sin() * 3.0);
        let covariance = DMatrix::identity(6, 6) + &columns * columns.transpose();
        let expected = residuals.dot(&(covariance.clone().try_inverse().unwrap() * &residuals));
        let freedom = FrameFreedom::of(columns);
        let mut left = residuals.as_slice().to_vec();
        freedom.whiten(&mut left);
        assert!((left.iter().map(|r| r * r).sum::<f64>() - expected).abs() < 1e-9);
        let nothing = FrameFreedom::of(DMatrix::zeros(3, QUANTITIES));
        let mut same = [1.0, 2.0, 3.0];
        nothing.whiten(&mut same);
        assert_eq!(same, [1.0, 2.0, 3.0], "what the scans do not show takes nothing up");
    }
}
