//! The report's text and tables from a diagnosis.

use std::path::Path;

use anyhow::Result;
use sha2::{Digest as _, Sha256};

use super::maps::Seen;
use crate::laboratory::{
    Diagnosis, DiagnosisSummary, EffectSummary, ErrorUnit, ParameterSummary, ScanEvidence, Verdict,
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
        compared: compared(input),
        verdict: verdict(summary.verdict),
        sentence: summary.sentence.clone(),
        tests: Vec::new(),
        waterfall: waterfall(summary),
        volumes: seen.map(Seen::volumes).unwrap_or_default(),
        scans: seen.map(Seen::scans).unwrap_or_default(),
        sections: seen.map(Seen::sections).unwrap_or_default(),
        covariates: Vec::new(),
        suspects: summary.suspects.iter().map(|suspect| self::suspect(suspect, summary.error_unit)).collect(),
        parameters: summary.parameters.iter().map(parameter).collect(),
        correlations: correlations(diagnosis),
        detectable: summary.detectable.iter().map(detectable).collect(),
        next_trial: None,
        suggested_effect: None,
        provenance: provenance(input)?,
        diagnosis: serde_json::to_value(summary)?,
    })
}

fn verdict(verdict: Verdict) -> page::Verdict {
    match verdict {
        Verdict::Identified => page::Verdict::Identified,
        Verdict::Ambiguous => page::Verdict::Ambiguous,
        Verdict::Partly => page::Verdict::Partly,
        Verdict::Unknown => page::Verdict::Unknown,
        Verdict::NothingMissing => page::Verdict::NothingMissing,
        Verdict::NotTestable => page::Verdict::NotTestable,
    }
}

fn compared(input: &ReportInput) -> Compared {
    let campaign = input.folder.file_name().map_or(String::new(), |name| name.to_string_lossy().into_owned());
    let effects: Vec<String> = input.diagnosis.model.effects.iter().map(|part| part.name.clone()).collect();
    let laws: Vec<String> = input.diagnosis.model.laws.iter().map(|part| part.name.clone()).collect();
    let model = [laws, effects].concat().join(", ");
    let Some((trials, evidence)) = input.scans else {
        return Compared { campaign, model, notes: input.notes.clone(), ..Compared::default() };
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
        notes: trials.trials.iter().flat_map(|trial| trial.notes.clone()).chain(input.notes.clone()).collect(),
    }
}

fn waterfall(summary: &DiagnosisSummary) -> Waterfall {
    let one = 1.0 / summary.error_unit.per_one();
    let excess = |rms: f64| (rms * rms - summary.noise_floor_um * summary.noise_floor_um).max(0.0);
    let base = excess(summary.base_rms_um);
    let step = |step: &crate::laboratory::WaterfallStep| WaterfallStep {
        name: step.step.clone(),
        calibration: Some(step.calibration_rms_um * one),
        evaluation: step.evaluation_rms_um.map(|rms| rms * one),
        volume_errors: Vec::new(),
        unexplained: (base > 0.0).then(|| excess(step.calibration_rms_um) / base),
    };
    let floor = WaterfallStep {
        name: "noise floor".to_owned(),
        calibration: Some(summary.noise_floor_um * one),
        ..WaterfallStep::default()
    };
    let steps = summary.waterfall.iter().map(step).chain([floor]).collect();
    let misfit = match summary.error_unit {
        ErrorUnit::Micrometre => Misfit::heights(),
        ErrorUnit::Percent => Misfit { name: "removal".to_owned(), unit: Stated::new("%", 0.01) },
    };
    Waterfall { misfit, passes: Vec::new(), steps }
}

fn suspect(suspect: &EffectSummary, unit: ErrorUnit) -> page::Suspect {
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

fn parameter(parameter: &ParameterSummary) -> page::ParameterEstimate {
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

fn correlations(diagnosis: &Diagnosis) -> Option<page::Correlations> {
    let covariance = diagnosis.fit.covariance()?;
    let count = covariance.nrows();
    let names = diagnosis.fit.coordinates.iter().map(|c| c.slot.name()).collect();
    let value = |k: usize| {
        let (i, j) = (k / count, k % count);
        covariance[(i, j)] / (covariance[(i, i)] * covariance[(j, j)]).sqrt()
    };
    (count > 1).then(|| page::Correlations { names, values: (0..count * count).map(value).collect() })
}

fn detectable(detectable: &crate::laboratory::Detectable) -> page::Detectable {
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

fn provenance(input: &ReportInput) -> Result<Provenance> {
    let mut files: Vec<_> =
        walkdir::WalkDir::new(input.folder).sort_by_file_name().into_iter().collect::<Result<_, _>>()?;
    files.retain(|entry| entry.file_type().is_file());
    let digest = |entry: &walkdir::DirEntry| -> Result<Digest> {
        let hash: String =
            Sha256::digest(std::fs::read(entry.path())?).iter().map(|byte| format!("{byte:02x}")).collect();
        let file = entry.path().strip_prefix(input.folder).unwrap_or(entry.path()).display().to_string();
        Ok(Digest { file, sha256: hash })
    };
    Ok(Provenance {
        inputs: files.iter().map(digest).collect::<Result<_>>()?,
        seed: input.seed,
        versions: vec![("robofin".to_owned(), env!("CARGO_PKG_VERSION").to_owned())],
        ..Provenance::default()
    })
}
