//! A proposal in the form that a study makes.

use lab::{CurvePoint, ErrorUnit, FittedForm, Proposal, ProposedForm, WaterfallStep};

/// Makes a form with its curve.
pub fn proposal() -> Proposal {
    let step = |step: &str, rms: f64| WaterfallStep {
        step: step.into(),
        calibration_rms: rms,
        evaluation_rms: Some(1.1 * rms),
    };
    let point = |k: u32| {
        let change = -0.002 * f64::from(k * k);
        CurvePoint { at: 10.0 * f64::from(k), change, band: [change - 0.03, change + 0.03], form: -0.01 * f64::from(k) }
    };
    let (name, summary) = ("form-line-of-worked-volume", "the rate is 21 % lower at 100 mm^3 than at 0 mm^3");
    let fitted = FittedForm {
        name: name.into(),
        summary: summary.into(),
        delta_chi2: 310.0,
        predicts_better_by: 120.5,
        p_value: 0.0025,
    };
    let text = format!("name = \"{name}\"\n[modify]\nrate = \"rate * (1 - a * volume)\" # <named> & edited by you\n");
    Proposal {
        forms: vec![ProposedForm {
            name: name.into(),
            summary: summary.into(),
            acts_on: ["rate".into(), "%".into()],
            variable: ["volume removed".into(), "mm^3".into()],
            curve: (0..8).map(point).collect(),
            fitted: vec![fitted],
        }],
        files: vec![(format!("{name}.toml"), text.clone()), ("closure-worked-volume.toml".into(), text)],
        model: String::new(),
        parameters: Vec::new(),
        error_unit: ErrorUnit::Metre,
        errors: vec![step("without it", 12.4e-6), step("+ form", 2.6e-6)],
        delta_chi2: 310.0,
    }
}
