//! The scans of a campaign as data, and their prediction with the simulations of its trials.

use std::ops::Range;

use effects::{CompiledModel, Effect, Library, Model, Process, RowCounts};
use rayon::prelude::*;
use sdf_bake::HeightMap;

use super::blur::{blurred, least_of};
use super::calibrate::fit_roughly;
use super::calibration::{Calibration, Order};
use super::coordinates::Coordinate;
use super::diagnose::with_values;
use super::error::LabError;
use super::evidence::{Agreement, Evidence, EvidenceError, Split};
use super::exposure_view::ExposureView;
use super::fit::robust_sum;
use super::height_view::COARSE;
use super::height_view::HeightView;
use super::lattice_error::LatticeError;
use super::pass_trend::{PassTrend, trend_of_scans};
use super::tile_noise::{FittedNoise, TileNoise};
use super::tiles::{TileGrid, Tiles};
use crate::campaign_simulation::CampaignSimulation;
use crate::criteria::{
    BLUR_WIDEST, BORDER_REACH, COATING_ERROR_RATIO, SANDING_VOXEL_PIXELS, SANDING_VOXELS_ACROSS,
    SIMULATION_LEAST_STEPS, SIMULATION_STEP_RATIO, TILE_BLOCK_SIDE, TILE_LEAST_SIDE, TILES_PER_SCAN,
};
use crate::simulation::SimulatedPass;
use files::journal::Journal;
use trials::measure::{CLEARANCE, NoiseFloor, despiked, noise_floor, untouched};
use trials::trial::{PassScan, Role, TRIAL_FILE, ToolPath, Trial, least_gap};

/// Values of the blur tried at first, and a change that counts as none [pixels].
const BLUR_STEPS: usize = 6;
const SETTLED_BLUR: f64 = 3e-4;

/// One scan and where it belongs.
pub struct ScanView {
    /// Trial and pass, from 0.
    pub trial: usize,
    /// Pass of it.
    pub pass: usize,
    /// Whether fits may see it.
    pub split: Split,
    /// The scan as data.
    pub data: ScanData,
}

/// What a scan shows.
pub enum ScanData {
    /// A ground surface.
    Heights(HeightView),
    /// Where sanding went through the coating.
    Exposure(ExposureView),
}

impl ScanData {
    /// The tiles that the tool may have touched.
    pub fn tiles(&self) -> &Tiles {
        match self {
            Self::Heights(view) => &view.tiles,
            Self::Exposure(view) => &view.tiles,
        }
    }

    /// The change of the tiles [m] behind a change of the whitened ones, without what the scan's degrees of freedom take up of it.
    fn unwhitened(&self, change: &[f64]) -> Vec<f64> {
        match self {
            Self::Heights(view) => view.unwhitened(change),
            Self::Exposure(view) => view.unwhitened(change),
        }
    }
}

/// All scans of a campaign.
pub struct ScanEvidence<'a> {
    /// The trials, ready to be simulated.
    pub simulation: CampaignSimulation<'a>,
    /// Scans in order of time.
    pub views: Vec<ScanView>,
    /// Noise of one scan by trial.
    pub noise: Vec<NoiseFloor>,
    /// Noise of one scan's tiles by trial, where surfaces are ground.
    pub tile_noise: Vec<Option<FittedNoise>>,
    /// Standard deviation of the instrument's lateral blur [m]; `None` where every model finds its own.
    pub blur: Option<f64>,
    /// Steps of a pass beyond which a simulation is given up.
    pub(super) most_steps: Option<usize>,
    /// What the simulation's lattice errs by, once it was measured.
    pub lattice_error: Option<LatticeError>,
    /// Predictions that were made before; `None` makes each again.
    pub journal: Option<Journal>,
}

impl<'a> ScanEvidence<'a> {
    /// Prepares all scans.
    ///
    /// - `voxel`: of the simulation [m]; `None` takes the scan's pitch when grinding and up to four times that when sanding,
    ///   where the surface stays and the pressure under a pad is smooth
    ///
    /// # Errors
    /// When a trial makes no part, or has no scan that can be used.
    pub fn new(trials: &'a [Trial], voxel: Option<f64>) -> Result<Self, EvidenceError> {
        let sands = trials.iter().all(|trial| trial.process == trials::trial::Process::Sanding);
        let pitch = |trial: &Trial| trial.scans.before.pixels.pitch;
        let coarse = || {
            let across = trials[0].tool.half_width() / SANDING_VOXELS_ACROSS;
            across.clamp(pitch(&trials[0]), SANDING_VOXEL_PIXELS * pitch(&trials[0]))
        };
        let simulation = CampaignSimulation::new(trials, voxel.or_else(|| sands.then(coarse)), false)?;
        let prepared: Result<Vec<_>, _> = trials.par_iter().enumerate().map(views_of).collect();
        let (mut views, mut noise, mut tile_noise) = (Vec::new(), Vec::new(), Vec::new());
        for prepared in prepared? {
            views.extend(prepared.views);
            noise.push(prepared.floor);
            tile_noise.push(prepared.tile_noise);
        }
        Ok(Self {
            simulation,
            views,
            noise,
            tile_noise,
            blur: None,
            most_steps: None,
            lattice_error: None,
            journal: None,
        })
    }

    /// The scans of a split.
    pub fn of(&self, split: Split) -> impl Iterator<Item = &ScanView> {
        self.views.iter().filter(move |view| view.split == split)
    }

    /// Passes of each trial that must be simulated to predict a split.
    fn needed(&self, split: Split) -> Vec<usize> {
        let trials = &self.simulation.trials;
        let mut needed = vec![0; trials.len()];
        for view in self.of(split) {
            needed[view.trial] = needed[view.trial].max(view.pass + 1);
        }
        for k in (1..trials.len()).rev() {
            if needed[k] > 0 && !trials[k].trial.fresh {
                needed[k - 1] = trials[k - 1].trial.passes.len();
            }
        }
        needed
    }

    /// Simulates what a split needs, and what the instrument's blur is found from.
    ///
    /// # Errors
    /// The first trial that fails.
    pub fn simulate(&self, model: &CompiledModel, split: Split) -> Result<Vec<Vec<SimulatedPass>>, EvidenceError> {
        let blur = if self.blur.is_none() { self.needed(Split::Calibration) } else { Vec::new() };
        let needed = self.needed(split).into_iter().enumerate().map(|(k, own)| own.max(*blur.get(k).unwrap_or(&0)));
        Ok(self.simulation.run_first(model, &needed.collect::<Vec<_>>())?)
    }

    /// A simulated surface as an instrument with this blur [m] sees it.
    pub fn seen(&self, view: &ScanView, simulated: &HeightMap, blur: f64) -> HeightMap {
        blurred(simulated, &self.simulation.trials[view.trial].trial.scans.before, blur)
    }

    /// Measures what the simulation's lattice errs by near a model. From then on it counts as an error of the
    /// data. Sanding leaves the surface as it was, and has none.
    ///
    /// # Errors
    /// When the model cannot be simulated on a lattice twice as fine.
    pub fn measure_lattice_error(&mut self, model: &CompiledModel) -> Result<(), EvidenceError> {
        if self.process() == Process::Sanding {
            return Ok(());
        }
        let error = LatticeError::new(self, model)?;
        for view in &mut self.views {
            let ScanData::Heights(data) = &view.data else { continue };
            let informed = data.clone().with_lattice_error(error.of(view.trial, view.pass));
            view.data = ScanData::Heights(informed.expect("a covariance grows with what is added to it"));
        }
        self.lattice_error = Some(error);
        Ok(())
    }

    /// Calibrates a model and those that it grew from: first roughly, then with what the lattice errs by there.
    ///
    /// - `models`: the model, and its base law before any fit
    /// - `done`: called after each fit with its name
    ///
    /// # Errors
    /// As [`Calibration::new`].
    pub fn calibrated(
        &mut self,
        (model, start): (&Model, &Model),
        library: &Library,
        (order, done): (Order, &dyn Fn(&str)),
    ) -> Result<Calibration, LabError> {
        let compiled = CompiledModel::new(model, library, self.rows())?;
        self.limit_steps(&compiled)?;
        if self.process() == Process::Sanding {
            return Calibration::new(self, (model, start), library, (order, done));
        }
        let rough = fit_roughly(self, &compiled)?;
        self.measure_lattice_error(&rough.model)?;
        // A fit that is far off says little about where the next should begin.
        let from = if rough.is_poor() { model.clone() } else { with_values(model, &rough) };
        let calibration = Calibration::new(self, (&from, start), library, (order, done))?;
        self.renewed(calibration)
    }

    /// A calibration taken further, with what the lattice errs by at its best values.
    ///
    /// # Errors
    /// When the model cannot be simulated.
    pub fn renewed(&mut self, calibration: Calibration) -> Result<Calibration, LabError> {
        if self.process() == Process::Sanding {
            return Ok(calibration);
        }
        self.measure_lattice_error(&calibration.last().fit.model)?;
        calibration.renewed(self)
    }

    /// Measured minus simulated tiles of a scan, whitened, through an instrument of so much blur.
    fn whitened(
        &self,
        view: &ScanView,
        (passes, model): (&[Vec<SimulatedPass>], &CompiledModel),
        blur: f64,
    ) -> Result<Vec<f64>, EvidenceError> {
        let pass = &passes[view.trial][view.pass];
        Ok(match (&view.data, &pass.scan) {
            (ScanData::Heights(data), PassScan::Heights(simulated)) => data.whitened(&self.seen(view, simulated, blur)),
            (ScanData::Exposure(data), _) => match pass.surface.dose_margin(model)? {
                Some(margin) => data.whitened(&margin),
                None => unreachable!("a sanded surface has doses"),
            },
            (ScanData::Heights(_), PassScan::Exposure(_)) => unreachable!("a simulated scan is like the real one"),
        })
    }

    /// Simulates a model once, and gives up every later simulation that takes far longer.
    ///
    /// # Errors
    /// When the model cannot be simulated.
    pub fn limit_steps(&mut self, model: &CompiledModel) -> Result<(), EvidenceError> {
        let passes = self.simulate(model, Split::Calibration)?;
        let most = passes.iter().flatten().map(|pass| pass.record.steps).max().unwrap_or(0);
        let most_steps = Some(SIMULATION_STEP_RATIO * most.max(SIMULATION_LEAST_STEPS));
        for simulation in &mut self.simulation.trials {
            simulation.change_process(|process| process.most_steps = most_steps);
        }
        self.most_steps = most_steps;
        Ok(())
    }

    /// Keeps the blur at what this model finds.
    ///
    /// # Errors
    /// When the model cannot be simulated.
    pub fn fix_blur(&mut self, model: &CompiledModel) -> Result<(), EvidenceError> {
        self.blur = None;
        let passes = self.simulate(model, Split::Calibration)?;
        self.blur = Some(self.blur_of(&passes, model)?);
        Ok(())
    }

    /// The instrument's blur [m]: the one with which the simulated rims of what the tool cut are like those of the
    /// calibration scans. It is found anew with every model, for a stiff contact and a sharp instrument leave like rims.
    ///
    /// # Errors
    /// When a formula of the scanner gives no finite number.
    pub fn blur_of(&self, passes: &[Vec<SimulatedPass>], model: &CompiledModel) -> Result<f64, EvidenceError> {
        if let Some(blur) = self.blur {
            return Ok(blur);
        }
        if self.process() == Process::Sanding {
            return Ok(0.0);
        }
        let pitch = self.simulation.trials[0].trial.scans.before.pixels.pitch;
        let scans: Vec<&ScanView> = self.of(Split::Calibration).collect();
        let cost = |blur: f64| -> Result<f64, EvidenceError> {
            let one = |view: &&ScanView| Ok(robust_sum(&self.whitened(view, (passes, model), blur)?));
            let costs: Result<Vec<f64>, EvidenceError> = scans.par_iter().map(one).collect();
            Ok(costs?.iter().sum())
        };
        least_of(cost, ([0.0, BLUR_WIDEST * pitch], BLUR_STEPS), SETTLED_BLUR * pitch)
    }

    fn agreement_made(&self, model: &CompiledModel, split: Split) -> Result<Vec<Agreement>, EvidenceError> {
        let passes = self.simulate(model, split)?;
        let blur = self.blur_of(&passes, model)?;
        let agreement = |view: &ScanView| {
            let pass = &passes[view.trial][view.pass];
            let about = format!("{} pass {}", self.simulation.trials[view.trial].trial.name, view.pass + 1);
            Ok(match (&view.data, &pass.scan, pass.surface.dose_margin(model)?) {
                (ScanData::Heights(data), PassScan::Heights(simulated), _) => {
                    let before = &self.simulation.trials[view.trial].trial.scans.before;
                    let [rms, floor, scale] =
                        data.agreement(&self.seen(view, simulated, blur), before, self.noise[view.trial].rms);
                    Agreement { about, rms, floor, noise: floor, scale }
                }
                (ScanData::Exposure(data), _, Some(margin)) => {
                    let (rms, floor) = (data.border_distance(&margin), data.border_floor());
                    let scale = COATING_ERROR_RATIO * data.border_width(&margin);
                    Agreement { about, rms, floor, noise: data.border_noise(), scale }
                }
                _ => unreachable!("a simulated scan is like the real one"),
            })
        };
        self.of(split).map(agreement).collect()
    }

    /// Ranges of the residuals of each scan of a split.
    pub fn ranges(&self, split: Split) -> Vec<Range<usize>> {
        let mut start = 0;
        let range = |view: &ScanView| {
            let range = start..start + view.data.tiles().len();
            start = range.end;
            range
        };
        self.of(split).map(range).collect()
    }
}

impl Evidence for ScanEvidence<'_> {
    fn process(&self) -> Process {
        match self.simulation.trials[0].trial.process {
            trials::trial::Process::Grinding => Process::Grinding,
            trials::trial::Process::Sanding => Process::Sanding,
        }
    }

    fn rows(&self) -> RowCounts {
        self.simulation.rows()
    }

    fn residuals(&self, model: &CompiledModel, split: Split) -> Result<Vec<f64>, EvidenceError> {
        self.remembered((model, split), || {
            let passes = self.simulate(model, split)?;
            let blur = self.blur_of(&passes, model)?;
            let scans = self.of(split).map(|view| self.whitened(view, (&passes, model), blur));
            Ok(scans.collect::<Result<Vec<_>, _>>()?.concat())
        })
    }

    fn agreement(&self, model: &CompiledModel, split: Split) -> Result<Vec<Agreement>, EvidenceError> {
        self.remembered((model, split), || self.agreement_made(model, split))
    }

    fn coordinates(&self, model: &CompiledModel) -> Vec<Coordinate> {
        let trials = self.simulation.trials.iter().zip(self.needed(Split::Calibration));
        let passes =
            trials.flat_map(|(simulation, needed)| (0..simulation.trial.passes.len()).map(move |pass| pass < needed));
        let seen: Vec<bool> = passes.collect();
        Coordinate::of(model, |slot| slot.row.is_none_or(|row| seen[row]))
    }

    fn size(&self, change: &[f64]) -> f64 {
        let views = self.of(Split::Calibration).zip(self.ranges(Split::Calibration));
        let squares = views.flat_map(|(view, range)| view.data.unwhitened(&change[range])).map(|left| left * left);
        (squares.sum::<f64>() / change.len().max(1) as f64).sqrt()
    }

    fn trend(&self, model: &CompiledModel) -> Result<Option<PassTrend>, EvidenceError> {
        trend_of_scans(self, model)
    }

    fn is_blind_to(&self, effect: &Effect) -> Option<String> {
        let why = match effect.name.as_str() {
            "scan-tilt" | "scan-shift" => "every fit leaves each scan's pose free",
            "lateral-blur" => "every fit finds the instrument's blur",
            _ => return None,
        };
        Some(why.to_owned())
    }

    fn lattice_fields(&self) -> Vec<(usize, Vec<f64>)> {
        let starts = self.ranges(Split::Calibration).into_iter().map(|range| range.start);
        let field = |(start, view): (usize, &ScanView)| match &view.data {
            ScanData::Heights(data) => Some((start, data.lattice_field())),
            ScanData::Exposure(_) => None,
        };
        starts.zip(self.of(Split::Calibration)).filter_map(field).collect()
    }

    fn blocks(&self, split: Split) -> Vec<usize> {
        let mut first = 0;
        let mut all = Vec::new();
        for view in self.of(split) {
            let (nx, ny) = view.data.tiles().grid.shape();
            let along = nx.div_ceil(TILE_BLOCK_SIDE);
            let block = |cell: &usize| first + cell / nx / TILE_BLOCK_SIDE * along + cell % nx / TILE_BLOCK_SIDE;
            all.extend(view.data.tiles().cells.iter().map(block));
            first += along * ny.div_ceil(TILE_BLOCK_SIDE);
        }
        all
    }
}

/// The scans of a trial as data, and the noise of one.
struct Prepared {
    views: Vec<ScanView>,
    floor: NoiseFloor,
    tile_noise: Option<FittedNoise>,
}

fn views_of((index, trial): (usize, &Trial)) -> Result<Prepared, EvidenceError> {
    let bad = |what: String| EvidenceError::NoData(format!("{}: {what}", trial.name));
    let (before, _) = despiked(&trial.scans.before);
    let repeat = trial.scans.repeats.first().ok_or_else(|| EvidenceError::NoData(no_repeat(trial)))?;
    let (repeat, _) = despiked(repeat);
    let floor = noise_floor(&before, &repeat).map_err(|error| bad(format!("the repeated scan: {error}")))?;
    let left = HeightMap { heights: floor.registration.left(&repeat, &before), ..before.clone() };
    let mut free = vec![true; before.heights.len()];
    let (mut views, mut tile_noise) = (Vec::new(), None);
    for (number, pass) in trial.passes.iter().enumerate() {
        let path = ToolPath::of(&pass.log, &trial.tool, pass.force_setpoint);
        let alone = untouched(&trial.scans.before, &path, &trial.tool, CLEARANCE);
        free.iter_mut().zip(alone).for_each(|(free, alone)| *free &= alone);
        let side = tile_side(&free, &before);
        let data = match &pass.scan {
            PassScan::Heights(scan) => {
                let [noise, coarse] = [side, COARSE * side].map(|side| noise_of_tiles(&left, side).map_err(&bad));
                let (noise, coarse) = (noise?, coarse?.noise);
                let view = HeightView::new(despiked(scan).0, &before, &free, (side, [noise.noise, coarse]));
                tile_noise = Some(noise);
                view.map(ScanData::Heights)
            }
            PassScan::Exposure(mask) => {
                let reach = BORDER_REACH * trial.tool.half_width();
                ExposureView::new(mask.clone(), &free, side, reach).map(ScanData::Exposure)
            }
        };
        let split = match pass.role {
            Role::Calibration => Split::Calibration,
            Role::Evaluation => Split::Evaluation,
        };
        let data = data.ok_or_else(|| bad(format!("pass {}: {}", number + 1, untouched_words(trial, &path))))?;
        views.push(ScanView { trial: index, pass: number, split, data });
    }
    Ok(Prepared { views, floor, tile_noise })
}

/// Why a trial without a repeated scan is no data, and what to do.
fn no_repeat(trial: &Trial) -> String {
    format!(
        "{}: [scan] has no repeat, and without a second scan of the surface before the first pass the noise is unknown: add \
         repeat = [\"before_repeat.csv\"]; only `simulate` needs none",
        trial.folder.join(TRIAL_FILE).display()
    )
}

/// Why a pass shows nothing.
fn untouched_words(trial: &Trial, path: &ToolPath) -> String {
    let clearance = 1e3 * CLEARANCE;
    match least_gap(&trial.tool, path, &trial.scans.before) {
        Some(gap) if gap > CLEARANCE => format!(
            "by its log the tool stays {:.2} mm or more above the scan `before`, and {clearance} mm count as contact: is the \
             zero of z_mm off, or radius_mm?",
            1e3 * gap
        ),
        Some(_) => {
            "the tool touched no part of the surface that all scans show: are too many pixels missing there?".into()
        }
        None => "by its log the tool never was over the scan `before`: is origin_mm off?".into(),
    }
}

/// Smallest tile with which the touched area does not have too many.
fn tile_side(free: &[bool], map: &HeightMap) -> usize {
    let touched = free.iter().filter(|free| !**free).count() as f64;
    ((touched / TILES_PER_SCAN as f64).sqrt().ceil() as usize)
        .clamp(TILE_LEAST_SIDE, map.pixels.nx.min(map.pixels.ny) / 4)
}

/// Noise of the means of tiles of a side, from what is left of two scans of one surface after laying one on the other.
fn noise_of_tiles(left: &HeightMap, side: usize) -> Result<FittedNoise, String> {
    let coarse = TileGrid { pixels: left.pixels, side }.coarsened(&left.heights);
    TileNoise::fitted(&coarse).ok_or_else(|| {
        let (nx, ny) = (coarse.pixels.nx, coarse.pixels.ny);
        format!(
            "the repeated scan shares too few pixels with the scan before: {nx} by {ny} tiles with holes give no noise"
        )
    })
}
