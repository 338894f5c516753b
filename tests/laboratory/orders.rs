//! Joint and staged order of a calibration, on one trial of two passes.

use effects::{Library, Model};
use lab::{Calibration, CalibrationSummary, Evidence, Order, ScanEvidence, Split, Totals, uncalibrated};
use study::Maps;
use study::{CalibrationReport, Data, calibration_report};
use trials::trial::{Campaign, PassScan, Role, Trial};

use crate::unseen::bundled;

/// Reads the first trial of the bundled campaign, with its second pass held out.
fn one_trial() -> Vec<Trial> {
    let mut trials = bundled();
    trials.truncate(1);
    trials[0].passes[1].role = Role::Evaluation;
    trials
}

fn calibrated(evidence: &ScanEvidence, order: Order) -> Calibration {
    let (model, library) = (Model::new(evidence.process()), Library::builtin());
    let start = uncalibrated(&model, library, evidence).unwrap();
    Calibration::new(evidence, (&model, &start), library, (order, &|_| {})).unwrap()
}

#[test]
fn the_staged_order_fits_the_volume_first_and_loses_it_again() {
    let trials = one_trial();
    let evidence = ScanEvidence::new(&trials, None).unwrap();
    let [joint, staged] = [Order::Joint, Order::Staged].map(|order| calibrated(&evidence, order));
    let totals = &staged.last().staged.as_ref().unwrap().totals;
    let [first, second] = totals.each_ref().map(|totals| totals[0].error());
    println!(
        "volume error after the first stage {:+.4} %, after the second {:+.4} %",
        100.0 * first.0,
        100.0 * second.0
    );
    assert!(first.0.abs() < 2e-4, "the rate meets the volume: {first:?}");
    let chi2 = |calibration: &Calibration| calibration.last().fit.chi2;
    println!("χ² joint {:.1}, staged {:.1}", chi2(&joint), chi2(&staged));
    assert!(chi2(&joint) <= chi2(&staged) + 1.0, "no order describes the profiles better than the joint one");
    let names: Vec<String> = staged.last().estimates().iter().map(|e| e.coordinate.slot.name()).collect();
    assert!(names[0].ends_with("grind_rate") && names.len() == joint.last().estimates().len(), "{names:?}");
    let summary = CalibrationSummary::new(&evidence, &staged, Library::builtin()).unwrap();
    assert!(summary.remarks.iter().any(|remark| remark.starts_with("staged order")), "{:?}", summary.remarks);
}

#[test]
fn a_scan_held_out_moves_no_calibrated_value() {
    let trials = one_trial();
    let mut spoilt = trials.clone();
    let PassScan::Heights(map) = &mut spoilt[0].passes[1].scan else { panic!("a ground surface") };
    map.heights.iter_mut().enumerate().for_each(|(at, height)| *height += 1e-4 * (at % 7) as f64);
    // The staged order uses totals and profiles; the test `unseen` covers profiles alone.
    let values = |trials: &[Trial]| {
        let evidence = ScanEvidence::new(trials, None).unwrap();
        let calibration = calibrated(&evidence, Order::Staged);
        let held_out = evidence.totals(&calibration.last().fit.model, Split::Evaluation).unwrap();
        (calibration.last().fit.model.values().to_vec(), held_out[0].measured)
    };
    let ((clean, volume), (same, other)) = (values(&trials), values(&spoilt));
    assert_eq!(clean, same, "bit for bit");
    assert_ne!(volume, other, "the scan was spoilt where it is judged");
}

#[test]
fn the_waterfall_begins_with_the_scans_as_they_came() {
    let trials = one_trial();
    let evidence = ScanEvidence::new(&trials, None).unwrap();
    let calibration = calibrated(&evidence, Order::Joint);
    let summary = CalibrationSummary::new(&evidence, &calibration, Library::builtin()).unwrap();
    let names: Vec<&str> = summary.waterfall.iter().map(|step| step.step.as_str()).collect();
    assert_eq!(names, ["raw", "registered", "base model"]);
    let errors: Vec<f64> = summary.waterfall.iter().map(|step| step.calibration_rms).collect();
    println!("{errors:?} m, floor {:e} m", summary.noise_floor);
    assert!(errors.windows(2).all(|pair| pair[1] < pair[0]), "each step lowers the error: {errors:?}");
    assert!(summary.waterfall.iter().all(|step| step.evaluation_rms.is_some()));
    assert_eq!(summary.removal.len(), 2, "one calibration scan and one held out");
}

#[test]
fn the_page_states_one_error_of_a_volume_one_scan_noise_and_the_floor_of_either_kind_of_passes() {
    let folder = std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join("data/campaigns/first-look");
    let campaign = Campaign { trials: one_trial(), ..Campaign::read(&folder).unwrap() };
    let evidence = ScanEvidence::new(&campaign.trials, None).unwrap();
    let calibration = calibrated(&evidence, Order::Joint);
    let summary = CalibrationSummary::new(&evidence, &calibration, Library::builtin()).unwrap();
    let data = Data::Scans(&campaign, Box::new(evidence));
    let report = calibration_report(&CalibrationReport {
        data: &data,
        calibration: &calibration,
        summary: &summary,
        waterfall: &summary.waterfall,
        rival: None,
        verdict: None,
        sentence: String::new(),
        seed: 0,
        answer: serde_json::Value::Null,
    })
    .unwrap();
    let [.., base, floor] = &report.waterfall.steps[..] else { panic!("a base model above the floor") };
    assert_eq!(report.volumes.len(), 2);
    assert_eq!(report.waterfall.passes.len(), 2);
    for (volume, error) in report.volumes.iter().zip(&base.volume_errors) {
        let (error, sigma) = error.expect("the base model has an error for each pass");
        println!("{}: {:.3} % ± {:.3} %", volume.pass, 100.0 * error, 100.0 * sigma);
        assert_eq!(error, (volume.base - volume.measured) / volume.measured, "{}", volume.pass);
        assert_eq!(sigma, volume.uncertainty / volume.measured, "{}", volume.pass);
    }
    let floors = [floor.calibration, floor.evaluation].map(|floor| floor.expect("both kinds have a floor"));
    assert!((floors[0] - summary.noise_floor).abs() < 1e-15, "{floors:?}");
    assert!((floors[1] - summary.evaluation_noise_floor.unwrap()).abs() < 1e-15, "{floors:?}");
    for (pass, scan) in report.compared.passes.iter().zip(&report.scans) {
        let Maps::Heights(maps) = &scan.maps else { panic!("a ground surface") };
        assert_eq!(pass.noise_floor, Some(maps.noise_floor), "{}", pass.name);
    }
}
