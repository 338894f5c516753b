//! Possible starts of welds on a part: its surface in strata of equal area, each with its exposure.

use rayon::prelude::*;

use crate::exposure::{ExposureRays, exposure};
use crate::surface::Surface;

/// Number of strata of a part.
const STRATA: usize = 512;
/// Rays per stratum, for a first estimate; welds are measured with more.
const RAYS: u32 = 32;
/// Height above the surface at which rays start [diagonals of the part].
const LIFT: f64 = 1e-4;
/// Tolerance between the exposure of a start and that of the weld, which lies elsewhere in the stratum; few rays are
/// used.
const SLACK: f64 = 0.1;

/// Exposure of one point in each stratum; `None` if the surface is inside another body or turned inwards.
#[derive(Clone, Debug, PartialEq)]
pub struct ExposureField {
    /// In order of cumulative area; all strata have equal area.
    pub strata: Vec<Option<f64>>,
}

impl ExposureField {
    /// Measures one point within each stratum.
    pub(crate) fn measure(surface: &Surface, reach: f64) -> Self {
        let lift = LIFT * surface.part.diagonal();
        let settings = ExposureRays { reach, lift, rays: RAYS };
        let of_stratum = |i: usize| {
            let share = (i as f64 + 0.5) / STRATA as f64;
            // Successive pairs of the R2 sequence (Roberts 2018).
            let within = [0.754_877_666_246_693, 0.569_840_290_998_053].map(|step| (0.5 + i as f64 * step).fract());
            let (face, weights) = surface.place_at(share, within);
            let corners = surface.part.corners(face as usize);
            let position = weights[0] * corners[0] + weights[1] * corners[1] + weights[2] * corners[2];
            let normal = surface.part.normal(face as usize);
            let outside = surface.is_open_space(position + lift * normal);
            outside.then(|| exposure(surface.query, position, normal, settings))
        };
        Self { strata: (0..STRATA).into_par_iter().map(of_stratum).collect() }
    }

    /// Least and greatest exposure; `None` if no point is outside.
    pub fn range(&self) -> Option<[f64; 2]> {
        let grow = |[low, high]: [f64; 2], e: [f64; 2]| [low.min(e[0]), high.max(e[1])];
        self.strata.iter().flatten().map(|&exposure| [exposure; 2]).reduce(grow)
    }

    /// Strata in which a weld whose least exposure is within a range may start.
    ///
    /// The exposure may fall along the weld, so only starts below the range are omitted, and those so far above it that
    /// no nearby weld is likely to be within.
    pub(crate) fn starts(&self, [low, high]: [f64; 2]) -> Vec<u32> {
        let fits = |exposure: f64| (low - SLACK..=high + SLACK).contains(&exposure);
        let within = |&i: &u32| self.strata[i as usize].is_some_and(fits);
        (0..self.strata.len() as u32).filter(within).collect()
    }

    /// Cumulative share of the area, in [0, 1), at a position within a stratum.
    pub(crate) fn share(&self, stratum: u32, within: f64) -> f64 {
        (f64::from(stratum) + within) / self.strata.len() as f64
    }
}
