//! The verbs `calibrate` and `study`: results, files that stay unchanged, and refusals.

use std::fs;
use std::path::{Path, PathBuf};
use std::process::{Command, Output};

use serde_json::Value;
use trials::table::Table;
use trials::trial::Role;

/// Writes a table whose removal grows with the pressure to the power of 0.75, in a folder of its own.
fn belt(place: &Path) -> PathBuf {
    let (from, to) =
        (Path::new(env!("CARGO_MANIFEST_DIR")).join("data/tables/belt-sanding"), place.join("belt-sanding"));
    fs::create_dir(&to).unwrap();
    for file in ["table.toml", "trials.csv"] {
        fs::copy(from.join(file), to.join(file)).unwrap();
    }
    to
}

fn robofin(args: &[&str], place: &Path) -> Output {
    Command::new(env!("CARGO_BIN_EXE_robofin")).args(args).current_dir(place).output().unwrap()
}

/// Runs a verb with `--json` and returns its answer.
fn answer(args: &[&str], place: &Path) -> Value {
    let run = robofin(&[args, &["--json"]].concat(), place);
    assert!(run.status.success(), "{args:?}: {}", String::from_utf8_lossy(&run.stderr));
    serde_json::from_slice(&run.stdout).unwrap()
}

fn steps(answer: &Value) -> Vec<(String, f64, f64)> {
    let number = |step: &Value, key: &str| step[key].as_f64().unwrap();
    let steps = answer["waterfall"].as_array().unwrap().iter();
    let step = |s: &Value| {
        let name = s["step"].as_str().unwrap().to_owned();
        (name, number(s, "calibration_rms"), number(s, "evaluation_rms"))
    };
    steps.map(step).collect()
}

#[test]
fn an_added_effect_is_one_more_step_and_the_error_falls() {
    let place = tempfile::tempdir().unwrap();
    let place = place.path();
    belt(place);
    let base = steps(&answer(&["calibrate", "belt-sanding", "--out", "base"], place));
    assert!(robofin(&["effects", "add", "base/model.toml", "pressure-exponent"], place).status.success());
    let with = answer(&["calibrate", "belt-sanding", "--model", "base/model.toml", "--out", "with"], place);
    let after = steps(&with);
    println!("{base:?}\n{after:?}");
    let names = |steps: &[(String, f64, f64)]| steps.iter().map(|step| step.0.clone()).collect::<Vec<_>>();
    assert_eq!(names(&base), ["not calibrated", "base model"]);
    assert_eq!(names(&after), ["not calibrated", "base model", "+ pressure-exponent"]);
    assert!((after[1].1 / base[1].1 - 1.0).abs() < 1e-3, "the base step is that of the calibration before");
    assert!(after[2].1 < 0.7 * after[1].1 && after[2].2 < 0.7 * after[1].2, "the error falls in both splits");
    let exponent = with["parameters"].as_array().unwrap().iter().find(|p| p["name"] == "pressure-exponent.exponent");
    let exponent = exponent.expect("the exponent is fitted");
    let [low, high] = [0, 1].map(|end| exponent["interval"][end].as_f64().unwrap());
    assert!(low < 0.75 && 0.75 < high, "0.75 made the table: {exponent}");
    let model = fs::read_to_string(place.join("with/model.toml")).unwrap();
    assert!(model.contains("[effect.pressure-exponent]"), "{model}");
    let page = fs::read_to_string(place.join("with/report.html")).unwrap();
    assert!(page.contains("+ pressure-exponent") && page.contains("not calibrated"));
}

#[test]
fn evaluation_rows_move_no_calibrated_value() {
    let place = tempfile::tempdir().unwrap();
    let place = place.path();
    let table = belt(place).join("trials.csv");
    let first = answer(&["calibrate", "belt-sanding", "--out", "first"], place);
    let text = fs::read_to_string(&table).unwrap();
    let mut lines: Vec<String> = text.lines().map(str::to_owned).collect();
    let rows = Table::read(table.parent().unwrap()).unwrap().rows;
    for row in rows.iter().filter(|row| row.role == Role::Evaluation).map(|row| row.line as usize - 1) {
        let mut cells: Vec<String> = lines[row].split(',').map(str::to_owned).collect();
        cells[5] = format!("{:.4}", 1.5 * cells[5].parse::<f64>().unwrap());
        lines[row] = cells.join(",");
    }
    fs::write(&table, lines.join("\n") + "\n").unwrap();
    let second = answer(&["calibrate", "belt-sanding", "--out", "second"], place);
    let model = |folder: &str| fs::read_to_string(place.join(folder).join("model.toml")).unwrap();
    assert_eq!(model("first"), model("second"), "byte for byte");
    let held_out = |answer: &Value| steps(answer).last().unwrap().2;
    println!("{:.2} %, spoilt {:.2} %", held_out(&first), held_out(&second));
    assert!(held_out(&second) > 1.3 * held_out(&first), "the evaluation rows are judged");
}

#[test]
fn a_study_taken_step_by_step_ends_as_the_whole_one() {
    let place = tempfile::tempdir().unwrap();
    let place = place.path();
    let table = belt(place).join("trials.csv");
    let whole = answer(&["study", "belt-sanding", "--out", "whole"], place);
    let one = ["study", "belt-sanding", "--out", "single", "--step"];
    let mut last = answer(&one, place);
    let mut count = 1;
    while !last["next"].is_null() {
        assert!(last["ended"].is_null());
        last = answer(&one, place);
        count += 1;
        assert!(count < 20, "{last}");
    }
    let done = |answer: &Value| -> Vec<String> {
        answer["done"].as_array().unwrap().iter().map(|d| d["action"].as_str().unwrap().to_owned()).collect()
    };
    assert_eq!(done(&whole)[..5], ["compare", "calibrate", "diagnose", "add", "calibrate"]);
    assert_eq!(done(&last), done(&whole));
    for key in ["verdict", "added", "sentence", "ended"] {
        assert_eq!(last[key], whole[key], "{key}");
    }
    let diagnosis = answer(&["diagnose", "belt-sanding", "--out", "diagnosis"], place);
    assert_eq!(whole["verdict"], diagnosis["verdict"], "one search at a time says what all at once say");
    assert_eq!(whole["added"][0], "pressure-exponent");
    let again = robofin(&one, place);
    assert!(again.status.success() && String::from_utf8_lossy(&again.stderr).contains("pressure-exponent"));

    fs::write(&table, fs::read_to_string(&table).unwrap().replace("0.0310", "0.0311")).unwrap();
    let other = robofin(&one, place);
    let said = String::from_utf8_lossy(&other.stderr).into_owned();
    assert!(
        other.status.code() == Some(2) && said.contains("other measurements") && said.contains("--force"),
        "{said}"
    );
    assert!(place.join("single/study.json").is_file(), "the study is still there");
}

#[test]
fn a_study_in_the_folder_of_its_measurements_goes_on() {
    let place = tempfile::tempdir().unwrap();
    let place = place.path();
    belt(place);
    let step = |out: &str| answer(&["study", "belt-sanding", "--out", out, "--step"], place);
    let first = step("belt-sanding/study");
    let second = step("belt-sanding/study");
    assert_eq!((&first["next"], &second["next"]), (&Value::from("calibrate"), &Value::from("diagnose")));
    assert_eq!(first["measurements_sha256"], second["measurements_sha256"]);
    assert_eq!(step("elsewhere")["measurements_sha256"], first["measurements_sha256"], "results are no measurements");
}

#[test]
fn a_study_that_fails_before_its_first_simulation_leaves_nothing() {
    let place = tempfile::tempdir().unwrap();
    let place = place.path();
    let made = robofin(&["trial", "synth", "--plan", "paper", "--size", "small", "--out", "trials"], place);
    assert!(made.status.success());
    let failed = robofin(&["study", "trials", "--out", "study", "--model", "no-such-model.toml"], place);
    assert_eq!(failed.status.code(), Some(2));
    let left: Vec<_> = fs::read_dir(place).unwrap().map(|entry| entry.unwrap().file_name()).collect();
    assert_eq!(left, ["trials"], "{}", String::from_utf8_lossy(&failed.stderr));
}

#[test]
fn nothing_is_overwritten_and_nothing_is_left_of_what_failed() {
    let place = tempfile::tempdir().unwrap();
    let place = place.path();
    for verb in ["calibrate", "study"] {
        let run = robofin(&[verb, "no-such-folder", "--out", "result"], place);
        let said = String::from_utf8_lossy(&run.stderr).into_owned();
        assert!(run.status.code() == Some(1) && said.contains("no-such-folder"), "{said}");
        fs::create_dir(place.join(verb)).unwrap();
        fs::write(place.join(verb).join("thesis.txt"), "years of work").unwrap();
        for force in [&[][..], &["--force"]] {
            let run = robofin(&[&[verb, "no-such-folder", "--out", verb], force].concat(), place);
            assert_eq!(run.status.code(), Some(2), "{}", String::from_utf8_lossy(&run.stderr));
        }
    }
    let order = robofin(&["calibrate", "no-such-folder", "--out", "result", "--order", "random"], place);
    assert!(order.status.code() == Some(2) && String::from_utf8_lossy(&order.stderr).contains("staged"));
    assert!(!place.join("result").exists());
}
