//! The proposed effects as steps of a report's waterfall.

use crate::{Waterfall, WaterfallStep};
use lab::Proposal;

/// Inserts the error with each proposed effect between the last model and the noise floor.
pub(super) fn add_proposal(waterfall: &mut Waterfall, proposal: &Proposal) {
    let Some(floor) = waterfall.steps.pop() else { return };
    let least = floor.calibration.unwrap_or(0.0);
    let excess = |rms: f64| (rms * rms - least * least).max(0.0);
    let base = waterfall.steps.iter().find(|step| step.unexplained == Some(1.0));
    let whole = base.or(waterfall.steps.last()).and_then(|step| step.calibration).map_or(0.0, excess);
    let step = |error: &lab::WaterfallStep| WaterfallStep {
        name: format!("{} (proposed)", error.step),
        calibration: Some(error.calibration_rms),
        evaluation: error.evaluation_rms,
        unexplained: (whole > 0.0).then(|| excess(error.calibration_rms) / whole),
        ..WaterfallStep::default()
    };
    waterfall.steps.extend(proposal.errors.iter().skip(1).map(step));
    waterfall.steps.push(floor);
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Misfit;
    use lab::ErrorUnit;

    #[test]
    fn the_proposal_stands_between_the_last_model_and_the_floor() {
        let step = |name: &str, calibration: f64, unexplained: Option<f64>| WaterfallStep {
            name: name.to_owned(),
            calibration: Some(calibration),
            unexplained,
            ..WaterfallStep::default()
        };
        let steps = vec![step("raw", 9e-5, None), step("base model", 5e-6, Some(1.0)), step("noise floor", 3e-6, None)];
        let mut waterfall = Waterfall { misfit: Misfit::heights(), passes: Vec::new(), steps, notes: Vec::new() };
        let error = |step: &str, rms: f64| lab::WaterfallStep {
            step: step.to_owned(),
            calibration_rms: rms,
            evaluation_rms: Some(2.0 * rms),
        };
        let proposal = Proposal {
            forms: Vec::new(),
            files: Vec::new(),
            model: String::new(),
            parameters: Vec::new(),
            error_unit: ErrorUnit::Metre,
            errors: vec![error("without it", 5e-6), error("+ form", 1e-6 * 13.0f64.sqrt())],
            delta_chi2: 1.0,
        };
        add_proposal(&mut waterfall, &proposal);
        let names: Vec<&str> = waterfall.steps.iter().map(|step| step.name.as_str()).collect();
        assert_eq!(names, ["raw", "base model", "+ form (proposed)", "noise floor"]);
        // 13 - 9 of 25 - 9 µm² remain.
        assert!((waterfall.steps[2].unexplained.unwrap() - 0.25).abs() < 1e-9);
        assert!((waterfall.steps[2].evaluation.unwrap() - 2e-6 * 13.0f64.sqrt()).abs() < 1e-12);
    }
}
