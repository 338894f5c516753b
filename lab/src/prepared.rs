//! Preparation of scans as data: despiked, cut into tiles where the tool may have been, with the noise of the tiles.

use rayon::prelude::*;
use sdf_bake::HeightMap;

use super::evidence::{EvidenceError, Split};
use super::exposure_view::ExposureView;
use super::height_view::{COARSE, HeightView};
use super::observation::Observation;
use super::scans::ScanView;
use super::tile_noise::{FittedNoise, TileNoise};
use super::tiles::TileGrid;
use crate::criteria::{BORDER_REACH, TILE_LEAST_SIDE, TILES_PER_SCAN};
use trials::measure::{CLEARANCE, NoiseSource, ScanNoise, despiked, roughness, untouched};
use trials::trial::{PassScan, Role, ToolPath, Trial, least_gap};

/// The scans of a campaign as data, and the noise of one scan by trial.
pub(super) struct Prepared {
    pub(super) views: Vec<ScanView>,
    pub(super) noise: Vec<ScanNoise>,
    pub(super) tile_noise: Vec<Option<FittedNoise>>,
}

/// A trial's scan before the first pass, and the area of each pass.
struct Surface<'a> {
    trial: &'a Trial,
    /// The scan without spikes.
    before: HeightMap,
    noise: ScanNoise,
    passes: Vec<Touched>,
}

/// Area that the tool may have touched up to a pass.
struct Touched {
    path: ToolPath,
    /// For each pixel, true if no tool came near it up to then.
    free: Vec<bool>,
    /// Side of a tile [pixels].
    side: usize,
}

/// Noise of tiles of one side [pixels], by trial.
type NoiseOfSide = (usize, Vec<Option<FittedNoise>>);

impl Prepared {
    /// Prepares all scans.
    ///
    /// # Errors
    /// For the first trial whose noise is unknown, or with a pass that touches nothing.
    pub(super) fn new(trials: &[Trial]) -> Result<Self, EvidenceError> {
        let noise = ScanNoise::of_campaign(trials).map_err(|error| EvidenceError::NoData(error.to_string()))?;
        let surfaces: Vec<Surface> =
            trials.par_iter().zip(noise).map(|(trial, noise)| Surface::new(trial, noise)).collect();
        let mut sides: Vec<usize> = surfaces
            .iter()
            .flat_map(|surface| &surface.passes)
            .flat_map(|pass| [pass.side, COARSE * pass.side])
            .collect();
        sides.sort_unstable();
        sides.dedup();
        let grinds = surfaces.iter().any(Surface::is_ground);
        let noises: Vec<NoiseOfSide> = match grinds {
            true => sides.into_par_iter().map(|side| (side, noise_of_tiles(&surfaces, side))).collect(),
            false => Vec::new(),
        };
        let views: Vec<Vec<ScanView>> =
            (0..surfaces.len()).into_par_iter().map(|k| surfaces[k].views(k, &noises)).collect::<Result<_, _>>()?;
        let tile_noise = surfaces.iter().enumerate().map(|(k, surface)| {
            let side = surface.passes.last()?.side;
            noises.iter().find(|noise| noise.0 == side)?.1[k].clone()
        });
        let tile_noise = tile_noise.collect();
        let noise = surfaces.into_iter().map(|surface| surface.noise).collect();
        Ok(Self { views: views.into_iter().flatten().collect(), noise, tile_noise })
    }
}

impl<'a> Surface<'a> {
    fn new(trial: &'a Trial, noise: ScanNoise) -> Self {
        let before = trial.scans.clean_before();
        let mut free = vec![true; before.heights.len()];
        let mut touched = |pass: &trials::trial::Pass| {
            let path = ToolPath::of(&pass.log, &trial.tool, pass.force_setpoint);
            let alone = untouched(&trial.scans.before, &path, &trial.tool, CLEARANCE);
            free.iter_mut().zip(alone).for_each(|(free, alone)| *free &= alone);
            Touched { path, side: tile_side(&free, &before), free: free.clone() }
        };
        let passes = trial.passes.iter().map(&mut touched).collect();
        Self { trial, before, noise, passes }
    }

    fn is_ground(&self) -> bool {
        self.trial.passes.iter().any(|pass| pass.scan.heights().is_some())
    }

    /// Converts the scans after the passes to data.
    fn views(&self, number: usize, noises: &[NoiseOfSide]) -> Result<Vec<ScanView>, EvidenceError> {
        let view = |(pass, touched): (usize, &Touched)| {
            let data = self.data(pass, number, noises)?;
            let none = || bad(self.trial, format!("pass {}: {}", pass + 1, untouched_words(self.trial, &touched.path)));
            let split = match self.trial.passes[pass].role {
                Role::Calibration => Split::Calibration,
                Role::Evaluation => Split::Evaluation,
            };
            Ok(ScanView { trial: number, pass, split, data: data.ok_or_else(none)? })
        };
        let is_scanned = |(pass, _): &(usize, &Touched)| !self.trial.passes[*pass].scan.is_missing();
        self.passes.iter().enumerate().filter(is_scanned).map(view).collect()
    }

    fn data(
        &self,
        pass: usize,
        number: usize,
        noises: &[NoiseOfSide],
    ) -> Result<Option<Box<dyn Observation>>, EvidenceError> {
        let Touched { free, side, .. } = &self.passes[pass];
        let noise = |side: usize| {
            let noise = noises.iter().find(|noise| noise.0 == side).and_then(|noise| noise.1[number].as_ref());
            noise.map(|fitted| fitted.noise).ok_or_else(|| bad(self.trial, self.no_noise(side)))
        };
        Ok(match &self.trial.passes[pass].scan {
            PassScan::Heights(scan) => {
                let noise = [noise(*side)?, noise(COARSE * side)?];
                let view = HeightView::new(despiked(scan).0, &self.before, free, (*side, noise));
                view.map(|view| Box::new(view) as Box<dyn Observation>)
            }
            PassScan::Exposure(mask) => {
                let reach = BORDER_REACH * self.trial.tool.half_width();
                let view = ExposureView::new(mask.clone(), free, *side, reach);
                view.map(|view| Box::new(view) as Box<dyn Observation>)
            }
        })
    }

    /// Message on why the noise of tiles of a side [pixels] is unknown.
    fn no_noise(&self, side: usize) -> String {
        let (nx, ny) = TileGrid { pixels: self.noise.left.pixels, side }.shape();
        format!(
            "the repeated scan shares too few pixels with the scan before: {nx} by {ny} tiles with holes are too few \
             for a noise estimate"
        )
    }
}

fn bad(trial: &Trial, what: String) -> EvidenceError {
    EvidenceError::NoData(format!("{}: {what}", trial.name))
}

/// Noise of the means of tiles of a side [pixels] by trial, from the difference of two scans of one surface, or else
/// from the roughness of one scan. One instrument scans all trials: its noise has one correlation function, and one
/// amplitude per trial.
fn noise_of_tiles(surfaces: &[Surface], side: usize) -> Vec<Option<FittedNoise>> {
    let coarse = |map: &HeightMap| TileGrid { pixels: map.pixels, side }.coarsened(&map.heights);
    let pairs = |surface: &&Surface| surface.noise.source != NoiseSource::OneScan;
    let differences: Vec<HeightMap> =
        surfaces.iter().filter(pairs).map(|surface| coarse(&surface.noise.left)).collect();
    let mut fitted = TileNoise::fitted(&differences).into_iter();
    let alone = |surface: &Surface| roughness(&coarse(&surface.before)).map(FittedNoise::alone);
    let of = |surface: &Surface| match pairs(&surface) {
        true => {
            fitted.next().flatten().or_else(|| alone(surface).filter(|_| surface.noise.source != NoiseSource::Repeat))
        }
        false => alone(surface),
    };
    surfaces.iter().map(of).collect()
}

/// Message on why a pass shows nothing.
fn untouched_words(trial: &Trial, path: &ToolPath) -> String {
    let clearance = 1e3 * CLEARANCE;
    match least_gap(&trial.tool, path, &trial.scans.before) {
        Some(gap) if gap > CLEARANCE => format!(
            "according to its log, the tool stays {:.2} mm or more above the scan `before`, and {clearance} mm count \
             as contact: is the \
             zero of z_mm off, or radius_mm?",
            1e3 * gap
        ),
        Some(_) => {
            "the tool touched no part of the surface that all scans show: are too many pixels missing there?".into()
        }
        None => "according to its log, the tool never was over the scan `before`: is origin_mm off?".into(),
    }
}

/// Smallest tile side at which the touched area does not exceed the limit of tiles.
fn tile_side(free: &[bool], map: &HeightMap) -> usize {
    let touched = free.iter().filter(|free| !**free).count() as f64;
    ((touched / TILES_PER_SCAN as f64).sqrt().ceil() as usize)
        .clamp(TILE_LEAST_SIDE, map.pixels.nx.min(map.pixels.ny) / 4)
}
