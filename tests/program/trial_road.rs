//! `simulate` of a trial: results, states, refusals.

use std::fs;
use std::path::{Path, PathBuf};

use effects::Process;
use glam::{DVec2, DVec3};
use robot::{Controller, LogRow};
use sdf_bake::{HeightMap, PixelGrid};
use tempfile::TempDir;
use trials::trial::{
    ForceInput, FrameErrors, FrameOffset, HeldTool, Log, Pass, PassScan, RPM, Role, Scans, Trial, write_trial,
};

use crate::program::{asset, files, names, robofin, run};

const RADIUS: f64 = 0.02;
/// An effect whose formula is undefined once the tool has moved 3 mm.
pub(crate) const BREAKING: &str = "name = \"my-effect\"\ntitle = \"Mine\"\nsource = \"none\"\n\n[parameters.reach]\nunit = \"mm\"\n\
                        null = inf\nrange = [1.0, 1e3]\ndefault = 3.0\n\n\
                        [modify]\nrate = \"rate * sqrt(1 - path_position / reach)\"\n";

/// Makes a log: down, 6 mm along the crown at 5 mm/s, up.
fn log(back: bool) -> Log {
    let row = |k: i32| {
        let time = 0.01 * f64::from(k);
        let along = (time - 0.2).clamp(0.0, 1.2);
        let lift = 5e-3 * ((0.2 - time).max(0.0) + (time - 1.4).max(0.0));
        let x = if back { 0.008 - 0.005 * along } else { 0.002 + 0.005 * along };
        LogRow {
            time,
            position: DVec3::new(x, 0.0, RADIUS + 0.8e-3 + lift),
            force: if lift == 0.0 { 15.0 } else { 0.0 },
            spindle_speed: 6000.0 * RPM,
            approach: DVec3::Z,
        }
    };
    let rows: Vec<LogRow> = (0..=160).map(row).collect();
    Log { temperature: vec![f64::NAN; rows.len()], rows, has_approach: false, covariates: Vec::new() }
}

/// Makes a trial of a plate of 18 mm by 8 mm with a bead along x, ground twice, to and fro.
pub(crate) fn trial() -> (TempDir, PathBuf) {
    let pixels = PixelGrid { origin: DVec2::new(-0.004, -0.004), pitch: 0.25e-3, nx: 73, ny: 33 };
    let bead = |p: DVec2| (0.8e-3 * (1.0 - (p.y / 2.5e-3).powi(2))).max(0.0);
    let scan = HeightMap::from_function(pixels, bead);
    let ground = |crown: f64| {
        let height = |p: DVec2| if (0.002..=0.008).contains(&p.x) { bead(p).min(crown) } else { bead(p) };
        PassScan::Heights(HeightMap::from_function(pixels, height))
    };
    let pass = |back: bool| Pass {
        log: log(back),
        scan: ground(if back { 0.74e-3 } else { 0.77e-3 }),
        role: Role::Calibration,
        force_setpoint: 15.0,
        feed: 5e-3,
        spindle_speed: 6000.0 * RPM,
        direction: if back { DVec3::NEG_X } else { DVec3::X },
    };
    let trial = Trial {
        folder: PathBuf::new(),
        name: "plate".into(),
        process: Process::Grinding,
        tool: HeldTool::wheel(RADIUS, 0.02, DVec3::Y),
        fresh: true,
        scans: Scans { before: scan.clone(), is_nominal: false, repeats: Vec::new(), material: None },
        controller: Controller::Admittance { mass: 2.0, damping: 1500.0, period: 5e-4 },
        force_input: ForceInput::Setpoint,
        frame_errors: FrameErrors::default(),
        frame_offset: FrameOffset::default(),
        coating: None,
        passes: vec![pass(false), pass(true)],
        columns: Vec::new(),
        notes: Vec::new(),
        findings: Vec::new(),
    };
    let folder = tempfile::tempdir().unwrap();
    let place = folder.path().join("plate");
    fs::create_dir(&place).unwrap();
    write_trial(&trial, &place).unwrap();
    (folder, place)
}

pub(crate) fn written(folder: &Path, name: &str, text: &str) -> String {
    let place = folder.join(name);
    fs::write(&place, text).unwrap();
    place.to_str().unwrap().to_owned()
}

pub(crate) fn simulate(trial: &Path, out: &Path, flags: &[&str]) -> std::process::Command {
    let mut command = robofin(["simulate", "--json"]);
    command.arg(trial).args(flags).arg("--out").arg(out);
    command
}

#[test]
fn a_trial_gives_its_figures_and_the_same_bytes_on_any_number_of_threads() {
    let (folder, place) = trial();
    let out = |name: &str| folder.path().join(name);
    let answer = run(&mut simulate(&place, &out("one"), &["--threads", "1"])).succeeds().answer();
    run(&mut simulate(&place, &out("two"), &["--threads", "2"])).succeeds();
    assert_eq!(files(&out("one")), files(&out("two")));
    let number = |value: &serde_json::Value| value.as_f64().unwrap();
    for (pass, removed) in answer["removed_by_law_mm3"].as_array().unwrap().iter().enumerate() {
        // 15 N over 1.2 s: k F t of the default law, minus the loss to the threshold.
        assert!((5.0..40.0).contains(&number(removed)), "{answer}");
        assert!((0.0..8.0).contains(&number(&answer["force_rms_error_n"][pass])), "{answer}");
    }
    assert!(number(&answer["real_time_factor"]) > 0.0 && number(&answer["steps"]) > 50.0, "{answer}");

    let replayed = run(&mut simulate(&place, &out("replay"), &["--replay"])).succeeds().answer();
    assert_ne!(replayed["impulse_ns"], answer["impulse_ns"]);
    run(&mut simulate(&place, &out("one"), &[])).is_refused(2, &["already exists", "--force"]);
    run(&mut simulate(&place, &out("one"), &["--force", "--replay"])).succeeds();
    assert_eq!(files(&out("one")), files(&out("replay")));
    run(&mut simulate(&place, &out("fine"), &["--voxel-mm", "1e-9"])).is_refused(2, &["--voxel-mm", "accepted"]);
    run(&mut simulate(&place, &out("coarse"), &["--voxel-mm", "50"])).is_refused(1, &["pass 1", "50 mm", "at most"]);
    assert!(!out("coarse").exists(), "refused before the work");
    run(&mut simulate(asset(), &out("asset"), &["--replay"])).is_refused(2, &["--replay", "only for a trial"]);
    for (flag, value) in [("--force-n", "20"), ("--passes", "2"), ("--wheel-width-mm", "20"), ("--grind-rate", "1e-9")]
    {
        run(&mut simulate(&place, &out("flags"), &[flag, value])).is_refused(2, &[flag, "only for an asset"]);
    }
}

#[test]
fn a_run_resumed_from_a_state_ends_in_the_same_bytes() {
    let (folder, place) = trial();
    let out = |name: &str| folder.path().join(name);
    let model = "process = \"grinding\"\n[effect.grit-dulling]\ndulling_volume = \"50 mm^3\"\n";
    let model = written(folder.path(), "model.toml", model);
    let (model, whole) = (["--model", &model], out("whole"));
    let from = ["--resume", whole.to_str().unwrap()];
    run(&mut simulate(&place, &whole, &[&model[..], &["--snapshot"]].concat())).succeeds();
    let flags = [&model[..], &from, &["--after-pass", "1", "--snapshot"]].concat();
    run(&mut simulate(&place, &out("resumed"), &flags)).succeeds();
    assert_eq!(files(&whole), files(&out("resumed")));

    let refused = run(&mut simulate(&place, &out("other"), &from));
    refused.is_refused(1, &["state-1.json", "grit-dulling.dulling_volume (then"]);
    let flags = [&model[..], &from, &["--after-pass", "3"]].concat();
    run(&mut simulate(&place, &out("other"), &flags)).is_refused(2, &["--after-pass 3", "1, 2"]);
    let log = fs::read_to_string(place.join("pass1_log.csv")).unwrap();
    fs::write(place.join("pass1_log.csv"), log.replacen(",15", ",14", 1)).unwrap();
    let flags = [&model[..], &from].concat();
    let error = run(&mut simulate(&place, &out("other"), &flags)).is_refused(1, &["state-1.json", "log of pass 1"]);
    assert!(!error.contains("scan before") && !error.contains("model"), "{error}");
    assert!(!out("other").exists());
}

#[test]
fn an_asset_is_ground_on_from_a_state() {
    let folder = tempfile::tempdir().unwrap();
    let out = |name: &str| folder.path().join(name);
    run(&mut simulate(asset(), &out("whole"), &["--snapshot"])).succeeds();
    let whole = out("whole");
    let flags = ["--snapshot", "--resume", whole.to_str().unwrap(), "--after-pass", "1"];
    run(&mut simulate(asset(), &out("resumed"), &flags)).succeeds();
    assert_eq!(files(&whole), files(&out("resumed")));
    run(&mut simulate(asset(), &out("other"), &[&flags[1..], &["--force-n", "16"]].concat()))
        .is_refused(1, &["force setpoint (then 15.0 N, now 16.0 N)"]);
}

#[test]
fn covariates_are_maps_over_the_scan() {
    let (folder, place) = trial();
    let out = folder.path().join("out");
    let answer = run(&mut simulate(&place, &out, &["--covariates"])).succeeds().answer();
    let text = fs::read_to_string(out.join("covariates/pass1_pressure_time_mpa_s.csv")).unwrap();
    let rows: Vec<Vec<f64>> =
        text.lines().map(|row| row.split(',').map(|cell| cell.parse().unwrap()).collect()).collect();
    assert!(rows.len() == 33 && rows.iter().all(|row| row.len() == 73));
    // MPa s times mm² is N s; the tool comes from above, so the area of the lattice is the projected one.
    let impulse = rows.iter().flatten().sum::<f64>() * 0.25 * 0.25;
    let expected = answer["impulse_ns"][0].as_f64().unwrap();
    assert!((impulse / expected - 1.0).abs() < 1e-5, "{impulse} {expected}");
    assert_eq!(names(&out.join("covariates")).len(), 18);
}

#[test]
fn models_that_do_not_fit_are_refused_and_those_that_break_leave_the_last_good_state() {
    let (folder, place) = trial();
    let out = |name: &str| folder.path().join(name);
    let model = |effect: &str| written(folder.path(), "model.toml", &format!("process = \"grinding\"\n{effect}"));
    let plain = run(&mut simulate(&place, &out("plain"), &[])).succeeds().answer();
    let dull = model("[effect.grit-dulling]\ndulling_volume = \"10 mm^3\"\n");
    let dulled = run(&mut simulate(&place, &out("dulled"), &["--model", &dull])).succeeds().answer();
    let second = |answer: &serde_json::Value| answer["removed_by_law_mm3"][1].as_f64().unwrap();
    assert!(second(&dulled) < 0.8 * second(&plain), "{dulled}");

    let sanding = model("[effect.pad-loading]\n");
    run(&mut simulate(&place, &out("sanding"), &["--model", &sanding])).is_refused(1, &["pad-loading", "grinding"]);
    let other = written(folder.path(), "other.toml", "process = \"sanding\"\n");
    run(&mut simulate(&place, &out("sanding"), &["--model", &other])).is_refused(2, &["sanding", "grinding"]);

    let own = folder.path().join("own");
    fs::create_dir(&own).unwrap();
    written(&own, "my-effect.toml", BREAKING);
    let breaking = model("[effect.my-effect]\n");
    let flags = ["--model", &breaking, "--effects", own.to_str().unwrap(), "--snapshot"];
    let error = run(&mut simulate(&place, &out("broken"), &flags)).is_refused(1, &["broken", "pass 1", "my-effect"]);
    assert!(error.contains("last good state"), "{error}");
    let kept = names(&out("broken"));
    assert_eq!(kept, ["after.nvdb", "simulation.json"]);
    let summary = fs::read_to_string(out("broken").join("simulation.json")).unwrap();
    assert!(summary.contains("\"stopped\": \"pass 1"), "{summary}");
    assert_ne!(files(&out("broken"))["after.nvdb"], files(&out("plain"))["after.nvdb"]);

    fs::remove_file(place.join("pass2_log.csv")).unwrap();
    run(&mut simulate(&place, &out("absent"), &[])).is_refused(1, &["pass2_log.csv"]);
    assert!(!out("absent").exists() && !out("sanding").exists());
}
