//! The page of an effect that was tried: how the error fell, and every scan without and with it.

use effects::Model;
use serde_json::Value;

use super::ledger::Entry;
use super::maps::Seen;
use super::measurements::Data;
use super::provenance::provenance;
use super::report_from_diagnosis::{compared, correlations, parameter};
use crate::{Misfit, Stated, StudyReport, Verdict, Waterfall, WaterfallStep};
use lab::{Attempt, Better, ErrorUnit, Paired, Result, Simulated};

/// What the two models are called.
const NAMES: [&str; 2] = ["without it", "with it"];

/// Fills the report of an attempt.
///
/// # Errors
/// When a model cannot be simulated, or an input file not be read again for its hash.
pub fn attempt_report(data: &Data, attempt: &Attempt, entry: &Entry) -> Result<StudyReport> {
    let models = [&attempt.before.model, &attempt.with.model];
    let report = pair_report(data, &attempt.models[1], (models, NAMES), &entry.paired)?;
    Ok(StudyReport {
        verdict: if entry.better == Better::Second { Verdict::Better } else { Verdict::NotBetter },
        sentence: format!("{}: {}", entry.tried, entry.sentence()),
        parameters: entry.parameters.iter().map(parameter).collect(),
        correlations: correlations(&attempt.with),
        diagnosis: serde_json::to_value(entry)?,
        ..report
    })
}

/// Fills a report of two models against the same data; nothing of it was fitted or tested.
///
/// - `models`: both, and what they are called
///
/// # Errors
/// As [`attempt_report`].
pub fn pair_report(
    data: &Data,
    model: &Model,
    (models, names): ([&effects::CompiledModel; 2], [&str; 2]),
    paired: &Paired,
) -> Result<StudyReport> {
    let simulated = data.scans().map(|(_, evidence)| Simulated::all(evidence, &models)).transpose()?;
    let seen = data.scans().zip(simulated.as_deref()).map(|((_, evidence), simulated)| Seen {
        evidence,
        base: &simulated[0],
        found: simulated.get(1),
        lines: &[],
    });
    let seen = seen.as_ref();
    Ok(StudyReport {
        compared: compared((model, data.scans()), data.folder(), &data.notes(), &[]),
        verdict: Verdict::NotBetter,
        sentence: String::new(),
        tests: Vec::new(),
        waterfall: waterfall(data, names, paired),
        volumes: seen.map(Seen::volumes).unwrap_or_default(),
        scans: seen.map(Seen::scans).unwrap_or_default(),
        sections: seen.map(Seen::sections).unwrap_or_default(),
        covariates: Vec::new(),
        suspects: Vec::new(),
        parameters: Vec::new(),
        correlations: None,
        detectable: Vec::new(),
        next_trial: None,
        proposal: None,
        provenance: provenance(data.folder(), 0)?,
        diagnosis: Value::Null,
    })
}

/// The errors of both models, and the floor.
fn waterfall(data: &Data, names: [&str; 2], paired: &Paired) -> Waterfall {
    let per_unit = data.evidence().unit().per_one();
    let misfit = match data.evidence().unit() {
        ErrorUnit::Micrometre => Misfit::heights(),
        ErrorUnit::Percent => Misfit { name: "removal".to_owned(), unit: Stated::new("%", 0.01) },
    };
    let step = |name: &str, calibration: f64, held_out: Option<f64>| WaterfallStep {
        name: name.to_owned(),
        calibration: Some(calibration / per_unit),
        evaluation: held_out.map(|rms| rms / per_unit),
        ..WaterfallStep::default()
    };
    let held_out = paired.held_out.as_ref();
    let excess = |rms: f64| (rms.powi(2) - paired.calibration.noise_floor.powi(2)).max(0.0);
    let whole = excess(paired.calibration.rms[0]);
    let model = |k: usize| WaterfallStep {
        unexplained: (whole > 0.0).then(|| excess(paired.calibration.rms[k]) / whole),
        ..step(names[k], paired.calibration.rms[k], held_out.map(|split| split.rms[k]))
    };
    let floor = step("noise floor", paired.calibration.noise_floor, held_out.map(|split| split.noise_floor));
    Waterfall { misfit, passes: Vec::new(), steps: vec![model(0), model(1), floor], notes: Vec::new() }
}
