//! Text and tables of a report, from a diagnosis.

use std::path::Path;

use effects::{CompiledModel, Model};
use lab::Result;
use serde::Serialize;

use super::failures::{self, Failures};
use super::maps::{self, Seen};
use super::proposal_step::add_proposal;
use super::provenance::provenance;
use super::shapley::overlap;
use super::waterfall::{Scans, Step};
use crate::{Compared, ComparedPass, Conclusion, Misfit, StudyReport, Waterfall, WaterfallStep};
use lab::{
    BASE_STEP, Diagnosis, DiagnosisSummary, ErrorUnit, RowEvidence, ScanEvidence, ScanView, Simulated, correlations,
};
use robot::Tool;
use trials::measure::Registration;
use trials::trial::{Campaign, Finding};

/// Methods of registration and comparison of scans, a sentence each.
const METHOD: [&str; 3] = [
    "Each scan is laid on the surface that the tool left alone; its height, tilt and shift stay free in every fit.",
    "The scan noise is the root mean square of one pixel's error, from the repeated scan before the first pass, or \
     else as the notes say.",
    "The noise floor is what the noise of the scan, and that of the scan before the first pass where the tool left it alone, \
     leaves of an error near the tool. Calibration and evaluation passes each have their own.",
];

/// Input of a report.
pub struct ReportInput<'a> {
    /// The campaign, if it has scans.
    pub scans: Option<(&'a Campaign, &'a ScanEvidence<'a>)>,
    /// The rows, if it is a table.
    pub rows: Option<&'a RowEvidence<'a>>,
    /// Folder of the measurements.
    pub folder: &'a Path,
    /// The diagnosis.
    pub diagnosis: &'a Diagnosis,
    /// Its summary.
    pub summary: &'a DiagnosisSummary,
    /// Seed of all draws.
    pub seed: u64,
    /// Notes on how the input files were interpreted.
    pub notes: Vec<String>,
    /// Findings of the consistency checks between scans and logs.
    pub findings: Vec<Finding>,
}

/// JSON answer of a diagnosis: the missing effects, and the misfit of the base model.
#[derive(Serialize)]
struct Answer<'a> {
    /// Notes on ambiguous input files and how they were interpreted.
    notes: &'a [String],
    /// Findings of the consistency checks between scans and logs.
    findings: &'a [Finding],
    #[serde(flatten)]
    summary: &'a DiagnosisSummary,
    #[serde(flatten)]
    failures: &'a Failures,
}

/// Fills a report; its `diagnosis` is the JSON answer.
///
/// # Errors
/// If a model cannot be simulated, or an input file cannot be read again for its hash.
pub fn report(input: &ReportInput) -> Result<StudyReport> {
    let ReportInput { diagnosis, summary, .. } = input;
    let filled = match (input.scans, input.rows) {
        (Some((_, evidence)), _) => of_scans(input, evidence)?,
        (None, Some(rows)) => of_rows(input, rows)?,
        (None, None) => Filled::default(),
    };
    let floors = (summary.noise_floor, summary.evaluation_noise_floor);
    let mut waterfall =
        filled.waterfall.unwrap_or_else(|| self::waterfall(&summary.waterfall, floors, summary.error_unit));
    waterfall.notes.extend(overlap(diagnosis, summary));
    summary.proposal.iter().for_each(|proposal| add_proposal(&mut waterfall, proposal));
    let compared = compared((&diagnosis.model, input.scans), input.folder, &input.notes, &filled.alignments);
    Ok(StudyReport {
        compared: Compared { blur: filled.blur, ..compared },
        conclusion: Conclusion::Searched(summary.verdict),
        sentence: summary.sentence.clone(),
        tests: filled.failures.tests.clone(),
        waterfall,
        volumes: filled.volumes,
        scans: filled.scans,
        sections: filled.sections,
        covariates: filled.covariates,
        tiles: Vec::new(),
        suspects: summary.suspects.clone(),
        unfitted: summary.unfitted.clone(),
        parameters: summary.parameters.clone(),
        correlations: correlations(&diagnosis.fit),
        detectable: summary.detectable.clone(),
        next_trial: summary.next_trial.clone(),
        proposal: input.summary.proposal.clone(),
        provenance: provenance(input.folder, input.seed)?,
        diagnosis: serde_json::to_value(Answer {
            notes: &input.notes,
            findings: &input.findings,
            summary,
            failures: &filled.failures,
        })?,
    })
}

/// Parts of a report that come from scans or rows.
#[derive(Default)]
struct Filled {
    failures: Failures,
    waterfall: Option<Waterfall>,
    /// Standard deviation of the instrument's blur, as the last model determines it [m].
    blur: Option<f64>,
    alignments: Vec<Option<Registration>>,
    volumes: Vec<super::PassVolume>,
    scans: Vec<super::ScanComparison>,
    sections: Vec<super::ScanSection>,
    covariates: Vec<super::CovariatePlot>,
}

fn of_scans(input: &ReportInput, evidence: &ScanEvidence) -> Result<Filled> {
    let first = &input.diagnosis.rounds[0];
    let found = input.diagnosis.found();
    let models: Vec<(String, &CompiledModel)> = [("base model".to_owned(), &first.base.model)]
        .into_iter()
        .chain(found.iter().map(|found| (format!("+ {}", found.suspect.name()), &found.suspect.fit.model)))
        .collect();
    let start = start_of(&first.base.model);
    let all: Vec<&CompiledModel> = [&start].into_iter().chain(models.iter().map(|(_, model)| *model)).collect();
    let simulated = Simulated::all(evidence, &all)?;
    let steps: Vec<Step> =
        models.into_iter().zip(&simulated[1..]).map(|((name, _), simulated)| Step { name, simulated }).collect();
    let scans = Scans::new(evidence, true);
    let (base, last) = (&simulated[1], (simulated.len() > 2).then(|| &simulated[simulated.len() - 1]));
    let seen = Seen { evidence, base, found: last, lines: &[] };
    let (failures, covariates) = failures::of_scans(evidence, (base, last), (first.base.coordinates.len(), input.seed));
    Ok(Filled {
        failures,
        waterfall: Some(scans.waterfall(&simulated[0], &steps)),
        blur: Some(last.unwrap_or(base).nuisances.blur).filter(|blur| *blur > 0.0),
        alignments: evidence.views.iter().map(|view| scans.alignment(view)).collect(),
        volumes: seen.volumes(),
        scans: seen.scans(),
        sections: seen.sections(),
        covariates,
    })
}

fn of_rows(input: &ReportInput, evidence: &RowEvidence) -> Result<Filled> {
    let base = &input.diagnosis.rounds[0].base;
    let found = input.diagnosis.found();
    let models = (&base.model, found.last().map(|found| &found.suspect.fit.model));
    let (failures, covariates) = failures::of_rows(evidence, models, (base.coordinates.len(), input.seed))?;
    Ok(Filled { failures, covariates, ..Filled::default() })
}

/// The base law before any fit: all parameters at their defaults.
fn start_of(base: &CompiledModel) -> CompiledModel {
    let mut start = base.clone();
    for (index, slot) in base.parameters().iter().enumerate() {
        start.set(index, slot.default);
    }
    start
}

/// The compared model and measurements: scans of a campaign, or rows.
pub(super) fn compared(
    (model, scans): (&Model, Option<(&Campaign, &ScanEvidence)>),
    folder: &Path,
    notes: &[String],
    alignments: &[Option<Registration>],
) -> Compared {
    let effects: Vec<String> = model.effects.iter().map(|part| part.name.clone()).collect();
    let laws: Vec<String> = model.laws.iter().map(|part| part.name.clone()).collect();
    let model = [laws, effects].concat().join(", ");
    let named = Compared { campaign: folder_name(folder), model, notes: notes.to_vec(), ..Compared::default() };
    match scans {
        Some((campaign, evidence)) => compared_scans(campaign, evidence, alignments, named),
        None => named,
    }
}

/// Name of a campaign's folder.
pub(super) fn folder_name(folder: &Path) -> String {
    folder.file_name().map_or(String::new(), |name| name.to_string_lossy().into_owned())
}

/// Adds the passes and lattice of a campaign with scans to `named`.
pub(super) fn compared_scans(
    campaign: &Campaign,
    evidence: &ScanEvidence,
    alignments: &[Option<Registration>],
    named: Compared,
) -> Compared {
    let trial = &campaign.trials[0];
    let tool = match &trial.tool.shape {
        Tool::Wheel(wheel) => format!("wheel, radius {} mm, width {} mm", wheel.radius * 1e3, wheel.width * 1e3),
        disc => format!("pad, radius {} mm", disc.rim_radius() * 1e3),
    };
    let pass = |(k, view): (usize, &ScanView)| {
        let pass = &campaign.trials[view.trial].passes[view.pass];
        ComparedPass {
            name: maps::name(evidence, view),
            role: maps::role(view),
            force: Some(pass.force_setpoint),
            feed: Some(pass.feed),
            spindle_speed: Some(pass.spindle_speed),
            noise_floor: pass.scan.heights().is_some().then_some(evidence.noise[view.trial].floor.rms),
            alignment: alignments.get(k).copied().flatten(),
        }
    };
    Compared {
        tool,
        passes: evidence.views.iter().enumerate().map(pass).collect(),
        pitch: Some(trial.scans.before.pixels.pitch),
        voxel: evidence.simulation.trials().first().map(|simulation| simulation.part.voxel),
        blur: evidence.nuisances.map(|nuisances| nuisances.blur).filter(|blur| *blur > 0.0),
        method: METHOD.map(str::to_owned).to_vec(),
        ..named
    }
}

/// Waterfall with the noise floors of calibration and evaluation passes as its last step. Steps before the base model
/// have no share of its excess.
pub(super) fn waterfall(
    steps: &[lab::WaterfallStep],
    (floor, held_out): (f64, Option<f64>),
    unit: ErrorUnit,
) -> Waterfall {
    let excess = |rms: f64| (rms * rms - floor * floor).max(0.0);
    let base = steps.iter().position(|step| step.step == BASE_STEP).unwrap_or(0);
    let whole = steps.get(base).map_or(0.0, |step| excess(step.calibration_rms));
    let step = |(k, step): (usize, &lab::WaterfallStep)| WaterfallStep {
        name: step.step.clone(),
        calibration: Some(step.calibration_rms),
        evaluation: step.evaluation_rms,
        unexplained: (k >= base && whole > 0.0).then(|| excess(step.calibration_rms) / whole),
        ..WaterfallStep::default()
    };
    let last = WaterfallStep {
        name: "noise floor".to_owned(),
        calibration: Some(floor),
        evaluation: held_out,
        ..WaterfallStep::default()
    };
    let steps = steps.iter().enumerate().map(step).chain([last]).collect();
    Waterfall { misfit: Misfit::of(unit), passes: Vec::new(), steps, notes: Vec::new() }
}
