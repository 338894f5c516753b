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
    let roles: Vec<Role> = table.rows[..3].iter().map(|row| row.role).collect();
    assert_eq!(roles, [Role::Calibration, Role::Calibration, Role::Evaluation]);
    assert!(table.notes.iter().any(|note| note.contains("every third one")), "{:?}", table.notes);
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
