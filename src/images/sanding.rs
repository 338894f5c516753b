//! Simulates sanding of a workpiece along a pattern, stage by stage, and stores the dose fields.
//!
//! Pressure, spindle speed and feed are chosen so that one straight stroke of the pad leaves a dose D of 1.6 on its
//! centre line. With a pad of radius R under the mean pressure p, ∫ p ω r dt along the centre line is p ω R² / v, so
//! Eq. (2) gives the feed v = (K_P/h_c) p ω R² / D.

use std::path::{Path, PathBuf};

use anyhow::{Context, Result, ensure};
use effects::{CompiledModel, Library, Model, RowCounts, States};
use files::input::{self, MOST_MESH_BYTES};
use glam::DVec3;
use robot::{Pad, Tool};
use sdf_bake::BrickGrid;
use sdf_bake::channels::Scalar;
use sdf_bake::nvdb::{self, Codec, GridRef};
use serde::{Deserialize, Serialize};
use sim::{Pass, PassSettings, PathSample, TOOL_CELLS, run_pass};

use super::plan::PlannedSanding;
use super::{FIELDS_FOLDER, ImageSet};
use crate::asset::{FileRecord, write_json};
use crate::store::remove;
use files::folder::StagedFolder;
use files::json_file::read_json;
use files::sha256;
use paths::{PadPatch, Pattern, Stroke};

/// Name of the record in a simulation's folder.
pub const SANDING_FILE: &str = "sanding.json";

/// Dose on the centre line of one straight stroke.
const LINE_DOSE: f64 = 1.6;
/// Mean pressure under the pad [Pa].
const PRESSURE: f64 = 14e3;
/// Spindle speed [rad/s]: 3000 rpm.
const SPINDLE: f64 = 100.0 * std::f64::consts::PI;
/// Text of the model: the base laws of sanding.
const MODEL: &str = "process = \"sanding\"\n";

/// Record of a simulated sanding path: settings and results.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct SandingRecord {
    /// Name.
    pub id: String,
    /// SHA-256 of the workpiece's file.
    pub workpiece_sha256: String,
    /// Radius of the pad [mm].
    pub pad_radius_mm: f64,
    /// Force on the pad [N].
    pub force_n: f64,
    /// Feed along the path [mm/s].
    pub feed_mm_s: f64,
    /// Speed of the spindle [rpm].
    pub spindle_rpm: f64,
    /// Records of the stages.
    pub stages: Vec<StageRecord>,
}

/// Record of one stage.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct StageRecord {
    /// Results of the stage.
    #[serde(flatten)]
    pub figures: StageFigures,
    /// File of the dose after it.
    pub file: FileRecord,
}

/// Results of one stage.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct StageFigures {
    /// Time in contact [s].
    pub contact_s: f64,
    /// Impulse ∫ F dt [N s].
    pub impulse_ns: f64,
    /// Volume of coating removed in this stage [mm³].
    pub coating_mm3: f64,
}

/// Simulates the stages of a path on a workpiece; `done` gets the part after each stage.
///
/// # Errors
/// If no region is large enough for the pad, a pass fails, or `done` fails.
pub fn sand(
    part: &mut BrickGrid,
    (pattern, stages): (Pattern, u32),
    mut done: impl FnMut(&BrickGrid, StageFigures) -> Result<()>,
) -> Result<Setting> {
    let patch = PadPatch::find(part)?;
    let library = Library::builtin();
    let model = CompiledModel::new(&Model::parse("sanding", MODEL, library)?, library, RowCounts::default())?;
    let setting = Setting::of(patch.radius, &model)?;
    let tool = Tool::from(Pad { radius: patch.radius });
    let settings = PassSettings { force_setpoint: setting.force, spindle_speed: SPINDLE, ..PassSettings::default() };
    let mut states = States::new(&model, TOOL_CELLS);
    for strokes in pattern.stages(&patch, stages) {
        let mut figures = StageFigures::default();
        for stroke in &strokes {
            let path = path(stroke, &patch, setting.feed)?;
            let pass = run_pass(part, Pass::first(&tool, &path, &settings, &model), &mut states, &mut |_| {})?;
            figures.contact_s += pass.contact_time;
            figures.impulse_ns += pass.impulse;
            figures.coating_mm3 += 1e9 * pass.coating_volume;
        }
        done(part, figures)?;
    }
    Ok(setting)
}

/// Settings of the sanding.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Setting {
    /// Radius of the pad [m].
    pub radius: f64,
    /// Normal force [N].
    pub force: f64,
    /// Feed along the path [m/s].
    pub feed: f64,
}

impl Setting {
    fn of(radius: f64, model: &CompiledModel) -> Result<Self> {
        let rate = model.law_value("sanding_rate").context("the base law of sanding has no sanding_rate")?;
        let feed = rate * PRESSURE * SPINDLE * radius * radius / LINE_DOSE;
        Ok(Self { radius, force: PRESSURE * std::f64::consts::PI * radius * radius, feed })
    }
}

/// Makes a stroke at constant feed, with the pad flat on the surface.
fn path(stroke: &Stroke, patch: &PadPatch, feed: f64) -> Result<sim::Path> {
    let mut time = 0.0;
    let mut before = None;
    let samples = stroke.iter().map(|&at| {
        let rest = patch.rest(at);
        time += before.map_or(0.0, |before: DVec3| before.distance(rest.contact)) / feed;
        before = Some(rest.contact);
        let axis = DVec3::Y.reject_from_normalized(rest.approach).normalize();
        PathSample { time, position: rest.contact, approach: rest.approach, axis }
    });
    Ok(sim::Path::from_samples(samples.collect())?)
}

impl ImageSet {
    pub(super) fn sanding_folder(&self, id: &str) -> PathBuf {
        self.folder().join(FIELDS_FOLDER).join(id)
    }

    /// Reads the record of a simulation.
    ///
    /// # Errors
    /// If it is missing or damaged.
    pub fn read_sanding(&self, id: &str) -> Result<SandingRecord> {
        let path = self.sanding_folder(id).join(SANDING_FILE);
        Ok(read_json(&path, "the record of a simulation")?)
    }

    /// Returns true if a simulation is complete, with all its files at their lengths.
    pub fn holds_sanding(&self, id: &str) -> bool {
        let folder = self.sanding_folder(id);
        let has_length = |(stage, record): (usize, &StageRecord)| {
            std::fs::metadata(folder.join(stage_file(stage + 1))).is_ok_and(|file| file.len() == record.file.bytes)
        };
        self.read_sanding(id).is_ok_and(|record| {
            record.stages.len() == self.recipe.stages as usize && record.stages.iter().enumerate().all(has_length)
        })
    }

    /// Simulates a path and stores the doses; the folder is complete or does not exist.
    ///
    /// # Errors
    /// Those of [`sand`], and if a file cannot be read or written.
    pub fn make_sanding(&self, planned: &PlannedSanding) -> Result<()> {
        let (mut part, workpiece_sha256) = self.read_workpiece(&self.recipe.workpieces[planned.workpiece].name)?;
        let folder = self.sanding_folder(&planned.id);
        remove(&folder)?;
        let staged = StagedFolder::fresh(&folder)?;
        let mut stages = Vec::new();
        let setting = sand(&mut part, (planned.pattern, self.recipe.stages), |part, figures| {
            let bytes = nvdb::write(&[dose_of(part)], Codec::Zip)?;
            let file = FileRecord::of_bytes(&bytes);
            stages.push(StageRecord { figures, file });
            write(&staged.path().join(stage_file(stages.len())), &bytes)
        })?;
        let record = SandingRecord {
            id: planned.id.clone(),
            workpiece_sha256,
            pad_radius_mm: 1e3 * setting.radius,
            force_n: setting.force,
            feed_mm_s: 1e3 * setting.feed,
            spindle_rpm: SPINDLE * 60.0 / std::f64::consts::TAU,
            stages,
        };
        write_json(&staged.path().join(SANDING_FILE), &record)?;
        staged.commit()?;
        Ok(())
    }

    /// Attaches the dose after a stage to a workpiece, and returns the hash of its file.
    ///
    /// # Errors
    /// If it is missing, damaged, or belongs to another workpiece.
    pub fn attach_dose(&self, part: &mut BrickGrid, sanding: &str, stage: u32) -> Result<String> {
        let path = self.sanding_folder(sanding).join(stage_file(stage as usize));
        let context = || format!("{}: no dose of this workpiece", path.display());
        let bytes = input::read(&path, MOST_MESH_BYTES)?;
        let file = nvdb::read(&bytes).with_context(context)?;
        let dose = file.grid(Scalar::Dose.name()).with_context(context)?;
        dose.attach_scalar(Scalar::Dose, part).with_context(context)?;
        ensure!(part.dose.iter().all(|dose| *dose >= 0.0), "{}: a dose below zero", path.display());
        Ok(sha256(&bytes))
    }
}

/// Returns the file name of the dose after a stage, from 1.
pub fn stage_file(stage: usize) -> String {
    format!("stage-{stage}.nvdb")
}

fn dose_of(part: &BrickGrid) -> GridRef<'_> {
    GridRef::Density { name: Scalar::Dose.name(), grid: part, values: &part.dose }
}

fn write(path: &Path, bytes: &[u8]) -> Result<()> {
    std::fs::write(path, bytes).with_context(|| format!("{}: cannot write this file", path.display()))
}

#[cfg(test)]
mod tests {
    use glam::DVec2;

    use super::*;
    use crate::images::workpiece::Coated;

    #[test]
    fn a_line_leaves_its_dose_in_the_middle_and_none_beside_the_pad() {
        let mut panel = Coated::named("panel", 1.0).unwrap().field(1).unwrap();
        let phi = panel.phi.clone();
        let patch = PadPatch::find(&panel).unwrap();
        let mut last = 0.0;
        let setting = sand(&mut panel, (Pattern::AlongX, 5), |part, figures| {
            let dose: f64 = part.dose.iter().map(|&dose| f64::from(dose)).sum();
            assert!(dose > last && figures.coating_mm3 > 0.0, "{figures:?}");
            last = dose;
            Ok(())
        });
        let setting = setting.unwrap();
        assert!(panel.phi == phi, "sanding moved the surface");
        let line = patch.rest(DVec2::new(0.5 * (patch.low.x + patch.high.x), patch.low.y));
        let dose = f64::from(panel.sample_dose(line.contact));
        // Neighbouring strokes overlap here, so the dose of one stroke is the least.
        assert!(dose > 0.9 * LINE_DOSE && dose < 2.0 * LINE_DOSE, "{dose}, {setting:?}");
        let beside = patch.rest(patch.low).contact - DVec3::new(1.2 * patch.radius, 0.0, 0.0);
        assert_eq!(panel.sample_dose(beside), 0.0);
    }
}
