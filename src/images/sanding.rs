//! Stored doses of simulated sanding, stage by stage.

use std::path::{Path, PathBuf};

use anyhow::{Context, Result, ensure};
use files::input::{self, MOST_MESH_BYTES};
use perception::{SPINDLE, StageFigures, sand};
use sdf_bake::BrickGrid;
use sdf_bake::channels::Scalar;
use sdf_bake::nvdb::{self, Codec, GridRef};
use serde::{Deserialize, Serialize};

use super::plan::PlannedSanding;
use super::{FIELDS_FOLDER, ImageSet};
use crate::asset::{FileRecord, write_json};
use crate::store::remove;
use files::folder::StagedFolder;
use files::json_file::read_json;
use files::sha256;

/// Name of the record in a simulation's folder.
pub const SANDING_FILE: &str = "sanding.json";

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
