//! Files as received from users: truncated, in other units, with other separators, with a clock that jumps.

use std::fs;

use trials::trial::{PassScan, Trial};

use crate::files::{edit, folder, noted, refused};

#[test]
fn a_wrong_key_names_the_near_one_and_its_place() {
    let folder = folder();
    edit(folder.path(), "trial.toml", |text| text.replace("force_setpoint_n", "force_setpoint"));
    refused(folder.path(), &["trial.toml, line", "column 1", "\"force_setpoint\" in [pass]", "\"force_setpoint_n\""]);
}

#[test]
fn wrong_values_in_the_manifest_are_refused_at_their_place() {
    for (from, to, words) in [
        ("radius_mm = 50.0", "radius_mm = -50.0", &["radius_mm is -50", "above zero", "line 7, column 13"][..]),
        ("radius_mm = 50.0", "radius_mm = nan", &["radius_mm is NaN", "above zero"]),
        ("radius_mm = 50.0", "radius_mm = \"50\"", &["invalid type: string", "column 13"]),
        ("process = \"grinding\"", "process = \"griding\"", &["griding", "grinding"]),
        ("format = \"finishing-trial/1\"", "format = \"finishing-trial/2\"", &["finishing-trial/2", "is expected"]),
        ("before = \"before.csv\"", "before = \"befor.csv\"", &["befor.csv is not there", "line"]),
        ("axis = [0.0, 1.0, 0.0]", "axis = [0, 0, 0]", &["axis is", "a vector with a length"]),
        ("kind = \"wheel\"", "kind = \"pad\"", &["a pad with width_mm", "radius only"]),
        ("period_s = 0.0005", "", &["an admittance controller without period_s"]),
        ("[[pass]]", "[pass]", &["invalid type: map"]),
        ("[scan]", "[scan", &["trial.toml, line"]),
    ] {
        let folder = folder();
        edit(folder.path(), "trial.toml", |text| {
            assert!(text.contains(from), "{from} is not in {text}");
            text.replacen(from, to, 1)
        });
        refused(folder.path(), words);
    }
    let empty = tempfile::tempdir().unwrap();
    refused(empty.path(), &["trial.toml", "cannot be read"]);
}

#[test]
fn separators_bom_and_line_ends_do_not_matter() {
    let plain = Trial::read(folder().path()).unwrap();
    let folder = folder();
    for name in ["before.csv", "pass1_after.csv", "pass1_log.csv"] {
        edit(folder.path(), name, |text| {
            format!("\u{feff}{}", text.replace(',', ";").replace('.', ",").replace('\n', "\r\n"))
        });
    }
    let trial = noted(folder.path(), &["before.csv", "decimals are written with commas"]);
    assert!(trial.notes.iter().any(|note| note.contains("semicolons")), "{:?}", trial.notes);
    assert_eq!(trial.scans.before.missing(), 4);
    let same = |(a, b): (&f64, &f64)| a == b || (a.is_nan() && b.is_nan());
    assert!(trial.scans.before.heights.iter().zip(&plain.scans.before.heights).all(same));
    assert_eq!(trial.passes[0].log.rows, plain.passes[0].log.rows);
}

#[test]
fn commas_that_separate_cells_and_decimals_are_refused() {
    let folder = folder();
    edit(folder.path(), "before.csv", |text| text.replace('.', ","));
    refused(folder.path(), &["before.csv"]);
    let folder = crate::files::folder();
    edit(folder.path(), "pass1_log.csv", |text| text.replace('.', ","));
    refused(folder.path(), &["pass1_log.csv, line", "are decimals written with commas?"]);
}

#[test]
fn a_file_that_was_cut_short_survives_without_the_cut_part() {
    let folder = folder();
    let whole = Trial::read(folder.path()).unwrap();
    edit(folder.path(), "pass1_log.csv", |text| text[..text.trim_end().len() - 20].to_owned());
    edit(folder.path(), "before.csv", |text| text[..text.len() - 20].to_owned());
    let cut = noted(folder.path(), &["pass1_log.csv", "cut short", "left out"]);
    assert_eq!(cut.passes[0].log.rows.len(), whole.passes[0].log.rows.len() - 1);
    assert!(cut.notes.iter().any(|note| note.contains("before.csv: line 33 is cut short")), "{:?}", cut.notes);
    assert!(cut.scans.before.missing() > whole.scans.before.missing());

    let folder = crate::files::folder();
    edit(folder.path(), "before.csv", |text| text[..text.len() / 2].to_owned());
    refused(folder.path(), &["pixels", "61 x 33"]);
    let folder = crate::files::folder();
    edit(folder.path(), "pass1_log.csv", |text| text.replacen("\n0.04,", "\n", 1));
    refused(folder.path(), &["pass1_log.csv, line 4", "cells where the header has"]);
}

#[test]
fn a_row_of_another_length_and_a_word_are_refused_at_their_cell() {
    let folder = folder();
    edit(folder.path(), "before.csv", |text| text.replacen("\n0,", "\n0,0,", 1));
    refused(folder.path(), &["before.csv, line 2, column 62", "62 cells where the first row has 61"]);
    let folder = crate::files::folder();
    edit(folder.path(), "pass1_after.csv", |text| text.replacen("\n0,0,", "\n0,oops,", 1));
    refused(folder.path(), &["pass1_after.csv, line 2, column 2", "\"oops\"", "a number"]);
}

#[test]
fn nan_and_infinity_are_missing_pixels_in_maps_and_refused_in_logs() {
    let folder = folder();
    edit(folder.path(), "before.csv", |text| text.replacen("\n0,0,0,", "\nNaN,inf,1e999,", 1));
    let trial = noted(folder.path(), &["before.csv", "3 cells say NaN or infinity"]);
    assert_eq!(trial.scans.before.missing(), 7);
    edit(folder.path(), "pass1_log.csv", |text| text.replacen("\n0.04,2,", "\n0.04,nan,", 1));
    refused(folder.path(), &["pass1_log.csv, line 4, column 2", "nan", "a finite number"]);
}

#[test]
fn scans_of_different_sizes_are_refused_with_both() {
    let folder = folder();
    edit(folder.path(), "pass1_after.csv", |text| text.lines().skip(1).map(|line| format!("{line}\n")).collect());
    refused(folder.path(), &["pass1_after.csv", "61 x 32 pixels", "61 x 33 pixels"]);
}

#[test]
fn units_that_cannot_be_are_named() {
    let scaled = |text: String, factor: f64, columns: std::ops::Range<usize>| -> String {
        let line = |line: &str| -> String {
            let cell = |(k, cell): (usize, &str)| match cell.parse::<f64>() {
                Ok(value) if columns.contains(&k) => format!("{}", value * factor),
                _ => cell.to_owned(),
            };
            line.split(',').enumerate().map(cell).collect::<Vec<_>>().join(",")
        };
        text.lines().map(|text| line(text) + "\n").collect()
    };
    let map = |factor: f64| {
        let folder = folder();
        for name in ["before.csv", "before_repeat.csv", "pass1_after.csv"] {
            edit(folder.path(), name, |text| scaled(text, factor, 0..usize::MAX));
        }
        folder
    };
    refused(map(1e3).path(), &["before", "look like µm"]);
    refused(map(1e-3).path(), &["before", "look like m"]);
    let log = |factor: f64, columns: std::ops::Range<usize>| {
        let folder = folder();
        edit(folder.path(), "pass1_log.csv", |text| scaled(text, factor, columns));
        folder
    };
    refused(log(1e-3, 1..4).path(), &["pass1_log.csv", "look like m"]);
    refused(log(1e3, 1..4).path(), &["pass1_log.csv", "look like µm"]);
    refused(log(1e3, 0..1).path(), &["pass1_log.csv", "look like ms"]);
}

#[test]
fn a_path_beside_the_map_is_refused_with_both_places() {
    let folder = folder();
    edit(folder.path(), "trial.toml", |text| text.replace("origin_mm = [0.0, -4.0]", "origin_mm = [0.0, 40.0]"));
    refused(folder.path(), &["pass1_log.csv", "all contact is at", "y 40.00 to 48.00 mm"]);
}

#[test]
fn a_clock_that_runs_backwards_is_refused_and_one_that_stands_is_noted() {
    let folder = folder();
    edit(folder.path(), "pass1_log.csv", |text| text.replacen("\n0.1,", "\n0.08,", 1));
    noted(folder.path(), &["pass1_log.csv", "1 rows repeat the time"]);
    edit(folder.path(), "pass1_log.csv", |text| {
        text.replacen("\n0.08,", "\n0.07,", 2).replacen("\n0.07,", "\n0.08,", 1)
    });
    refused(folder.path(), &["pass1_log.csv, line 7, column 1", "runs backwards, from 0.08 s to 0.07 s"]);
}

#[test]
fn what_is_no_table_is_refused() {
    for (bytes, words) in [
        (&b""[..], "empty"),
        (b"\xef\xbb\xbf  \r\n", "empty"),
        (b"\xff\xfet\0_\0s\0", "UTF-16"),
        (b"0,1\n\0,0\n", "zero"),
        (b"PK\x03\x04\0\0", "not a readable zip"),
        (b",,,\n,,,\n,,,\n,,,\n", "every cell is empty"),
    ] {
        let folder = folder();
        fs::write(folder.path().join("before.csv"), bytes).unwrap();
        refused(folder.path(), &["before.csv", words]);
    }
    let folder = folder();
    fs::write(folder.path().join("pass1_log.csv"), "t_s,x_mm,y_mm,z_mm,force_n,spindle_rpm\n").unwrap();
    refused(folder.path(), &["pass1_log.csv", "0 rows", "at least 2"]);
    fs::write(folder.path().join("pass1_log.csv"), "t_s,x_mm,y_mm,z_mm,force,spindle_rpm\n0,0,0,0,0,0\n").unwrap();
    refused(folder.path(), &["line 1", "no column force_n", "the nearest is \"force\""]);
}

#[test]
fn masks_hold_zero_and_one() {
    let folder = tempfile::tempdir().unwrap();
    trials::trial::write_trial(&crate::files::sanding(), folder.path()).unwrap();
    let trial = Trial::read(folder.path()).unwrap();
    assert!(matches!(&trial.passes[0].scan, PassScan::Exposure(mask) if mask.exposed.contains(&None)));
    edit(folder.path(), "pass1_exposed.csv", |text| text.replacen("\n0,", "\n0.5,", 1));
    refused(folder.path(), &["pass1_exposed.csv, line", "0.5", "1 for exposed"]);
}

#[test]
fn words_for_missing_heights_are_read_as_missing_and_walls_a_metre_deep_are_refused() {
    let plain = Trial::read(folder().path()).unwrap();
    let with = |text: &str, word: &str| {
        let (row, rest) = text.split_once('\n').unwrap();
        let cells: Vec<&str> = row.split(',').collect();
        format!("{},{word},{}\n{rest}", cells[0], cells[2..].join(","))
    };
    for word in ["-9999", "-9999.0", "-32768", "1.70141e38"] {
        let folder = folder();
        edit(folder.path(), "before.csv", |text| with(&text, word));
        let trial = noted(folder.path(), &["before.csv", "1 cells say", "read as missing"]);
        assert_eq!(trial.scans.before.missing(), plain.scans.before.missing() + 1, "{word}");
    }
    let folder = folder();
    edit(folder.path(), "before.csv", |text| with(&text, "-5000"));
    refused(folder.path(), &["before.csv", "from -5000.0 to", "heights within a metre", "Leave such cells empty"]);
}

#[test]
fn a_log_of_a_thousand_columns_is_refused_in_few_words() {
    let folder = folder();
    let header: String = (0..1000).map(|k| format!("column_{k},")).collect();
    fs::write(folder.path().join("pass1_log.csv"), format!("{header}end\n1\n")).unwrap();
    let message = refused(folder.path(), &["pass1_log.csv, line 1", "no column t_s", "and 981 more"]);
    assert!(message.chars().count() < 2000, "{message}");
}
