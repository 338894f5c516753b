//! The report's text and tables from a diagnosis.

use std::path::Path;

use anyhow::Result;
use sha2::{Digest as _, Sha256};
use sim::effect::Model;

use super::maps::Seen;
use crate::laboratory::{
    BASE_STEP, Diagnosis, DiagnosisSummary, EffectSummary, ErrorUnit, Fit, ParameterSummary, ScanEvidence, Verdict,
};
use crate::study_report as page;
use crate::study_report::{
    Compared, ComparedPass, Digest, Misfit, Provenance, Stated, StudyReport, Waterfall, WaterfallStep,
};
use crate::trial::{Campaign, PassScan, Tool};

/// What a report is made from.
pub struct ReportInput<'a> {
    /// The campaign, where it has scans.
    pub scans: Option<(&'a Campaign, &'a ScanEvidence<'a>)>,
    /// Where it was read.
    pub folder: &'a Path,
    /// What was found.
    pub diagnosis: &'a Diagnosis,
    /// The same in numbers.
    pub summary: &'a DiagnosisSummary,
    /// Seed of all draws.
    pub seed: u64,
    /// What the reader understood of the files.
    pub notes: Vec<String>,
}

/// Fills a report.
///
/// # Errors
/// When a model cannot be simulated, or an input file not be read again for its hash.
pub fn report(input: &ReportInput) -> Result<StudyReport> {
    let ReportInput { diagnosis, summary, .. } = input;
    let base = &diagnosis.rounds[0].base.model;
    let found = (!diagnosis.found().is_empty()).then(|| match diagnosis.verdict {
        Verdict::Ambiguous => &diagnosis.rounds[0].findings[0].suspect.fit.model,
        _ => &diagnosis.fit.model,
    });
    let seen = input.scans.map(|(_, evidence)| Seen::new(evidence, base, found)).transpose()?;
    let seen = seen.as_ref();
    Ok(StudyReport {
        compared: compared((&diagnosis.model, input.scans), input.folder, &input.notes),
        verdict: verdict(summary.verdict),
        sentence: summary.sentence.clone(),
        tests: Vec::new(),
        waterfall: waterfall(&summary.waterfall, summary.noise_floor_um, summary.error_unit),
        volumes: seen.map(Seen::volumes).unwrap_or_default(),
        scans: seen.map(Seen::scans).unwrap_or_default(),
        sections: seen.map(Seen::sections).unwrap_or_default(),
        covariates: Vec::new(),
        suspects: summary.suspects.iter().map(|suspect| self::suspect(suspect, summary.error_unit)).collect(),
        parameters: summary.parameters.iter().map(parameter).collect(),
        correlations: correlations(&diagnosis.fit),
        detectable: summary.detectable.iter().map(detectable).collect(),
        next_trial: None,
        suggested_effect: None,
        provenance: provenance(input.folder, input.seed)?,
        diagnosis: serde_json::to_value(summary)?,
    })
}

pub(super) fn verdict(verdict: Verdict) -> page::Verdict {
    match verdict {
        Verdict::Identified => page::Verdict::Identified,
        Verdict::Ambiguous => page::Verdict::Ambiguous,
        Verdict::Partly => page::Verdict::Partly,
        Verdict::Unknown => page::Verdict::Unknown,
        Verdict::NothingMissing => page::Verdict::NothingMissing,
        Verdict::NotTestable => page::Verdict::NotTestable,
    }
}

/// What was compared: a model with the scans of a campaign, or with rows.
pub(super) fn compared(
    (model, scans): (&Model, Option<(&Campaign, &ScanEvidence)>),
    folder: &Path,
    notes: &[String],
) -> Compared {
    let campaign = folder.file_name().map_or(String::new(), |name| name.to_string_lossy().into_owned());
    let effects: Vec<String> = model.effects.iter().map(|part| part.name.clone()).collect();
    let laws: Vec<String> = model.laws.iter().map(|part| part.name.clone()).collect();
    let model = [laws, effects].concat().join(", ");
    let Some((trials, evidence)) = scans else {
        return Compared { campaign, model, notes: notes.to_vec(), ..Compared::default() };
    };
    let trial = &trials.trials[0];
    let tool = match trial.tool {
        Tool::Wheel { radius, width, .. } => format!("wheel, radius {} mm, width {} mm", radius * 1e3, width * 1e3),
        Tool::Pad { radius } => format!("pad, radius {} mm", radius * 1e3),
    };
    let pass = |view: &crate::laboratory::ScanView| {
        let trial = &trials.trials[view.trial];
        let pass = &trial.passes[view.pass];
        ComparedPass {
            name: format!("{}, pass {}", trial.name, view.pass + 1),
            role: Seen::role(view),
            force: Some(pass.force_setpoint),
            feed: Some(pass.feed),
            spindle_speed: Some(pass.spindle_speed),
            noise_floor: matches!(pass.scan, PassScan::Heights(_)).then_some(evidence.noise[view.trial].sigma),
            alignment: None,
        }
    };
    Compared {
        campaign,
        model,
        tool,
        passes: evidence.views.iter().map(pass).collect(),
        pitch: Some(trial.scans.before.pixels.pitch),
        voxel: evidence.twin.trials.first().map(|twin| twin.part.voxel),
        blur: evidence.blur.filter(|blur| *blur > 0.0),
        method: vec![
            "Each scan is laid on the surface that the tool left alone; its height, tilt and shift stay free in every fit."
                .to_owned(),
            "The noise floor comes from the repeated scan before the first pass.".to_owned(),
        ],
        notes: trials.trials.iter().flat_map(|trial| trial.notes.clone()).chain(notes.iter().cloned()).collect(),
    }
}

/// The steps and the noise floor below them. Steps before the base model have no share of its excess.
pub(super) fn waterfall(steps: &[crate::laboratory::WaterfallStep], floor: f64, unit: ErrorUnit) -> Waterfall {
    let one = 1.0 / unit.per_one();
    let excess = |rms: f64| (rms * rms - floor * floor).max(0.0);
    let base = steps.iter().position(|step| step.step == BASE_STEP).unwrap_or(0);
    let whole = steps.get(base).map_or(0.0, |step| excess(step.calibration_rms_um));
    let step = |(k, step): (usize, &crate::laboratory::WaterfallStep)| WaterfallStep {
        name: step.step.clone(),
        calibration: Some(step.calibration_rms_um * one),
        evaluation: step.evaluation_rms_um.map(|rms| rms * one),
        volume_errors: Vec::new(),
        unexplained: (k >= base && whole > 0.0).then(|| excess(step.calibration_rms_um) / whole),
    };
    let last =
        WaterfallStep { name: "noise floor".to_owned(), calibration: Some(floor * one), ..WaterfallStep::default() };
    let misfit = match unit {
        ErrorUnit::Micrometre => Misfit::heights(),
        ErrorUnit::Percent => Misfit { name: "removal".to_owned(), unit: Stated::new("%", 0.01) },
    };
    Waterfall { misfit, passes: Vec::new(), steps: steps.iter().enumerate().map(step).chain([last]).collect() }
}

pub(super) fn suspect(suspect: &EffectSummary, unit: ErrorUnit) -> page::Suspect {
    let one = 1.0 / unit.per_one();
    page::Suspect {
        name: suspect.name.clone(),
        title: suspect.title.clone(),
        probability: suspect.probability,
        gain: suspect.gain,
        evaluation_before: suspect.evaluation_rms_um_before.map(|rms| rms * one),
        evaluation_after: suspect.evaluation_rms_um_after.map(|rms| rms * one),
        look_alikes: suspect.indistinguishable_from.clone(),
        note: if suspect.probability > 0.0 {
            String::new()
        } else {
            format!("ruled out: chance {:.3}, or too small to matter, or at its null", suspect.chance)
        },
    }
}

pub(super) fn parameter(parameter: &ParameterSummary) -> page::ParameterEstimate {
    let note = parameter.note.as_deref().unwrap_or_default();
    page::ParameterEstimate {
        name: parameter.name.clone(),
        unit: Stated::new(&parameter.unit, 1.0),
        value: parameter.value,
        interval: parameter.interval,
        on_bound: note.starts_with("on its"),
        identifiable: !note.starts_with("not"),
        fixed: false,
    }
}

pub(super) fn correlations(fit: &Fit) -> Option<page::Correlations> {
    let covariance = fit.covariance()?;
    let count = covariance.nrows();
    let names = fit.coordinates.iter().map(|c| c.slot.name()).collect();
    let value = |k: usize| {
        let (i, j) = (k / count, k % count);
        covariance[(i, j)] / (covariance[(i, i)] * covariance[(j, j)]).sqrt()
    };
    (count > 1).then(|| page::Correlations { names, values: (0..count * count).map(value).collect() })
}

pub(super) fn detectable(detectable: &crate::laboratory::Detectable) -> page::Detectable {
    page::Detectable {
        name: detectable.effect.clone(),
        parameter: detectable.parameter.clone(),
        unit: Stated::new(&detectable.unit, 1.0),
        size: detectable.size,
        typical: None,
        map_rms: None,
        note: if detectable.testable { String::new() } else { "not testable with these passes".to_owned() },
    }
}

/// SHA-256 over the hashes of all files of a folder: whether measurements are the same.
///
/// # Errors
/// When a file cannot be read.
pub fn inputs_sha256(folder: &Path) -> Result<String> {
    let inputs = provenance(folder, 0)?.inputs;
    let lines: String = inputs.iter().map(|input| format!("{} {}\n", input.sha256, input.file)).collect();
    Ok(crate::part::sha256(lines.as_bytes()))
}

pub(super) fn provenance(folder: &Path, seed: u64) -> Result<Provenance> {
    let mut files: Vec<_> = walkdir::WalkDir::new(folder).sort_by_file_name().into_iter().collect::<Result<_, _>>()?;
    files.retain(|entry| entry.file_type().is_file());
    let digest = |entry: &walkdir::DirEntry| -> Result<Digest> {
        let hash: String =
            Sha256::digest(std::fs::read(entry.path())?).iter().map(|byte| format!("{byte:02x}")).collect();
        let file = entry.path().strip_prefix(folder).unwrap_or(entry.path()).display().to_string();
        Ok(Digest { file, sha256: hash })
    };
    Ok(Provenance {
        inputs: files.iter().map(digest).collect::<Result<_>>()?,
        seed,
        versions: vec![("robofin".to_owned(), env!("CARGO_PKG_VERSION").to_owned())],
        ..Provenance::default()
    })
}
