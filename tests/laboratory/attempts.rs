//! Attempts: a formula becomes an effect, both models are compared, and the ledger records the result.

use std::fs;
use std::path::Path;
use std::process::{Command, Output};

use serde_json::Value;

fn robofin(folder: &Path, words: &[&str]) -> Output {
    Command::new(env!("CARGO_BIN_EXE_robofin")).current_dir(folder).args(words).output().expect("the program runs")
}

fn answer(folder: &Path, words: &[&str]) -> Value {
    let output = robofin(folder, &[words, &["--json"]].concat());
    assert!(output.status.success(), "{words:?}: {}", String::from_utf8_lossy(&output.stderr));
    serde_json::from_slice(&output.stdout).expect("JSON")
}

fn refused(folder: &Path, words: &[&str]) -> String {
    let output = robofin(folder, words);
    let told = String::from_utf8_lossy(&output.stderr).into_owned();
    assert_eq!(output.status.code(), Some(2), "{words:?}: {told}");
    told
}

/// Makes a small campaign whose tool dulls by 1/e after 60 mm³; only its first trial begins with a fresh tool.
fn dulling(folder: &Path) {
    let synth = ["trial", "synth", "--size", "small", "--seed", "11", "--out", "trials"];
    let output = robofin(folder, &[&synth[..], &["--effect", "grit-dulling:dulling_volume=60 mm^3"]].concat());
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
}

fn parameter<'a>(answer: &'a Value, name: &str) -> &'a Value {
    let all = answer["parameters"].as_array().expect("parameters");
    all.iter().find(|parameter| parameter["name"] == name).unwrap_or_else(|| panic!("no {name} in {all:?}"))
}

#[test]
fn a_formula_is_fitted_compared_and_kept() {
    let place = tempfile::tempdir().expect("a folder");
    let folder = place.path();
    dulling(folder);
    let right = answer(folder, &["try", "trials", "rate * exp(-ground_volume / a)", "--keep"]);
    let a = parameter(&right, "try-1.a");
    println!("{right:#}");
    assert!((a["value"].as_f64().expect("a value") - 60.0).abs() < 6.0, "{a}");
    assert_eq!((a["unit"].as_str(), right["better"].as_str()), (Some("mm^3"), Some("second")));
    let split = &right["held_out"];
    assert!(split["rms"][1].as_f64() < split["rms"][0].as_f64());
    assert!(right["predicts_better_by"].as_f64() > Some(10.0));

    let nothing = answer(folder, &["try", "trials", "rate * (1 + b * tool_y / 10 [mm])", "--set", "b=0.01"]);
    assert_eq!((nothing["beside"].as_u64(), nothing["number"].as_u64()), (Some(1), Some(2)));
    assert_ne!(nothing["better"], "second", "{nothing:#}");

    let ledger = answer(folder, &["ledger", "trials-ledger"]);
    assert_eq!(ledger["current"]["number"], 1);
    assert_eq!(ledger["attempts"].as_array().map(Vec::len), Some(2));
    let back = answer(folder, &["ledger", "trials-ledger", "--to", "0"]);
    assert_eq!(back["current"]["number"], 0);
    for file in ["0/model.toml", "1/model.toml", "1/report.html", "2/report.html", "effects/try-1.toml"] {
        assert!(folder.join("trials-ledger").join(file).is_file(), "{file}");
    }
    let lines = fs::read_to_string(folder.join("trials-ledger/ledger.jsonl")).expect("the ledger");
    assert_eq!(lines.lines().count(), 3);

    let pair = answer(
        folder,
        &[
            "compare",
            "trials",
            "--model",
            "trials-ledger/0/model.toml",
            "--model",
            "trials-ledger/1/model.toml",
            "--effects",
            "trials-ledger/effects",
            "--out",
            "pair",
        ],
    );
    assert_eq!(pair["better"], "second", "{pair:#}");
}

#[test]
fn what_cannot_be_tried_is_refused_and_nothing_is_written() {
    let place = tempfile::tempdir().expect("a folder");
    let folder = place.path();
    let campaign = Path::new(env!("CARGO_MANIFEST_DIR")).join("data/campaigns/first-look");
    let campaign = campaign.to_str().expect("a path");
    for (words, said) in [
        (vec!["rate * (1 + a"], "at character 14"),
        (vec!["rate * exp(-ground_volum / a)"], "did you mean `ground_volume`"),
        (vec!["dose_rate * (1 + a)"], "no value of grinding"),
        (vec!["rate * (1 + a * ground_volume)", "--set", "b=1"], "no parameter of the formula"),
        (vec!["rate * (1 + a)", "--set", "a=much"], "VALUE UNIT"),
        (vec!["--effect", "grit-duling"], "did you mean `grit-dulling`"),
        (vec!["absent.toml"], "no such file"),
        (vec!["--effect", "grit-dulling", "rate * a"], "cannot be used with"),
    ] {
        let told = refused(folder, &[&["try", campaign], &words[..]].concat());
        assert!(told.contains(said), "{words:?}: {told}");
    }
    let table = Path::new(env!("CARGO_MANIFEST_DIR")).join("data/tables/belt-sanding");
    let output = robofin(folder, &["try", table.to_str().expect("a path"), "--effect", "tool-tilt"]);
    let told = String::from_utf8_lossy(&output.stderr);
    assert_eq!(output.status.code(), Some(1), "{told}");
    assert!(told.contains("tool-tilt: these data cannot show it: acts only across the surface"), "{told}");
    let told = refused(folder, &["ledger", "nowhere"]);
    assert!(told.contains("no ledger"), "{told}");
    fs::create_dir(folder.join("mine")).expect("a folder");
    fs::write(folder.join("mine/notes.txt"), "mine").expect("a file");
    let told = refused(folder, &["try", campaign, "--effect", "grit-dulling", "--ledger", "mine"]);
    assert!(told.contains("holds no ledger.jsonl"), "{told}");
    assert_eq!(fs::read_dir(folder.join("mine")).expect("a folder").count(), 1);
    assert!(!folder.join("first-look-ledger/ledger.jsonl").exists());
}
