//! Making a trial from scans and logs, and files of instruments and robots in other formats, as a user does it.

use std::fs;
use std::path::{Path, PathBuf};

use trials::trial::read_log;

use crate::program::{asset, robofin, run};
use crate::trial_road::trial;

/// Writes the files of a valid trial without its `trial.toml`.
fn files_alone(folder: &Path) -> PathBuf {
    let bundled = Path::new(env!("CARGO_MANIFEST_DIR")).join("data/campaigns/first-look/trial-1");
    let place = folder.join("plate");
    fs::create_dir(&place).unwrap();
    for name in ["before.csv", "before_repeat.csv", "pass1_after.csv", "pass1_log.csv"] {
        fs::copy(bundled.join(name), place.join(name)).unwrap();
    }
    place
}

#[test]
fn init_writes_once_and_check_says_what_is_wrong_and_what_is_not() {
    let folder = tempfile::tempdir().unwrap();
    let place = files_alone(folder.path());
    let printed = run(robofin(["trial", "init", "--print"]).arg(&place)).succeeds();
    assert!(printed.stdout.contains("pitch_mm = 0.0   # FILL IN") && !place.join("trial.toml").exists());
    let answer = run(robofin(["trial", "init", "--json"]).arg(&place)).succeeds().answer();
    assert_eq!(answer["text"].as_str(), Some(printed.stdout.as_str()));
    let open: Vec<&str> = answer["open"].as_array().unwrap().iter().map(|open| open.as_str().unwrap()).collect();
    assert!(open.contains(&"[scan] pitch_mm"), "{open:?}");
    run(robofin(["trial", "init"]).arg(&place)).is_refused(1, &["trial.toml", "this file exists", "--print"]);

    // Keys marked FILL IN are refused with their line until they have a value.
    let out = folder.path().join("check");
    let mut check = robofin(["trial", "check", "--json"]);
    run(check.arg(&place).arg("--out").arg(&out)).is_refused(1, &["trial.toml, line", "pitch_mm is 0"]);
    let file = place.join("trial.toml");
    let text = fs::read_to_string(&file).unwrap();
    let said = |radius: &str| {
        let lines = text.lines().map(|line| match line.split(' ').next() {
            Some("pitch_mm") => "pitch_mm = 0.3\n".to_owned(),
            Some("origin_mm") => "origin_mm = [0.0, -7.2]\n".to_owned(),
            Some("radius_mm") => format!("radius_mm = {radius}\n"),
            Some("width_mm") => "width_mm = 20.0\n".to_owned(),
            _ => format!("{line}\n"),
        });
        fs::write(&file, lines.collect::<String>()).unwrap();
    };
    said("25.0");
    let answer = run(robofin(["trial", "check", "--json"]).arg(&place).arg("--out").arg(&out)).succeeds().answer();
    assert_eq!(answer["usable"], false);
    let refused = |answer: &serde_json::Value| answer["trials"][0]["refused"].as_u64();
    assert!(refused(&answer) > Some(0), "{answer}");
    said("50.0");
    let mut again = robofin(["trial", "check", "--json", "--force"]);
    let answer = run(again.arg(&place).arg("--out").arg(&out)).succeeds().answer();
    assert_eq!((answer["usable"].as_bool(), refused(&answer)), (Some(true), Some(0)), "{answer}");
    let page = fs::read_to_string(out.join("report.html")).unwrap();
    for words in ["All checks pass", "What will be used", "the logged force presses the tool on", "Tool on the surface"]
    {
        assert!(page.contains(words), "no {words:?} on the page");
    }
}

#[test]
fn check_goes_on_after_the_first_refusal() {
    let (folder, place) = trial();
    let file = place.join("trial.toml");
    let text = fs::read_to_string(&file).unwrap();
    fs::write(&file, text.replace("radius_mm = 20", "radius_mm = 10").replace("feed_mm_s = 5", "feed_mm_s = 500"))
        .unwrap();
    let out = folder.path().join("check");
    let answer = run(robofin(["trial", "check", "--json"]).arg(&place).arg("--out").arg(&out)).succeeds().answer();
    let checks = answer["trials"][0]["checks"].as_array().unwrap();
    let refusing: Vec<&str> = checks
        .iter()
        .filter(|check| check["findings"].as_array().unwrap().iter().any(|found| found["severity"] == "refused"))
        .map(|check| check["check"].as_str().unwrap())
        .collect();
    assert!(refusing.contains(&"readings") && refusing.contains(&"contact"), "{refusing:?}");
}

#[test]
fn scans_are_converted_and_nothing_is_replaced() {
    let folder = tempfile::tempdir().unwrap();
    let source = Path::new(env!("CARGO_MANIFEST_DIR")).join("instruments/tests/files/gwyddion.gwy");
    let summary = |place: &Path| run(robofin(["convert", "--json"]).arg(place)).succeeds().answer()["summary"].clone();
    let original = summary(&source);
    assert!(original.as_str().unwrap().starts_with("24 x 17 pixels, 0.005 x 0.004 mm apart"), "{original}");
    let out = folder.path().join("map.x3p");
    run(robofin(["convert"]).arg(&source).arg("--out").arg(&out)).succeeds();
    assert_eq!(summary(&out), original);
    run(robofin(["convert"]).arg(&source).arg("--out").arg(&out)).is_refused(2, &["map.x3p", "is not replaced"]);
    run(robofin(["convert"]).arg(&source).arg("--out").arg(folder.path().join("map.png")))
        .is_refused(1, &["png", "sur"]);
    run(robofin(["convert"]).arg(folder.path().join("absent.sur"))).is_refused(1, &["absent.sur"]);
}

#[test]
fn a_path_is_written_as_a_program_and_read_again() {
    let folder = tempfile::tempdir().unwrap();
    let place = |name: &str| folder.path().join(name);
    let plan = |out: &Path| run(robofin(["path"]).arg(asset()).args(["--weld", "1", "--out"]).arg(out)).succeeds();
    plan(&place("weld.csv"));
    let planned = read_log(&place("weld.csv")).unwrap().content;
    for name in ["weld.src", "weld.mod", "weld.script"] {
        plan(&place(name));
        let back = place(&format!("{name}.csv"));
        run(robofin(["convert"]).arg(place(name)).arg("--out").arg(&back)).succeeds();
        let read = read_log(&back).unwrap().content;
        assert!(read.rows.len() < planned.rows.len(), "{name}: straight stretches are two points");
        let (first, last) = (planned.rows.first().unwrap(), planned.rows.last().unwrap());
        let (start, end) = (read.rows.first().unwrap(), read.rows.last().unwrap());
        assert!(
            start.position.distance(first.position) < 1e-6 && end.position.distance(last.position) < 1e-6,
            "{name}"
        );
        assert!(end.approach.distance(last.approach) < 1e-4, "{name}: {} for {}", end.approach, last.approach);
        assert!((end.time / last.time - 1.0).abs() < 0.05, "{name}: {} for {} s", end.time, last.time);
    }
}
