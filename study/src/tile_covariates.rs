//! Relative residuals of each pass at the tiles of its track, with the covariates of each tile.

use sdf_bake::HeightMap;
use sim::Covariates;

use super::track::Ground;
use crate::DisplayUnit;
use lab::Simulated;
use lab::criteria::{TILE_BLOCK_SIDE, TRACK_REMOVAL_SHARE, TRACK_REMOVAL_SIGMAS};
use lab::{
    CovariateField, CovariateStudy, ExposureView, HeightView, ScanEvidence, ScanView, Split, Tiles, covariate_study,
};
use trials::measure::despiked;
use trials::trial::RPM;

/// Covariates of a place while it is worked on: name, unit and SI value of one unit.
const COVARIATES: [(&str, &str, f64); 18] = [
    ("mean pressure", "MPa", 1e6),
    ("peak pressure", "MPa", 1e6),
    ("contact time", "s", 1.0),
    ("slip speed", "m/s", 1.0),
    ("sliding distance", "m", 1.0),
    ("slope along x", "mrad", 1e-3),
    ("slope along y", "mrad", 1e-3),
    ("way along the path", "mm", 1e-3),
    ("volume that the tool removed before", "mm³", 1e-9),
    ("depth below the original surface", "µm", 1e-6),
    ("place along x", "mm", 1e-3),
    ("place along y", "mm", 1e-3),
    ("pass of the trial", "", 1.0),
    ("direction of feed along x", "", 1.0),
    ("force setpoint", "N", 1.0),
    ("feed", "mm/s", 1e-3),
    ("spindle speed", "rpm", RPM),
    ("weld metal", "", 1.0),
];

/// Number of covariates of a tile.
pub const COUNT: usize = COVARIATES.len();

/// Name and unit of a covariate.
pub fn covariate(at: usize) -> (String, DisplayUnit) {
    let (name, unit, si) = COVARIATES[at];
    (name.to_owned(), DisplayUnit::new(unit, si))
}

/// Studies the dependence of a split's residuals on the covariates of each place.
pub fn study(evidence: &ScanEvidence, simulated: &Simulated, split: Split, seed: u64) -> CovariateStudy {
    let fields: Vec<CovariateField> = evidence.of(split).filter_map(|view| field(evidence, simulated, view)).collect();
    let masks = evidence.of(split).any(|view| view.data.as_exposure().is_some());
    covariate_study(&fields, if masks { 0.0 } else { 1.0 }, seed)
}

/// Residuals and covariates of the tiles that a pass worked on; `None` where its covariates were not simulated.
pub(super) fn field(evidence: &ScanEvidence, simulated: &Simulated, view: &ScanView) -> Option<CovariateField> {
    let places = Places::new(evidence, simulated, view)?;
    let heights = || places.removed(view.data.as_heights()?);
    let (tiles, kept, residuals, sigmas) = heights().or_else(|| Some(places.exposed(view.data.as_exposure()?)))?;
    let nx = tiles.grid.shape().0;
    let block = |&tile: &usize| {
        let cell = tiles.cells[tile];
        cell / nx / TILE_BLOCK_SIDE * nx.div_ceil(TILE_BLOCK_SIDE) + cell % nx / TILE_BLOCK_SIDE
    };
    let values = places.values(tiles);
    Some(CovariateField {
        nx,
        cells: kept.iter().map(|&tile| tiles.cells[tile]).collect(),
        residuals,
        sigmas,
        blocks: kept.iter().map(block).collect(),
        values: values.iter().map(|values| kept.iter().map(|&tile| values[tile]).collect()).collect(),
    })
}

/// Tiles, indices of those kept, their residuals and the residuals' standard deviations.
type Kept<'a> = (&'a Tiles, Vec<usize>, Vec<f64>, Vec<f64>);

/// A pass, the scan before it, and the covariates of its places.
struct Places<'a> {
    evidence: &'a ScanEvidence<'a>,
    simulated: &'a Simulated,
    view: &'a ScanView,
    covariates: &'a Covariates,
    /// Scan of the same trial after the pass before.
    earlier: Option<&'a ScanView>,
}

impl<'a> Places<'a> {
    fn new(evidence: &'a ScanEvidence, simulated: &'a Simulated, view: &'a ScanView) -> Option<Self> {
        let covariates = simulated.pass(view).covariates.as_ref()?;
        let before = |other: &&ScanView| other.trial == view.trial && other.pass + 1 == view.pass;
        Some(Self { evidence, simulated, view, covariates, earlier: evidence.views.iter().find(before) })
    }

    /// The simulated surface before the pass, as the instrument sees it.
    fn before(&self) -> HeightMap {
        let first = || despiked(&self.evidence.simulation.trials()[self.view.trial].trial.scans.before).0;
        self.earlier.and_then(|view| self.simulated.heights(view)).unwrap_or_else(first)
    }

    /// Relative residual of the removal: measured minus simulated removal of the pass, over the simulated one.
    fn removed(&self, data: &'a HeightView) -> Option<Kept<'a>> {
        let now = Ground::new(self.view, self.simulated)?;
        let earlier = self.earlier.and_then(|view| Ground::new(view, self.simulated));
        let missed = |at: usize| earlier.as_ref().map_or(0.0, |earlier| earlier.left[at]) - now.left[at];
        let (missed, removed) = (means(&data.tiles, missed), now.removed(&self.before()));
        let removed = means(&data.tiles, |at| removed[at]);
        let scans = if earlier.is_some() { 2.0f64 } else { 1.0 };
        let noise = data.noise.sigma() * scans.sqrt();
        let mut sorted: Vec<f64> = removed.iter().copied().filter(|depth| depth.is_finite()).collect();
        sorted.sort_by(f64::total_cmp);
        let deep = sorted.get(sorted.len() * 9 / 10).copied().unwrap_or(0.0);
        let least = (TRACK_REMOVAL_SIGMAS * noise).max(TRACK_REMOVAL_SHARE * deep);
        let keeps = |&tile: &usize| removed[tile] > least && missed[tile].is_finite() && self.is_known(data, tile);
        let kept: Vec<usize> = (0..removed.len()).filter(keeps).collect();
        let residuals = kept.iter().map(|&tile| missed[tile] / removed[tile]).collect();
        let sigmas = kept.iter().map(|&tile| noise / removed[tile]).collect();
        Some((&data.tiles, kept, residuals, sigmas))
    }

    /// Returns true if the simulated tool touched the centre of a tile.
    fn is_known(&self, data: &HeightView, tile: usize) -> bool {
        let place = data.tiles.centres[tile];
        self.covariates.pixels.nearest(place).is_some_and(|at| self.covariates.contact_time[at] > 0.0)
    }

    /// Measured minus simulated share of substrate.
    fn exposed(&self, data: &'a ExposureView) -> Kept<'a> {
        let exposed = self.simulated.exposed(self.view);
        let one = |holds: bool| f64::from(u8::from(holds));
        let missed = |at: usize| data.measured.exposed[at].map_or(f64::NAN, |seen| one(seen) - one(exposed[at]));
        let (missed, time) = (means(&data.tiles, missed), self.at_pixels(&self.covariates.contact_time));
        let time = means(&data.tiles, |at| time[at]);
        let kept: Vec<usize> = (0..missed.len()).filter(|&tile| missed[tile].is_finite() && time[tile] > 0.0).collect();
        let residuals = kept.iter().map(|&tile| missed[tile]).collect();
        let sigmas = vec![1.0; kept.len()];
        (&data.tiles, kept, residuals, sigmas)
    }

    fn at_pixels(&self, values: &[f64]) -> Vec<f64> {
        self.covariates.at(&self.evidence.simulation.trials()[self.view.trial].trial.scans.before.pixels, values)
    }

    /// All covariates at all tiles, in the order of [`COVARIATES`]; zero where a place was not touched.
    fn values(&self, tiles: &Tiles) -> Vec<Vec<f64>> {
        let trial = self.evidence.simulation.trials()[self.view.trial].trial;
        let pass = &trial.passes[self.view.pass];
        let known = |value: f64| if value.is_finite() { value } else { 0.0 };
        let of = |values: &[f64]| -> Vec<f64> {
            let values = self.at_pixels(values);
            means(tiles, |at| values[at]).into_iter().map(known).collect()
        };
        let place = |value: &dyn Fn(glam::DVec2) -> f64| tiles.centres.iter().map(|&c| value(c)).collect::<Vec<f64>>();
        let level = |value: f64| vec![value; tiles.len()];
        let surface = self.before();
        let slope =
            |step: usize| -> Vec<f64> { means(tiles, |at| slope(&surface, at, step)).into_iter().map(known).collect() };
        let original = &trial.scans.before.heights;
        let depth = means(tiles, |at| original[at] - surface.heights[at]).into_iter().map(known).collect();
        let (way, volume) = self.way_and_volume(tiles, pass.feed);
        let label = |at: usize| trial.scans.material.as_ref().map_or(0.0, |map| f64::from(map.labels[at]));
        vec![
            of(&self.covariates.mean_pressure()),
            of(&self.covariates.peak_pressure),
            of(&self.covariates.contact_time),
            of(&self.covariates.mean_slip_speed()),
            of(&self.covariates.slip_way),
            slope(1),
            slope(surface.pixels.nx),
            way,
            volume,
            depth,
            place(&|centre| centre.x),
            place(&|centre| centre.y),
            level((self.view.pass + 1) as f64),
            level(pass.direction.x),
            level(pass.force_setpoint),
            level(pass.feed),
            level(pass.spindle_speed),
            means(tiles, label),
        ]
    }

    /// Position along the path at which a tile is first touched [m], and the volume that the tool has removed since it
    /// was fresh [m³].
    fn way_and_volume(&self, tiles: &Tiles, feed: f64) -> (Vec<f64>, Vec<f64>) {
        let touched = &self.covariates.first_contact;
        let known = touched.iter().copied().filter(|time| time.is_finite());
        let (start, end) = known.fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), t| (low.min(t), high.max(t)));
        let pixels = self.at_pixels(touched);
        let times = means(tiles, |at| pixels[at]);
        let time = |time: &f64| if time.is_finite() { time - start } else { 0.0 };
        let own = self.simulated.pass(self.view).record.removed_volume;
        let before = self.removed_before();
        let share = |at: &f64| time(at) / (end - start).max(f64::MIN_POSITIVE);
        (times.iter().map(|at| feed * time(at)).collect(), times.iter().map(|at| before + own * share(at)).collect())
    }

    /// Volume that the tool has removed since it was fresh, before this pass [m³].
    fn removed_before(&self) -> f64 {
        let mut sum = 0.0;
        for (number, passes) in self.simulated.passes.iter().enumerate().take(self.view.trial + 1) {
            if self.evidence.simulation.trials()[number].trial.fresh {
                sum = 0.0;
            }
            let done = if number == self.view.trial { self.view.pass } else { passes.len() };
            sum += passes[..done].iter().map(|pass| pass.record.removed_volume).sum::<f64>();
        }
        sum
    }
}

/// Slope of a map towards the pixel that is `step` indices further [1].
fn slope(map: &HeightMap, at: usize, step: usize) -> f64 {
    match (at.checked_sub(step), map.heights.get(at + step)) {
        (Some(low), Some(high)) => (high - map.heights[low]) / (2.0 * map.pixels.pitch),
        _ => f64::NAN,
    }
}

/// Mean of the known values of each tile, NaN where none is.
fn means(tiles: &Tiles, value: impl Fn(usize) -> f64) -> Vec<f64> {
    let mut sums = vec![(0.0, 0.0); tiles.len()];
    for (tile, at) in tiles.pixels() {
        let value = value(at);
        if value.is_finite() {
            sums[tile].0 += value;
            sums[tile].1 += 1.0;
        }
    }
    sums.into_iter().map(|(sum, count)| sum / count).collect()
}
