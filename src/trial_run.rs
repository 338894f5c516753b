//! A simulated trial on disk: logs, scans, field and residuals. If a pass fails, the passes before it are kept.

use std::fs;
use std::path::Path;
use std::time::Instant;

use anyhow::Result;
use effects::CompiledModel;
use glam::DVec3;
use robot::Controller;
use sdf_bake::nvdb::{self, Codec};
use serde::Serialize;

use crate::console::Console;
use crate::finishing::{log_csv, model_facts};
use files::folder::StagedFolder;
use files::json_file::write_json;
use files::output::FolderKind;
use lab::covariate_maps;
use study::snapshot::{self, Keeping, Resume, STATE_NAMES, Snapshot};

use lab::{Origin, identity, model_origin};
use trial_simulation::{SimulatedPass, Simulation, SimulationError, TrialState, exposed_share};
use trials::measure::{CLEARANCE, DegreesOfFreedom, despiked, noise_floor, register, untouched};
use trials::trial::{HeldTool, ToolPath, Trial};

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

/// A simulated trial.
pub struct TrialRun {
    passes: Vec<SimulatedPass>,
    state: TrialState,
    /// Reason why it ended before its last pass.
    pub stopped: Option<SimulationError>,
    /// Simulated time over computing time.
    pub real_time_factor: f64,
}

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
    /// Root mean square of measured minus simulated heights after registration [µm]; empty for sanding.
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

impl TrialRun {
    /// Simulates a trial with a fresh tool, or its remaining passes after an earlier state.
    ///
    /// - `folder`: folder of the states that `keeping` requests
    ///
    /// # Errors
    /// If a state cannot be read or written, or is of another run. A failed pass is in [`TrialRun::stopped`].
    pub fn run(
        simulation: &Simulation,
        model: &CompiledModel,
        (keeping, folder): (&Keeping, &Path),
        console: &Console,
    ) -> Result<Self> {
        let state = simulation.start(model, Simulation::fresh_states(model), 0);
        let mut trial_run = Self { passes: Vec::new(), state, stopped: None, real_time_factor: 0.0 };
        if let Some(resume) = &keeping.resume {
            trial_run.put_back(simulation, model, resume)?;
            console.step("resumed", format!("after pass {} of {}", resume.passes, resume.folder.display()));
        }
        let first = trial_run.passes.len();
        keeping.copy_earlier(folder)?;
        let started = Instant::now();
        for pass in first..simulation.trial.passes.len() {
            let bar = console.bar(&format!("pass {}", pass + 1), 100);
            let mut show = |at: sim::Progress| bar.set_position((100.0 * at.time / at.duration) as u64);
            let ran = simulation.run_pass(model, &mut trial_run.state, &mut show);
            bar.finish_and_clear();
            match ran {
                Ok(ran) => trial_run.passes.push(ran),
                Err(error) => {
                    trial_run.stopped = Some(error);
                    break;
                }
            }
            if keeping.snapshots {
                trial_run.keep(simulation, model, folder)?;
            }
        }
        trial_run.real_time_factor = simulation.duration(first) / started.elapsed().as_secs_f64();
        Ok(trial_run)
    }

    /// Reads all passes up to a state of an earlier run.
    fn put_back(&mut self, simulation: &Simulation, model: &CompiledModel, resume: &Resume) -> Result<()> {
        for pass in 1..=resume.passes {
            let Snapshot { part, tool, trial_time, record } =
                snapshot::read(&resume.folder, pass, model, &origin(simulation, model, pass))?;
            self.state = TrialState { part, tool, passes: pass, trial_time, first_row: self.state.first_row };
            self.passes.push(simulation.scanned(model, &self.state, record)?);
        }
        Ok(())
    }

    /// Writes the state after the last pass.
    fn keep(&self, simulation: &Simulation, model: &CompiledModel, folder: &Path) -> Result<()> {
        let TrialState { part, tool, passes, trial_time, .. } = self.state.clone();
        let record = self.passes[passes - 1].record.clone();
        let state = Snapshot { part, tool, trial_time, record };
        Ok(snapshot::write(folder, passes, &state, origin(simulation, model, passes))?)
    }

    /// Returns the number of passes done.
    pub fn done(&self) -> usize {
        self.passes.len()
    }

    /// Returns the results of the run; they do not depend on the machine.
    pub fn summary(&self, trial: &Trial, model: &CompiledModel) -> TrialRunSummary {
        let each = |figure: fn(&SimulatedPass) -> f64| self.passes.iter().map(figure).collect();
        let clean = |map| despiked(map).0;
        let repeat = trial.scans.repeats.first().map(clean);
        let noise = repeat.and_then(|repeat| noise_floor(&clean(&trial.scans.before), &repeat).ok());
        let measured = trial.passes.iter().filter_map(|pass| pass.scan.mask().map(exposed_share));
        TrialRunSummary {
            format: SIMULATION_FORMAT,
            version: env!("CARGO_PKG_VERSION"),
            trial: trial.name.clone(),
            voxel_mm: self.state.part.voxel * 1e3,
            model: model_facts(model).into_iter().collect(),
            removed_by_law_mm3: each(|pass| pass.record.removed_volume * 1e9),
            coating_mm3: each(|pass| pass.record.coating_volume * 1e9),
            exposed_share: self.passes.iter().filter_map(|pass| pass.exposed_share).collect(),
            measured_exposed_share: measured.collect(),
            force_rms_error_n: each(|pass| pass.record.force_rms_error),
            impulse_ns: each(|pass| pass.record.impulse),
            residual_rms_um: (0..self.passes.len())
                .filter_map(|pass| residual(trial, &self.passes, pass))
                .map(|r| r * 1e6)
                .collect(),
            noise_floor_um: noise.map(|noise| noise.rms * 1e6),
            steps: self.passes.iter().map(|pass| pass.record.steps).sum(),
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
        for (i, pass) in self.passes.iter().enumerate() {
            if let Some(covariates) = &pass.covariates {
                let folder = place("covariates");
                fs::create_dir_all(&folder)?;
                covariate_maps::write(&folder, i + 1, covariates, &trial.scans.before.pixels)?;
            }
            fs::write(place(&format!("pass{}_log.csv", i + 1)), log_csv(&pass.record.log))?;
            fs::write(place(&format!("pass{}_{}.csv", i + 1, pass.scan.file_word())), pass.scan.csv())?;
        }
        fs::write(place("after.nvdb"), nvdb::write_field(&self.state.part, Codec::Zip)?)?;
        write_json(&place(SIMULATION_FILE), summary)?;
        staged.commit()?;
        console.step("written", "logs, scans, field and figures");
        Ok(())
    }

    /// Reports the results of each pass on the console.
    pub fn describe(&self, summary: &TrialRunSummary, console: &Console) {
        for (i, pass) in self.passes.iter().enumerate() {
            let mut text = match pass.exposed_share {
                Some(share) => format!(
                    "{:.1} % exposed, {:.1} % measured; {:.2} mm³ of coating",
                    share * 100.0,
                    summary.measured_exposed_share.get(i).unwrap_or(&f64::NAN) * 100.0,
                    pass.record.coating_volume * 1e9
                ),
                None => format!("{:.2} mm³ removed", pass.record.removed_volume * 1e9),
            };
            if let Some(residual) = summary.residual_rms_um.get(i) {
                text += &format!("; {residual:.2} µm rms off the scan");
            }
            console.step(&format!("pass {}", i + 1), text);
        }
        if let Some(noise) = summary.noise_floor_um {
            console.step("noise", format!("{noise:.2} µm rms in one scan"));
        }
        console.step("speed", format!("{:.0} times real time", self.real_time_factor));
    }
}

/// Returns the root mean square of measured minus simulated heights after a pass [m], registered where no pass so far
/// touched the part; `None` for exposure masks, and if too little is untouched.
pub fn residual(trial: &Trial, simulated: &[SimulatedPass], pass: usize) -> Option<f64> {
    let (measured, simulated) = (trial.passes[pass].scan.heights()?, simulated[pass].scan.heights()?);
    let (measured, _) = despiked(measured);
    let mut free = vec![true; measured.heights.len()];
    for before in &trial.passes[..=pass] {
        let path = ToolPath::of(&before.log, &trial.tool, before.force_setpoint);
        let alone = untouched(&trial.scans.before, &path, &trial.tool, CLEARANCE);
        free.iter_mut().zip(alone).for_each(|(free, alone)| *free &= alone);
    }
    let laid = register(&measured, simulated, DegreesOfFreedom::PlaneAndShift, |at| free[at]).ok()?;
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
