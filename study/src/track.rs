//! Measured and simulated result of a pass in its track: volume, plateau, exposed area.

use sdf_bake::{HeightMap, PixelGrid};

use crate::Direction;
use lab::Simulated;
use lab::criteria::PLATEAU_REMOVAL_SIGMAS;
use lab::{HeightView, ScanEvidence, ScanView, Split};
use trials::measure::{
    CLEARANCE, DegreesOfFreedom, Plateau, Registration, SectionAxis, despiked, plateau_pixels, register,
    untouched_in_passes,
};
use trials::trial::Pass;

/// A volume with its standard uncertainty.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Volume {
    /// Measured [m³].
    pub measured: f64,
    /// Standard uncertainty from noise and the scans' poses [m³].
    pub uncertainty: f64,
    /// Simulated [m³].
    pub simulated: f64,
}

/// Height and slope of a plateau, measured and simulated.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PlateauFigures {
    /// Mean of measured minus simulated height [m].
    pub height_error: f64,
    /// Its standard uncertainty [m].
    pub height_uncertainty: f64,
    /// Slope across the path, measured and simulated [1].
    pub slopes: [f64; 2],
    /// Standard uncertainty of the measured slope [1].
    pub slope_uncertainty: f64,
}

/// Exposed substrate, measured and simulated.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ExposureFigures {
    /// Measured and simulated area [m²].
    pub areas: [f64; 2],
    /// Intersection over union.
    pub overlap: f64,
}

/// One scan of a ground surface compared with one model.
pub struct Ground<'a> {
    data: &'a HeightView,
    /// The simulated surface as the instrument sees it.
    pub seen: HeightMap,
    /// Measured minus simulated height, with height and tilt of the scan from the untouched surface, and the
    /// best-fitting shift [m]; NaN where it is not known.
    pub left: Vec<f64>,
}

impl<'a> Ground<'a> {
    /// Compares a scan with a simulation; `None` when sanding.
    pub fn new(view: &'a ScanView, simulated: &Simulated) -> Option<Self> {
        let (data, seen) = (view.data.as_heights()?, simulated.heights(view)?);
        let left = data.left_held(&seen.heights);
        Some(Self { data, seen, left })
    }

    /// The same simulation compared with other measured heights, without registration.
    pub fn against(&self, measured: &HeightMap) -> Self {
        let left = measured.heights.iter().zip(&self.seen.heights).map(|(measured, seen)| measured - seen).collect();
        Self { data: self.data, seen: self.seen.clone(), left }
    }

    /// Root mean square residual near the tool [m].
    pub fn rms(&self) -> f64 {
        let left = self.data.tiles.pixels().map(|(_, at)| self.left[at]).filter(|left| left.is_finite());
        let (sum, count) = left.fold((0.0, 0.0), |(sum, count), left| (sum + left * left, count + 1.0));
        (sum / f64::max(count, 1.0)).sqrt()
    }

    /// Measured heights, levelled on the untouched surface, and the simulated ones shifted to where they fit best [m].
    /// Their difference is [`Ground::left`].
    pub fn heights(&self) -> (Vec<f64>, Vec<f64>) {
        let measured = self.data.levelled();
        let shifted = measured.iter().zip(&self.left).map(|(measured, left)| measured - left).collect();
        (measured, shifted)
    }

    /// Depth that the simulation removed since `before` [m].
    pub fn removed(&self, before: &HeightMap) -> Vec<f64> {
        before.heights.iter().zip(&self.seen.heights).map(|(before, after)| before - after).collect()
    }

    /// Volume removed since the scan before the first pass, including rims: which tiles are rims depends on the model.
    /// Their uncertainty is taken to be that of the others.
    pub fn volume(&self, before: &HeightMap) -> Volume {
        let area = self.seen.pixels.pitch.powi(2);
        let removed = self.removed(before);
        let (judged, fitted) = (&self.data.judged, &self.data.tiles);
        let sum = |of: &[f64]| {
            let known = judged.pixels().map(|(_, at)| of[at]).filter(|value| value.is_finite());
            area * known.sum::<f64>()
        };
        let simulated = sum(&removed);
        let share = judged.pixels().count() as f64 / fitted.pixels().count().max(1) as f64;
        let uncertainty = share * self.data.volume_sigma();
        Volume { measured: simulated - sum(&self.left), uncertainty, simulated }
    }

    /// Mean measured depth since the scan before the first pass, near the tool [m].
    fn depth(&self, before: &HeightMap) -> f64 {
        let known = |at: &usize| (self.left[*at] + before.heights[*at]).is_finite();
        let count = self.data.tiles.pixels().filter(|(_, at)| known(at)).count();
        self.volume(before).measured / (self.seen.pixels.pitch.powi(2) * count.max(1) as f64)
    }

    /// The plateau that a pass left.
    pub fn plateau(&self, before: &HeightMap, pass: &Pass, noise: f64) -> Plateau {
        let across = if pass.direction.x.abs() >= pass.direction.y.abs() { SectionAxis::Y } else { SectionAxis::X };
        plateau_pixels(self.seen.pixels, &self.removed(before), PLATEAU_REMOVAL_SIGMAS * noise, across)
    }

    /// Height and slope of a plateau, or of a section of one; `None` if too little of it is known.
    pub fn figures(&self, plateau: &Plateau) -> Option<PlateauFigures> {
        let knows = |at: usize| self.left[at].is_finite();
        let (mean, slope) = (plateau.mean_weights(knows), plateau.slope_weights(knows));
        let sum = |weights: &[(usize, f64)], of: &[f64]| weights.iter().map(|&(at, w)| w * of[at]).sum::<f64>();
        let simulated = sum(&slope, &self.seen.heights);
        let found = PlateauFigures {
            height_error: sum(&mean, &self.left),
            height_uncertainty: self.sigma(&mean),
            slopes: [simulated + sum(&slope, &self.left), simulated],
            slope_uncertainty: self.sigma(&slope),
        };
        (found.height_error.is_finite() && found.slopes[0].is_finite()).then_some(found)
    }

    /// Standard deviation of a weighted sum over pixels, from noise and pose.
    fn sigma(&self, weights: &[(usize, f64)]) -> f64 {
        let mut of_pixel = vec![0.0; self.left.len()];
        weights.iter().for_each(|&(at, weight)| of_pixel[at] = weight);
        let mut of_tile = vec![0.0; self.data.tiles.len()];
        self.data.tiles.pixels().for_each(|(tile, at)| of_tile[tile] += of_pixel[at]);
        self.data.held_sigma(&of_tile)
    }
}

/// Largest mean measured depth after the passes of a split [m]; infinite when sanding, where scans show no depth.
pub fn deepest(evidence: &ScanEvidence, simulated: &Simulated, split: Split) -> f64 {
    let depth = |view: &ScanView| {
        let before = &evidence.simulation.trials()[view.trial].trial.scans.before;
        Some(Ground::new(view, simulated)?.depth(before))
    };
    evidence.of(split).filter_map(depth).reduce(f64::max).unwrap_or(f64::INFINITY)
}

/// Pixels of a section.
pub fn line_of(pixels: PixelGrid, line: Direction) -> Vec<usize> {
    let nearest = |place: f64, start: f64, count: usize| {
        (((place - start) / pixels.pitch).round().max(0.0) as usize).min(count - 1)
    };
    let along_x = |j: usize| (0..pixels.nx).map(|i| pixels.at(i, j)).collect();
    match line {
        Direction::Across(x) => {
            let i = nearest(x, pixels.origin.x, pixels.nx);
            (0..pixels.ny).map(|j| pixels.at(i, j)).collect()
        }
        Direction::Along(y) => along_x(nearest(y, pixels.origin.y, pixels.ny)),
        Direction::AlongCrest => along_x(pixels.ny / 2),
    }
}

/// Exposed area of a mask; `None` when grinding.
pub fn exposure(view: &ScanView, simulated: &Simulated) -> Option<ExposureFigures> {
    let data = view.data.as_exposure()?;
    let exposed = simulated.exposed(view);
    let known = data.measured.exposed.iter().zip(&exposed).filter_map(|(m, s)| m.map(|m| (m, *s)));
    let count = |takes: fn(bool, bool) -> bool| known.clone().filter(|&(m, s)| takes(m, s)).count() as f64;
    let pixel = data.measured.pixels.pitch.powi(2);
    let (both, either) = (count(|m, s| m && s), count(|m, s| m || s));
    Some(ExposureFigures {
        areas: [pixel * count(|m, _| m), pixel * count(|_, s| s)],
        overlap: if either > 0.0 { both / either } else { 1.0 },
    })
}

/// Registration of a scan on the scan before the first pass, over the untouched surface, and its levelled heights;
/// `None` when sanding, or if too little is untouched.
pub fn alignment(evidence: &ScanEvidence, view: &ScanView) -> Option<(Registration, HeightMap)> {
    let trial = evidence.simulation.trials()[view.trial].trial;
    let data = view.data.as_heights()?;
    let (before, _) = despiked(&trial.scans.before);
    let free = untouched_in_passes(&trial.scans.before, &trial.passes[..=view.pass], &trial.tool, CLEARANCE);
    let found = register(&data.measured, &before, DegreesOfFreedom::All, |at| free[at]).ok()?;
    let levelled = found.levelled(&data.measured);
    Some((found, levelled))
}
