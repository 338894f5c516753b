//! Invalid campaigns: refused with the file's name, or read with the same answer.

use std::fs;
use std::path::Path;

use effects::{CompiledModel, Library, Model};
use lab::{Agreement, Evidence, ScanEvidence, Split, calibrate_scans};
use tempfile::TempDir;
use trials::trial::{Campaign, Trial};

/// Copies the first trial of the bundled campaign, where a test may damage it.
fn trial() -> TempDir {
    let folder = tempfile::tempdir().unwrap();
    let from = Path::new(env!("CARGO_MANIFEST_DIR")).join("data/campaigns/first-look/trial-1");
    for entry in fs::read_dir(from).unwrap() {
        let entry = entry.unwrap();
        fs::copy(entry.path(), folder.path().join(entry.file_name())).unwrap();
    }
    folder
}

/// Changes the cells of a table without a header, or of the rows below one.
fn cells(folder: &Path, name: &str, header: usize, change: impl Fn(usize, usize, &str) -> String) {
    let place = folder.join(name);
    let text = fs::read_to_string(&place).unwrap();
    let line = |(row, line): (usize, &str)| {
        let cell = |(column, cell): (usize, &str)| change(row - header, column, cell);
        if row < header { line.to_owned() } else { line.split(',').enumerate().map(cell).collect::<Vec<_>>().join(",") }
    };
    let lines: Vec<String> = text.lines().enumerate().map(line).collect();
    fs::write(place, lines.join("\n") + "\n").unwrap();
}

fn scaled(cell: &str, factor: f64, plus: f64) -> String {
    cell.parse::<f64>().map_or(cell.to_owned(), |value| format!("{:.6}", factor * value + plus))
}

#[track_caller]
fn refused(folder: &Path, words: &[&str]) {
    let message = Trial::read(folder).expect_err("it must be refused").to_string();
    println!("{message}");
    words.iter().for_each(|word| assert!(message.contains(word), "{word:?} is missing in: {message}"));
}

/// Returns the number of tiles, and the agreement of the base law with each scan, with its defaults or fitted.
fn judged(folder: &Path, is_fitted: bool) -> (usize, Vec<Agreement>) {
    let trials = Campaign::read(folder).unwrap().trials;
    let mut evidence = ScanEvidence::new(&trials, None).unwrap();
    let model = Model::new(evidence.process());
    let law = if is_fitted {
        calibrate_scans(&mut evidence, &model, Library::builtin()).unwrap().last().fit.model.clone()
    } else {
        CompiledModel::new(&model, Library::builtin(), evidence.rows()).unwrap()
    };
    let tiles = evidence.views.iter().map(|view| view.data.tiles().len()).sum();
    (tiles, evidence.agreement(&law, Split::Calibration).unwrap())
}

/// Asserts that a change of the files changes no error of the base law with its defaults by more than `tolerance` [1].
#[track_caller]
fn survives(tolerance: f64, damage: impl Fn(&Path)) {
    survives_judged((tolerance, false), damage);
}

/// Same as [`survives`], optionally with a fitted law.
#[track_caller]
fn survives_judged((tolerance, is_fitted): (f64, bool), damage: impl Fn(&Path)) {
    let (sound, damaged) = (trial(), trial());
    damage(damaged.path());
    let [(tiles, before), (left, after)] = [&sound, &damaged].map(|folder| judged(folder.path(), is_fitted));
    for (before, after) in before.iter().zip(&after) {
        println!("{}: {:.3e} m before, {:.3e} m after, {left} of {tiles} tiles", before.about, before.rms, after.rms);
        assert!((after.rms / before.rms - 1.0).abs() <= tolerance, "{before:?} {after:?}");
    }
    assert!(left as f64 > 0.8 * tiles as f64, "{left} of {tiles} tiles are left");
}

#[test]
fn swapped_scans_are_refused_by_name() {
    let folder = trial();
    let place = |name: &str| folder.path().join(name);
    fs::rename(place("before.csv"), place("kept.csv")).unwrap();
    fs::rename(place("pass1_after.csv"), place("before.csv")).unwrap();
    fs::rename(place("kept.csv"), place("pass1_after.csv")).unwrap();
    refused(folder.path(), &["pass1_after.csv", "higher than before the pass", "swapped"]);
    let folder = trial();
    let place = |name: &str| folder.path().join(name);
    fs::rename(place("pass1_after.csv"), place("kept.csv")).unwrap();
    fs::rename(place("pass2_after.csv"), place("pass1_after.csv")).unwrap();
    fs::rename(place("kept.csv"), place("pass2_after.csv")).unwrap();
    refused(folder.path(), &["pass2_after.csv", "swapped"]);
}

#[test]
fn a_displaced_map_is_refused_with_its_way() {
    let folder = trial();
    let place = folder.path().join("pass1_after.csv");
    let text = fs::read_to_string(&place).unwrap();
    let moved = |line: &str| {
        let cells: Vec<&str> = line.split(',').collect();
        [&["", "", ""], &cells[..cells.len() - 3]].concat().join(",")
    };
    fs::write(&place, text.lines().map(|line| moved(line) + "\n").collect::<String>()).unwrap();
    refused(folder.path(), &["pass1_after.csv", "0.90 mm along x and 0.00 mm along y beside the scan before"]);
}

#[test]
fn a_wrong_unit_of_any_scan_is_refused_by_name() {
    for name in ["before.csv", "before_repeat.csv", "pass1_after.csv", "pass2_after.csv"] {
        let folder = trial();
        cells(folder.path(), name, 0, |_, _, cell| scaled(cell, 1e3, 0.0));
        refused(folder.path(), &[name, "look like µm"]);
    }
}

#[test]
fn a_map_of_another_size_is_refused_with_both() {
    let folder = trial();
    let place = folder.path().join("pass2_after.csv");
    let text = fs::read_to_string(&place).unwrap();
    fs::write(&place, text.lines().skip(1).map(|line| format!("{line}\n")).collect::<String>()).unwrap();
    refused(folder.path(), &["pass2_after.csv", "pixels", "as in the scan before the first pass"]);
}

#[test]
fn a_tilted_map_is_survived_and_noted() {
    survives(0.03, |folder| {
        let tilt = |row: usize, column: usize| 0.3 + 0.3 * (0.012 * column as f64 - 0.02 * row as f64);
        cells(folder, "pass1_after.csv", 0, |row, column, cell| scaled(cell, 1.0, tilt(row, column)));
        let notes = Trial::read(folder).unwrap().notes;
        assert!(notes.iter().any(|note| note.contains("pass1_after.csv: tilted by 23")), "{notes:?}");
    });
}

#[test]
// The law is fitted, because the scans' poses absorb a part of the misfit of an unfitted law, depending on the noise.
fn a_fifth_of_the_pixels_may_be_missing() {
    survives_judged((0.15, true), |folder| {
        for (number, name) in
            ["before.csv", "before_repeat.csv", "pass1_after.csv", "pass2_after.csv"].iter().enumerate()
        {
            cells(folder, name, 0, |row, column, cell| {
                let mixed = (row * 1000 + column + 1_000_000 * number).wrapping_mul(0x9e37_79b9_7f4a_7c15) >> 40;
                if mixed % 5 == 0 { String::new() } else { cell.to_owned() }
            });
        }
    });
}

#[test]
fn clocks_that_are_off_are_survived_and_noted() {
    survives(1e-3, |folder| {
        cells(folder, "pass2_log.csv", 1, |_, column, cell| match column {
            0 => scaled(cell, 1.0, 1_048_576.0),
            _ => cell.to_owned(),
        })
    });
    let late = trial();
    cells(late.path(), "pass2_log.csv", 1, |_, column, cell| match column {
        0 => scaled(cell, 1.0, 1_048_576.0),
        _ => cell.to_owned(),
    });
    let notes = Trial::read(late.path()).unwrap().notes;
    assert!(notes.iter().any(|note| note.contains("pass2_log.csv: begins 291.3 h after")), "{notes:?}");
    let slow = trial();
    cells(slow.path(), "pass1_log.csv", 1, |_, column, cell| match column {
        0 => scaled(cell, 2.0, 0.0),
        _ => cell.to_owned(),
    });
    let notes = Trial::read(slow.path()).unwrap().notes;
    assert!(notes.iter().any(|note| note.contains("where the feed is 10 mm/s: is the clock right?")), "{notes:?}");
}

#[test]
fn last_lines_cut_in_half_are_survived_and_noted() {
    survives(0.05, |folder| {
        for name in ["pass1_log.csv", "pass1_after.csv"] {
            let place = folder.join(name);
            let text = fs::read_to_string(&place).unwrap();
            let last = text.trim_end().rfind('\n').unwrap();
            fs::write(&place, &text[..last + (text.len() - last) / 2]).unwrap();
        }
        let notes = Trial::read(folder).unwrap().notes;
        assert!(notes.iter().filter(|note| note.contains("cut short")).count() == 2, "{notes:?}");
    });
}
