//! Paired comparison of two models on the same data, by blocks of neighbouring tiles or rows that may be correlated.
//! Errors that both models share cancel, so that the comparison is more sensitive than the two errors alone.

use effects::CompiledModel;
use rayon::prelude::*;
use serde::{Deserialize, Serialize};

use super::evidence::{Agreement, Evidence, EvidenceError, Split};
use super::fit::robust_sum;
use super::verdict::rms;
use crate::criteria::INTERVAL_SIGMAS;

/// Two models compared on one split of the data.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct PairedSplit {
    /// Root mean square errors of the two models [unit of errors].
    pub rms: [f64; 2],
    /// Noise floor, in the same unit.
    pub noise_floor: f64,
    /// Robust χ² of the first minus that of the second.
    pub delta_chi2: f64,
    /// Its standard error, from the differences of the blocks; absent if there is one block.
    pub sigma: Option<f64>,
    /// Number of blocks, and of those in which the second model is better.
    pub blocks: [usize; 2],
}

/// Two models compared on the same data.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Paired {
    /// Comparison on calibration data.
    pub calibration: PairedSplit,
    /// Comparison on held-out data; absent if there are none.
    pub held_out: Option<PairedSplit>,
}

/// The better of two models.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Better {
    /// The first.
    First,
    /// The second.
    Second,
    /// No significant difference.
    Neither,
}

impl Paired {
    /// Compares two models on the same data without refitting.
    ///
    /// # Errors
    /// If one cannot be simulated.
    pub fn new(evidence: &dyn Evidence, models: [&CompiledModel; 2]) -> Result<Self, EvidenceError> {
        let held_out = !evidence.blocks(Split::Evaluation).is_empty();
        Ok(Self {
            calibration: PairedSplit::new(evidence, models, Split::Calibration)?,
            held_out: held_out.then(|| PairedSplit::new(evidence, models, Split::Evaluation)).transpose()?,
        })
    }

    /// The split that decides: held-out data where there are any, else calibration data.
    pub fn deciding(&self) -> &PairedSplit {
        self.held_out.as_ref().unwrap_or(&self.calibration)
    }
}

impl PairedSplit {
    fn new(evidence: &dyn Evidence, models: [&CompiledModel; 2], split: Split) -> Result<Self, EvidenceError> {
        let residuals: Result<Vec<_>, _> = models.par_iter().map(|model| evidence.residuals(model, split)).collect();
        let agreement: Result<Vec<_>, _> = models.par_iter().map(|model| evidence.agreement(model, split)).collect();
        let (residuals, agreement) = (residuals?, agreement?);
        let error = |of: &[Agreement]| rms(of, |scan| scan.rms);
        let (delta_chi2, sigma, blocks) = difference([&residuals[0], &residuals[1]], &evidence.blocks(split));
        Ok(Self {
            rms: [error(&agreement[0]), error(&agreement[1])],
            noise_floor: rms(&agreement[0], |scan| scan.noise),
            delta_chi2,
            sigma,
            blocks,
        })
    }

    /// Returns the better model at the 95 % level.
    pub fn better(&self) -> Better {
        let Some(margin) = self.sigma.map(|sigma| INTERVAL_SIGMAS * sigma) else { return Better::Neither };
        match self.delta_chi2 {
            delta if delta > margin => Better::Second,
            delta if delta < -margin => Better::First,
            _ => Better::Neither,
        }
    }
}

/// Difference of two robust sums of squares, its standard error over blocks, and the number of blocks and of those that
/// favour the second model.
fn difference([first, second]: [&[f64]; 2], block_of: &[usize]) -> (f64, Option<f64>, [usize; 2]) {
    let count = block_of.iter().max().map_or(0, |most| most + 1);
    let mut sums = vec![None; count];
    for ((a, b), &block) in first.iter().zip(second).zip(block_of) {
        *sums[block].get_or_insert(0.0) += robust_sum(&[*a]) - robust_sum(&[*b]);
    }
    let known: Vec<f64> = sums.into_iter().flatten().collect();
    let blocks = known.len() as f64;
    let total: f64 = known.iter().sum();
    let squares: f64 = known.iter().map(|sum| (sum - total / blocks).powi(2)).sum();
    let sigma = (blocks > 1.0).then(|| (squares * blocks / (blocks - 1.0)).sqrt());
    (total, sigma, [known.len(), known.iter().filter(|sum| **sum > 0.0).count()])
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn equal_models_differ_by_nothing() {
        let residuals = [0.3, -1.2, 0.7, 2.0];
        assert_eq!(difference([&residuals, &residuals], &[0, 0, 1, 1]), (0.0, Some(0.0), [2, 0]));
    }

    #[test]
    fn the_standard_error_is_that_of_a_sum_over_blocks() {
        // Differences of the blocks: 1, 3, 2, 6.
        let first = [1.0, 1.2, 0.8, 1.1];
        let squares =
            |by: [f64; 4]| -> Vec<f64> { first.iter().zip(by).map(|(a, by)| f64::sqrt(a * a - by)).collect() };
        let second = squares([0.1, 0.3, 0.2, 0.6]);
        let (total, sigma, blocks) = difference([&first, &second], &[0, 1, 2, 3]);
        assert!((total - 1.2).abs() < 1e-12 && blocks == [4, 4]);
        let variance = [0.1, 0.3, 0.2, 0.6f64].iter().map(|by| (by - 0.3).powi(2)).sum::<f64>() / 3.0;
        assert!((sigma.unwrap() - (4.0 * variance).sqrt()).abs() < 1e-12);
    }

    #[test]
    fn a_difference_that_one_block_makes_alone_is_no_difference() {
        let (first, second) = ([1.0, 1.0, 1.0, 3.0], [1.0, 1.0, 1.0, 0.0]);
        let (delta_chi2, sigma, blocks) = difference([&first, &second], &[0, 1, 2, 3]);
        let split = PairedSplit { rms: [1.0; 2], noise_floor: 1.0, delta_chi2, sigma, blocks };
        assert_eq!(split.better(), Better::Neither);
    }
}
