//! Noise of the instrument, from two scans of one surface.

use rayon::prelude::*;
use sdf_bake::HeightMap;

use super::register::{DegreesOfFreedom, Registration, RegistrationError, has_slope, register};
use super::robust::{MAD_TO_SIGMA, centre_and_sigma, median};

/// Longest lag of the variogram [pixels].
const MOST_LAG: usize = 40;
/// Relative rise of an exponential variogram at its correlation length.
const RISE: f64 = 0.632;

/// Noise of one scan, from the difference between two scans of one surface.
#[derive(Clone, Debug, PartialEq)]
pub struct NoiseFloor {
    /// Robust standard deviation of a pixel of one scan [m]: the core of the distribution, without tails.
    pub sigma: f64,
    /// Root mean square error of one scan, tails included [m].
    pub rms: f64,
    /// White part, independent from pixel to pixel: the variogram extrapolated to lag zero [m].
    pub white: f64,
    /// Correlated part, shared by neighbouring pixels [m].
    pub correlated: f64,
    /// Correlation length of that part [m]; 0 without one.
    pub correlation_length: f64,
    /// Number of pixels that both scans have.
    pub pixels: usize,
    /// Registration of the second scan with the first.
    pub registration: Registration,
}

impl NoiseFloor {
    /// The same with all heights multiplied.
    pub(super) fn times(self, factor: f64) -> Self {
        let [sigma, rms, white, correlated] =
            [self.sigma, self.rms, self.white, self.correlated].map(|height| factor * height);
        Self { sigma, rms, white, correlated, ..self }
    }
}

/// Compares two scans of one surface after registration with a lateral shift. Pixels at the border and beside missing
/// ones are excluded: a shift changes them by a slope that is poorly known.
///
/// The difference of two scans has twice the variance of one. Its robust variogram
/// `g(l) = ½ (1.4826 median |d(x + l) - d(x)|)²`, the mean over x and y, rises from the white part at lag zero to
/// the whole variance (Matheron 1963; Cressie and Hawkins 1980 for the robust form).
///
/// # Errors
/// [`RegistrationError`] if the scans cannot be registered.
pub fn noise_floor(first: &HeightMap, second: &HeightMap) -> Result<NoiseFloor, RegistrationError> {
    noise_floor_where(first, second, |_| true)
}

/// The same over the pixels that `takes` selects.
///
/// # Errors
/// As [`noise_floor`].
pub fn noise_floor_where(
    first: &HeightMap,
    second: &HeightMap,
    takes: impl Fn(usize) -> bool,
) -> Result<NoiseFloor, RegistrationError> {
    let registration = register(second, first, DegreesOfFreedom::All, &takes)?;
    let left = registration.left(second, first).into_iter().enumerate();
    let known = |at: usize| takes(at) && has_slope(first, at);
    let difference: Vec<f64> = left.map(|(at, left)| if known(at) { left } else { f64::NAN }).collect();
    let known: Vec<f64> = difference.iter().copied().filter(|d| d.is_finite()).collect();
    let Some((_, spread)) = centre_and_sigma(&known) else {
        return Err(RegistrationError::TooFewPixels { found: 0 });
    };
    let rms = (known.iter().map(|d| d * d).sum::<f64>() / known.len() as f64 / 2.0).sqrt();
    let lags = MOST_LAG.min(first.pixels.nx.min(first.pixels.ny) / 2).max(2);
    let variogram: Vec<f64> = (1..=lags).into_par_iter().map(|lag| variogram(&difference, first, lag)).collect();
    let sill = spread * spread;
    let white = (2.0 * variogram[0] - variogram[1]).clamp(0.0, sill);
    let goal = white + RISE * (sill - white);
    let reached = variogram.iter().position(|&g| g >= goal).map_or(lags, |k| k + 1);
    let correlated = (sill - white).max(0.0);
    let shares = correlated > 0.05 * sill;
    Ok(NoiseFloor {
        sigma: (sill / 2.0).sqrt(),
        rms,
        white: (white / 2.0).sqrt(),
        correlated: if shares { (correlated / 2.0).sqrt() } else { 0.0 },
        correlation_length: if shares { reached as f64 * first.pixels.pitch } else { 0.0 },
        pixels: known.len(),
        registration,
    })
}

/// Robust semivariance [m²] at a lag [pixels], the mean of both directions.
fn variogram(difference: &[f64], map: &HeightMap, lag: usize) -> f64 {
    let (nx, ny) = (map.pixels.nx, map.pixels.ny);
    let along = |di: usize, dj: usize| {
        let pairs = (0..ny - dj).flat_map(|j| (0..nx - di).map(move |i| (j * nx + i, (j + dj) * nx + i + di)));
        let steps = pairs.map(|(a, b)| (difference[b] - difference[a]).abs()).filter(|step| step.is_finite());
        0.5 * (MAD_TO_SIGMA * median(steps.collect()).unwrap_or(0.0)).powi(2)
    };
    0.5 * (along(lag, 0) + along(0, lag))
}

#[cfg(test)]
mod tests {
    use glam::DVec2;
    use rand::{RngExt, SeedableRng};
    use rand_pcg::Pcg64Mcg;
    use sdf_bake::PixelGrid;

    use super::*;

    /// A plate with white noise of `white` [m] and, over blocks of 16 pixels, shared noise of `shared` [m].
    fn scan(seed: u64, white: f64, shared: f64) -> HeightMap {
        let pixels = PixelGrid { origin: DVec2::ZERO, pitch: 0.25e-3, nx: 240, ny: 160 };
        let mut random = Pcg64Mcg::seed_from_u64(seed);
        // The sum of twelve uniform numbers is approximately normal, with a variance of one.
        let mut normal = move || (0..12).map(|_| random.random::<f64>()).sum::<f64>() - 6.0;
        let squares: Vec<f64> = (0..15 * 10).map(|_| shared * normal()).collect();
        let heights = (0..pixels.len()).map(|k| {
            let (i, j) = (k % 240, k / 240);
            let tilt = 1e-4 * seed as f64 * i as f64 * 0.25e-3;
            let spike = if k % 200 == 17 { 90e-6 } else { 0.0 };
            tilt + 5e-6 * seed as f64 + spike + white * normal() + squares[j / 16 * 15 + i / 16]
        });
        HeightMap { pixels, heights: heights.collect() }
    }

    #[test]
    fn white_noise_is_measured_below_spikes_offset_and_tilt() {
        let floor = noise_floor(&scan(1, 2e-6, 0.0), &scan(2, 2e-6, 0.0)).unwrap();
        println!("2 µm white: {floor:?}");
        assert!((floor.sigma / 2e-6 - 1.0).abs() < 0.03, "{}", floor.sigma);
        assert!((floor.white / 2e-6 - 1.0).abs() < 0.05, "{}", floor.white);
        assert!(floor.correlated < 0.5e-6, "{}", floor.correlated);
        assert!((floor.registration.tilt.x - 1e-4).abs() < 3e-6, "{:?}", floor.registration);
    }

    #[test]
    fn shared_noise_is_told_from_white_noise() {
        let floor = noise_floor(&scan(1, 1e-6, 3e-6), &scan(2, 1e-6, 3e-6)).unwrap();
        println!("1 µm white, 3 µm shared over 4 mm: {floor:?}");
        assert!((floor.sigma / 10f64.sqrt() / 1e-6 - 1.0).abs() < 0.2, "{}", floor.sigma);
        assert!(floor.white < 1.4e-6 && floor.correlated > 2.3e-6, "{floor:?}");
        assert!((1e-3..5e-3).contains(&floor.correlation_length), "{}", floor.correlation_length);
    }
}
