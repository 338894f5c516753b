//! `--backend` and `--batch`: the same results on every backend, and a clear refusal where a trial cannot run.

use std::fs;
use std::path::{Path, PathBuf};
use std::process::Command;

use sdf_bake::{BrickGrid, nvdb};
use serde_json::Value;
use shaders::choice::DRIVER_PACKAGE;
use tempfile::TempDir;
use trials::trial::{Trial, write_trial};

use crate::program::{names, robofin, run};
use crate::trial_road::{BREAKING, simulate, trial, written};

const SOFT: &str = "process = \"grinding\"\n[law.winkler]\nstiffness = \"20 MPa/mm\"\n[law.preston-threshold]\ngrind_rate = \"1.4 mm/(MPa s)\"\n";
const TABLE: &str = "name,winkler.stiffness,preston-threshold.grind_rate\nsoft,20,1.4\nhard,40,1.1\n";

/// Makes the plate's trial with its first pass cut at this time [s].
fn short_trial(until: f64) -> (TempDir, PathBuf) {
    let (folder, place) = trial();
    let mut trial = Trial::read(&place).unwrap();
    trial.passes.truncate(1);
    let log = &mut trial.passes[0].log;
    log.rows.retain(|row| row.time <= until);
    log.temperature.truncate(log.rows.len());
    let place = folder.path().join("short");
    fs::create_dir(&place).unwrap();
    write_trial(&trial, &place).unwrap();
    (folder, place)
}

/// Returns true if there is an adapter; otherwise reports the skipped test.
fn has_adapter(untested: &str) -> bool {
    shaders::testing::device(untested).is_some()
}

/// Runs on any adapter, with Mesa's messages on the session suppressed.
fn on_device(trial: &Path, out: &Path, flags: &[&str]) -> Command {
    let mut command = simulate(trial, out, &[&["--backend", "gpu"], flags].concat());
    command.env("NODEVICE_SELECT", "1");
    command
}

/// Hides all drivers from a command.
fn without_drivers(mut command: Command) -> Command {
    command
        .env("VK_DRIVER_FILES", "/nonexistent")
        .env("VK_ICD_FILENAMES", "/nonexistent")
        .env("WGPU_BACKEND", "vulkan");
    command
}

fn field(folder: &Path) -> BrickGrid {
    nvdb::read(&fs::read(folder.join("after.nvdb")).unwrap()).unwrap().to_field().unwrap()
}

/// Returns the greatest difference of φ [voxels], bricks in only one of the fields included.
fn apart(a: &BrickGrid, b: &BrickGrid) -> f64 {
    let one_way = |from: &BrickGrid, other: &BrickGrid| {
        let apart = |(at, phi): (usize, &f32)| f64::from((phi - other.phi_at(from.voxel_of(at))).abs()) / from.voxel;
        from.phi.iter().enumerate().map(apart).fold(0.0, f64::max)
    };
    one_way(a, b).max(one_way(b, a))
}

/// Asserts agreement within a thousandth; for the force error, which is a difference itself, within a thousandth of the
/// setpoint.
#[track_caller]
fn agree(a: &Value, b: &Value) {
    for key in ["removed_by_law_mm3", "coating_mm3", "impulse_ns", "residual_rms_um", "force_rms_error_n", "steps"] {
        let numbers = |value: &Value| -> Vec<f64> {
            let list = value[key].as_array().cloned().unwrap_or_else(|| vec![value[key].clone()]);
            list.iter().map(|number| number.as_f64().unwrap()).collect()
        };
        let (one, other) = (numbers(a), numbers(b));
        assert!(!one.is_empty() && one.len() == other.len(), "{key}: {a} {b}");
        let least = if key == "force_rms_error_n" { 15.0 } else { 0.0 };
        let near = |(x, y): (&f64, &f64)| (x - y).abs() <= 1e-3 * x.abs().max(least);
        assert!(one.iter().zip(&other).all(near), "{key}: {one:?} {other:?}");
    }
}

/// Reads a file with one JSON object a line.
fn lines(folder: &Path) -> Vec<Value> {
    let text = fs::read_to_string(folder.join("batch.jsonl")).unwrap();
    text.lines().map(|line| serde_json::from_str(line).unwrap()).collect()
}

#[test]
fn a_trial_has_the_figures_and_the_field_of_the_cpu_on_the_device_alone_and_in_a_batch() {
    if !has_adapter("simulate --backend gpu") {
        return;
    }
    let (folder, place) = short_trial(0.5);
    let out = |name: &str| folder.path().join(name);
    let model = written(folder.path(), "model.toml", SOFT);
    let table = written(folder.path(), "sets.csv", TABLE);
    let cpu = run(&mut simulate(&place, &out("cpu"), &["--model", &model, "--backend", "cpu"])).succeeds().answer();
    let gpu = run(&mut on_device(&place, &out("gpu"), &["--model", &model])).succeeds().answer();
    assert_eq!(cpu["backend"], "cpu");
    assert!(gpu["backend"].as_str().unwrap().contains("vulkan") || !cfg!(target_os = "linux"), "{gpu}");
    agree(&cpu, &gpu);
    assert!(cpu["removed_by_law_mm3"][0].as_f64().unwrap() > 1.0, "{cpu}");
    let difference = apart(&field(&out("cpu")), &field(&out("gpu")));
    assert!(difference <= 1e-4, "{difference} voxels");
    assert_eq!(names(&out("cpu")), names(&out("gpu")));

    run(&mut on_device(&place, &out("sets"), &["--batch", &table])).succeeds();
    let sets = lines(&out("sets"));
    assert_eq!(sets[0]["name"], "soft");
    for key in ["removed_by_law_mm3", "impulse_ns", "force_rms_error_n", "residual_rms_um", "steps"] {
        assert_eq!(sets[0][key], gpu[key], "{key}: a trial in a batch is the trial alone");
        assert_ne!(sets[1][key], Value::Null);
    }
    run(&mut simulate(&place, &out("sets-cpu"), &["--batch", &table])).succeeds();
    sets.iter().zip(&lines(&out("sets-cpu"))).for_each(|(gpu, cpu)| agree(cpu, gpu));
}

#[test]
fn sets_of_a_batch_are_single_runs_and_a_bad_line_is_named_by_its_number() {
    let (folder, place) = short_trial(0.5);
    let out = |name: &str| folder.path().join(name);
    let batch = |text: &str, name: &str| {
        let table = written(folder.path(), "sets.csv", text);
        run(&mut simulate(&place, &out(name), &["--batch", &table, "--backend", "cpu"]))
    };
    let answer = batch(TABLE, "sets").succeeds().answer();
    assert_eq!(answer["runs"], 2);
    let sets = lines(&out("sets"));
    for (set, (stiffness, rate)) in sets.iter().zip([(20, 1.4), (40, 1.1)]) {
        let text = SOFT.replace("20 MPa", &format!("{stiffness} MPa")).replace("1.4 mm", &format!("{rate} mm"));
        let model = written(folder.path(), "model.toml", &text);
        let single = run(&mut simulate(&place, &out("one"), &["--model", &model, "--force"])).succeeds().answer();
        for key in ["removed_by_law_mm3", "impulse_ns", "force_rms_error_n", "residual_rms_um", "steps"] {
            assert_eq!(set[key], single[key], "{key}");
        }
        assert_eq!(set["parameters"]["winkler.stiffness"], f64::from(stiffness));
    }
    for (text, code, words) in [
        (TABLE.replace("40,1.1", "stiff,1.1"), 1, &["sets.csv:3", "winkler.stiffness is \"stiff\"", "MPa/mm"][..]),
        (TABLE.replace("40,1.1", "40"), 1, &["sets.csv:3"]),
        (TABLE.replace("40,1.1", "-40,1.1"), 1, &["sets.csv:3", "winkler.stiffness", "-40 MPa/mm", "0.5 MPa/mm to"]),
        (TABLE.replace("hard", "soft"), 1, &["sets.csv:3", "\"soft\""]),
        (
            TABLE.replace("winkler.stiffness", "winkler.softness"),
            1,
            &["sets.csv:1", "\"winkler.softness\"", "winkler.stiffness"],
        ),
        (TABLE.lines().next().unwrap().to_owned(), 1, &["sets.csv:2", "no parameter set"]),
    ] {
        batch(&text, "bad").is_refused(code, words);
        assert!(!out("bad").exists());
    }
    // A parameter set whose run fails does not affect the others, and its line states the reason.
    let own = out("own");
    fs::create_dir(&own).unwrap();
    written(&own, "my-effect.toml", BREAKING);
    let model = written(folder.path(), "model.toml", "process = \"grinding\"\n[effect.my-effect]\n");
    let table = written(folder.path(), "sets.csv", "name,my-effect.reach\nshort,1\nlong,100\n");
    let flags = ["--model", &model, "--effects", own.to_str().unwrap(), "--batch", &table];
    run(&mut simulate(&place, &out("some"), &flags)).is_refused(1, &["1 of 2 runs ended early", "batch.jsonl"]);
    let some = lines(&out("some"));
    assert!(some[0]["stopped"].as_str().unwrap().contains("my-effect"), "{}", some[0]);
    assert!(some[1]["stopped"].is_null() && some[1]["removed_by_law_mm3"][0].as_f64().unwrap() > 1.0, "{}", some[1]);
}

#[test]
fn a_formula_without_a_number_on_the_device_is_named_and_leaves_the_last_good_state_of_the_cpu() {
    if !has_adapter("a formula that fails on the device") {
        return;
    }
    let (folder, place) = short_trial(0.9);
    let out = |name: &str| folder.path().join(name);
    let own = out("own");
    fs::create_dir(&own).unwrap();
    // This formula has almost no influence until it becomes undefined; its slope has a pole there, so rounding cannot
    // match.
    let formula = "rate * (1 + 1e-6 * (1 - sqrt(1 - path_position / reach)))";
    written(&own, "my-effect.toml", &BREAKING.replace("rate * sqrt(1 - path_position / reach)", formula));
    let model = written(folder.path(), "model.toml", "process = \"grinding\"\n[effect.my-effect]\n");
    let flags = ["--model", &model, "--effects", own.to_str().unwrap()];
    let words = ["pass 1", "my-effect", "hook rate", "last good state"];
    let on_cpu = run(&mut simulate(&place, &out("cpu"), &flags)).is_refused(1, &words);
    let on_device = run(&mut on_device(&place, &out("gpu"), &flags)).is_refused(1, &words);
    let time =
        |error: &str| error.split("at ").find_map(|rest| rest.split_once(" s of the pass")).unwrap().0.to_owned();
    assert_eq!(time(&on_cpu), time(&on_device));
    assert_eq!(names(&out("gpu")), ["after.nvdb", "simulation.json"]);
    let (cpu, gpu) = (field(&out("cpu")), field(&out("gpu")));
    assert!(apart(&cpu, &gpu) <= 1e-4, "{} voxels", apart(&cpu, &gpu));
}

#[test]
fn without_an_adapter_gpu_is_an_error_and_auto_one_line_and_the_cpu() {
    let (folder, place) = short_trial(0.3);
    let out = |name: &str| folder.path().join(name);
    let gpu = without_drivers(on_device(&place, &out("gpu"), &[]));
    run(&mut { gpu }).is_refused(1, &["--backend gpu", "no graphics adapter found", DRIVER_PACKAGE]);
    assert!(!out("gpu").exists());
    let said = run(&mut without_drivers(simulate(&place, &out("auto"), &[]))).succeeds();
    let backend: Vec<&str> = said.stderr.lines().filter(|line| line.trim_start().starts_with("backend ")).collect();
    assert!(backend.len() == 1 && backend[0].contains("CPU: ") && backend[0].contains(DRIVER_PACKAGE), "{backend:?}");
    assert_eq!(said.answer()["backend"], "cpu");

    let survey = run(&mut without_drivers(robofin(["backends", "--json"]))).succeeds().answer();
    assert_eq!(survey["adapters"].as_array().unwrap().len(), 0);
    assert!(survey["auto"].as_str().unwrap().starts_with("CPU: ") && survey["self_check_voxels"].is_null(), "{survey}");
    run(&mut simulate(&place, &out("cuda"), &["--backend", "cuda"]))
        .is_refused(2, &["--backend", "cuda", "auto, cpu or gpu"]);
}

#[test]
fn what_the_device_does_not_run_is_wrong_use_with_gpu_and_the_cpu_with_auto() {
    let (folder, place) = short_trial(0.3);
    let out = |name: &str| folder.path().join(name);
    run(&mut on_device(&place, &out("maps"), &["--covariates"]))
        .is_refused(2, &["--backend gpu", "cpu and auto are accepted"]);
    let said = run(&mut simulate(&place, &out("maps"), &["--covariates"])).succeeds().stderr;
    assert!(said.lines().any(|line| line.contains("CPU: the GPU backend does not run maps")), "{said}");
    let picture = folder.path().join("part.png");
    run(robofin(["render", "--backend", "gpu"]).arg(&place).arg("--out").arg(&picture))
        .is_refused(2, &["part.png", "CPU"]);
}
