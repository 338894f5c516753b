//! Noise of a trial's scans in numbers, and a test of whether whitening makes it white.

use serde::Serialize;

use super::scans::ScanEvidence;
use super::structure::neighbours;
use super::tile_noise::{FittedNoise, Kernel};
use crate::criteria::SIGNIFICANCE_LEVEL;
use trial_simulation::Simulation;
use trials::measure::{NoiseSource, ScanNoise};

/// Seed of the draws behind the p-value; it belongs to the measurements, not to a search.
const SEED: u64 = 1;

/// Noise of one scan's tiles, from two scans of one surface.
#[derive(Clone, Debug, Serialize)]
pub struct NoiseSummary {
    /// Name of the trial.
    pub trial: String,
    /// Correlation function of the noise that tiles share.
    pub kernel: Kernel,
    /// Standard deviation of the part that is independent between tiles [µm].
    pub alone_um: f64,
    /// Standard deviation of the part that is correlated between tiles [µm].
    pub shared_um: f64,
    /// Correlation length of the kernel [mm].
    pub length_mm: f64,
    /// Source of the estimate.
    pub source: NoiseSource,
    /// Mean square of the whitened difference of the two scans; one where the noise model is right. `None` without two
    /// scans of one surface, as are the values derived from it.
    pub variance: Option<f64>,
    /// Moran's I of the whitened difference (Moran 1950).
    pub morans_i: Option<f64>,
    /// P-value of this correlation where the noise model is right.
    pub p_value: Option<f64>,
    /// True if no test rejects the noise model. Otherwise p-values and intervals are not valid.
    pub is_white: bool,
}

impl NoiseSummary {
    /// Noise of each ground trial.
    pub fn all(evidence: &ScanEvidence) -> Vec<Self> {
        let level = SIGNIFICANCE_LEVEL / evidence.tile_noise.len().max(1) as f64;
        let trials = evidence.simulation.trials().iter().zip(&evidence.noise).zip(&evidence.tile_noise);
        let summary = |((simulation, noise), fitted): ((&Simulation, &ScanNoise), &Option<FittedNoise>)| {
            Some(Self::new((&simulation.trial.name, &noise.source), fitted.as_ref()?, level))
        };
        trials.filter_map(summary).collect()
    }

    fn new((trial, source): (&str, &NoiseSource), fitted: &FittedNoise, level: f64) -> Self {
        let grids = &fitted.whitened;
        let test = (!grids.is_empty()).then(|| neighbours(grids, &[], SEED));
        let residuals = grids.iter().flat_map(|grid| &grid.residuals);
        let (sum, count) = residuals.fold((0.0, 0.0), |(sum, n), r| (sum + r * r, n + 1.0));
        let noise = fitted.noise;
        Self {
            trial: trial.to_owned(),
            kernel: noise.kernel,
            alone_um: 1e6 * noise.alone,
            shared_um: 1e6 * noise.shared,
            length_mm: 1e3 * noise.length,
            source: source.clone(),
            variance: test.as_ref().map(|_| sum / count),
            morans_i: test.as_ref().map(|test| test.statistic),
            p_value: test.as_ref().map(|test| test.p_value),
            is_white: test.is_some_and(|test| test.p_value > level),
        }
    }

    /// Formats the noise in one line.
    pub fn shown(&self) -> String {
        let Self { trial, alone_um, shared_um, length_mm, .. } = self;
        let source = self.source.words().map_or(String::new(), |words| format!("; {words}"));
        let (Some(variance), Some(morans_i), Some(p_value)) = (self.variance, self.morans_i, self.p_value) else {
            return format!("{trial}: alone {alone_um:.2} µm{source}");
        };
        let kernel = self.kernel.words();
        let white = if self.is_white { "" } else { "; not white: p-values and intervals are not valid" };
        format!(
            "{trial}: alone {alone_um:.2} µm, shared {shared_um:.2} µm over {length_mm:.2} mm ({kernel}); whitened: variance \
             {variance:.2}, neighbours {morans_i:+.3}, p {p_value:.3}{white}{source}"
        )
    }
}
