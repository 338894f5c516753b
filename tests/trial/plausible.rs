//! Files that contradict each other through a wrong unit, sign, frame or copy: refused with name, gap and guess.
//! Unusual but valid campaigns are accepted.

use std::path::{Path, PathBuf};

use tempfile::TempDir;
use trials::trial::{Campaign, HeldTool, PassScan, Trial, write_trial};

use crate::files::{edit, grinding, noted, pixels, refused};
use crate::shared::campaigns;

const MAPS: [&str; 4] = ["before.csv", "before_repeat.csv", "pass1_after.csv", "pass2_after.csv"];
const LOGS: [&str; 2] = ["pass1_log.csv", "pass2_log.csv"];
const Z: usize = 3;
const FORCE: usize = 4;
const RPM: usize = 5;

fn first_look() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("data/campaigns/first-look/trial-1")
}

/// Copies the first trial of the bundled campaign: a bead ground twice by a wheel of 50 mm.
fn sound() -> TempDir {
    let folder = tempfile::tempdir().unwrap();
    for entry in std::fs::read_dir(first_look()).unwrap() {
        let entry = entry.unwrap();
        std::fs::copy(entry.path(), folder.path().join(entry.file_name())).unwrap();
    }
    folder
}

/// Changes the numbers of a table: `change` takes column and value.
fn numbers(folder: &Path, names: &[&str], change: impl Fn(usize, f64) -> f64) {
    let cell = |(column, cell): (usize, &str)| match cell.parse::<f64>() {
        Ok(value) => format!("{:.9}", change(column, value)),
        Err(_) => cell.to_owned(),
    };
    let line = |line: &str| line.split(',').enumerate().map(cell).collect::<Vec<_>>().join(",") + "\n";
    for name in names {
        edit(folder, name, |text| text.lines().map(line).collect());
    }
}

/// Changes one column of both logs.
fn column(column: usize, change: impl Fn(f64) -> f64) -> TempDir {
    let folder = sound();
    numbers(folder.path(), &LOGS, |at, value| if at == column { change(value) } else { value });
    folder
}

/// Changes `trial.toml`.
fn manifest(from: &str, to: &str) -> TempDir {
    let folder = sound();
    edit(folder.path(), "trial.toml", |text| {
        assert!(text.contains(from), "{from} is not in {text}");
        text.replace(from, to)
    });
    folder
}

/// Reverses rows, or the cells of each row.
fn mirrored(folder: &Path, name: &str, rows: bool) {
    edit(folder, name, |text| {
        let mut lines: Vec<String> = text.lines().map(str::to_owned).collect();
        if rows {
            lines.reverse();
        } else {
            lines.iter_mut().for_each(|line| *line = line.split(',').rev().collect::<Vec<_>>().join(","));
        }
        lines.join("\n") + "\n"
    });
}

fn copied(folder: &Path, from: &str, to: &str) {
    std::fs::copy(folder.join(from), folder.join(to)).unwrap();
}

#[track_caller]
fn says(folder: &TempDir, words: &[&str]) {
    println!("{}", refused(folder.path(), words));
}

#[test]
fn a_force_in_kilonewtons_is_refused() {
    says(
        &column(FORCE, |force| 1e-3 * force),
        &["pass1_log.csv", "force_n is 0.01", "times smaller", "force_setpoint_n", "kN"],
    );
}

#[test]
fn a_force_in_millinewtons_is_refused() {
    says(&column(FORCE, |force| 1e3 * force), &["pass1_log.csv", "times larger", "force_setpoint_n", "mN"]);
}

#[test]
fn a_force_in_kilograms_or_pounds_is_refused() {
    says(&column(FORCE, |force| force / 9.80665), &["pass1_log.csv", "10.", "times smaller", "kgf"]);
    says(&column(FORCE, |force| force / 4.448), &["pass1_log.csv", "times smaller", "lbf"]);
}

#[test]
fn a_force_with_the_other_sign_is_refused() {
    says(&column(FORCE, |force| -force), &["pass1_log.csv", "force_n is -", "force_setpoint_n", "other sign"]);
    says(&column(FORCE, |force| -1e-3 * force), &["pass1_log.csv", "other sign", "kN"]);
}

#[test]
fn a_setpoint_in_kilonewtons_is_refused() {
    says(
        &manifest("force_setpoint_n = 15.0", "force_setpoint_n = 0.015"),
        &["pass1_log.csv", "force_setpoint_n of trial.toml in kN"],
    );
}

#[test]
fn a_log_of_the_tip_is_refused() {
    says(&column(Z, |z| z - 50.0), &["pass1_log.csv", "z_mm", "below the surface", "lowest point, not its centre"]);
}

#[test]
fn a_log_with_z_off_is_refused_with_the_gap() {
    for off in [5.0, 2.0, -5.0] {
        let side = if off > 0.0 { "above" } else { "below" };
        says(&column(Z, |z| z + off), &["pass1_log.csv", "z_mm", side, "the zero of z_mm lies", "mm"]);
    }
    says(&column(Z, |z| -z), &["pass1_log.csv", "z_mm has the other sign"]);
    says(&column(Z, |z| 1e-3 * z), &["pass1_log.csv", "z_mm looks like m"]);
}

#[test]
fn a_small_gap_is_noted() {
    let folder = column(Z, |z| z + 0.4);
    noted(
        folder.path(),
        &["pass1_log.csv: z_mm: while it presses, the tool lies 0.", "above the surface of pass1_after.csv"],
    );
}

#[test]
fn a_wrong_radius_is_refused_with_the_right_one() {
    let radius = |value: &str| manifest("radius_mm = 50", &format!("radius_mm = {value}"));
    says(
        &radius("500"),
        &["pass1_log.csv", "below the surface", "radius_mm = 500 of trial.toml is 10 times too large"],
    );
    says(&radius("100"), &["pass1_log.csv", "radius_mm = 100 of trial.toml is the diameter"]);
    says(&radius("25"), &["pass1_log.csv", "above the surface", "radius_mm = 25 of trial.toml is half of the radius"]);
}

#[test]
fn a_spindle_speed_in_radians_per_second_is_refused() {
    says(&column(RPM, |rpm| rpm * 0.104_72), &["pass1_log.csv", "spindle_rpm", "9.5 times smaller", "rad/s"]);
    says(
        &manifest("spindle_rpm = 6000.0", "spindle_rpm = 628.3"),
        &["pass1_log.csv", "spindle_rpm of trial.toml in rad/s"],
    );
    says(&column(RPM, |rpm| rpm / 60.0), &["pass1_log.csv", "60 times smaller", "revolutions per second"]);
}

#[test]
fn a_rim_faster_than_any_wheel_is_refused() {
    let folder = column(RPM, |rpm| 10.0 * rpm);
    edit(folder.path(), "trial.toml", |text| text.replace("spindle_rpm = 6000", "spindle_rpm = 60000"));
    says(&folder, &["trial.toml", "spindle_rpm = 60000", "m/s", "at most 280 m/s"]);
}

#[test]
fn a_feed_in_millimetres_per_minute_is_refused() {
    let feed = std::fs::read_to_string(first_look().join("trial.toml")).unwrap();
    let feed = feed.lines().find(|line| line.starts_with("feed_mm_s")).unwrap().to_owned();
    let value: f64 = feed.split('=').nth(1).unwrap().trim().parse().unwrap();
    says(
        &manifest(&feed, &format!("feed_mm_s = {}", 60.0 * value)),
        &["pass1_log.csv", "feed_mm_s of trial.toml in mm/min"],
    );
    says(
        &manifest(&feed, &format!("feed_mm_s = {}", 1e-3 * value)),
        &["pass1_log.csv", "feed_mm_s of trial.toml in m/s"],
    );
}

#[test]
fn maps_in_metres_are_refused() {
    let folder = sound();
    numbers(folder.path(), &MAPS, |_, height| 1e-3 * height);
    says(&folder, &["pass1_log.csv", "above the surface of before.csv", "look like m"]);
    for (name, words) in
        [("before.csv", "look like m"), ("pass1_after.csv", "look like m"), ("before_repeat.csv", "look like m")]
    {
        let folder = sound();
        numbers(folder.path(), &[name], |_, height| 1e-3 * height);
        says(&folder, &[name, words]);
    }
}

#[test]
fn maps_with_the_other_sign_are_refused() {
    let folder = sound();
    numbers(folder.path(), &MAPS, |_, height| -height);
    says(
        &folder,
        &["pass1_log.csv", "above the surface of before.csv", "the heights of the scans have the other sign"],
    );
    for name in ["before.csv", "pass2_after.csv", "before_repeat.csv"] {
        let folder = sound();
        numbers(folder.path(), &[name], |_, height| -height);
        says(&folder, &[name, "other sign"]);
    }
}

#[test]
fn a_mirrored_scan_is_refused_by_name() {
    for name in ["before.csv", "before_repeat.csv", "pass1_after.csv"] {
        let folder = sound();
        mirrored(folder.path(), name, false);
        says(&folder, &[name, "mirrored along x"]);
    }
    let folder = sound();
    mirrored(folder.path(), "before.csv", true);
    says(&folder, &["before.csv", "mirrored along y"]);
    let folder = sound();
    mirrored(folder.path(), "before.csv", false);
    mirrored(folder.path(), "before.csv", true);
    says(&folder, &["before.csv", "half a turn"]);
}

/// Makes a plate, ground over 10 mm by a narrow wheel, whose groove lies 3 mm beside the path.
fn beside() -> Trial {
    let mut trial = grinding();
    let plate = |seed: usize, depth: f64| {
        let mixed =
            |at: usize| (at * 7 + seed).wrapping_mul(0x9e37_79b9_7f4a_7c15).rotate_left(31).wrapping_mul(0xbf58_476d);
        let noise = |at: usize| 2e-6 * ((mixed(at) >> 20) % 1009) as f64 / 1009.0;
        let groove = |p: glam::DVec2| (2.2e-3..=3.6e-3).contains(&p.y) && (2e-3..=12e-3).contains(&p.x);
        let mut map = sdf_bake::HeightMap::from_function(pixels(), |p| if groove(p) { -depth } else { 0.0 });
        map.heights.iter_mut().enumerate().for_each(|(at, height)| *height += noise(at));
        map
    };
    trial.tool = HeldTool::wheel(0.05, 2e-3, glam::DVec3::Y);
    (trial.scans.before, trial.scans.repeats) = (plate(1, 0.0), vec![plate(2, 0.0)]);
    trial.passes[0].log.rows.iter_mut().for_each(|row| row.position.z -= 1.5e-3);
    trial.passes[0].scan = PassScan::Heights(plate(3, 50e-6));
    trial
}

#[test]
fn removal_beside_the_path_is_refused() {
    let folder = tempfile::tempdir().unwrap();
    write_trial(&beside(), folder.path()).unwrap();
    says(
        &folder,
        &["pass1_after.csv", "100 % of the ground area", "where the tool never came", "mm along y", "origin_mm"],
    );
}

#[test]
fn copies_are_refused_by_name() {
    for (from, to) in [
        ("before.csv", "before_repeat.csv"),
        ("before.csv", "pass1_after.csv"),
        ("pass1_after.csv", "pass2_after.csv"),
        ("pass2_after.csv", "before_repeat.csv"),
    ] {
        let folder = sound();
        copied(folder.path(), from, to);
        let first = if from == "pass2_after.csv" { to } else { from };
        says(&folder, &["the same heights as", first, "copy"]);
    }
    let folder = sound();
    copied(folder.path(), "before.csv", "before_repeat.csv");
    numbers(folder.path(), &["before_repeat.csv"], |_, height| height + 0.012);
    says(&folder, &["before_repeat.csv", "the same heights as before.csv"]);
}

/// Repeats a scan of a ground surface: other noise, shifted by ±3 µm, on the heights of another file.
fn scanned_again(folder: &Path, from: &str, to: &str) {
    let text = std::fs::read_to_string(folder.join(from)).unwrap();
    let noise = |at: usize| 3e-3 * ((at.wrapping_mul(7919) % 1009) as f64 / 504.0 - 1.0);
    let line = |(row, line): (usize, &str)| {
        let cell = |(column, cell): (usize, &str)| match cell.parse::<f64>() {
            Ok(height) => format!("{:.4}", height + noise(row * 1000 + column)),
            Err(_) => cell.to_owned(),
        };
        line.split(',').enumerate().map(cell).collect::<Vec<_>>().join(",") + "\n"
    };
    std::fs::write(folder.join(to), text.lines().enumerate().map(line).collect::<String>()).unwrap();
}

#[test]
fn a_repeated_scan_made_after_a_pass_is_refused() {
    for from in ["pass1_after.csv", "pass2_after.csv"] {
        let folder = sound();
        scanned_again(folder.path(), from, "before_repeat.csv");
        says(&folder, &["before_repeat.csv", "below before.csv", "of what pass1_after.csv shows", "made after a pass"]);
    }
}

#[test]
fn a_repeated_scan_named_from_after_the_last_pass_is_refused() {
    let folder = manifest("repeat = [\"before_repeat.csv\"]", "repeat = [\"pass2_after.csv\"]");
    says(&folder, &["trial.toml", "pass2_after.csv is named as two scans"]);
}

#[test]
fn a_repeated_scan_of_another_part_is_refused() {
    let folder = sound();
    let other = first_look().with_file_name("trial-2").join("before.csv");
    std::fs::copy(other, folder.path().join("before_repeat.csv")).unwrap();
    says(&folder, &["before_repeat.csv"]);
}

#[test]
fn a_repeated_scan_with_its_own_noise_passes() {
    let folder = sound();
    scanned_again(folder.path(), "before_repeat.csv", "kept.csv");
    copied(folder.path(), "kept.csv", "before_repeat.csv");
    assert_eq!(Trial::read(folder.path()).unwrap().notes, Trial::read(&first_look()).unwrap().notes);
}

#[test]
fn sound_campaigns_pass_without_a_note() {
    let bundled = first_look();
    let mut folders = vec![bundled.parent().unwrap().to_owned()];
    if let Some(place) = campaigns() {
        folders.extend("abcdefgh".chars().map(|name| place.join(format!("open-{name}"))));
    }
    for folder in folders {
        let campaign = Campaign::read(&folder).unwrap_or_else(|error| panic!("{}: {error}", folder.display()));
        let notes = campaign.notes();
        assert!(notes.is_empty(), "{}: {notes:?}", folder.display());
    }
}
