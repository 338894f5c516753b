//! Answer of `calibrate`: JSON summary and report.

use std::path::PathBuf;

use effects::Library;
use lab::{Calibration, CalibrationSummary, RemovalError, Result, WaterfallStep};
use serde::Serialize;
use trials::trial::Finding;

use super::calibrated::{CalibrationReport, calibration_report};
use super::measurements::Data;
use crate::StudyReport;

/// File that marks the folder of a calibration.
pub const CALIBRATION_FILE: &str = "calibration.json";

/// The answer of `calibrate --json`, and [`CALIBRATION_FILE`].
#[derive(Serialize)]
pub struct CalibrationAnswer {
    /// File of the fitted model.
    pub model: PathBuf,
    /// Notes on ambiguous input files and how they were interpreted.
    pub notes: Vec<String>,
    /// Findings of the consistency checks between scans and logs.
    pub findings: Vec<Finding>,
    /// Summary of the calibration.
    #[serde(flatten)]
    pub summary: CalibrationSummary,
}

impl CalibrationAnswer {
    /// Summarises a calibration; the instrument's blur stays at the value of its model.
    ///
    /// # Errors
    /// If a model cannot be simulated, or an input file cannot be read again for its hash.
    pub fn new(
        data: &mut Data,
        calibration: &Calibration,
        library: &Library,
        model: PathBuf,
    ) -> Result<(Self, StudyReport)> {
        let summary = CalibrationSummary::new(data.evidence(), calibration, library)?;
        data.fix_nuisances(&calibration.last().fit.model)?;
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

    /// Lines for the console, each with its label.
    pub fn described(&self) -> Vec<(&'static str, String)> {
        let summary = &self.summary;
        let error = |step: &WaterfallStep| ("error", step.shown(summary.error_unit));
        let removed = |removal: &RemovalError| {
            let role = if removal.is_calibration { "" } else { ", held out" };
            let error = removal.error_percent.last().copied().filter(|error| error.is_finite());
            let shown = error.map_or("nothing measured".to_owned(), |error| {
                format!("{error:+.2} % ± {:.2} %", removal.sigma_percent)
            });
            ("removed", format!("{}{role}: {shown}", removal.about))
        };
        let mut lines: Vec<(&'static str, String)> = summary.waterfall.iter().map(error).collect();
        lines.push(("floor", summary.error_unit.shown(summary.noise_floor)));
        lines.push(("χ²", format!("{:.0} at {} degrees of freedom", summary.chi2, summary.degrees_of_freedom)));
        lines.extend(summary.removal.iter().map(removed));
        lines.extend(summary.parameters.iter().map(|parameter| ("parameter", parameter.shown())));
        lines.extend(summary.remarks.iter().map(|remark| ("note", remark.clone())));
        lines
    }

    /// Sentence on the ratio of the whole model's error to the noise floor.
    fn sentence(&self) -> String {
        let unit = self.summary.error_unit;
        let last = self.summary.waterfall.last().map_or(0.0, |step| step.calibration_rms);
        let floor = self.summary.noise_floor;
        format!(
            "Calibrated: {} are left, {:.2} times the noise floor of {}.",
            unit.shown(last),
            last / floor,
            unit.shown(floor)
        )
    }
}
