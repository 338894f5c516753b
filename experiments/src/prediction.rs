//! Predictions of a trial that was not made: each hypothesis is simulated and seen as its scans would be.

use effects::{CompiledModel, States};
use nalgebra::{DMatrix, DVector};
use rayon::prelude::*;
use sdf_bake::{HeightMap, PixelGrid};

use super::design::Design;
use super::hypothesis::Hypothesis;
use super::score::Predicted;
use lab::criteria::{CHANGED_HEIGHT, NEXT_TRIAL_TILES, NEXT_TRIAL_VOXEL_RATIO};
use lab::{EvidenceError, HeightView, Observation, ScanEvidence, ScanView, TileGrid, TileNoise, Tiles, Whitener};
use trial_simulation::CampaignError;
use trial_simulation::SeenSurface;
use trial_simulation::{SimulatedPass, Simulation, SimulationError, Variation};
use trials::trial::Trial;

/// Index of the template trial.
pub(super) const TEMPLATE: usize = 0;

/// Hypotheses prepared for simulation on candidate trials.
pub(super) struct Predictor<'a> {
    evidence: &'a ScanEvidence<'a>,
    hypotheses: Vec<Simulated>,
    /// Standard deviation of whitened data that is attributed to noise.
    spread: f64,
    /// Side of a tile [pixels] and the noise of its mean; `None` when sanding.
    tiles: Option<(usize, TileNoise)>,
    /// Voxel of the simulation [m].
    voxel: f64,
}

/// A hypothesis with its model and the perturbed models for derivatives.
struct Simulated {
    /// Best values first, then one for each coordinate.
    models: Vec<CompiledModel>,
    /// Step of each coordinate in the perturbed models.
    ways: DVector<f64>,
    /// State of the tool at the end of the campaign, by model.
    worn: Vec<States>,
    has_rows: bool,
}

/// The scan after a pass as data.
enum PlannedScan<'a> {
    /// Tiles of the cut that the hypotheses predict.
    Cut(Tiles, Box<Whitener>),
    /// The same tiles as in the scan of the trial that was made.
    AsMeasured(&'a dyn Observation),
}

/// A trial as all hypotheses predict it at their best values.
pub(super) struct Outline<'a> {
    /// Scans, by pass.
    scans: Vec<PlannedScan<'a>>,
    /// Factor on whitened data: more scans have less noise.
    scale: f64,
    /// Whitened data, by hypothesis.
    pub(super) data: Vec<DVector<f64>>,
}

/// Heights of the pixels [m], or doses minus the exposure threshold, by pass.
type Surfaces = Vec<Vec<f64>>;

impl<'a> Predictor<'a> {
    /// # Errors
    /// If the last trial cannot be simulated with a hypothesis.
    pub(super) fn new(
        evidence: &'a ScanEvidence<'a>,
        hypotheses: &[Hypothesis],
        spread: f64,
    ) -> Result<Self, EvidenceError> {
        let own = evidence.simulation.trials()[TEMPLATE].part.voxel;
        let tiles = tiles(evidence);
        let voxel = if tiles.is_some() { NEXT_TRIAL_VOXEL_RATIO * own } else { own };
        let last = last_group(evidence, voxel)?;
        let simulated = |hypothesis: &Hypothesis| {
            let (models, ways) = hypothesis.models();
            let worn = models.par_iter().map(|model| worn(&last, model)).collect::<Result<_, EvidenceError>>()?;
            Ok(Simulated { models, ways, worn, has_rows: hypothesis.has_rows() })
        };
        let hypotheses = hypotheses.iter().map(simulated).collect::<Result<_, EvidenceError>>()?;
        Ok(Self { evidence, hypotheses, spread, tiles, voxel })
    }

    /// Predicts the trial with all hypotheses at their best values.
    ///
    /// # Errors
    /// If a hypothesis cannot be simulated on the trial.
    pub(super) fn outline(&self, design: &Design) -> Result<Outline<'_>, EvidenceError> {
        let rows = self.evidence.simulation.rows().passes;
        if design.passes().count() > rows && self.hypotheses.iter().any(|one| one.has_rows) {
            return Err(EvidenceError::NoData("more passes than the model has parameters for".to_owned()));
        }
        let stages = self.prepared(design)?;
        let best = |one: &Simulated| self.surfaces(&stages, &one.models[0], &one.worn[0]);
        let best: Vec<Surfaces> = self.hypotheses.par_iter().map(best).collect::<Result<_, _>>()?;
        let scans = self.scans(&stages, &best)?;
        let scale = (design.scans as f64).sqrt() / self.spread;
        let outline = Outline { scans, scale, data: Vec::new() };
        Ok(Outline { data: best.iter().map(|surfaces| outline.whitened_scans(surfaces)).collect(), ..outline })
    }

    /// Adds derivatives to the same predictions.
    ///
    /// # Errors
    /// As [`Self::outline`].
    pub(super) fn predicted(&self, design: &Design, outline: &Outline) -> Result<Vec<Predicted>, EvidenceError> {
        let stages = self.prepared(design)?;
        let predicted = |(one, best): (&Simulated, &DVector<f64>)| {
            let moved = |(model, worn)| -> Result<DVector<f64>, EvidenceError> {
                Ok(outline.whitened_scans(&self.surfaces(&stages, model, worn)?))
            };
            let moved = one.models[1..].par_iter().zip(&one.worn[1..]).map(moved).collect::<Result<Vec<_>, _>>()?;
            Ok(Predicted { data: best.clone(), jacobian: one.jacobian(best, &moved) })
        };
        self.hypotheses.iter().zip(&outline.data).map(predicted).collect()
    }

    fn prepared<'t>(&self, design: &'t Design) -> Result<Vec<Simulation<'t>>, EvidenceError> {
        let stage = |stage| Simulation::new(stage, self.voxel, false).map_err(|error| failed(stage, error));
        design.stages.iter().map(stage).collect()
    }

    /// Simulates the surface after each pass of a trial with a model.
    fn surfaces(&self, stages: &[Simulation], model: &CompiledModel, worn: &States) -> Result<Surfaces, EvidenceError> {
        let (mut tool, mut row, mut part) = (worn.clone(), 0, None);
        let mut surfaces = Vec::new();
        for simulation in stages {
            let mut state = simulation.start(model, tool, row);
            state.part = part.take().unwrap_or(state.part);
            for _ in &simulation.trial.passes {
                let pass = simulation.run_pass(model, &mut state, &mut |_| {});
                surfaces.push(surface(pass.map_err(|error| failed(simulation.trial, error))?, model)?);
            }
            row += simulation.trial.passes.len();
            (tool, part) = (state.tool, Some(state.part));
        }
        Ok(surfaces)
    }

    /// Returns the observation model of the scan after each pass, from the surfaces predicted by the hypotheses.
    fn scans(&self, stages: &[Simulation], best: &[Surfaces]) -> Result<Vec<PlannedScan<'_>>, EvidenceError> {
        let views: Vec<&ScanView> = self.evidence.views.iter().filter(|view| view.trial == TEMPLATE).collect();
        let before = self.unground(&stages[0], &self.hypotheses[0].models[0])?;
        let scan = |pass: usize| {
            let data = views[pass.min(views.len() - 1)].data.as_ref();
            let Some(view) = data.as_heights() else { return Ok(PlannedScan::AsMeasured(data)) };
            let after: Vec<&[f64]> = best.iter().map(|surfaces| &surfaces[pass][..]).collect();
            let (tiles, whitener) = self.cut(view, &before, &after).ok_or_else(|| nothing(pass))?;
            Ok(PlannedScan::Cut(tiles, Box::new(whitener)))
        };
        (0..best[0].len()).map(scan).collect()
    }

    /// The scan before the first pass, as a simulation that removes nothing reproduces it.
    fn unground(&self, simulation: &Simulation, model: &CompiledModel) -> Result<Vec<f64>, EvidenceError> {
        let like = &simulation.trial.passes[0].scan;
        let seen = SeenSurface::of(&simulation.part, (pixels_of(simulation.trial), like), model, (1, 0));
        Ok(seen.reported(model)?.heights().map_or_else(Vec::new, |map| map.heights.clone()))
    }

    /// Tiles within the union of all hypotheses' cuts except rims, with the scan noise of the first hypothesis.
    fn cut(&self, view: &HeightView, before: &[f64], after: &[&[f64]]) -> Option<(Tiles, Whitener)> {
        let (side, noise) = self.tiles.as_ref()?;
        let pixels = view.measured.pixels;
        let is_cut = |at: usize| after.iter().any(|after| (before[at] - after[at]).abs() > CHANGED_HEIGHT);
        let cut: Vec<bool> = (0..pixels.len()).map(is_cut).collect();
        let is_inside = |at: usize| cut[at] && beside(pixels, at, *side).all(|beside| cut[beside]);
        let tiles = TileGrid { pixels, side: *side }.tiles(is_inside);
        let change = before.iter().zip(after[0]).map(|(before, after)| after - before).collect();
        let scan = HeightMap { pixels, heights: after[0].to_vec() };
        let whitener = view.whitener_of((&scan, &HeightMap { pixels, heights: change }), &tiles, noise)?;
        (!tiles.is_empty()).then_some((tiles, whitener))
    }
}

impl Outline<'_> {
    /// Returns the whitened data of the scans of predicted surfaces, pass by pass.
    fn whitened_scans(&self, surfaces: &Surfaces) -> DVector<f64> {
        let scan = |(planned, surface): (&PlannedScan, &Vec<f64>)| planned.data(surface);
        DVector::from_vec(self.scans.iter().zip(surfaces).flat_map(scan).collect()) * self.scale
    }
}

impl Simulated {
    /// Finite-difference derivatives, from the data at the best values and at each moved coordinate.
    fn jacobian(&self, best: &DVector<f64>, moved: &[DVector<f64>]) -> DMatrix<f64> {
        let slope = |row: usize, k: usize| {
            if self.ways[k] == 0.0 { 0.0 } else { (moved[k][row] - best[row]) / self.ways[k] }
        };
        DMatrix::from_fn(best.len(), moved.len(), slope)
    }
}

impl PlannedScan<'_> {
    /// Converts the surface after one pass to whitened data.
    fn data(&self, surface: &[f64]) -> Vec<f64> {
        match self {
            Self::Cut(tiles, whitener) => whitener.whitened_field(&tiles.means(|at| surface[at])),
            Self::AsMeasured(data) => data.whitened(surface),
        }
    }
}

/// Pixels one tile away from a pixel.
fn beside(pixels: PixelGrid, at: usize, side: usize) -> impl Iterator<Item = usize> {
    let (i, j, side) = ((at % pixels.nx) as i64, (at / pixels.nx) as i64, side as i64);
    let places = [(i - side, j), (i + side, j), (i, j - side), (i, j + side)];
    let is_on = move |(i, j): &(i64, i64)| (0..pixels.nx as i64).contains(i) && (0..pixels.ny as i64).contains(j);
    places.into_iter().filter(is_on).map(move |(i, j)| pixels.at(i as usize, j as usize))
}

fn pixels_of(trial: &Trial) -> PixelGrid {
    trial.scans.before.pixels
}

fn surface(pass: SimulatedPass, model: &CompiledModel) -> Result<Vec<f64>, EvidenceError> {
    let margin = pass.surface.dose_margin(model)?;
    let heights = || pass.scan.heights().map_or_else(Vec::new, |map| map.heights.clone());
    Ok(margin.unwrap_or_else(heights))
}

/// Tiles of ground scans: side such that the first trial's last scan has at most [`NEXT_TRIAL_TILES`], and the noise of
/// a tile's mean from the repeated scans of all trials.
fn tiles(evidence: &ScanEvidence) -> Option<(usize, TileNoise)> {
    let view = evidence.views.iter().rfind(|view| view.trial == TEMPLATE)?;
    let data = view.data.as_heights()?;
    let own = data.tiles.grid.side;
    let ratio = (data.tiles.len() as f64 / NEXT_TRIAL_TILES as f64).sqrt().max(1.0);
    let side = (own as f64 * ratio).ceil() as usize;
    let coarse = |map: &HeightMap| TileGrid { pixels: map.pixels, side }.coarsened(&map.heights);
    let maps: Vec<HeightMap> = evidence.noise.iter().map(|noise| coarse(&noise.without_gaps())).collect();
    match TileNoise::fitted(&maps).swap_remove(TEMPLATE) {
        Some(fitted) => Some((side, fitted.noise)),
        None => Some((own, data.noise)),
    }
}

/// The last trial, and those before it since the tool was fresh.
fn last_group<'t>(evidence: &'t ScanEvidence, voxel: f64) -> Result<Vec<(Simulation<'t>, usize)>, EvidenceError> {
    let all = evidence.simulation.trials();
    let start = all.iter().rposition(|own| own.trial.fresh).unwrap_or(0);
    let mut row = all[..start].iter().map(|own| own.trial.passes.len()).sum();
    let mut group = Vec::new();
    for own in &all[start..] {
        let simulation = own.again(voxel, &Variation::default()).map_err(|error| failed(own.trial, error))?;
        group.push((simulation, row));
        row += own.trial.passes.len();
    }
    Ok(group)
}

/// State of the tool after the trials.
fn worn(trials: &[(Simulation, usize)], model: &CompiledModel) -> Result<States, EvidenceError> {
    let mut tool = Simulation::fresh_states(model);
    for (simulation, row) in trials {
        let ran = simulation.run(model, &mut tool, *row, &mut |_, _| {});
        ran.map_err(|error| failed(simulation.trial, error))?;
    }
    Ok(tool)
}

fn failed(trial: &Trial, error: SimulationError) -> EvidenceError {
    CampaignError { trial: trial.name.clone(), error }.into()
}

fn nothing(pass: usize) -> EvidenceError {
    EvidenceError::NoData(format!("pass {} of this trial would remove nothing", pass + 1))
}
