//! A rehearsed trial on disk: logs and scans in the trial's own form, the field, and how far it is from the measurement.

use std::fs;
use std::path::Path;
use std::time::Instant;

use anyhow::Result;
use sdf_bake::BrickGrid;
use sdf_bake::nvdb::{self, Codec, GridRef};
use serde::Serialize;
use sim::effect::CompiledModel;

use crate::asset::write_json;
use crate::console::Console;
use crate::finishing::{log_csv, model_facts};
use crate::folder::StagedFolder;
use crate::measure::{Freedom, despiked, noise_floor, register, untouched};
use crate::trial::{PassScan, ToolPath, Trial, exposure_csv, heights_csv};
use crate::twin::{SimulatedPass, Twin, exposed_share};

/// Name of the result file.
pub const REHEARSAL_FILE: &str = "simulation.json";
/// Value of its `format` key.
const REHEARSAL_FORMAT: &str = "robofin-simulation/1";
/// Pixels nearer to the tool than this count as touched when scans are laid on each other [m].
const CLEARANCE: f64 = 0.1e-3;

/// A simulated trial.
pub struct Rehearsal {
    passes: Vec<SimulatedPass>,
    part: BrickGrid,
    /// Time simulated over time taken.
    pub real_time_factor: f64,
}

/// `simulation.json`, and most of the answer of `simulate --json`.
#[derive(Clone, Debug, Serialize)]
pub struct RehearsalSummary {
    format: &'static str,
    version: &'static str,
    trial: String,
    voxel_mm: f64,
    model: std::collections::BTreeMap<String, String>,
    /// Volume that Eq. (1) removes in each pass [mm³].
    removed_mm3: Vec<f64>,
    /// Volume of coating that Eq. (2) takes off in each pass [mm³].
    coating_mm3: Vec<f64>,
    /// Share of the scanned area that is exposed after each pass, simulated and measured; empty when grinding.
    exposed_share: Vec<f64>,
    measured_exposed_share: Vec<f64>,
    /// Root mean square of force minus setpoint in contact [N].
    force_rms_error_n: Vec<f64>,
    /// ∫ F dt of each pass [N s].
    impulse_ns: Vec<f64>,
    /// Measured minus simulated heights after laying the scans on the untouched area [µm rms]; empty when sanding.
    residual_rms_um: Vec<f64>,
    /// Noise of one scan, from the repeated scan [µm]; absent without one.
    #[serde(skip_serializing_if = "Option::is_none")]
    noise_floor_um: Option<f64>,
    /// Steps of all passes.
    steps: usize,
}

impl Rehearsal {
    /// Simulates a trial with a fresh tool.
    ///
    /// # Errors
    /// When a pass fails.
    pub fn run(twin: &Twin, model: &CompiledModel, console: &Console) -> Result<Self> {
        let started = Instant::now();
        let mut states = Twin::fresh_states(model);
        let bar = console.bar(&twin.trial.name, 100 * twin.trial.passes.len() as u64);
        let (passes, part) = twin.run(model, &mut states, 0, &mut |pass, at| {
            bar.set_position(100 * pass as u64 + (100.0 * at.time / at.duration) as u64);
        })?;
        bar.finish_and_clear();
        Ok(Self { passes, part, real_time_factor: twin.duration() / started.elapsed().as_secs_f64() })
    }

    /// The figures of the run; they do not depend on the machine.
    pub fn summary(&self, trial: &Trial, model: &CompiledModel) -> RehearsalSummary {
        let each = |figure: fn(&SimulatedPass) -> f64| self.passes.iter().map(figure).collect();
        let clean = |map| despiked(map).0;
        let repeat = trial.scans.repeats.first().map(clean);
        let noise = repeat.and_then(|repeat| noise_floor(&clean(&trial.scans.before), &repeat).ok());
        let measured = trial.passes.iter().filter_map(|pass| match &pass.scan {
            PassScan::Exposure(mask) => Some(exposed_share(mask)),
            PassScan::Heights(_) => None,
        });
        RehearsalSummary {
            format: REHEARSAL_FORMAT,
            version: env!("CARGO_PKG_VERSION"),
            trial: trial.name.clone(),
            voxel_mm: self.part.voxel * 1e3,
            model: model_facts(model).into_iter().collect(),
            removed_mm3: each(|pass| pass.record.removed_volume * 1e9),
            coating_mm3: each(|pass| pass.record.coating_volume * 1e9),
            exposed_share: self.passes.iter().filter_map(|pass| pass.exposed_share).collect(),
            measured_exposed_share: measured.collect(),
            force_rms_error_n: each(|pass| pass.record.force_rms_error),
            impulse_ns: each(|pass| pass.record.impulse),
            residual_rms_um: (0..self.passes.len()).filter_map(|pass| self.residual(trial, pass)).map(|r| r * 1e6).collect(),
            noise_floor_um: noise.map(|noise| noise.rms * 1e6),
            steps: self.passes.iter().map(|pass| pass.record.steps).sum(),
        }
    }

    /// Root mean square of measured minus simulated heights after a pass [m], the scans laid on each other where no
    /// pass so far touched the part; `None` for exposure masks and where too little is untouched.
    pub fn residual(&self, trial: &Trial, pass: usize) -> Option<f64> {
        let (PassScan::Heights(measured), PassScan::Heights(simulated)) =
            (&trial.passes[pass].scan, &self.passes[pass].scan)
        else {
            return None;
        };
        let (measured, _) = despiked(measured);
        let mut free = vec![true; measured.heights.len()];
        for before in &trial.passes[..=pass] {
            let path = ToolPath::of(&before.log, &trial.tool, before.force_setpoint);
            let alone = untouched(&trial.scans.before, &path, &trial.tool, CLEARANCE);
            free.iter_mut().zip(alone).for_each(|(free, alone)| *free &= alone);
        }
        let laid = register(&measured, simulated, Freedom::PlaneAndShift, |at| free[at]).ok()?;
        let left: Vec<f64> = laid.left(&measured, simulated).into_iter().filter(|left| left.is_finite()).collect();
        Some((left.iter().map(|left| left * left).sum::<f64>() / left.len().max(1) as f64).sqrt())
    }

    /// Writes logs and scans in the trial's form, the field and the figures.
    ///
    /// # Errors
    /// When a file cannot be written.
    pub fn write(&self, summary: &RehearsalSummary, staged: StagedFolder, console: &Console) -> Result<()> {
        let place = |name: &str| staged.path().join(name);
        for (i, pass) in self.passes.iter().enumerate() {
            fs::write(place(&format!("pass{}_log.csv", i + 1)), log_csv(&pass.record.log))?;
            let (name, text) = match &pass.scan {
                PassScan::Heights(map) => ("after", heights_csv(map)),
                PassScan::Exposure(mask) => ("exposed", exposure_csv(mask)),
            };
            fs::write(place(&format!("pass{}_{name}.csv", i + 1)), text)?;
        }
        let mut grids = vec![GridRef::LevelSet { name: "phi", grid: &self.part }];
        if !self.part.dose.is_empty() {
            grids.push(GridRef::Density { name: "dose", grid: &self.part, values: &self.part.dose });
        }
        fs::write(place("after.nvdb"), nvdb::write(&grids, Codec::Zip)?)?;
        write_json(&place(REHEARSAL_FILE), summary)?;
        staged.commit()?;
        console.step("written", "logs, scans, field and figures");
        Ok(())
    }

    /// The figures of each pass, for people.
    pub fn describe(&self, summary: &RehearsalSummary, console: &Console) {
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

/// Whether a folder is a trial.
pub fn is_trial(folder: &Path) -> bool {
    folder.join(crate::trial::TRIAL_FILE).is_file()
}
