//! The noise of a trial's scans in numbers, and whether whitening makes it white.

use serde::Serialize;

use super::scans::ScanEvidence;
use super::structure::{ResidualGrid, neighbours};
use super::tile_noise::{FittedNoise, Kernel};
use crate::criteria::SIGNIFICANCE_LEVEL;

/// Seed of the draws behind the p-value: it belongs to the measurements, not to a search.
const SEED: u64 = 1;

/// The noise of one scan's tiles, as two scans of one surface show it.
#[derive(Clone, Debug, Serialize)]
pub struct NoiseSummary {
    /// Name of the trial.
    pub trial: String,
    /// How the noise that tiles share falls with distance.
    pub kernel: Kernel,
    /// Standard deviation of the part that a tile has alone [µm].
    pub alone_um: f64,
    /// Standard deviation of the part that neighbours share [µm].
    pub shared_um: f64,
    /// Length of the kernel [mm].
    pub length_mm: f64,
    /// Mean square of the whitened difference of the two scans; one where the noise is right.
    pub variance: f64,
    /// Correlation of neighbours in it (Moran 1950).
    pub morans_i: f64,
    /// Chance of at least such a correlation where the noise is right.
    pub p_value: f64,
    /// Whether nothing speaks against the noise. If not, p-values and intervals are not valid.
    pub is_white: bool,
}

impl NoiseSummary {
    /// One for each trial that was ground.
    pub fn all(evidence: &ScanEvidence) -> Vec<Self> {
        let trials = evidence.simulation.trials.iter().zip(&evidence.tile_noise);
        let fitted = trials.filter_map(|(simulation, noise)| Some((&simulation.trial.name, noise.as_ref()?)));
        let level = SIGNIFICANCE_LEVEL / evidence.tile_noise.len().max(1) as f64;
        fitted.map(|(trial, noise)| Self::new(trial, noise, level)).collect()
    }

    fn new(trial: &str, fitted: &FittedNoise, level: f64) -> Self {
        let grid = |residuals: &Vec<f64>| ResidualGrid {
            nx: fitted.side,
            cells: (0..residuals.len()).collect(),
            residuals: residuals.clone(),
        };
        let grids: Vec<ResidualGrid> = fitted.whitened.iter().map(grid).collect();
        let test = neighbours(&grids, SEED);
        let (sum, count) = fitted.whitened.iter().flatten().fold((0.0, 0.0), |(sum, n), r| (sum + r * r, n + 1.0));
        let noise = fitted.noise;
        Self {
            trial: trial.to_owned(),
            kernel: noise.kernel,
            alone_um: 1e6 * noise.alone,
            shared_um: 1e6 * noise.shared,
            length_mm: 1e3 * noise.length,
            variance: sum / f64::max(count, 1.0),
            morans_i: test.statistic,
            p_value: test.p_value,
            is_white: test.p_value > level,
        }
    }

    /// In a line.
    pub fn shown(&self) -> String {
        let Self { trial, alone_um, shared_um, length_mm, variance, morans_i, p_value, .. } = self;
        let kernel = self.kernel.words();
        let white = if self.is_white { "" } else { "; not white: p-values and intervals are not valid" };
        format!(
            "{trial}: alone {alone_um:.2} µm, shared {shared_um:.2} µm over {length_mm:.2} mm ({kernel}); whitened: variance \
             {variance:.2}, neighbours {morans_i:+.3}, p {p_value:.3}{white}"
        )
    }
}
