//! Noise of the borders of masks, from the variogram of their residuals.

use glam::DVec2;
use nalgebra::{DMatrix, DVector};

use super::tile_noise::{Kernel, TileNoise};
use crate::criteria::BORDER_MAJORITY_RADIUS;

/// Number of bins of the variogram, each half a tile's side wide.
const BINS: usize = 12;
/// Bins per tile side.
const BINS_PER_SIDE: f64 = 2.0;
/// Least number of pairs in a bin.
const PAIRS_LEAST: usize = 30;
/// Correlation lengths that are tried [tile sides]: those that the bins resolve.
const LENGTHS: [f64; 2] = [0.25, 2.0];
const LENGTH_STEPS: i32 = 40;
/// Bias of the robust estimate, and its part that falls with the number of pairs (Cressie and Hawkins 1980, Eq. 10).
const BIAS: [f64; 2] = [0.457, 0.494];
/// Terms of the variogram: noise of single tiles, noise that a border shares, smooth error of the model.
const TERMS: usize = 3;

/// Steps of the search for the noise of the dose, which halve its interval.
const DOSE_STEPS: usize = 20;
/// Greatest noise of the dose that is considered [1].
const DOSE_NOISE_MOST: f64 = 1.0;

/// Residual of the border of a mask at one place.
#[derive(Clone, Copy, Debug)]
pub(super) struct BorderResidual {
    /// The place, on the measured border [m].
    pub(super) place: DVec2,
    /// Distance from the measured to the simulated border [m].
    pub(super) distance: f64,
    /// Distance across the simulated border over which the dose changes by one [m].
    pub(super) width: f64,
}

/// Noise of the border of a mask: that of its pixels, and that of the dose, which moves a border the farther the less the
/// dose changes across it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct BorderNoise {
    /// Noise of the position where the dose is exact.
    pub tile: TileNoise,
    /// Standard deviation of the dose [1], with the same correlation along the border.
    pub dose: f64,
}

/// Pairs of places at similar distances.
#[derive(Clone, Copy, Debug, Default)]
struct Bin {
    pairs: usize,
    /// Sum of their distances [tile sides].
    distances: f64,
    /// Sum of the roots of their absolute differences [m^½].
    roots: f64,
}

/// A variogram by distance.
struct Variogram([Bin; BINS]);

/// Least standard deviation of a border's position [m] in a mask of this pitch. A pixel only shows on which side it
/// lies, so that the border is uniformly distributed over a pixel in each row that crosses it; the majority takes the mean
/// of several rows.
fn resolution(pitch: f64) -> f64 {
    pitch / (12.0 * (2 * BORDER_MAJORITY_RADIUS + 1) as f64).sqrt()
}

impl BorderNoise {
    /// Noise before a simulation is known.
    ///
    /// - `scatter`: scatter of the border at single pixels [m], which a border shares over the side of a tile
    pub(super) fn expected(scatter: f64, (side, pitch): (f64, f64)) -> Self {
        let tile = TileNoise { alone: resolution(pitch), shared: scatter, length: side, kernel: Kernel::default() };
        Self { tile, dose: 0.0 }
    }

    /// Fits the noise to the residuals of masks. The noise of the dose is that with which places of any width
    /// scatter as much as pixels alone would let them.
    ///
    /// - `side`, `pitch`: of a tile and of a pixel [m]
    ///
    /// Returns `None` if there are too few places.
    pub(super) fn fitted(masks: &[Vec<BorderResidual>], (side, pitch): (f64, f64)) -> Option<Self> {
        let least = resolution(pitch);
        let with = |dose: f64| -> Option<Self> {
            let scaled = |own: &BorderResidual| (own.place, own.distance / ratio(dose * own.width, least));
            let masks: Vec<Along> = masks.iter().map(|mask| mask.iter().map(scaled).collect()).collect();
            Some(Self { tile: variogram_noise(&masks, (side, pitch))?, dose })
        };
        let alone = with(0.0)?;
        let (mut low, mut high) = (0.0, DOSE_NOISE_MOST);
        let mut best = alone;
        for _ in 0..DOSE_STEPS {
            let middle = 0.5 * (low + high);
            let found = with(middle)?;
            if found.tile.shared > least {
                low = middle;
                best = found;
            } else {
                high = middle;
            }
        }
        Some(best)
    }

    /// Ratio of the noise at a place to that where the dose is exact.
    ///
    /// - `width`: distance over which the dose changes by one [m]
    pub(super) fn ratio(&self, width: f64, pitch: f64) -> f64 {
        ratio(self.dose * width, resolution(pitch))
    }
}

fn ratio(moved: f64, resolution: f64) -> f64 {
    (moved / resolution).hypot(1.0)
}

/// Places on the border of one mask, and their residuals [m].
type Along = Vec<(DVec2, f64)>;

/// Fits the noise of a border to its residuals. Half the mean square difference of two places at a
/// distance d is `n² + σ² (1 − ρ(d/L)) + c d²` (Matheron 1963): noise of single tiles, noise with the correlation function ρ
/// that the border shares over a length L, and the smooth error of a model that lacks an effect.
///
/// - `side`, `pitch`: of a tile and of a pixel [m]
///
/// Returns `None` if there are too few places.
fn variogram_noise(masks: &[Along], (side, pitch): (f64, f64)) -> Option<TileNoise> {
    let variogram = Variogram::of(masks, side)?;
    let ratio = (LENGTHS[1] / LENGTHS[0]).powf(f64::from(LENGTH_STEPS - 1).recip());
    let lengths = |kernel: Kernel| (0..LENGTH_STEPS).map(move |step| (kernel, LENGTHS[0] * ratio.powi(step)));
    let forms = Kernel::ALL.into_iter().flat_map(lengths);
    let fits = forms.map(|(kernel, length)| (variogram.fit(kernel, length), kernel, length));
    let ((_, [alone, shared, _]), kernel, length) = fits.min_by(|a, b| a.0.0.total_cmp(&b.0.0))?;
    let sigma = |variance: f64| variance.sqrt().max(resolution(pitch));
    Some(TileNoise { alone: sigma(alone), shared: sigma(shared), length: length * side, kernel })
}

impl Bin {
    /// Half the mean square difference [m²]; few outliers change it little (Cressie and Hawkins 1980).
    fn value(&self) -> f64 {
        let pairs = self.pairs as f64;
        0.5 * (self.roots / pairs).powi(4) / (BIAS[0] + BIAS[1] / pairs)
    }
}

impl Variogram {
    /// Collects all pairs of places on the same mask; `None` if a bin has too few that differ.
    fn of(masks: &[Along], side: f64) -> Option<Self> {
        let mut bins = [Bin::default(); BINS];
        for mask in masks {
            for (k, (place, residual)) in mask.iter().enumerate() {
                for (other, beside) in &mask[..k] {
                    let distance = place.distance(*other) / side;
                    let Some(bin) = bins.get_mut((BINS_PER_SIDE * distance) as usize) else { continue };
                    bin.pairs += 1;
                    bin.distances += distance;
                    bin.roots += (residual - beside).abs().sqrt();
                }
            }
        }
        let is_known = |bin: &Bin| bin.pairs >= PAIRS_LEAST && bin.roots > 0.0;
        bins.iter().all(is_known).then_some(Self(bins))
    }

    /// Weighted least squares with non-negative terms, each bin relative to its own value (Cressie 1985). Returns the cost,
    /// and the variances of the terms [m²]; the last is per square tile side.
    ///
    /// - `length`: of the kernel [tile sides]
    fn fit(&self, kernel: Kernel, length: f64) -> (f64, [f64; TERMS]) {
        let row = |bin: &Bin| {
            let (pairs, distance) = (bin.pairs as f64, bin.distances / bin.pairs as f64);
            [1.0, 1.0 - kernel.at(distance / length), distance * distance].map(|term| pairs.sqrt() / bin.value() * term)
        };
        let rows = self.0.each_ref().map(row);
        let goal = DVector::from_iterator(BINS, self.0.iter().map(|bin| (bin.pairs as f64).sqrt()));
        let with = |chosen: Vec<usize>| {
            let columns = DMatrix::from_fn(BINS, chosen.len(), |bin, k| rows[bin][chosen[k]]);
            let found = columns.clone().svd(true, true).solve(&goal, 0.0).ok()?;
            let mut variances = [0.0; TERMS];
            chosen.iter().zip(found.iter()).for_each(|(&term, variance)| variances[term] = *variance);
            let cost = (columns * found - &goal).norm_squared();
            variances.iter().all(|variance| *variance >= 0.0).then_some((cost, variances))
        };
        // The best non-negative fit is the best of the free fits of some terms that is not negative.
        let some = |kept: usize| (0..TERMS).filter(|term| kept >> term & 1 == 1).collect();
        let fits = (1..1 << TERMS).filter_map(|kept| with(some(kept)));
        fits.min_by(|a, b| a.0.total_cmp(&b.0)).unwrap_or((f64::INFINITY, [0.0; TERMS]))
    }
}

#[cfg(test)]
mod tests {
    use rand::{RngExt, SeedableRng};
    use rand_pcg::Pcg64Mcg;

    use super::*;

    const PITCH: f64 = 0.5e-3;
    const SIDE: f64 = 4.0 * PITCH;
    /// Correlation length of the drawn noise [m].
    const LENGTH: f64 = 1.7e-3;

    /// Straight borders of 0.3 m under a dose that changes by one over 4 to 14 mm, with drawn noise of the dose and of the
    /// pixels, and a smooth error of the model.
    fn drawn(dose: f64, smooth: f64) -> Vec<Vec<BorderResidual>> {
        let mut random = Pcg64Mcg::seed_from_u64(7);
        let mut normal = || (0..12).map(|_| random.random::<f64>()).sum::<f64>() - 6.0;
        // White noise averaged with a Gaussian has the correlation of a Gaussian that is wider by the root of two.
        let weights: Vec<f64> = (-20..=20).map(|k| (-(f64::from(k) * PITCH / LENGTH).powi(2)).exp()).collect();
        let norm = weights.iter().map(|weight| weight * weight).sum::<f64>().sqrt();
        let mask = |_: usize| -> Vec<BorderResidual> {
            let white: Vec<f64> = (0..640).map(|_| normal()).collect();
            let noise = |k: usize| weights.iter().zip(&white[k..]).map(|(a, b)| a * b).sum::<f64>() / norm;
            let at = |k: usize| {
                let place = DVec2::new(k as f64 * PITCH, 0.0);
                let width = 9e-3 + 5e-3 * (place.x / 40e-3).sin();
                let sigma = (dose * width).hypot(resolution(PITCH));
                BorderResidual { place, distance: sigma * noise(k) + smooth * (place.x / 60e-3).cos(), width }
            };
            (0..600).map(at).collect()
        };
        (0..4).map(mask).collect()
    }

    #[test]
    fn the_noise_of_the_dose_is_found() {
        for dose in [0.01, 0.03] {
            let found = BorderNoise::fitted(&drawn(dose, 0.0), (SIDE, PITCH)).unwrap();
            println!("{found:?}");
            assert!((found.dose / dose - 1.0).abs() < 0.2, "{found:?} for {dose}");
            assert!((found.tile.shared / resolution(PITCH) - 1.0).abs() < 0.02, "{found:?}");
            let apart = found.tile.kernel.at(SIDE / found.tile.length);
            assert!((apart - (-0.5 * (SIDE / LENGTH).powi(2)).exp()).abs() < 0.15, "{found:?}: {apart}");
        }
    }

    #[test]
    fn a_missing_effect_is_not_taken_for_noise() {
        // A smooth error of half a pixel, several times the noise.
        let [alone, beside] =
            [0.0, 0.5 * PITCH].map(|smooth| BorderNoise::fitted(&drawn(0.01, smooth), (SIDE, PITCH)).unwrap().dose);
        assert!((beside / alone - 1.0).abs() < 0.1, "{alone} and {beside}");
    }

    #[test]
    fn pixels_limit_what_a_quiet_border_shows() {
        let quiet: Vec<Vec<BorderResidual>> = drawn(0.0, 0.0)
            .into_iter()
            .map(|mask| mask.into_iter().map(|left| BorderResidual { distance: 0.1 * left.distance, ..left }).collect())
            .collect();
        let found = BorderNoise::fitted(&quiet, (SIDE, PITCH)).unwrap();
        assert_eq!([found.tile.alone, found.tile.shared], [resolution(PITCH); 2]);
        assert!(found.dose < 1e-5, "{found:?}");
        assert_eq!(BorderNoise::fitted(&quiet[..0], (SIDE, PITCH)), None);
    }
}
