//! Faults of a driver during work: finished results are kept, and one line states the failure and the remedy.

use std::fs;
use std::path::{Path, PathBuf};
use std::process::Command;

use serde_json::Value;
use tempfile::TempDir;
use trials::trial::{Trial, write_trial};

use crate::faulty_driver::{can_be_made, counted, with_faults};
use crate::program::{asset, names, robofin, run};
use crate::trial_road::{simulate, trial, written};

/// Returns a command for a short grinding of the asset's weld on the GPU.
fn grind(passes: &str, out: &Path, flags: &[&str]) -> Command {
    let mut command = robofin(["simulate", "--json", "--backend", "gpu", "--feed-mm-s", "100", "--passes", passes]);
    command.args(flags).arg(asset()).arg("--out").arg(out);
    command
}

/// Makes the plate's trial with its first passes, each cut at this time [s].
fn short_trial(folder: &Path, passes: usize, until: f64) -> PathBuf {
    let (_kept, place) = trial();
    let mut trial = Trial::read(&place).unwrap();
    trial.passes.truncate(passes);
    for pass in &mut trial.passes {
        pass.log.rows.retain(|row| row.time <= until);
        pass.log.temperature.truncate(pass.log.rows.len());
    }
    let place = folder.join(format!("short-{passes}"));
    fs::create_dir(&place).unwrap();
    write_trial(&trial, &place).unwrap();
    place
}

/// Counts the submissions of a run of the first pass alone.
fn submissions(folder: &TempDir, mut first_pass: Command) -> usize {
    let notes = folder.path().join("notes");
    run(with_faults(&mut first_pass, &[("NOTES", notes.to_str().unwrap())])).succeeds();
    let (submissions, refused) = counted(&notes);
    assert!(submissions >= 3 && refused == 0, "{submissions} submissions, {refused} refused allocations");
    submissions
}

/// Returns the submission in the middle of a second pass that has about as many as the first.
fn middle_of_second(first: usize) -> String {
    (first + first.div_ceil(2)).to_string()
}

/// Asserts that a file is the same in two folders.
#[track_caller]
fn same(a: &Path, b: &Path, file: &str) {
    assert_eq!(fs::read(a.join(file)).unwrap(), fs::read(b.join(file)).unwrap(), "{file}");
}

fn json(file: &Path) -> Value {
    serde_json::from_slice(&fs::read(file).unwrap()).unwrap()
}

#[test]
fn a_device_lost_in_the_second_pass_along_a_weld_leaves_the_first_and_can_be_resumed() {
    if !can_be_made("a device lost in the middle of a run") {
        return;
    }
    let folder = tempfile::tempdir().unwrap();
    let out = |name: &str| folder.path().join(name);
    let at = middle_of_second(submissions(&folder, grind("1", &out("one"), &["--snapshot"])));
    let mut two = grind("2", &out("two"), &["--snapshot"]);
    let words = ["two keeps what was good until then: 1 of 2 passes", "--resume", "pass 2: ", "was lost while "];
    let said = run(with_faults(&mut two, &[("LOST_AT", &at)])).is_refused(1, &words);
    assert!(said.contains("the part is as it was before the pass") && said.matches("was lost").count() == 1, "{said}");
    for file in ["ground.nvdb", "pass-1.csv", "state-1.nvdb"] {
        same(&out("one"), &out("two"), file);
    }
    let (one, two) = (json(&out("one").join("grind.json")), json(&out("two").join("grind.json")));
    for key in ["removed_mm3", "weld_left_mm3", "base_removed_mm3", "steps"] {
        assert_eq!(one[key], two[key], "{key}");
    }
    assert!(one["stopped"].is_null() && two["stopped"].as_str().unwrap().contains("pass 2: "), "{two}");
    assert!(!names(&out("two")).contains(&"pass-2.csv".to_owned()));

    let mut on = robofin(["simulate", "--json", "--backend", "cpu", "--feed-mm-s", "100", "--passes", "2", "--resume"]);
    let answer = run(on.arg(out("two")).arg(asset()).arg("--out").arg(out("on"))).succeeds().answer();
    assert_eq!(answer["removed_mm3"][0], one["removed_mm3"][0]);
    assert!(answer["removed_mm3"][1].as_f64().unwrap() > 1.0, "{answer}");
}

#[test]
fn memory_that_runs_out_in_the_second_pass_is_named_in_mib_and_leaves_the_first() {
    if !can_be_made("memory that runs out in the middle of a run") {
        return;
    }
    let folder = tempfile::tempdir().unwrap();
    let out = |name: &str| folder.path().join(name);
    let first = submissions(&folder, grind("1", &out("one"), &[])).to_string();
    let words =
        ["1 of 2 passes", "pass 2: ", "ran out of memory while uploading ", " MiB (trials: 1)", "--backend cpu"];
    run(with_faults(&mut grind("2", &out("two"), &[]), &[("FULL_AT", &first)])).is_refused(1, &words);
    for file in ["ground.nvdb", "pass-1.csv"] {
        same(&out("one"), &out("two"), file);
    }
}

#[test]
fn no_more_is_taken_than_the_share_of_the_memory_that_may_be_used() {
    if !can_be_made("a share of the memory of a device") {
        return;
    }
    let folder = tempfile::tempdir().unwrap();
    let out = folder.path().join("out");
    let with_share = |budget: &str, percent: Option<&str>, words: &[&str]| {
        let mut command = grind("1", &out, &[]);
        command.envs(percent.map(|percent| ("ROBOFIN_GPU_MEMORY_PERCENT", percent)));
        run(with_faults(&mut command, &[("BUDGET_MIB", budget)])).is_refused(1, words);
        assert!(!out.exists());
    };
    let held = "4.0 MiB are held already";
    let uploading = ["pass 1: ", "ran out of memory while uploading ", " MiB (trials: 1)", held, "--backend cpu"];
    with_share("5", None, &[&uploading[..], &["90 % may be used"]].concat());
    with_share("45", Some("10"), &[&uploading[..], &["10 % may be used (ROBOFIN_GPU_MEMORY_PERCENT)"]].concat());
    with_share("64", Some("0"), &["refused to open", "memory", "0 % may be used", "--backend cpu"]);
    with_share("64", Some("101"), &["ROBOFIN_GPU_MEMORY_PERCENT is \"101\"", "0 to 100"]);
    let answer = run(with_faults(&mut robofin(["backends", "--json"]), &[("BUDGET_MIB", "64")])).succeeds().answer();
    assert!(answer["self_check_voxels"].is_number(), "{answer}");
}

#[test]
fn a_trial_keeps_the_passes_before_the_one_in_which_the_device_was_lost() {
    if !can_be_made("a device lost in the middle of a trial") {
        return;
    }
    let folder = tempfile::tempdir().unwrap();
    let out = |name: &str| folder.path().join(name);
    let (one, two) = (short_trial(folder.path(), 1, 0.4), short_trial(folder.path(), 2, 0.4));
    let gpu = ["--backend", "gpu", "--snapshot"];
    let at = middle_of_second(submissions(&folder, simulate(&one, &out("one"), &gpu)));
    let mut command = simulate(&two, &out("two"), &gpu);
    run(with_faults(&mut command, &[("LOST_AT", &at)]))
        .is_refused(1, &["1 of 2 passes", "pass 2: ", "was lost while "]);
    for file in ["after.nvdb", "pass1_log.csv", "pass1_after.csv", "state-1.nvdb"] {
        same(&out("one"), &out("two"), file);
    }
    assert!(json(&out("two").join("simulation.json"))["stopped"].as_str().unwrap().contains("pass 2: "));
    let from = out("two");
    let resumed = ["--backend", "cpu", "--resume", from.to_str().unwrap()];
    let answer = run(&mut simulate(&two, &out("on"), &resumed)).succeeds().answer();
    assert_eq!(answer["removed_by_law_mm3"].as_array().unwrap().len(), 2);
}

#[test]
fn sets_of_a_batch_keep_their_passes_before_the_one_in_which_the_device_was_lost() {
    if !can_be_made("a device lost in the middle of a batch") {
        return;
    }
    let folder = tempfile::tempdir().unwrap();
    let out = |name: &str| folder.path().join(name);
    let (one, two) = (short_trial(folder.path(), 1, 0.4), short_trial(folder.path(), 2, 0.4));
    let table = written(folder.path(), "sets.csv", "name,winkler.stiffness\nsoft,20\nhard,40\n");
    let gpu = ["--backend", "gpu", "--batch", &table];
    let at = middle_of_second(submissions(&folder, simulate(&one, &out("one"), &gpu)));
    let mut command = simulate(&two, &out("two"), &gpu);
    let words = ["2 of 2 runs ended early", "batch.jsonl", "pass 2: ", "was lost while "];
    run(with_faults(&mut command, &[("LOST_AT", &at)])).is_refused(1, &words);
    let lines = |name: &str| -> Vec<Value> {
        let text = fs::read_to_string(out(name).join("batch.jsonl")).unwrap();
        text.lines().map(|line| serde_json::from_str(line).unwrap()).collect()
    };
    for (whole, kept) in lines("one").iter().zip(lines("two")) {
        assert_eq!(whole["removed_by_law_mm3"], kept["removed_by_law_mm3"]);
        assert_eq!(kept["removed_by_law_mm3"].as_array().unwrap().len(), 1, "{kept}");
        assert!(kept["stopped"].as_str().unwrap().contains("was lost while "), "{kept}");
    }
}

#[test]
fn a_picture_names_the_fault_of_its_device() {
    if !can_be_made("a device lost while a picture is drawn") {
        return;
    }
    let folder = tempfile::tempdir().unwrap();
    let pictures = folder.path().join("pictures");
    for (fault, words) in [
        (("LOST_AT", "1"), ["was lost while drawing a picture of 18.8 MiB", "--backend cpu"]),
        (("BUDGET_MIB", "10"), ["ran out of memory while drawing a picture of 18.8 MiB", "a smaller picture"]),
    ] {
        let mut command = robofin(["render", "--backend", "gpu", "--size", "640x480"]);
        command.arg(asset()).arg("--out").arg(&pictures);
        run(with_faults(&mut command, &[fault])).is_refused(1, &words);
        assert!(!pictures.exists());
    }
}
