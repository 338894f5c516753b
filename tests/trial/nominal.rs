//! Trials without a scan before the first pass, and passes that were not scanned.

use std::fs;
use std::path::Path;

use glam::DVec2;
use sdf_bake::{HeightMap, PixelGrid};
use tempfile::TempDir;
use trials::init::guess;
use trials::measure::{DegreesOfFreedom, NoiseSource, ScanNoise, register};
use trials::trial::{HeldTool, PassScan, Trial, write_trial};

use crate::files::{edit, folder, grinding, refused, sanding};

fn bundled() -> Trial {
    Trial::read(&Path::new(env!("CARGO_MANIFEST_DIR")).join("data/campaigns/first-look/trial-1")).expect("a trial")
}

/// Writes a trial, with the lines of its `trial.toml` replaced that begin with a word; an empty text removes the line.
fn written(trial: &Trial, replaced: &[(&str, &str)]) -> TempDir {
    let place = tempfile::tempdir().expect("a temporary folder");
    write_trial(trial, place.path()).expect("the trial is written");
    edit(place.path(), "trial.toml", |text| {
        let line = |line: &str| match replaced.iter().find(|(word, _)| line.starts_with(word)) {
            Some((_, other)) => format!("{other}\n"),
            None => format!("{line}\n"),
        };
        text.lines().map(line).collect()
    });
    place
}

/// Noise without correlation, between −1 and 1; its standard deviation is 1 / √3.
fn noise(k: usize) -> f64 {
    2.0 * ((12.9898 * k as f64 + 0.3).sin() * 43758.5453).rem_euclid(1.0) - 1.0
}

/// The true surface of the plate before its pass [m].
fn plate(place: DVec2) -> f64 {
    1.5e-3 + 2e-3 * (place.x - 7e-3) - 1e-3 * place.y
}

/// A flat plate with a track of 50 µm under a wheel 3 mm wide; pixels have a noise of 1.15 µm.
fn ground_plate() -> Trial {
    let pixels = PixelGrid { origin: DVec2::new(-0.01, -0.0075), pitch: 0.25e-3, nx: 140, ny: 61 };
    let mut trial = grinding();
    trial.tool = HeldTool::wheel(0.05, 0.003, glam::DVec3::Y);
    trial.scans.before = HeightMap::from_function(pixels, plate);
    (trial.scans.repeats, trial.scans.material) = (Vec::new(), None);
    let cut = |place: DVec2| {
        let [beside, along] = [place.y.abs() < 1.5e-3, (1.5e-3..12.5e-3).contains(&place.x)];
        if beside && along { 50e-6 } else { 0.0 }
    };
    let mut after = HeightMap::from_function(pixels, |place| plate(place) - cut(place));
    after.heights.iter_mut().enumerate().for_each(|(k, height)| *height += 2e-6 * noise(k));
    trial.passes[0].scan = PassScan::Heights(after);
    trial
}

#[test]
fn a_plane_is_laid_under_the_track_and_its_noise_is_that_of_one_scan() {
    let place = written(&ground_plate(), &[("before", "nominal = \"plane\"")]);
    let trial = Trial::read(place.path()).expect("a trial");
    assert!(trial.scans.is_nominal && trial.notes.iter().any(|note| note.contains("no scan before")));
    let map = &trial.scans.before;
    let off = |k: usize| (map.heights[k] - plate(map.pixels.position(k % 140, k / 140))).abs();
    let most = (0..map.heights.len()).map(off).fold(0.0, f64::max);
    println!("the plane is off by {:.3} µm at most", 1e6 * most);
    // Three parameters from about 7,000 pixels: a corner is off by some 1.15 µm · √(7 / 7000).
    assert!(most < 0.2e-6, "{most}");
    let found = &ScanNoise::of_campaign(std::slice::from_ref(&trial)).expect("a noise")[0];
    assert_eq!(found.source, NoiseSource::Nominal);
    let ratio = found.floor.rms / (2e-6 / 3f64.sqrt());
    assert!((ratio - 1.0).abs() < 0.05, "{ratio}");
}

#[test]
fn a_drawn_surface_is_moved_onto_the_first_scan() {
    let known = bundled();
    let place = written(&known, &[("before", "nominal = \"drawn.csv\""), ("repeat", "")]);
    let mut drawn = known.scans.before.clone();
    let pixels = drawn.pixels;
    let raised = |k: usize| 1.3e-3 + pixels.position(k % pixels.nx, k / pixels.nx).dot(DVec2::new(2e-3, -3e-3));
    drawn.heights.iter_mut().enumerate().for_each(|(k, height)| *height += raised(k));
    fs::write(place.path().join("drawn.csv"), trials::trial::heights_csv(&drawn)).unwrap();
    let trial = Trial::read(place.path()).expect("a trial");
    let found = register(&trial.scans.before, &known.scans.before, DegreesOfFreedom::Plane, |_| true).unwrap();
    println!("offset {:.2} µm, tilt {:.3} mrad", 1e6 * found.offset, 1e3 * found.tilt.length());
    // The scan after the pass has an offset and a tilt of its own.
    assert!(found.offset.abs() < 30e-6 && found.tilt.length() < 0.5e-3, "{found:?}");
    let again = tempfile::tempdir().unwrap();
    write_trial(&trial, again.path()).expect("the trial is written");
    let again = Trial::read(again.path()).expect("the written trial");
    assert!(again.scans.is_nominal && again.passes[1].scan.csv() == trial.passes[1].scan.csv());
}

#[test]
fn a_pass_without_a_scan_is_read_and_written() {
    let known = bundled();
    let place = written(&known, &[("scan = \"pass1", "")]);
    let trial = Trial::read(place.path()).expect("a trial");
    assert!(trial.passes[0].scan.is_missing() && !trial.passes[1].scan.is_missing());
    let (passes, scan) = trial.first_scanned().expect("a scan");
    assert!(passes.len() == 2 && scan.csv() == known.passes[1].scan.csv());
    let again = tempfile::tempdir().unwrap();
    write_trial(&trial, again.path()).expect("the trial is written");
    assert!(!again.path().join("pass1_after.csv").exists());
    assert!(Trial::read(again.path()).expect("the written trial").passes[0].scan.is_missing());
}

#[test]
fn one_scan_after_two_passes_and_their_logs_become_a_trial() {
    let place = written(&bundled(), &[]);
    for name in ["trial.toml", "before.csv", "before_repeat.csv", "material.csv", "pass1_after.csv"] {
        fs::remove_file(place.path().join(name)).unwrap();
    }
    let guess = guess(place.path()).expect("a guess");
    println!("{}", guess.text);
    assert!(guess.text.contains("nominal = \"plane\"   # guessed"), "{}", guess.text);
    assert_eq!(guess.text.matches("\nscan = \"pass1_after.csv\"").count(), 0);
    assert_eq!(guess.text.matches("\n[[pass]]\nlog = \"pass1_log.csv\"\n# scan").count(), 1);
    assert_eq!(guess.text.matches("\nlog = \"pass2_log.csv\"\nscan = \"pass2_after.csv\"").count(), 1);
    fs::write(place.path().join("part.stl"), "solid part\nendsolid part\n").unwrap();
    let guess = trials::init::guess(place.path()).expect("a guess");
    assert!(guess.text.contains("nominal = \"part.stl\""), "{}", guess.text);
}

#[test]
fn a_surface_before_is_given_once() {
    let both = written(&grinding(), &[("before", "before = \"before.csv\"\nnominal = \"plane\"")]);
    refused(both.path(), &["trial.toml, line", "both before and nominal", "one of them is expected"]);
    let none = written(&grinding(), &[("before", "")]);
    refused(none.path(), &["trial.toml", "[scan] without before", "nominal = \"plane\""]);
    let repeated = written(&grinding(), &[("before", "nominal = \"plane\"")]);
    refused(repeated.path(), &["trial.toml, line", "a repeated scan beside nominal"]);
    let missing = written(&grinding(), &[("before", "nominal = \"part.stl\""), ("repeat", "")]);
    refused(missing.path(), &["trial.toml, line", "part.stl is not there"]);
    let mask = written(&sanding(), &[("before", "nominal = \"plane\""), ("repeat", "")]);
    refused(mask.path(), &["trial.toml, line", "nominal = \"plane\"", "a file is expected"]);
    for replaced in [&[("scan", "")][..], &[("scan", ""), ("before", "nominal = \"plane\""), ("repeat", "")]] {
        refused(written(&grinding(), replaced).path(), &["trial.toml", "no [[pass]] with a scan"]);
    }
}

#[test]
fn times_of_a_pass_that_a_log_does_not_have_are_refused() {
    for time in ["[9.0, 1.0]", "[nan, 1.0]", "[0.0, inf]", "[100.0, 200.0]"] {
        let place = written(&grinding(), &[("log", &format!("log = \"pass1_log.csv\"\ntime_s = {time}"))]);
        refused(place.path(), &["trial.toml, line", "time_s = [", "rows of pass1_log.csv", "0.0 to 2.4 s"]);
    }
    let place = written(&grinding(), &[("log", "log = \"pass1_log.csv\"\ntime_s = [0.1, 2.3]")]);
    let trial = Trial::read(place.path()).expect("a trial");
    let rows = &trial.passes[0].log.rows;
    assert!(rows.len() > 100 && rows[0].time >= 0.1 && rows.last().is_some_and(|row| row.time <= 2.3));
    assert_eq!(trial.passes[0].log.covariates[0].values.len(), rows.len());
}

#[test]
fn a_nominal_surface_that_no_scan_shows_free_of_the_tool_is_refused() {
    // The wheel of this trial is wider than its map.
    let place: TempDir = folder();
    let named = |text: String| text.replace("before = \"before.csv\"", "nominal = \"before.csv\"");
    edit(place.path(), "trial.toml", |text| {
        named(text).lines().filter(|line| !line.starts_with("repeat")).map(|line| format!("{line}\n")).collect()
    });
    let read: Result<Trial, _> = Trial::read(place.path());
    let found = read.map(|trial| ScanNoise::of_campaign(&[trial]).expect_err("too few pixels").to_string());
    let message = found.unwrap_or_else(|error| error.to_string());
    assert!(message.contains("pixels"), "{message}");
}
