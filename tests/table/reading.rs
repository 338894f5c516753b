//! Columns, units, order and roles.

use effects::Process;
use trials::table::{Removed, Table};
use trials::trial::Role;

use crate::synthetic::{Hidden, MANIFEST, csv, folder, work};

fn read(manifest: &str, csv: &str) -> Table {
    Table::read(folder(manifest, csv).path()).unwrap_or_else(|error| panic!("{error}"))
}

#[test]
fn quantities_come_out_in_si_units() {
    let table = read(MANIFEST, &csv(&work(Hidden::Nothing, 0.0, 1)));
    let row = &table.rows[0];
    let made = work(Hidden::Nothing, 0.0, 1)[0];
    assert_eq!((row.force, row.speed, row.duration), (Some(made.force), Some(made.speed), Some(made.duration)));
    assert!((row.pressure.unwrap() / (made.force / 1e-4) - 1.0).abs() < 1e-12);
    assert!((row.removal_rate.unwrap() * made.duration / made.depth - 1.0).abs() < 1e-6);
    assert_eq!((table.process, table.removed), (Process::Grinding, Removed::Depth));
    assert_eq!(table.covariates.iter().map(|covariate| covariate.name.as_str()).collect::<Vec<_>>(), ["wear"]);
    assert_eq!(table.rows.iter().filter(|row| row.role == Role::Evaluation).count(), 30);
    assert!(table.notes.iter().any(|note| note.contains("30 of 90 are drawn at random")), "{:?}", table.notes);
}

#[test]
fn mass_rate_spindle_speed_pressure_and_temperature_are_understood() {
    let manifest = r#"
format = "finishing-table/1"
name = "polishing"
process = "polishing"
csv = "rows.csv"
radius_mm = 50
[columns]
pressure = { column = "p", unit = "kPa", area_mm2 = 200 }
spindle_rpm = { column = "n" }
removed = { column = "mrr", unit = "g/min", density_kg_m3 = 8000 }
usage = [{ column = "hours", unit = "h" }]
temperature = { column = "T", unit = "degC" }
"#;
    let csv = "p,n,mrr,hours,T\n20,600,0.24,1,20\n30,600,0.36,2,21\n40,600,0.48,3,22\n50,600,0.6,4,23\n60,600,0.72,5,24\n70,-600,0.8,6,25\n";
    let table = read(manifest, csv);
    let row = &table.rows[0];
    assert_eq!((table.process, table.removed), (Process::Sanding, Removed::Volume));
    assert!((row.removal_rate.unwrap() / (0.24e-3 / 60.0 / 8000.0) - 1.0).abs() < 1e-12);
    assert!((row.force.unwrap() - 4.0).abs() < 1e-12);
    assert!((row.speed.unwrap() - 0.05 * 20.0 * std::f64::consts::PI).abs() < 1e-12);
    assert!((table.rows[5].speed.unwrap() - row.speed.unwrap()).abs() < 1e-12);
    assert_eq!(row.duration, None);
    let usage: Vec<(&str, f64)> = table.usage.iter().map(|usage| usage.name.as_str()).zip(row.usage.clone()).collect();
    assert!(usage.contains(&("hours", 3600.0)) && usage.contains(&("T", 293.15)), "{usage:?}");
    assert!(table.notes.iter().any(|note| note.contains("no column gives a duration")), "{:?}", table.notes);
}

#[test]
fn rows_are_put_in_the_order_of_their_dates() {
    let rows = csv(&work(Hidden::Nothing, 0.0, 1));
    let dated = |(k, line): (usize, &str)| match k {
        0 => format!("{line},date\n"),
        _ => format!("{line},{:02}.03.2024 10:00\n", 1 + (k * 7) % 28),
    };
    let text: String = rows.lines().take(25).enumerate().map(dated).collect();
    let manifest = MANIFEST.replace("csv = \"rows.csv\"", "csv = \"rows.csv\"\norder = \"date\"");
    let table = read(&manifest, &text);
    let began: Vec<f64> = table.rows.iter().map(|row| row.began.unwrap()).collect();
    assert!(began.is_sorted() && began[0] == 0.0 && began[1] % 86400.0 == 0.0, "{began:?}");
    assert!(!table.rows.iter().map(|row| row.line).is_sorted());
    assert!(table.notes.iter().any(|note| note.contains("by date, read as %d.%m.%Y %H:%M")), "{:?}", table.notes);
}

#[test]
fn semicolons_decimal_commas_quotes_bom_and_line_ends_do_not_matter() {
    let rows = csv(&work(Hidden::Nothing, 0.0, 1));
    let plain = read(MANIFEST, &rows);
    let quoted = rows.replace(',', ";").replace('.', ",").replacen("load", "\"load\"", 1).replace('\n', "\r\n");
    let other = read(MANIFEST, &format!("\u{feff}{quoted}"));
    assert_eq!(plain.rows, other.rows);
    for word in ["semicolons", "commas"] {
        assert!(other.notes.iter().any(|note| note.contains(word)), "{:?}", other.notes);
    }
}

#[test]
fn the_table_of_the_project_is_read() {
    let folder = std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join("data/tables/belt-sanding");
    let table = Table::read(&folder).unwrap();
    assert_eq!(table.rows.len(), 72);
    assert_eq!(table.groups.len(), 2);
    assert!(table.rows[0].began.is_some());
}

#[test]
fn columns_that_differ_in_case_are_two() {
    let text = csv(&work(Hidden::Nothing, 0.0, 1)).replacen("wear", "T", 1);
    let table = read(&format!("{MANIFEST}temperature = {{ column = \"T\", unit = \"degC\" }}\n"), &text);
    assert_eq!((table.usage[0].name.as_str(), table.usage[0].unit.as_str()), ("T", "degC"));
    assert!(table.rows[0].duration.unwrap() >= 20.0, "t is the duration");
    let upper = read(&MANIFEST.replace("\"load\"", "\"LOAD\""), &csv(&work(Hidden::Nothing, 0.0, 1)));
    assert_eq!(upper.rows.len(), 90, "one column that differs in case is meant");
}

#[test]
fn noise_may_be_stated() {
    let text = csv(&work(Hidden::Nothing, 0.0, 1));
    for (stated, noise) in [("\"5 %\"", 0.05), ("\"0.5%\"", 0.005), ("0.03", 0.03), ("\"0.02 1\"", 0.02)] {
        let table = read(&MANIFEST.replace("[columns]", &format!("noise = {stated}\n[columns]")), &text);
        assert!((table.noise.unwrap() - noise).abs() < 1e-12, "{stated}");
        assert_eq!(lab::RowEvidence::new(&table).unwrap().noise, table.noise.unwrap());
    }
    for stated in ["5", "\"5 mm\"", "0.0", "\"much\"", "[1]"] {
        let manifest = MANIFEST.replace("[columns]", &format!("noise = {stated}\n[columns]"));
        let error = Table::read(folder(&manifest, &text).path()).unwrap_err().to_string();
        assert!(error.contains("table.toml, line 6") && error.contains("noise = \"5 %\""), "{stated}: {error}");
    }
}

#[test]
fn a_file_sorted_by_a_setting_is_no_time_unless_it_says_so() {
    let mut rows = work(Hidden::Nothing, 0.0, 1);
    assert!(read(MANIFEST, &csv(&rows)).in_time);
    let ordered = |order: &str| MANIFEST.replace("[columns]", &format!("order = \"{order}\"\n[columns]"));
    let none = read(&ordered("none"), &csv(&rows));
    assert!(!none.in_time && none.notes.iter().any(|note| note.contains("nothing about time")), "{:?}", none.notes);
    rows.sort_by(|a, b| a.force.total_cmp(&b.force));
    let sorted = read(MANIFEST, &csv(&rows));
    assert!(!sorted.in_time && sorted.notes.iter().any(|note| note.contains("sorted by force")), "{:?}", sorted.notes);
    assert!(read(&ordered("file"), &csv(&rows)).in_time);
}

#[test]
fn a_mark_of_a_missing_value_is_no_value() {
    let usage = format!("{MANIFEST}usage = {{ column = \"wear\", unit = \"mm^3\" }}\n");
    let text = csv(&work(Hidden::Nothing, 0.0, 1));
    let line = text.lines().nth(6).unwrap();
    let cells: Vec<&str> = line.split(',').collect();
    let marked = text.replace(line, &[cells[0], cells[1], cells[2], "-9999", cells[4]].join(","));
    let table = read(&usage, &marked);
    assert_eq!(table.rows.len(), 89);
    assert!(table.notes.iter().any(|note| note.contains("line 7 (wear is -9999, a mark of a missing value)")));
    assert!(read(MANIFEST, &marked).covariates[0].values[5].is_nan());
}
