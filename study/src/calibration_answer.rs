//! What `calibrate` answers: its numbers for machines, and the report of them.

use std::path::PathBuf;

use effects::Library;
use lab::{Calibration, CalibrationSummary, Result};
use serde::Serialize;
use trials::trial::Finding;

use super::calibrated::{CalibrationReport, calibration_report};
use super::measurements::Data;
use crate::StudyReport;

/// The file by which the folder of a calibration is known.
pub const CALIBRATION_FILE: &str = "calibration.json";

/// The answer of `calibrate --json`, and [`CALIBRATION_FILE`].
#[derive(Serialize)]
pub struct CalibrationAnswer {
    /// File of the fitted model.
    pub model: PathBuf,
    /// What the reader understood of the files where it was not the plain case.
    pub notes: Vec<String>,
    /// What the checks of scans and logs against each other found.
    pub findings: Vec<Finding>,
    /// The numbers.
    #[serde(flatten)]
    pub summary: CalibrationSummary,
}

impl CalibrationAnswer {
    /// Sums up a calibration; the instrument's blur stays at what its model finds.
    ///
    /// # Errors
    /// When a model cannot be simulated, or an input file not be read again for its hash.
    pub fn new(
        data: &mut Data,
        calibration: &Calibration,
        library: &Library,
        model: PathBuf,
    ) -> Result<(Self, StudyReport)> {
        let summary = CalibrationSummary::new(data.evidence(), calibration, library)?;
        data.fix_observation(&calibration.last().fit.model)?;
        let answer = Self { model, notes: data.notes(), findings: data.findings(), summary };
        let report = calibration_report(&CalibrationReport {
            data,
            calibration,
            summary: &answer.summary,
            waterfall: &answer.summary.waterfall,
            rival: None,
            verdict: None,
            sentence: answer.sentence(),
            seed: 0,
            answer: serde_json::to_value(&answer)?,
        })?;
        Ok((answer, report))
    }

    /// How far the whole model is from the noise floor.
    fn sentence(&self) -> String {
        let unit = self.summary.error_unit.symbol();
        let last = self.summary.waterfall.last().map_or(0.0, |step| step.calibration_rms_um);
        let floor = self.summary.noise_floor_um;
        format!(
            "Calibrated: {last:.2} {unit} are left, {:.2} times the noise floor of {floor:.2} {unit}.",
            last / floor
        )
    }
}
