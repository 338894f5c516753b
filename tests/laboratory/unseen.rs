//! Held-out passes take no part in any fit.

use std::path::Path;

use effects::{CompiledModel, Library, Model};
use lab::{Evidence, Fit, FitOptions, ScanEvidence, Split};
use trials::trial::{Campaign, PassScan, Role, Trial};

pub fn bundled() -> Vec<Trial> {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("data/campaigns/first-look");
    Campaign::read(&folder).expect("the bundled campaign").trials
}

/// Runs a short fit; returns the residuals at its start, and the fitted coordinates.
fn fitted(trials: &[Trial]) -> (Vec<f64>, Vec<f64>) {
    let mut evidence = ScanEvidence::new(trials, None).unwrap();
    let model = CompiledModel::new(&Model::new(evidence.process()), Library::builtin(), evidence.rows()).unwrap();
    evidence.limit_steps(&model).unwrap();
    let residuals = evidence.residuals(&model, Split::Calibration).unwrap();
    let fit = Fit::new(&evidence, &model, evidence.coordinates(&model), FitOptions { derivatives: 1, steps: 2 });
    (residuals, fit.unwrap().at)
}

#[test]
fn changed_evaluation_scans_change_no_fit() {
    let trials = bundled();
    let mut spoilt = trials.clone();
    let mut changed = 0;
    for pass in spoilt.iter_mut().flat_map(|trial| &mut trial.passes).filter(|pass| pass.role == Role::Evaluation) {
        let PassScan::Heights(map) = &mut pass.scan else { panic!("a ground surface") };
        map.heights.iter_mut().enumerate().for_each(|(at, height)| *height += 1e-4 * (at % 7) as f64);
        changed += 1;
    }
    assert!(changed > 0, "the campaign holds passes out");
    assert_eq!(fitted(&trials), fitted(&spoilt), "bit for bit");
}

#[test]
fn evaluation_scans_are_judged_where_asked_for() {
    let trials = bundled();
    let evidence = ScanEvidence::new(&trials, None).unwrap();
    let model = CompiledModel::new(&Model::new(evidence.process()), Library::builtin(), evidence.rows()).unwrap();
    let agreement = evidence.agreement(&model, Split::Evaluation).unwrap();
    println!("{agreement:?}");
    assert!(!agreement.is_empty());
    assert!(agreement.iter().all(|a| a.rms > a.floor && a.floor > 1e-6));
}
