//! Report page of an attempt: the fall of the error, and every scan without and with the effect.

use effects::Model;

use super::calibrated::plain_report;
use super::ledger::Entry;
use super::maps::Seen;
use super::measurements::Data;
use crate::{Conclusion, Misfit, StudyReport, Waterfall, WaterfallStep};
use lab::{Attempt, Better, Paired, Result, Simulated, correlations};

/// Names of the two models on the page.
const NAMES: [&str; 2] = ["without it", "with it"];

/// Fills the report of an attempt.
///
/// # Errors
/// If a model cannot be simulated, or an input file cannot be read again for its hash.
pub fn attempt_report(data: &Data, attempt: &Attempt, entry: &Entry) -> Result<StudyReport> {
    let models = [&attempt.before.model, &attempt.with.model];
    let report = pair_report(data, &attempt.models[1], (models, NAMES), &entry.paired)?;
    Ok(StudyReport {
        conclusion: if entry.better == Better::Second { Conclusion::Better } else { Conclusion::NotBetter },
        sentence: format!("{}: {}", entry.tried, entry.sentence()),
        parameters: entry.parameters.clone(),
        correlations: correlations(&attempt.with),
        diagnosis: serde_json::to_value(entry)?,
        ..report
    })
}

/// Fills a report that compares two models on the same data, without fits or tests.
///
/// - `models`: both models, with their names
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
    let seen = Seen::of(data, simulated.as_deref());
    let report = plain_report(data, model, seen.as_ref(), (waterfall(data, names, paired), 0))?;
    Ok(StudyReport { conclusion: Conclusion::NotBetter, ..report })
}

/// Waterfall of the errors of both models and the noise floor.
fn waterfall(data: &Data, names: [&str; 2], paired: &Paired) -> Waterfall {
    let step = |name: &str, calibration: f64, held_out: Option<f64>| WaterfallStep {
        name: name.to_owned(),
        calibration: Some(calibration),
        evaluation: held_out,
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
    let misfit = Misfit::of(data.evidence().unit());
    Waterfall { misfit, passes: Vec::new(), steps: vec![model(0), model(1), floor], notes: Vec::new() }
}
