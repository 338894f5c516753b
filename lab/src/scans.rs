//! The scans of a campaign as data, and their prediction with the simulations of its trials.

use std::ops::Range;

use effects::{CompiledModel, Effect, Library, Model, Process, RowCounts, Signal};
use nalgebra::DMatrix;

use super::coarse_scans::CoarseLattice;
use super::coordinates::Coordinate;
use super::evidence::{Agreement, Evidence, EvidenceError, Split};
use super::fit::Fit;
use super::frame::{FrameEstimate, FrameFreedom};
use super::mask_errors::MaskErrors;
use super::nuisances::Nuisances;
use super::observation::{Observation, Untouched};
use super::pass_trend::{PassTrend, trend_of_scans};
use super::prepared::Prepared;
use super::repredicted::Repredicted;
use super::simulation_errors::SimulationErrors;
use super::structure::ResidualGrid;
use super::tile_noise::FittedNoise;
use super::totals::Totals;
use super::unlisted::{Basis, Exposures};
use crate::criteria::{SANDING_VOXEL_PIXELS, SANDING_VOXELS_ACROSS, TILE_BLOCK_SIDE};
use files::journal::Journal;
use trial_simulation::CampaignSimulation;
use trial_simulation::lacking;
use trial_simulation::{SimulatedPass, Simulation};
use trials::measure::ScanNoise;
use trials::trial::Trial;

/// One scan with its trial and pass.
pub struct ScanView {
    /// Index of the trial.
    pub trial: usize,
    /// Index of the pass in the trial.
    pub pass: usize,
    /// The split that it belongs to.
    pub split: Split,
    /// The scan as data.
    pub data: Box<dyn Observation>,
}

/// All scans of a campaign.
pub struct ScanEvidence<'a> {
    /// The trials, prepared for simulation.
    pub simulation: CampaignSimulation<'a>,
    /// Scans in order of time.
    pub views: Vec<ScanView>,
    /// Noise of one scan by trial, with its source.
    pub noise: Vec<ScanNoise>,
    /// Noise of one scan's tiles by trial, where surfaces are ground.
    pub tile_noise: Vec<Option<FittedNoise>>,
    /// Nuisance parameters of predictions; `None` if each model determines its own.
    pub nuisances: Option<Nuisances>,
    /// The same trials on a coarser lattice, once the step limit is known; `None` if the tool is too small for it.
    pub(super) coarse: Option<CampaignSimulation<'a>>,
    /// Number of steps of a pass beyond which a simulation is abandoned.
    pub(super) most_steps: Option<usize>,
    /// Errors of the simulation, once measured.
    pub simulation_errors: Option<SimulationErrors>,
    /// Lattice error of masks, once measured.
    pub mask_errors: Option<MaskErrors>,
    /// Frame and clock, if the logs were moved and the response of the scans to them is known.
    pub frame: Option<FrameFreedom>,
    /// Journal of earlier predictions; `None` computes each again.
    pub journal: Option<Journal>,
}

impl<'a> ScanEvidence<'a> {
    /// Prepares all scans.
    ///
    /// - `voxel`: voxel of the simulation [m]; `None` takes the scan's pitch when grinding and up to four times that
    ///   when sanding, where the surface stays and the pressure under a pad is smooth
    ///
    /// # Errors
    /// If a trial makes no part, or has no scan that can be used.
    pub fn new(trials: &'a [Trial], voxel: Option<f64>) -> Result<Self, EvidenceError> {
        let sands = trials.iter().all(|trial| trial.process.signal() == Signal::Dose);
        let pitch = |trial: &Trial| trial.scans.before.pixels.pitch;
        let coarse = || {
            let across = trials[0].tool.half_width() / SANDING_VOXELS_ACROSS;
            across.clamp(pitch(&trials[0]), SANDING_VOXEL_PIXELS * pitch(&trials[0]))
        };
        let simulation = CampaignSimulation::new(trials, voxel.or_else(|| sands.then(coarse)), false)?;
        let Prepared { views, noise, tile_noise } = Prepared::new(trials)?;
        Ok(Self {
            simulation,
            views,
            noise,
            tile_noise,
            nuisances: None,
            coarse: None,
            most_steps: None,
            simulation_errors: None,
            mask_errors: None,
            frame: None,
            journal: None,
        })
    }

    /// Sources of the noise of trials without a repeated scan, one sentence each.
    pub fn noise_notes(&self) -> Vec<String> {
        let trials = self.simulation.trials().iter().zip(&self.noise);
        let words = |(simulation, noise): (&Simulation, &ScanNoise)| {
            Some(format!("{}: {}", simulation.trial.name, noise.source.words()?))
        };
        trials.filter_map(words).collect()
    }

    /// The scans of a split.
    pub fn of(&self, split: Split) -> impl Iterator<Item = &ScanView> {
        self.views.iter().filter(move |view| view.split == split)
    }

    /// Whitened differences of the repeated scans from which the noise of a split's scans was estimated.
    pub fn repeats(&self, split: Split) -> Vec<ResidualGrid> {
        let of_split = |trial: &usize| self.of(split).any(|view| view.trial == *trial);
        let fitted = (0..self.tile_noise.len()).filter(of_split).filter_map(|trial| self.tile_noise[trial].as_ref());
        fitted.flat_map(|fitted| fitted.whitened.iter().cloned()).collect()
    }

    /// Number of passes of each trial that must be simulated to predict a split.
    pub(super) fn needed(&self, split: Split) -> Vec<usize> {
        let trials = self.simulation.trials();
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

    /// Simulates the passes that a split needs, and those that determine the nuisance parameters.
    ///
    /// # Errors
    /// For the first trial that fails.
    pub fn simulate(&self, model: &CompiledModel, split: Split) -> Result<Vec<Vec<SimulatedPass>>, EvidenceError> {
        let nuisances = if self.nuisances.is_none() { self.needed(Split::Calibration) } else { Vec::new() };
        let needed =
            self.needed(split).into_iter().enumerate().map(|(k, own)| own.max(*nuisances.get(k).unwrap_or(&0)));
        Ok(self.simulation.run_first(model, &needed.collect::<Vec<_>>())?)
    }

    fn agreement_made(&self, model: &CompiledModel, split: Split) -> Result<Vec<Agreement>, EvidenceError> {
        let passes = self.simulate(model, split)?;
        let nuisances = self.nuisances_of((&passes, model))?;
        let agreement = |view: &ScanView| {
            let about = format!("{} pass {}", self.simulation.trials()[view.trial].trial.name, view.pass + 1);
            let predicted = self.predicted(view, (&passes, model), nuisances)?;
            Ok(Agreement { about, ..view.data.agreement(&predicted, self.untouched(view)) })
        };
        self.of(split).map(agreement).collect()
    }

    /// Scan of a view's workpiece before its first pass.
    pub fn untouched(&self, view: &ScanView) -> Untouched<'_> {
        let heights = &self.simulation.trials()[view.trial].trial.scans.before;
        Untouched { heights, noise: self.noise[view.trial].floor.rms }
    }

    /// Message on a column that an effect reads and the files lack.
    fn lacks_column(&self, effect: &Effect) -> Option<String> {
        let trials = self.simulation.trials().iter().map(|simulation| simulation.trial);
        let mut lacking = trials.filter_map(|trial| Some((trial, lacking(trial, effect)?)));
        let (trial, (state, _)) = lacking.next()?;
        Some(format!("reads column {}, which {} does not give in each row and in its unit", state.name, trial.name))
    }

    /// Index ranges of the residuals of each scan of a split.
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
        self.simulation.trials()[0].trial.process
    }

    fn rows(&self) -> RowCounts {
        self.simulation.rows()
    }

    fn residuals(&self, model: &CompiledModel, split: Split) -> Result<Vec<f64>, EvidenceError> {
        self.remembered((model, split, 1.0), || self.scan_residuals((&self.simulate(model, split)?, model), split))
    }

    fn agreement(&self, model: &CompiledModel, split: Split) -> Result<Vec<Agreement>, EvidenceError> {
        self.remembered((model, split, 1.0), || self.agreement_made(model, split))
    }

    fn quicker(&self) -> Option<Box<dyn Totals + '_>> {
        let simulation = self.coarse.as_ref()?;
        Some(Box::new(Repredicted { data: self, prediction: CoarseLattice { usual: self, simulation } }))
    }

    fn coordinates(&self, model: &CompiledModel) -> Vec<Coordinate> {
        let trials = self.simulation.trials().iter().zip(self.needed(Split::Calibration));
        let passes =
            trials.flat_map(|(simulation, needed)| (0..simulation.trial.passes.len()).map(move |pass| pass < needed));
        let seen: Vec<bool> = passes.collect();
        Coordinate::of(model, |slot| slot.row.is_none_or(|row| seen[row]))
    }

    fn size(&self, change: &[f64]) -> f64 {
        let views = self.of(Split::Calibration).zip(self.ranges(Split::Calibration));
        let squares =
            views.flat_map(|(view, range)| view.data.whitener().unwhiten(&change[range])).map(|left| left * left);
        (squares.sum::<f64>() / change.len().max(1) as f64).sqrt()
    }

    fn trend(&self, model: &CompiledModel) -> Result<Option<PassTrend>, EvidenceError> {
        trend_of_scans(self, model)
    }

    fn is_blind_to(&self, effect: &Effect) -> Option<String> {
        let known = self.simulation.trials()[0].trial.frame_errors;
        let is_free = |sigma: f64| self.frame.is_some() && sigma > 0.0;
        let why = match effect.name.as_str() {
            "scan-tilt" | "scan-shift" => "every fit leaves each scan's pose free",
            "lateral-blur" => "every fit finds the instrument's blur",
            "path-offset" if is_free(known.shift) => {
                "every fit leaves the robot's frame free, and says where it is off"
            }
            "clock-offset" if is_free(known.lag) => "every fit leaves the robot's clock free, and says where it is off",
            _ => return self.lacks_column(effect),
        };
        Some(why.to_owned())
    }

    fn frame(&self, fit: &Fit) -> Result<Option<FrameEstimate>, EvidenceError> {
        self.frame_estimate(fit)
    }

    fn lattice_field(&self) -> Vec<f64> {
        self.lattice_field_of(Split::Calibration)
    }

    fn folds(&self) -> Vec<usize> {
        self.stretches()
    }

    fn pass_folds(&self) -> Vec<usize> {
        let ranges = self.ranges(Split::Calibration);
        if ranges.len() < 2 {
            return self.folds();
        }
        ranges.into_iter().enumerate().flat_map(|(pass, range)| range.map(move |_| pass)).collect()
    }

    fn closure(&self) -> DMatrix<f64> {
        self.closure_columns()
    }

    fn smooth_errors(&self, model: &CompiledModel) -> Result<DMatrix<f64>, EvidenceError> {
        self.smooth_error_columns(model)
    }

    fn bases(&self, model: (&Model, &Fit), library: &Library) -> Result<Vec<Basis>, EvidenceError> {
        match Exposures::new(self, model, library)? {
            Some(exposures) => Basis::all(self, &exposures),
            None => Ok(Vec::new()),
        }
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
