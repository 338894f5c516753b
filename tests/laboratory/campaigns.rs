//! Hidden effects of the shared campaigns, and of a table.

use std::path::Path;

use effects::{Library, Model};
use lab::{Diagnosis, Evidence, ScanEvidence, Verdict, calibrate_scans};
use trials::trial::Campaign;

use crate::shared_folder::shared;

#[test]
fn a_tilted_wheel_is_named() {
    let Some(place) = shared("campaigns/open-c") else { return };
    let trials = Campaign::read(&place).unwrap().trials;
    let library = Library::builtin();
    let mut evidence = ScanEvidence::new(&trials, None).unwrap();
    let model = Model::new(evidence.process());
    let fit = calibrate_scans(&mut evidence, &model, library).unwrap().last().fit.clone();
    let diagnosis = Diagnosis::new(&evidence, (&model, fit), library, (1, &|_, _, _| {})).unwrap();
    let found = diagnosis.found();
    let best = found.first().expect("something is found");
    let roll = best.suspect.fit.model.index("tool-tilt.roll_angle").expect("the tilt is in the model");
    let roll = best.suspect.fit.model.value(roll);
    println!("{:?}: {} {:.2} mrad, p {:.3}", diagnosis.verdict, best.suspect.name(), roll * 1e3, best.probability);
    assert_eq!(best.suspect.name(), "tool-tilt");
    assert_eq!(diagnosis.verdict, Verdict::Identified);
    assert!((roll / 12e-3 - 1.0).abs() < 0.1, "12 mrad are hidden, {roll} rad found");
}

#[test]
fn a_campaign_that_is_not_there_is_named() {
    let run = std::process::Command::new(env!("CARGO_BIN_EXE_robofin"))
        .args(["diagnose", "no-such-folder", "--out"])
        .arg(Path::new(env!("CARGO_TARGET_TMPDIR")).join("no-diagnosis"))
        .output()
        .unwrap();
    let said = String::from_utf8_lossy(&run.stderr);
    assert!(!run.status.success() && said.contains("no-such-folder"), "{said}");
    assert!(!Path::new(env!("CARGO_TARGET_TMPDIR")).join("no-diagnosis").exists());
}
