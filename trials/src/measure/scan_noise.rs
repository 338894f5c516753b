//! Noise of each trial's scans: from its repeated scan, or from a substitute.

use rayon::prelude::*;
use sdf_bake::{HeightMap, PixelGrid};
use serde::Serialize;

use super::noise::{NoiseFloor, noise_floor, noise_floor_where};
use super::{CLEARANCE, RegistrationError, centre_and_sigma, despiked, untouched_in_passes};
use crate::trial::Trial;

/// Minimum number of untouched pixels for a robust spread within a tenth. Of 2,000 pixels in patches of 4 x 4 that
/// share noise, 125 are independent; the relative error of their spread is 1.17 / √(2 · 125) (Rousseeuw and Croux
/// 1993).
const LEAST_UNTOUCHED: usize = 2000;
/// Relative difference of two pitches that counts as rounding.
const SAME_PITCH: f64 = 1e-6;

/// Source of the noise estimate of a trial's scans.
#[derive(Clone, Debug, Default, PartialEq, Eq, Serialize)]
#[serde(rename_all = "kebab-case", tag = "kind", content = "trial")]
pub enum NoiseSource {
    /// The trial's repeated scan.
    #[default]
    Repeat,
    /// The repeated scan of another trial.
    OtherTrial(String),
    /// Pixels that no tool touched between the scan before and the first one after a pass.
    Untouched,
    /// Pixels that no tool touched, between the nominal surface and the first scan after a pass.
    Nominal,
    /// The roughness of the scan before alone.
    OneScan,
}

/// Difference of two scans of one surface, or of a scan and the nominal surface, or its substitute.
#[derive(Clone, Debug, PartialEq)]
pub struct ScanNoise {
    /// Source of the difference.
    pub source: NoiseSource,
    /// Difference after registration [m], on the trial's pixels; NaN where it is unknown.
    pub left: HeightMap,
    /// The noise statistics.
    pub floor: NoiseFloor,
}

/// Error of a trial whose noise cannot be estimated.
#[derive(Debug, thiserror::Error)]
#[error("{trial}: {what}: {why}")]
pub struct ScanNoiseError {
    trial: String,
    what: &'static str,
    why: String,
}

impl ScanNoiseError {
    fn new(trial: &Trial, what: &'static str, why: impl ToString) -> Self {
        Self { trial: trial.name.clone(), what, why: why.to_string() }
    }
}

impl NoiseSource {
    /// True if the noise may be underestimated: grinding marks lie where the tool was.
    pub fn is_lower_bound(&self) -> bool {
        matches!(self, Self::Untouched | Self::Nominal)
    }

    /// Description for messages, after the name of the trial; `None` for a repeated scan.
    pub fn words(&self) -> Option<String> {
        Some(match self {
            Self::Repeat => return None,
            Self::OtherTrial(name) => format!("no repeated scan: its noise is taken from the one of {name}"),
            Self::Untouched => {
                "no repeated scan: its noise is taken from where no tool came between the scan before and \
                                that after the first pass, a lower bound"
                    .to_owned()
            }
            Self::Nominal => "no scan before the first pass: the noise is taken from where no tool came, between the \
                              nominal surface and the first scan; it holds the texture of the surface and its \
                              deviation from the drawing, but no grinding marks, and is a lower bound"
                .to_owned(),
            Self::OneScan => "no repeated scan: its noise is taken from the roughness of the scan before alone, which holds \
                              the texture of the surface and lacks what neighbouring pixels share; p-values and intervals \
                              are not valid"
                .to_owned(),
        })
    }
}

impl ScanNoise {
    /// The noise of each trial.
    ///
    /// # Errors
    /// A repeated scan that cannot be registered with the scan before, or a scan without enough pixels.
    pub fn of_campaign(trials: &[Trial]) -> Result<Vec<Self>, ScanNoiseError> {
        let own: Vec<Option<Self>> = trials.par_iter().map(Self::repeated).collect::<Result<_, _>>()?;
        let known: Vec<(&Trial, &Self)> =
            trials.iter().zip(&own).filter_map(|(trial, noise)| Some((trial, noise.as_ref()?))).collect();
        let others = |trial: &Trial| {
            let pitch = trial.scans.before.pixels.pitch;
            let alike = |(_, noise): &&(&Trial, &Self)| (noise.left.pixels.pitch / pitch - 1.0).abs() < SAME_PITCH;
            known.iter().find(alike).map(|(donor, noise)| noise.lent_to(trial, &donor.name))
        };
        let scanned = |(trial, own): (&Trial, &Option<Self>)| match own.clone().or_else(|| others(trial)) {
            Some(noise) => Ok(noise),
            None => Self::untouched(trial).map_or_else(|| Self::one_scan(trial), Ok),
        };
        let one = |(trial, own): (&Trial, &Option<Self>)| match Self::nominal(trial) {
            Some(noise) => noise,
            None => scanned((trial, own)),
        };
        trials.par_iter().zip(&own).map(one).collect()
    }

    /// The difference with its gaps filled by mirroring what is beside them: noise like the noise there.
    pub fn without_gaps(&self) -> HeightMap {
        HeightMap { heights: mirrored_into_gaps(&self.left), ..self.left.clone() }
    }

    /// From a trial's repeated scan, if it has one.
    fn repeated(trial: &Trial) -> Result<Option<Self>, ScanNoiseError> {
        let Some(repeat) = trial.scans.repeats.first() else { return Ok(None) };
        let (before, repeat) = (trial.scans.clean_before(), despiked(repeat).0);
        let bad = |error: RegistrationError| ScanNoiseError::new(trial, "the repeated scan", error);
        let floor = noise_floor(&before, &repeat).map_err(bad)?;
        let left = HeightMap { heights: floor.registration.left(&repeat, &before), ..before };
        // A spike on a steep rim shows only in the difference.
        Ok(Some(Self { source: NoiseSource::Repeat, left: despiked(&left).0, floor }))
    }

    /// The same noise on the pixels of another trial, mirrored at the borders.
    fn lent_to(&self, trial: &Trial, name: &str) -> Self {
        let PixelGrid { nx, ny, .. } = self.left.pixels;
        let pixels = trial.scans.before.pixels;
        let at = |k: usize| self.left.height(mirrored(k % pixels.nx, nx), mirrored(k / pixels.nx, ny));
        let left = HeightMap { pixels, heights: (0..pixels.len()).map(at).collect() };
        Self { source: NoiseSource::OtherTrial(name.to_owned()), left, floor: self.floor.clone() }
    }

    /// From pixels that no tool touched, between a nominal surface and the first scan of heights; `None` if the surface
    /// was scanned, or if there are no heights.
    fn nominal(trial: &Trial) -> Option<Result<Self, ScanNoiseError>> {
        let (_, scan) = trial.first_scanned().filter(|_| trial.scans.is_nominal)?;
        scan.heights()?;
        let few = format!("fewer than the {LEAST_UNTOUCHED} pixels that are needed");
        let what = "the first scan and the nominal surface, where no tool came";
        let found = Self::untouched(trial).ok_or_else(|| ScanNoiseError::new(trial, what, few));
        // The surface of the drawing has no noise: the whole difference is that of one scan.
        Some(found.map(|noise| Self { source: NoiseSource::Nominal, floor: noise.floor.times(2f64.sqrt()), ..noise }))
    }

    /// From pixels that no tool touched between the scan before and the first one after a pass; `None` if they are too
    /// few.
    fn untouched(trial: &Trial) -> Option<Self> {
        let (passes, scan) = trial.first_scanned()?;
        let (before, after) = (trial.scans.clean_before(), despiked(scan.heights()?).0);
        let free = untouched_in_passes(&before, passes, &trial.tool, CLEARANCE);
        let floor = noise_floor_where(&before, &after, |at| free[at]).ok()?;
        let mut left = HeightMap { heights: floor.registration.left(&after, &before), ..before };
        left.heights.iter_mut().zip(&free).filter(|(_, free)| !**free).for_each(|(left, _)| *left = f64::NAN);
        let left = despiked(&left).0;
        (floor.pixels >= LEAST_UNTOUCHED).then_some(Self { source: NoiseSource::Untouched, left, floor })
    }

    /// From the roughness of the scan before alone.
    ///
    /// A cross difference `h(i, j) − h(i+1, j) − h(i, j+1) + h(i+1, j+1)` has four times the variance of a pixel. Every
    /// shape that is a function of x plus one of y cancels: planes, straight beads, cylinders.
    fn one_scan(trial: &Trial) -> Result<Self, ScanNoiseError> {
        let before = trial.scans.clean_before();
        let crosses = cross_differences(&before);
        let known: Vec<f64> = crosses.iter().copied().filter(|cross| cross.is_finite()).collect();
        let few = || RegistrationError::TooFewPixels { found: known.len() };
        let (_, spread) =
            centre_and_sigma(&known).ok_or_else(|| ScanNoiseError::new(trial, "the scan before", few()))?;
        let sigma = 0.5 * spread;
        let floor = NoiseFloor {
            sigma,
            rms: sigma,
            white: sigma,
            correlated: 0.0,
            correlation_length: 0.0,
            pixels: known.len(),
            registration: Default::default(),
        };
        // A difference of two scans has twice the variance of one.
        let heights = crosses.iter().map(|cross| cross / 2f64.sqrt()).collect();
        Ok(Self { source: NoiseSource::OneScan, left: HeightMap { heights, ..before }, floor })
    }
}

/// Robust standard deviation of one value of a map from its cross differences; `None` if they are too few.
pub fn roughness(map: &HeightMap) -> Option<f64> {
    let known: Vec<f64> = cross_differences(map).into_iter().filter(|cross| cross.is_finite()).collect();
    centre_and_sigma(&known).map(|(_, spread)| 0.5 * spread)
}

/// The cross difference of each pixel with its neighbours to higher x and y; NaN at the border and beside missing ones.
fn cross_differences(map: &HeightMap) -> Vec<f64> {
    let PixelGrid { nx, ny, .. } = map.pixels;
    let cross = |k: usize| {
        let (i, j) = (k % nx, k / nx);
        let inside = i + 1 < nx && j + 1 < ny;
        if inside {
            map.height(i, j) - map.height(i + 1, j) - map.height(i, j + 1) + map.height(i + 1, j + 1)
        } else {
            f64::NAN
        }
    };
    (0..map.heights.len()).map(cross).collect()
}

/// Mirrors an index outside a row of `count` at the row's ends.
fn mirrored(at: usize, count: usize) -> usize {
    let within = at % (2 * count);
    if within < count { within } else { 2 * count - 1 - within }
}

/// Heights of a map with its gaps filled, along y, by mirroring what is beside them.
fn mirrored_into_gaps(map: &HeightMap) -> Vec<f64> {
    let PixelGrid { nx, ny, .. } = map.pixels;
    let mut filled = map.heights.clone();
    for i in 0..nx {
        let known: Vec<usize> = (0..ny).filter(|&j| map.height(i, j).is_finite()).collect();
        for j in (0..ny).filter(|_| !known.is_empty()) {
            let after = known.partition_point(|&own| own < j);
            if known.get(after) == Some(&j) {
                continue;
            }
            let below = after.checked_sub(1).map(|k| (j - known[k], after - 1));
            let above = known.get(after).map(|own| (own - j, after));
            let nearest = below.into_iter().chain(above).min();
            let (distance, edge) = nearest.expect("some are known");
            // Counted in known pixels, so that a gap as wide as the pixels beside it is filled, too.
            let source = if Some((distance, edge)) == below {
                edge.saturating_sub(distance - 1)
            } else {
                (edge + distance - 1).min(known.len() - 1)
            };
            filled[map.pixels.at(i, j)] = map.height(i, known[source]);
        }
    }
    filled
}

#[cfg(test)]
mod tests {
    use glam::DVec2;

    use super::*;

    fn map(nx: usize, ny: usize, height: impl Fn(f64, f64) -> f64) -> HeightMap {
        let pixels = PixelGrid { origin: DVec2::ZERO, pitch: 1.0, nx, ny };
        HeightMap::from_function(pixels, |place| height(place.x, place.y))
    }

    #[test]
    fn shapes_along_x_and_y_leave_no_roughness() {
        let smooth = map(40, 30, |x, y| 2e-3 * (0.1 * x).sin() + 1e-3 * (1.0 - (y / 15.0 - 1.0).powi(2)));
        assert!(roughness(&smooth).unwrap() < 1e-15);
        // Heights without correlation between neighbours, uniform between 0 and 1 µm.
        let rough = map(120, 90, |x, y| 1e-6 * ((12.9898 * x + 78.233 * y).sin() * 43758.5453).rem_euclid(1.0));
        let expected = 1e-6 / 12f64.sqrt();
        assert!((roughness(&rough).unwrap() / expected - 1.0).abs() < 0.1, "{}", roughness(&rough).unwrap());
    }

    #[test]
    fn gaps_show_the_mirror_image_of_what_is_beside_them() {
        let mut striped = map(1, 8, |_, y| y);
        for j in [2, 3, 4, 5] {
            striped.heights[j] = f64::NAN;
        }
        assert_eq!(mirrored_into_gaps(&striped), [0.0, 1.0, 1.0, 0.0, 7.0, 6.0, 6.0, 7.0]);
        let lost = HeightMap { heights: vec![f64::NAN; 8], ..striped };
        assert!(mirrored_into_gaps(&lost).iter().all(|height| height.is_nan()));
    }

    #[test]
    fn indices_beyond_a_row_are_mirrored() {
        assert_eq!([0, 2, 3, 5, 6, 11].map(|at| mirrored(at, 3)), [0, 2, 2, 0, 0, 0]);
    }
}
