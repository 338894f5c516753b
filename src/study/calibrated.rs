//! The report's text and tables from a calibration.

use anyhow::Result;
use serde_json::Value;
use sim::effect::{CompiledModel, Model};

use super::fill::{compared, correlations, parameter, provenance, verdict, waterfall};
use super::maps::Seen;
use super::measurements::Data;
use super::simulated::Simulated;
use super::{failures, scan_tests};
use crate::laboratory::{Calibration, CalibrationSummary, RemovalError, Verdict, WaterfallStep};
use crate::study_report as page;
use crate::study_report::{Compared, StudyReport, Waterfall};

/// What the report of a calibration is made from.
pub struct CalibrationReport<'a> {
    /// The measurements.
    pub data: &'a Data<'a>,
    /// What was fitted.
    pub calibration: &'a Calibration,
    /// The same in numbers.
    pub summary: &'a CalibrationSummary,
    /// Steps of the waterfall; those of the summary, or those of a study that goes on.
    pub waterfall: &'a [WaterfallStep],
    /// What the maps show beside the base law, where that is not the whole model.
    pub rival: Option<&'a CompiledModel>,
    /// The verdict of a study, where it has come to one.
    pub verdict: Option<Verdict>,
    /// What was done, or found, in a sentence.
    pub sentence: String,
    /// Seed of all draws.
    pub seed: u64,
    /// The answer for programs.
    pub answer: Value,
}

/// A report with what was compared, where it fails, a waterfall, maps, sections and volumes, and nothing fitted or found.
///
/// - `models`: what was compared; what its maps show, without and with effects
/// - `freedoms`: parameters that were fitted without effects
///
/// # Errors
/// When a model cannot be simulated, or an input file not be read again for its hash.
pub(super) fn bare_report(
    data: &Data,
    (model, base, with_effects): (&Model, &CompiledModel, Option<&CompiledModel>),
    waterfall: Waterfall,
    (freedoms, seed): (usize, u64),
) -> Result<StudyReport> {
    let models: Vec<&CompiledModel> = [base].into_iter().chain(with_effects).collect();
    let simulated = data.scans().map(|(_, evidence)| Simulated::all(evidence, &models)).transpose()?;
    let seen = data.scans().zip(simulated.as_deref()).map(|((_, evidence), simulated)| Seen {
        evidence,
        base: &simulated[0],
        found: simulated.get(1),
        lines: &[],
    });
    let seen = seen.as_ref();
    let (failures, covariates) = match (seen, data.rows()) {
        (Some(seen), _) => failures::of_scans(seen.evidence, (seen.base, seen.found), (freedoms, seed)),
        (None, Some(rows)) => failures::of_rows(rows, (base, with_effects), (freedoms, seed))?,
        (None, None) => Default::default(),
    };
    Ok(StudyReport {
        compared: compared((model, data.scans()), data.folder(), &data.notes_of_table(), &[]),
        verdict: page::Verdict::Calibrated,
        sentence: String::new(),
        tests: scan_tests::reported(&failures.tests),
        waterfall,
        volumes: seen.map(Seen::volumes).unwrap_or_default(),
        scans: seen.map(Seen::scans).unwrap_or_default(),
        sections: seen.map(Seen::sections).unwrap_or_default(),
        covariates,
        suspects: Vec::new(),
        parameters: Vec::new(),
        correlations: None,
        detectable: Vec::new(),
        next_trial: None,
        suggested_effect: None,
        provenance: provenance(data.folder(), seed)?,
        diagnosis: Value::Null,
    })
}

/// Fills the report of a calibration.
///
/// # Errors
/// As of a simulation that fails, or an input file that cannot be read again for its hash.
pub fn calibration_report(input: &CalibrationReport) -> Result<StudyReport> {
    let CalibrationReport { data, calibration, summary, .. } = input;
    let base = &calibration.steps[0].fit.model;
    let grown = (calibration.steps.len() > 1).then(|| &calibration.last().fit.model);
    let last = input.rival.or(grown);
    let mut falls = waterfall(input.waterfall, summary.noise_floor_um, summary.error_unit);
    add_removal(&mut falls, summary, calibration.steps.len());
    let bare = bare_report(
        data,
        (&calibration.model, base, last),
        falls,
        (calibration.steps[0].fit.coordinates.len(), input.seed),
    )?;
    let notes = [bare.compared.notes.clone(), summary.remarks.clone()].concat();
    Ok(StudyReport {
        compared: Compared { notes, ..bare.compared },
        verdict: input.verdict.map_or(page::Verdict::Calibrated, verdict),
        sentence: input.sentence.clone(),
        parameters: summary.parameters.iter().map(parameter).collect(),
        correlations: correlations(&calibration.last().fit),
        diagnosis: input.answer.clone(),
        ..bare
    })
}

/// Puts the errors of what was removed beside the waterfall's fitted steps, which stand before the floor.
fn add_removal(falls: &mut Waterfall, summary: &CalibrationSummary, fitted: usize) {
    falls.passes = summary.removal.iter().map(|removal| removal.about.clone()).collect();
    let first = falls.steps.len() - 1 - fitted;
    for (k, step) in falls.steps[first..first + fitted].iter_mut().enumerate() {
        let error = |removal: &RemovalError| Some((0.01 * removal.error_percent[k], 0.01 * removal.sigma_percent));
        step.volume_errors = summary.removal.iter().map(error).collect();
    }
}
