//! Text and tables of a report, from a calibration.

use effects::{CompiledModel, Model};
use lab::Result;
use serde_json::Value;

use super::failures;
use super::maps::Seen;
use super::measurements::Data;
use super::provenance::provenance;
use super::report_from_diagnosis::{compared, waterfall};
use super::waterfall::of_measured;
use crate::{Compared, Conclusion, PassVolume, StudyReport, Waterfall};
use lab::{BASE_STEP, Calibration, CalibrationSummary, Simulated, Verdict, WaterfallStep};

/// Input of a calibration report.
pub struct CalibrationReport<'a> {
    /// The measurements.
    pub data: &'a Data<'a>,
    /// The calibration.
    pub calibration: &'a Calibration,
    /// Its summary.
    pub summary: &'a CalibrationSummary,
    /// Steps of the waterfall: those of the summary, or those of a study in progress.
    pub waterfall: &'a [WaterfallStep],
    /// Model shown in the maps beside the base law, if it is not the whole model.
    pub rival: Option<&'a CompiledModel>,
    /// Verdict of a study, if there is one.
    pub verdict: Option<Verdict>,
    /// Sentence on the step that was done, or on the result.
    pub sentence: String,
    /// Seed of all draws.
    pub seed: u64,
    /// JSON answer for programs.
    pub answer: Value,
}

/// Fills a report with the comparison, structure tests, covariates, a waterfall, maps, sections and volumes, without
/// fits or findings.
///
/// - `models`: the compared model, and those of its maps, without and with effects
/// - `degrees_of_freedom`: number of parameters that were fitted without effects
///
/// # Errors
/// If a model cannot be simulated, or an input file cannot be read again for its hash.
pub(super) fn bare_report(
    data: &Data,
    (model, base, with_effects): (&Model, &CompiledModel, Option<&CompiledModel>),
    waterfall: Waterfall,
    (degrees_of_freedom, seed): (usize, u64),
) -> Result<StudyReport> {
    let models: Vec<&CompiledModel> = [base].into_iter().chain(with_effects).collect();
    let simulated = data.scans().map(|(_, evidence)| Simulated::all(evidence, &models)).transpose()?;
    let seen = Seen::of(data, simulated.as_deref());
    let (failures, covariates) = match (&seen, data.rows()) {
        (Some(seen), _) => failures::of_scans(seen.evidence, (seen.base, seen.found), (degrees_of_freedom, seed)),
        (None, Some(rows)) => failures::of_rows(rows, (base, with_effects), (degrees_of_freedom, seed))?,
        (None, None) => Default::default(),
    };
    Ok(StudyReport {
        tests: failures.tests,
        covariates,
        tiles: seen.as_ref().map(Seen::tiles).unwrap_or_default(),
        ..plain_report(data, model, seen.as_ref(), (waterfall, seed))?
    })
}

/// Fills a report with the comparison, a waterfall, maps, sections and volumes, without tests, fits or findings.
///
/// # Errors
/// If an input file cannot be read again for its hash.
pub(super) fn plain_report(
    data: &Data,
    model: &Model,
    seen: Option<&Seen>,
    (waterfall, seed): (Waterfall, u64),
) -> Result<StudyReport> {
    Ok(StudyReport {
        compared: compared((model, data.scans()), data.folder(), &data.notes(), &[]),
        conclusion: Conclusion::Calibrated,
        sentence: String::new(),
        tests: Vec::new(),
        waterfall,
        volumes: seen.map(Seen::volumes).unwrap_or_default(),
        scans: seen.map(Seen::scans).unwrap_or_default(),
        sections: seen.map(Seen::sections).unwrap_or_default(),
        covariates: Vec::new(),
        tiles: Vec::new(),
        suspects: Vec::new(),
        unfitted: Vec::new(),
        parameters: Vec::new(),
        correlations: Vec::new(),
        detectable: Vec::new(),
        next_trial: None,
        proposal: None,
        provenance: provenance(data.folder(), seed)?,
        diagnosis: Value::Null,
    })
}

/// Fills the report of a calibration.
///
/// # Errors
/// If a simulation fails, or an input file cannot be read again for its hash.
pub fn calibration_report(input: &CalibrationReport) -> Result<StudyReport> {
    let CalibrationReport { data, calibration, summary, .. } = input;
    let base = &calibration.steps[0].fit.model;
    let grown = (calibration.steps.len() > 1).then(|| &calibration.last().fit.model);
    let last = input.rival.or(grown);
    let floors = (summary.noise_floor, summary.evaluation_noise_floor);
    let falls = waterfall(input.waterfall, floors, summary.error_unit);
    let mut bare = bare_report(
        data,
        (&calibration.model, base, last),
        falls,
        (calibration.steps[0].fit.coordinates.len(), input.seed),
    )?;
    add_volumes(&mut bare, input.rival.is_none());
    let notes = [bare.compared.notes.clone(), summary.remarks.clone()].concat();
    Ok(StudyReport {
        compared: Compared { notes, ..bare.compared },
        conclusion: input.verdict.map_or(Conclusion::Calibrated, Conclusion::Searched),
        sentence: input.sentence.clone(),
        parameters: summary.parameters.clone(),
        correlations: summary.correlations.clone(),
        diagnosis: input.answer.clone(),
        ..bare
    })
}

/// Copies the errors of the removed volumes to the steps of the waterfall that they belong to: the base model and the
/// last one before the floor.
///
/// - `is_last_shown`: true if the volumes with effects are those of the last step, false if they are of another model
fn add_volumes(report: &mut StudyReport, is_last_shown: bool) {
    let (falls, volumes) = (&mut report.waterfall, &report.volumes);
    falls.passes = volumes.iter().map(|volume| volume.pass.clone()).collect();
    let share = |volume: &PassVolume, simulated: f64| {
        of_measured(volume.measured, [simulated - volume.measured, volume.uncertainty])
    };
    let last = falls.steps.len().saturating_sub(2);
    let Some(base) = falls.steps.iter().position(|step| step.name == BASE_STEP) else { return };
    falls.steps[base].volume_errors = volumes.iter().map(|volume| share(volume, volume.base)).collect();
    if last > base && is_last_shown {
        let with_effect = |volume: &PassVolume| share(volume, volume.with_effect?);
        falls.steps[last].volume_errors = volumes.iter().map(with_effect).collect();
    }
}
