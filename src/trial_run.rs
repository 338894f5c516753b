//! A simulated trial on disk: logs, scans, field and residuals. If a pass fails, the passes before it are kept.

use std::fs;
use std::path::Path;

use anyhow::Result;
use effects::CompiledModel;
use glam::DVec3;
use robot::Controller;
use sdf_bake::nvdb::{self, Codec};
use serde::Serialize;

use crate::console::Console;
use crate::finishing::{log_csv, model_facts};
use crate::pass_run::{PassRun, Passes};
use files::folder::StagedFolder;
use files::json_file::write_json;
use files::output::FolderKind;
use lab::covariate_maps;
use study::snapshot::STATE_NAMES;

use lab::{Origin, identity, model_origin};
use sim::{PassRecord, Progress};
use trial_simulation::{RunState, SimulatedPass, Simulation, exposed_share};
use trials::measure::{CLEARANCE, DegreesOfFreedom, despiked, noise_floor, register, untouched_in_passes};
use trials::trial::{HeldTool, PassScan, Trial};

/// Name of the result file.
pub const SIMULATION_FILE: &str = "simulation.json";
/// Other files of a simulated trial.
const SIMULATION_NAMES: &[&str] = &["after.nvdb", "pass*_log.csv", "pass*_after.csv", "pass*_exposed.csv"];
/// Kind of a simulated trial's folder.
pub const TRIAL_RUN: FolderKind = FolderKind {
    marker: SIMULATION_FILE,
    key: "trial",
    names: &[("", SIMULATION_NAMES), ("covariates/", &["pass*_*.csv"]), ("", STATE_NAMES)],
};
/// Value of its `format` key.
const SIMULATION_FORMAT: &str = "robofin-simulation/1";

/// The passes of a trial.
pub struct TrialPasses<'a> {
    /// The prepared trial.
    pub simulation: &'a Simulation<'a>,
    /// Model of the passes.
    pub model: &'a CompiledModel,
}

/// A completed pass of a trial.
pub struct TrialPass {
    /// The simulated pass.
    pub simulated: SimulatedPass,
    /// Root mean square of measured minus simulated heights [m]; see [`residual`].
    pub residual: Option<f64>,
    /// Measured share of the scanned area that is exposed; `None` for grinding.
    pub measured_share: Option<f64>,
}

/// A simulated trial.
pub type TrialRun = PassRun<TrialPass>;

/// `simulation.json`, and most of the answer of `simulate --json`.
#[derive(Clone, Debug, Serialize)]
pub struct TrialRunSummary {
    format: &'static str,
    version: &'static str,
    trial: String,
    voxel_mm: f64,
    model: std::collections::BTreeMap<String, String>,
    /// Volume removed by Eq. (1) in each pass [mm³].
    removed_by_law_mm3: Vec<f64>,
    /// Volume of coating removed by Eq. (2) in each pass [mm³].
    coating_mm3: Vec<f64>,
    /// Exposed share of the scanned area after each pass, simulated and measured; empty for grinding.
    exposed_share: Vec<f64>,
    measured_exposed_share: Vec<f64>,
    /// Root mean square of force minus setpoint in contact [N].
    force_rms_error_n: Vec<f64>,
    /// Impulse ∫ F dt of each pass [N s].
    impulse_ns: Vec<f64>,
    /// Root mean square of measured minus simulated heights after registration, of each scanned pass [µm]; empty for
    /// sanding.
    residual_rms_um: Vec<f64>,
    /// Noise of one scan, from the repeated scan [µm]; absent without one.
    #[serde(skip_serializing_if = "Option::is_none")]
    noise_floor_um: Option<f64>,
    /// Number of steps in all passes.
    steps: usize,
    /// Reason why the run ended before its last pass; absent if it did not.
    #[serde(skip_serializing_if = "Option::is_none")]
    stopped: Option<String>,
}

impl TrialPasses<'_> {
    fn pass(&self, simulated: SimulatedPass, number: usize) -> TrialPass {
        let trial = self.simulation.trial;
        let residual = residual(trial, &simulated, number - 1);
        let scan = Some(&trial.passes[number - 1].scan).filter(|scan| !scan.is_missing());
        let measured_share = scan.and_then(PassScan::mask).map(exposed_share);
        TrialPass { simulated, residual, measured_share }
    }
}

impl Passes for TrialPasses<'_> {
    type Pass = TrialPass;

    fn count(&self) -> usize {
        self.simulation.trial.passes.len()
    }

    fn model(&self) -> &CompiledModel {
        self.model
    }

    fn start(&self) -> RunState {
        self.simulation.start(self.model, Simulation::fresh_states(self.model), 0)
    }

    fn run(&self, state: &mut RunState, progress: &mut dyn FnMut(Progress)) -> Result<TrialPass> {
        Ok(self.pass(self.simulation.run_pass(self.model, state, progress)?, state.passes))
    }

    fn read_back(&self, _: &RunState, after: &RunState, record: PassRecord) -> Result<TrialPass> {
        Ok(self.pass(self.simulation.scanned(self.model, after, record)?, after.passes))
    }

    fn record<'p>(&self, pass: &'p TrialPass) -> &'p PassRecord {
        &pass.simulated.record
    }

    fn describe(&self, TrialPass { simulated, residual, measured_share }: &TrialPass) -> String {
        let record = &simulated.record;
        let mut text = match simulated.exposed_share {
            Some(share) => format!(
                "{:.1} % exposed, {:.1} % measured; {:.2} mm³ of coating",
                share * 100.0,
                measured_share.unwrap_or(f64::NAN) * 100.0,
                record.coating_volume * 1e9
            ),
            None => format!("{:.2} mm³ removed", record.removed_volume * 1e9),
        };
        if let Some(residual) = residual {
            text += &format!("; {:.2} µm rms off the scan", residual * 1e6);
        }
        text
    }

    fn origin(&self, passes: usize) -> Origin {
        origin(self.simulation, self.model, passes)
    }
}

impl TrialRun {
    /// Returns the results of the run; they do not depend on the machine.
    pub fn summary(&self, trial: &Trial, model: &CompiledModel) -> TrialRunSummary {
        let each = |figure: fn(&PassRecord) -> f64| {
            self.passes.iter().map(|pass| figure(&pass.simulated.record)).collect::<Vec<f64>>()
        };
        let clean = |map| despiked(map).0;
        let noise = trial.scans.repeats.first().and_then(|repeat| {
            let (before, repeat) = rayon::join(|| clean(&trial.scans.before), || clean(repeat));
            noise_floor(&before, &repeat).ok()
        });
        TrialRunSummary {
            format: SIMULATION_FORMAT,
            version: env!("CARGO_PKG_VERSION"),
            trial: trial.name.clone(),
            voxel_mm: self.state.part.voxel * 1e3,
            model: model_facts(model).into_iter().collect(),
            removed_by_law_mm3: each(|record| record.removed_volume * 1e9),
            coating_mm3: each(|record| record.coating_volume * 1e9),
            exposed_share: self.passes.iter().filter_map(|pass| pass.simulated.exposed_share).collect(),
            measured_exposed_share: self.passes.iter().filter_map(|pass| pass.measured_share).collect(),
            force_rms_error_n: each(|record| record.force_rms_error),
            impulse_ns: each(|record| record.impulse),
            residual_rms_um: self.passes.iter().filter_map(|pass| pass.residual).map(|r| r * 1e6).collect(),
            noise_floor_um: noise.map(|noise| noise.rms * 1e6),
            steps: self.passes.iter().map(|pass| pass.simulated.record.steps).sum(),
            stopped: self.stopped.as_ref().map(ToString::to_string),
        }
    }

    /// Writes logs and scans in the trial's format, the field and the results.
    ///
    /// # Errors
    /// If a file cannot be written.
    pub fn write(
        &self,
        summary: &TrialRunSummary,
        trial: &Trial,
        staged: StagedFolder,
        console: &Console,
    ) -> Result<()> {
        let place = |name: &str| staged.path().join(name);
        for (i, TrialPass { simulated: pass, .. }) in self.passes.iter().enumerate() {
            if let Some(covariates) = &pass.covariates {
                let folder = place("covariates");
                fs::create_dir_all(&folder)?;
                covariate_maps::write(&folder, i + 1, covariates, &trial.scans.before.pixels)?;
            }
            fs::write(place(&format!("pass{}_log.csv", i + 1)), log_csv(&pass.record))?;
            fs::write(place(&format!("pass{}_{}.csv", i + 1, pass.scan.file_word())), pass.scan.csv())?;
        }
        fs::write(place("after.nvdb"), nvdb::write_field(&self.state.part, Codec::Zip)?)?;
        write_json(&place(SIMULATION_FILE), summary)?;
        staged.commit()?;
        console.step("written", "logs, scans, field and figures");
        Ok(())
    }

    /// Reports noise and speed on the console.
    pub fn describe(&self, summary: &TrialRunSummary, console: &Console) {
        if let Some(noise) = summary.noise_floor_um {
            console.step("noise", format!("{noise:.2} µm rms in one scan"));
        }
        console.step("speed", format!("{:.0} times real time", self.real_time_factor()));
    }
}

/// Returns the root mean square of measured minus simulated heights after a pass [m], registered where no pass so far
/// touched the part; `None` for exposure masks, for a pass without a scan, and if too little is untouched.
///
/// - `pass`: its number, from 0
pub fn residual(trial: &Trial, simulated: &SimulatedPass, pass: usize) -> Option<f64> {
    let (measured, simulated) = (trial.passes[pass].scan.heights()?, simulated.scan.heights()?);
    let (measured, _) = despiked(measured);
    let free = untouched_in_passes(&trial.scans.before, &trial.passes[..=pass], &trial.tool, CLEARANCE);
    let laid = register(&measured, simulated, DegreesOfFreedom::All, |at| free[at]).ok()?;
    let left: Vec<f64> = laid.left(&measured, simulated).into_iter().filter(|left| left.is_finite()).collect();
    Some((left.iter().map(|left| left * left).sum::<f64>() / left.len().max(1) as f64).sqrt())
}

/// Collects all inputs that the state after `passes` passes of a trial depends on.
fn origin(simulation: &Simulation, model: &CompiledModel, passes: usize) -> Origin {
    let trial = simulation.trial;
    let mut origin = model_origin(model);
    let mut add = |name: String, value: String| origin.insert(name, value);
    add("trial".into(), trial.name.clone());
    add("tool".into(), identity(&(ToolForm::of(&trial.tool), trial.fresh)));
    add("controller".into(), identity(&ControllerForm::of(trial.controller)));
    add("replay".into(), simulation.replay.to_string());
    add("coating".into(), identity(&trial.coating));
    add("voxel".into(), format!("{:?} m", simulation.part.voxel));
    add("scan before".into(), identity(&trial.scans.before));
    add("material map".into(), identity(&trial.scans.material));
    for (i, pass) in trial.passes[..passes].iter().enumerate() {
        add(format!("log of pass {}", i + 1), identity(&pass.log));
        add(format!("force setpoint of pass {}", i + 1), format!("{:?} N", pass.force_setpoint));
        add(format!("spindle speed of pass {}", i + 1), format!("{:?} rad/s", pass.spindle_speed));
    }
    origin
}

/// A tool as identified in snapshots.
#[derive(Serialize)]
enum ToolForm {
    Wheel { radius: f64, width: f64, axis: DVec3 },
    Pad { radius: f64 },
}

impl ToolForm {
    fn of(HeldTool { shape, axis }: &HeldTool) -> Self {
        let radius = shape.rim_radius();
        match axis {
            Some(axis) => Self::Wheel { radius, width: shape.width(), axis: *axis },
            None => Self::Pad { radius },
        }
    }
}

/// A controller as identified in snapshots.
#[derive(Serialize)]
enum ControllerForm {
    Admittance { mass: f64, damping: f64, period: f64 },
    Ideal,
}

impl ControllerForm {
    /// Returns `None` for a replay.
    fn of(controller: Controller) -> Option<Self> {
        match controller {
            Controller::Admittance { mass, damping, period } => Some(Self::Admittance { mass, damping, period }),
            Controller::Ideal => Some(Self::Ideal),
            Controller::Replay => None,
        }
    }
}

/// Returns true if a folder is a trial.
pub fn is_trial(folder: &Path) -> bool {
    folder.join(trials::trial::TRIAL_FILE).is_file()
}
