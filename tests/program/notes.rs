//! Notes on implausible files: reported to people and in JSON alike, and refusals with file, key and remedy.

use std::fs;
use std::path::{Path, PathBuf};

use serde_json::Value;

use crate::program::{Outcome, robofin, run};
use crate::trial_road::{simulate, trial};

fn bundled(name: &str) -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("data").join(name)
}

fn changed(place: &Path, change: impl Fn(&str) -> String) {
    let file = place.join("trial.toml");
    let text = fs::read_to_string(&file).unwrap();
    fs::write(file, change(&text)).unwrap();
}

/// Returns the notes of a JSON answer; asserts that standard error shows the same ones.
#[track_caller]
fn notes(outcome: &Outcome, label: &str) -> Vec<String> {
    let answer = outcome.answer();
    let notes: Vec<String> =
        answer["notes"].as_array().expect("notes").iter().map(|note: &Value| note.as_str().unwrap().into()).collect();
    for note in &notes {
        assert!(outcome.stderr.contains(&format!("{label}  {note}")), "{note:?} is missing in: {}", outcome.stderr);
    }
    notes
}

#[test]
fn notes_on_a_trial_are_in_the_answer_of_simulate() {
    let (folder, place) = trial();
    changed(&place, |text| {
        text.lines().filter(|line| !line.starts_with("feed_mm_s")).map(|l| format!("{l}\n")).collect()
    });
    let outcome = run(&mut simulate(&place, &folder.path().join("out"), &[])).succeeds();
    let notes = notes(&outcome, "trial");
    assert!(notes.contains(&"pass1_log.csv: feed_mm_s is not given and taken from here".to_owned()), "{notes:?}");
}

#[test]
fn notes_on_measurements_are_in_the_answers_of_all_verbs_that_read_them() {
    let folder = tempfile::tempdir().unwrap();
    for verb in [&["compare"][..], &["calibrate"], &["diagnose"], &["study", "--step"]] {
        let mut command = robofin(verb);
        command.arg("--json").arg(bundled("tables/belt-sanding")).arg("--out").arg(folder.path().join(verb[0]));
        let notes = notes(&run(&mut command).succeeds(), "note");
        assert!(notes.iter().any(|note| note.contains("72 rows")), "{verb:?}: {notes:?}");
    }
    let mut command = robofin(["compare", "--json"]);
    let slow = folder.path().join("slow");
    fs::create_dir(&slow).unwrap();
    for entry in fs::read_dir(bundled("campaigns/first-look/trial-1")).unwrap() {
        let entry = entry.unwrap();
        fs::copy(entry.path(), slow.join(entry.file_name())).unwrap();
    }
    changed(&slow, |text| text.replace("feed_mm_s = 10", "feed_mm_s = 20"));
    let outcome = run(command.arg(&slow).arg("--out").arg(folder.path().join("out"))).succeeds();
    let notes = notes(&outcome, "note");
    assert!(notes.iter().any(|note| note.contains("where the feed is 20 mm/s")), "{notes:?}");
    let answer = outcome.answer();
    let rejects = answer["tests"].as_array().unwrap().iter().any(|test| test["rejects"] == true);
    assert_eq!(answer["agrees"], Value::Bool(!rejects));
}

#[test]
fn a_trial_without_a_repeated_scan_is_compared_and_the_source_of_its_noise_is_said() {
    let folder = tempfile::tempdir().unwrap();
    let place = folder.path().join("plate");
    fs::create_dir(&place).unwrap();
    for entry in fs::read_dir(bundled("campaigns/first-look/trial-1")).unwrap() {
        let entry = entry.unwrap();
        fs::copy(entry.path(), place.join(entry.file_name())).unwrap();
    }
    changed(&place, |text| text.replace("repeat = [\"before_repeat.csv\"]\n", ""));
    let mut command = robofin(["compare", "--json"]);
    let outcome = run(command.arg(&place).arg("--out").arg(folder.path().join("out"))).succeeds();
    let notes = notes(&outcome, "note");
    assert!(notes.iter().any(|note| note.contains("no repeated scan: its noise is taken from")), "{notes:?}");
    assert_eq!(outcome.answer()["noise"][0]["source"]["kind"], "untouched");
}

#[test]
fn a_tool_above_the_surface_is_refused_with_its_gap() {
    let (folder, place) = trial();
    changed(&place, |text| text.replace("radius_mm = 20", "radius_mm = 10"));
    let words = [
        "pass1_log.csv",
        "10.00 mm above the surface of before.csv",
        "radius_mm = 10 of trial.toml is half of the radius",
    ];
    run(&mut simulate(&place, &folder.path().join("out"), &[])).is_refused(1, &words);
    changed(&place, |text| text.replace("radius_mm = 10.0", "radius_mm = 19.7"));
    let outcome = run(&mut simulate(&place, &folder.path().join("near"), &[])).succeeds();
    assert!(notes(&outcome, "trial").iter().any(|note| note.contains("lies 0.30 mm above the surface of before.csv")));
    fs::copy(place.join("before.csv"), place.join("before_repeat.csv")).unwrap();
    changed(&place, |text| {
        text.replace("before = \"before.csv\"\n", "before = \"before.csv\"\nrepeat = [\"before_repeat.csv\"]\n")
    });
    let words = ["before_repeat.csv", "the same heights as before.csv"];
    run(robofin(["compare"]).arg(&place).arg("--out").arg(folder.path().join("c"))).is_refused(1, &words);
    let again = |text: String| text.replace("0.8,", "0.801,");
    let text = fs::read_to_string(place.join("before.csv")).unwrap();
    fs::write(place.join("before_repeat.csv"), again(text)).unwrap();
    let words = ["pass 1", "0.30 mm or more above the scan `before`", "0.1 mm"];
    run(robofin(["compare"]).arg(&place).arg("--out").arg(folder.path().join("c"))).is_refused(1, &words);
}
