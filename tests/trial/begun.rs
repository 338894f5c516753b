//! Trials started from files of other programs: guesses of `trial init`, and findings of `trial check`.

use std::fs;
use std::path::{Path, PathBuf};

use glam::DVec2;
use instruments::surface::{self, Surface};
use sdf_bake::HeightMap;
use trials::init::guess;
use trials::measure::NoiseSource;
use trials::trial::{ForceInput, Log, PassScan, RPM, Severity, Trial};

/// Origin of the scanner in the frame of the log [m].
const SCANNER: DVec2 = DVec2::new(-0.1, -0.05);

fn bundled() -> Trial {
    Trial::read(&Path::new(env!("CARGO_MANIFEST_DIR")).join("data/campaigns/first-look/trial-1")).expect("a trial")
}

/// Writes a map in the format of its extension, in the frame of the scanner.
fn write_map(place: PathBuf, map: &HeightMap) {
    let surface = Surface {
        format: "test",
        nx: map.pixels.nx,
        ny: map.pixels.ny,
        pitch: Some(DVec2::splat(map.pixels.pitch)),
        origin: Some(map.pixels.origin - SCANNER),
        heights: map.heights.clone(),
        notes: Vec::new(),
    };
    fs::write(&place, surface::write(&place, &surface).expect("a map")).unwrap();
}

/// Writes a log in the style of a German controller: metres, decimal commas, a negative force, no spindle.
fn write_log(place: PathBuf, log: &Log) {
    let number = |value: f64| format!("{value:.6}").replace('.', ",");
    let row = |row: &robot::LogRow| {
        let [x, y, z] = row.position.to_array();
        [row.time, x, y, z, -row.force].map(number).join(";")
    };
    let rows: Vec<String> = log.rows.iter().map(row).collect();
    fs::write(place, format!("Zeit [s];TCP.X [m];TCP.Y [m];TCP.Z [m];Kraft [N]\r\n{}\r\n", rows.join("\r\n"))).unwrap();
}

/// Writes the bundled trial to a folder of files of other programs, with meaningless names.
fn begun() -> tempfile::TempDir {
    let (trial, place) = (bundled(), tempfile::tempdir().unwrap());
    let file = |name: &str| place.path().join(name);
    write_map(file("scan_c.asc"), &trial.scans.before);
    write_map(file("scan_b.asc"), &trial.scans.repeats[0]);
    for (k, (pass, name)) in trial.passes.iter().zip(["scan_d.asc", "scan_a.asc"]).enumerate() {
        let PassScan::Heights(map) = &pass.scan else { panic!("ground") };
        write_map(file(name), map);
        write_log(file(&format!("robot{}.txt", k + 9)), &pass.log);
    }
    let labels = trial.scans.material.as_ref().expect("labels");
    fs::write(file("zones.csv"), trials::trial::labels_csv(labels)).unwrap();
    fs::write(file("notes.pdf"), b"%PDF-1.4 nothing").unwrap();
    place
}

/// Returns the line of a text that begins with a key.
#[track_caller]
fn line<'a>(text: &'a str, key: &str) -> &'a str {
    text.lines().find(|line| line.starts_with(key)).unwrap_or_else(|| panic!("no {key} in {text}"))
}

#[test]
fn a_folder_of_scans_and_logs_becomes_a_trial_that_passes_its_checks() {
    let place = begun();
    let guess = guess(place.path()).expect("a guess");
    println!("{}\n{:?}\n{:?}", guess.text, guess.seen, guess.open);
    assert!(line(&guess.text, "before").contains("scan_c.asc") || line(&guess.text, "before").contains("scan_b.asc"));
    assert_eq!(guess.text.matches("scan = \"scan_d.asc\"").count(), 1, "the first pass took less off");
    assert!(line(&guess.text, "material").contains("zones.csv") && guess.text.contains("process = \"grinding\""));
    assert_eq!(guess.open, ["spindle_rpm of pass 1", "spindle_rpm of pass 2"]);
    assert!(guess.seen.iter().any(|seen| seen.starts_with("notes.pdf: neither scan nor log")), "{:?}", guess.seen);
    let radius: f64 = line(&guess.text, "radius_mm").split(['=', '#']).nth(1).unwrap().trim().parse().unwrap();
    assert!((radius - 50.0).abs() < 0.1, "{radius}");
    let told = |text: String, key: &str, value: &str| {
        let lines = text
            .lines()
            .map(|line| if line.starts_with(key) { format!("{key} = {value}\n") } else { format!("{line}\n") });
        lines.collect::<String>()
    };
    let text = told(told(told(guess.text, "radius_mm", "50.0"), "width_mm", "20.0"), "spindle_rpm", "6000");
    fs::write(place.path().join("trial.toml"), text).unwrap();
    let (trial, checks) = Trial::checked(place.path()).expect("a trial");
    let refused =
        checks.iter().flat_map(|check| &check.findings).filter(|finding| finding.severity == Severity::Refused);
    assert_eq!(refused.count(), 0, "{checks:?}");
    assert_eq!((trial.force_input, trial.scans.repeats.len(), trial.passes.len()), (ForceInput::Log, 1, 2));
    let known = bundled();
    for (pass, known) in trial.passes.iter().zip(&known.passes) {
        assert!((pass.force_setpoint / known.force_setpoint - 1.0).abs() < 0.03, "{}", pass.force_setpoint);
        assert!((pass.feed / known.feed - 1.0).abs() < 0.02, "{}", pass.feed);
        assert_eq!((pass.spindle_speed, pass.direction), (6000.0 * RPM, known.direction));
        let off = pass.log.rows[7].position.truncate() - (known.log.rows[7].position.truncate() - SCANNER);
        assert!(off.length() < 0.6e-3, "the path lies {off} beside where it was");
    }
}

#[test]
fn a_log_of_several_strokes_becomes_a_pass_for_each() {
    let (known, place) = (bundled(), tempfile::tempdir().unwrap());
    let file = |name: &str| place.path().join(name);
    write_map(file("scan_a.asc"), &known.scans.before);
    let PassScan::Heights(last) = &known.passes[1].scan else { panic!("ground") };
    write_map(file("scan_b.asc"), last);
    let rows = |k: usize| known.passes[k].log.rows.clone();
    let later = rows(0).last().expect("rows").time - rows(1)[0].time + 2.0;
    let second = rows(1).into_iter().map(|row| robot::LogRow { time: row.time + later, ..row });
    write_log(file("robot.txt"), &Log { rows: rows(0).into_iter().chain(second).collect(), ..Log::default() });
    let guess = guess(place.path()).expect("a guess");
    println!("{}", guess.text);
    assert_eq!(guess.text.matches("log = \"robot.txt\"\ntime_s = [").count(), 2);
    assert_eq!(guess.text.matches("\n# scan = \"FILE\"").count(), 1);
    assert_eq!(guess.text.matches("\nscan = \"scan_b.asc\"").count(), 1);
    let text = guess.text.replace("spindle_rpm = 0.0", "spindle_rpm = 6000").replace("width_mm = ", "width_mm = 20 # ");
    fs::write(file("trial.toml"), &text).unwrap();
    let trial = Trial::read(place.path()).expect("a trial");
    assert_eq!(trial.passes.len(), 2);
    for (pass, known) in trial.passes.iter().zip(&known.passes) {
        // The time in the air between both strokes is shared out by halves.
        assert!(pass.log.rows.len().abs_diff(known.log.rows.len()) < 30, "{}", pass.log.rows.len());
        assert_eq!(pass.direction, known.direction);
        assert!((pass.force_setpoint / known.force_setpoint - 1.0).abs() < 0.03, "{}", pass.force_setpoint);
    }
    assert!(!trial.notes.iter().any(|note| note.contains("strokes")), "{:?}", trial.notes);
    // The whole log as one pass is noted, with the times of its strokes.
    let whole: String =
        text.lines().filter(|line| !line.starts_with("time_s")).map(|line| format!("{line}\n")).collect();
    let (head, passes) = whole.split_at(whole.find("[[pass]]").expect("a pass"));
    let second = passes.rfind("[[pass]]").expect("two passes");
    let one = passes[second..].lines().filter(|line| !line.starts_with("direction"));
    let one: String = one.map(|line| format!("{line}\n")).collect();
    fs::write(file("trial.toml"), format!("{head}{one}")).unwrap();
    let (trial, _) = Trial::checked(place.path()).expect("a trial");
    assert!(trial.notes.iter().any(|note| note.contains("2 strokes")), "{:?}", trial.notes);
    fs::write(file("trial.toml"), text.replace("time_s = [", "time_s = [1000")).unwrap();
    let error = Trial::read(place.path()).expect_err("no rows").to_string();
    assert!(error.contains("trial.toml, line") && error.contains("holds 0 rows of robot.txt"), "{error}");
}

#[test]
fn a_folder_without_a_log_or_a_scan_is_refused_with_what_was_seen() {
    let place = begun();
    for name in ["robot9.txt", "robot10.txt"] {
        fs::remove_file(place.path().join(name)).unwrap();
    }
    let error = guess(place.path()).expect_err("no log").to_string();
    assert!(error.contains("no log in") && error.contains("scan_a.asc: height map (ESRI"), "{error}");
    let empty = tempfile::tempdir().unwrap();
    let error = guess(empty.path()).expect_err("nothing").to_string();
    assert!(error.contains("no scan in no file") && error.contains("Gwyddion"), "{error}");
    assert!(guess(&empty.path().join("absent")).is_err());
}

#[test]
fn scans_in_other_formats_are_the_same_trial() {
    let (known, place) = (bundled(), tempfile::tempdir().unwrap());
    let source = known.folder.clone();
    for name in ["pass1_log.csv", "pass2_log.csv"] {
        fs::copy(source.join(name), place.path().join(name)).unwrap();
    }
    for (name, map) in [("before.sur", &known.scans.before), ("again.x3p", &known.scans.repeats[0])] {
        write_map(place.path().join(name), map);
    }
    let after = |k: usize| match &known.passes[k].scan {
        PassScan::Heights(map) => map.clone(),
        PassScan::Exposure(_) => panic!("ground"),
    };
    write_map(place.path().join("one.sur"), &after(0));
    write_map(place.path().join("two.x3p"), &after(1));
    let text = fs::read_to_string(source.join("trial.toml")).unwrap();
    let text = text.replace("before.csv", "before.sur").replace("before_repeat.csv", "again.x3p");
    let text = text.replace("pass1_after.csv", "one.sur").replace("pass2_after.csv", "two.x3p");
    let text: String =
        text.lines().filter(|line| !line.starts_with("material")).map(|line| format!("{line}\n")).collect();
    fs::write(place.path().join("trial.toml"), text).unwrap();
    let read = Trial::read(place.path()).expect("a trial");
    for (found, known) in [(&read.scans.before, &known.scans.before), (&read.scans.repeats[0], &known.scans.repeats[0])]
    {
        assert_eq!(found.pixels, known.pixels);
        let off = found.heights.iter().zip(&known.heights).map(|(a, b)| (a - b).abs()).filter(|off| off.is_finite());
        assert!(off.fold(0.0, f64::max) < 1e-9, "SUR has steps of less than a nanometre");
        assert_eq!(found.missing(), known.missing());
    }
}

#[test]
fn a_scan_with_a_place_of_its_own_is_brought_onto_the_pixels_of_the_first() {
    let place = begun();
    let guess = guess(place.path()).expect("a guess");
    let text = guess.text.replace("spindle_rpm = 0.0", "spindle_rpm = 6000").replace("width_mm = ", "width_mm = 20 # ");
    fs::write(place.path().join("trial.toml"), text).unwrap();
    // The last scan again, but only a part of it and shifted by half a pixel.
    let known = bundled();
    let PassScan::Heights(map) = &known.passes[1].scan else { panic!("ground") };
    let mut pixels = map.pixels;
    pixels.origin += DVec2::splat(0.5 * pixels.pitch);
    (pixels.nx, pixels.ny) = (pixels.nx - 4, pixels.ny - 2);
    let between = |k: usize| {
        let (i, j) = (k % pixels.nx, k / pixels.nx);
        0.25 * (map.height(i, j) + map.height(i + 1, j) + map.height(i, j + 1) + map.height(i + 1, j + 1))
    };
    let part = HeightMap { pixels, heights: (0..pixels.len()).map(between).collect() };
    write_map(place.path().join("scan_a.asc"), &part);
    let (trial, _) = Trial::checked(place.path()).expect("a trial");
    let PassScan::Heights(found) = &trial.passes[1].scan else { panic!("ground") };
    assert_eq!(found.pixels, trial.scans.before.pixels);
    assert!(trial.notes.iter().any(|note| note.contains("are brought onto")), "{:?}", trial.notes);
    let (i, j) = (map.pixels.nx / 2, map.pixels.ny / 2);
    assert!((found.height(i, j) - map.height(i, j)).abs() < 30e-6, "{} {}", found.height(i, j), map.height(i, j));
}

#[test]
fn columns_that_are_not_there_are_refused_by_name() {
    let place = begun();
    let guess = guess(place.path()).expect("a guess");
    let refused = |from: &str, to: &str, words: &[&str]| {
        fs::write(place.path().join("trial.toml"), guess.text.replace(from, to)).unwrap();
        let error = Trial::read(place.path()).expect_err(to).to_string();
        assert!(words.iter().all(|word| error.contains(word)), "{error}");
    };
    refused("\"TCP.X [m]\"", "\"TCP.Q [m]\"", &["robot", "TCP.Q", "for x", "TCP.X [m]"]);
    refused("unit = \"N\"", "unit = \"kPa\"", &["trial.toml, line", "kPa", "force"]);
    refused("force = {", "forse = {", &["unknown key \"forse\"", "did you mean \"force\"?"]);
    refused("time = {", "# time = {", &["[log.columns] without time"]);
    refused("column = \"Kraft [N]\"", "colum = \"Kraft [N]\"", &["the name of a column, or { column"]);
    refused(
        "kind = \"logged-force\"",
        "kind = \"logged-force\"\nmass_kg = 2",
        &["mass_kg", "only kind = \"admittance\""],
    );
}

#[test]
fn a_trial_without_a_repeated_scan_says_where_its_noise_is_seen() {
    let mut trial = bundled();
    trial.scans.repeats.clear();
    let noise = trials::measure::ScanNoise::of_campaign(std::slice::from_ref(&trial)).expect("a noise");
    assert_eq!(noise[0].source, NoiseSource::Untouched);
}

#[test]
fn masks_after_the_passes_are_sanding() {
    let (mut trial, place) = (crate::files::sanding(), tempfile::tempdir().unwrap());
    // Scans have noise, so one lies above the other at some pixels and below it at others.
    let noise = |k: usize| 2e-6 * ((12.9898 * k as f64).sin() * 43758.5453).rem_euclid(1.0);
    let before = &trial.scans.before.heights;
    trial.scans.repeats[0].heights = before.iter().enumerate().map(|(k, height)| height + noise(k)).collect();
    trials::trial::write_trial(&trial, place.path()).unwrap();
    fs::remove_file(place.path().join("trial.toml")).unwrap();
    let guess = guess(place.path()).expect("a guess");
    for words in ["process = \"sanding\"", "kind = \"pad\"", "scan = \"pass1_exposed.csv\"", "before = \"before.csv\""]
    {
        assert!(guess.text.contains(words), "no {words} in {}", guess.text);
    }
}
