//! Registration of maps, noise of the instrument, and residuals between two maps.
//!
//! [`untouched`] finds the pixels that a tool did not touch. On those, [`register`] fits a scan to a reference, because
//! every scan has its own offset and tilt. [`noise_floor`] estimates from a repeated scan how well any model can agree;
//! [`residual`] measures how well one does. Missing pixels are never filled here. In a mask, [`majority`] is the share of
//! exposed pixels around each pixel, and [`Border`] is the contour of such a field.

mod border;
mod exposed_share;
mod least_of;
mod noise;
mod plateau;
mod register;
mod robust;
mod scan_noise;
mod untouched;

use sdf_bake::HeightMap;

pub use border::{Border, BorderDistance};
pub use exposed_share::{between, covered, majority, shares_around};
pub use least_of::least_of;
pub use noise::{NoiseFloor, noise_floor};
pub use plateau::{Plateau, SectionAxis, plateau_pixels};
pub(crate) use register::has_slope;
pub use register::{DegreesOfFreedom, Registration, RegistrationError, register};
pub use robust::{MAD_TO_SIGMA, centre_and_sigma, median};
pub use scan_noise::{NoiseSource, ScanNoise, ScanNoiseError, roughness};
pub use untouched::{CLEARANCE, untouched, untouched_in_passes};

/// Residual between two maps over a mask.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Residual {
    /// Root mean square [m]; 0 without pixels.
    pub rms: f64,
    /// Mean [m].
    pub mean: f64,
    /// Number of pixels that both maps have and the mask selects.
    pub pixels: usize,
}

/// `measured - reference` over the pixels that `takes` selects; both maps have the same pixels.
pub fn residual(measured: &HeightMap, reference: &HeightMap, takes: impl Fn(usize) -> bool) -> Residual {
    let pairs = measured.heights.iter().zip(&reference.heights).enumerate();
    let kept = pairs.filter(|(at, (a, b))| takes(*at) && a.is_finite() && b.is_finite()).map(|(_, (a, b))| a - b);
    let (pixels, sum, squares) = kept.fold((0, 0.0, 0.0), |(n, sum, squares), d| (n + 1, sum + d, squares + d * d));
    let count = (pixels as f64).max(1.0);
    Residual { rms: (squares / count).sqrt(), mean: sum / count, pixels }
}

/// The map with its spikes replaced by missing pixels, and the indices of the spikes.
pub fn despiked(map: &HeightMap) -> (HeightMap, Vec<usize>) {
    let spikes = map.spikes();
    let mut clean = map.clone();
    for &at in &spikes {
        clean.heights[at] = f64::NAN;
    }
    (clean, spikes)
}

/// A map without the spikes that are hidden on a steep rim and show only in the difference from a second scan.
pub fn unlike_repeat(map: &HeightMap, repeat: &HeightMap) -> HeightMap {
    let ((clean, _), (repeat, _)) = rayon::join(|| despiked(map), || despiked(repeat));
    let mut checked = map.clone();
    if let Ok(over) = register(&repeat, &clean, DegreesOfFreedom::All, |_| true) {
        let (_, spikes) = despiked(&HeightMap { heights: over.left(&repeat, &clean), ..clean });
        spikes.into_iter().for_each(|at| checked.heights[at] = f64::NAN);
    }
    checked
}
