//! Invalid tables: each is refused with its name, or read with a note.

use trials::table::Table;

use crate::synthetic::{Hidden, MANIFEST, csv, folder, work};

fn rows() -> String {
    csv(&work(Hidden::Nothing, 0.02, 41))
}

fn refused(manifest: &str, csv: &str, words: &[&str]) {
    let error = Table::read(folder(manifest, csv).path()).expect_err(&format!("{words:?}")).to_string();
    for word in words {
        assert!(error.contains(word), "{word:?} is not in {error:?}");
    }
}

fn noted(csv: &str, words: &[&str]) -> Table {
    let table = Table::read(folder(MANIFEST, csv).path()).unwrap_or_else(|error| panic!("{error}"));
    for word in words {
        assert!(table.notes.iter().any(|note| note.contains(word)), "{word:?} is not in {:?}", table.notes);
    }
    table
}

/// Returns the CSV with one cell of a line replaced.
fn with_cell(line: usize, column: usize, cell: &str) -> String {
    let change = |(k, text): (usize, &str)| {
        let mut cells: Vec<&str> = text.split(',').collect();
        if k + 1 == line {
            cells[column] = cell;
        }
        cells.join(",") + "\n"
    };
    rows().lines().enumerate().map(change).collect()
}

#[test]
fn faults_of_the_manifest_are_refused_at_their_place() {
    for (from, to, words) in [
        (
            "finishing-table/1",
            "finishing-trial/1",
            &["table.toml, line 1", "finishing-trial/1", "finishing-table/1"][..],
        ),
        ("process = \"grinding\"", "process = \"griding\"", &["line 3", "griding", "grinding, sanding or polishing"]),
        ("csv = \"rows.csv\"", "csv = \"row.csv\"", &["line 4", "row.csv is not there"]),
        (
            "column = \"load\"",
            "column = \"loda\"",
            &["line 7", "no column \"loda\" for force", "did you mean \"load\""],
        ),
        ("unit = \"N\"", "unit = \"mm\"", &["line 7", "the unit of force is one of [m]", "such as N"]),
        ("unit = \"um\"", "unit = \"furlong\"", &["line 10", "furlong"]),
        ("unit = \"um\"", "unit = \"kg\"", &["no density for a removed mass", "density_kg_m3"]),
        (", unit = \"s\"", "", &["line 9", "no unit in duration"]),
        ("force =", "forse =", &["unknown key \"forse\"", "did you mean \"force\""]),
        ("area_mm2 = 100", "area_mm2 = -1", &["line 7", "area_mm2 is not above zero"]),
        ("area_mm2 = 100", "aera_mm2 = 100", &["unknown key \"aera_mm2\"", "did you mean \"area_mm2\""]),
        ("[columns]", "[colums]", &["unknown key \"colums\"", "columns"]),
        ("[columns]", "[columns", &["table.toml, line 6"]),
        ("duration = { column = \"t\", unit = \"s\" }\n", "", &["no duration in [columns]"]),
        ("removed = {", "wear = {", &["no removed in [columns]"]),
        (
            "speed = { column = \"belt\", unit = \"m/s\" }",
            "spindle_rpm = { column = \"belt\" }",
            &["no radius for spindle_rpm"],
        ),
    ] {
        assert!(MANIFEST.contains(from), "{from}");
        refused(&MANIFEST.replacen(from, to, 1), &rows(), words);
    }
    let empty = tempfile::tempdir().unwrap();
    let error = Table::read(empty.path()).unwrap_err().to_string();
    assert!(error.contains("table.toml") && error.contains("cannot be read"), "{error}");
}

#[test]
fn bad_cells_cost_their_row_and_are_named() {
    for (cell, column, words) in [
        ("", 0, &["1 rows are left out: line 7 (load is empty)"][..]),
        ("nan", 0, &["line 7 (load is \"nan\", not a number)"]),
        ("-5", 0, &["line 7 (load is -5, not above zero)"]),
        ("n/a", 1, &["line 7 (belt is \"n/a\", not a number)"]),
        ("0", 2, &["line 7 (t is 0, not above zero)"]),
    ] {
        let table = noted(&with_cell(7, column, cell), words);
        assert_eq!(table.rows.len(), 89, "{cell}");
    }
    for cell in ["", "-3", "broken"] {
        let table = noted(&with_cell(7, 4, cell), &["1 rows are without a removal", "line 7 (depth is"]);
        assert_eq!(table.rows.len(), 90, "{cell}");
        assert_eq!(table.rows[5].removal_rate, None);
    }
}

#[test]
fn a_last_line_cut_in_half_is_left_out_and_any_other_is_refused() {
    let whole = rows();
    let cut = whole.trim_end().rsplit_once(',').unwrap().0;
    assert_eq!(noted(cut, &["line 91, the last one, is cut short after 4 cells"]).rows.len(), 89);
    let short: String = whole
        .lines()
        .enumerate()
        .map(|(k, line)| if k == 5 { "10,20\n".to_owned() } else { format!("{line}\n") })
        .collect();
    refused(MANIFEST, &short, &["rows.csv, line 6", "2 cells where the header has 5"]);
}

#[test]
fn wrong_units_are_named() {
    refused(
        &MANIFEST.replace("\"um\"", "\"m\""),
        &rows(),
        &["rows.csv, line 1, column 5", "the median of depth", "is the unit right?"],
    );
    refused(&MANIFEST.replace("\"m/s\"", "\"km/s\""), &rows(), &["the median of belt", "is the unit right?"]);
}

#[test]
fn tables_without_enough_are_refused() {
    refused(MANIFEST, "", &["rows.csv", "the file is empty"]);
    refused(MANIFEST, "load,belt,t,wear,depth\n", &["0 rows with a removal", "at least 4"]);
    let text: String = rows()
        .lines()
        .enumerate()
        .map(
            |(k, line)| {
                if k == 0 { format!("{line}\n") } else { line.replacen(|c: char| c.is_ascii_digit(), "x", 1) + "\n" }
            },
        )
        .collect();
    refused(MANIFEST, &text, &["rows.csv, line 2, column 1", "not a number", "90 of 90 rows cannot be used"]);
    refused(
        &MANIFEST.replace("csv = \"rows.csv\"", "csv = \"rows.csv\"\norder = \"dat\""),
        &rows(),
        &["no column \"dat\" for order"],
    );
}

#[test]
fn an_order_or_role_that_cannot_be_read_is_refused_at_its_line() {
    let added = |name: &str, cell: &dyn Fn(usize) -> String| -> String {
        rows()
            .lines()
            .enumerate()
            .map(|(k, line)| format!("{line},{}\n", if k == 0 { name.to_owned() } else { cell(k) }))
            .collect()
    };
    let dates = added("date", &|k| if k == 8 { "soon".to_owned() } else { format!("2024-03-{:02}", 1 + k % 28) });
    let ordered = MANIFEST.replace("csv = \"rows.csv\"", "csv = \"rows.csv\"\norder = \"date\"");
    refused(&ordered, &dates, &["rows.csv, line 9, column 6", "\"soon\"", "2024-03-31"]);
    let roles = added("split", &|k| if k == 4 { "maybe".to_owned() } else { "calibration".to_owned() });
    refused(
        &format!("{MANIFEST}role = {{ column = \"split\" }}\n"),
        &roles,
        &["rows.csv, line 5, column 6", "\"maybe\"", "calibration or evaluation"],
    );
}

#[test]
fn rows_of_a_thousand_columns_are_refused_in_few_words() {
    let header: String = (0..1000).map(|k| format!("column_{k},")).collect();
    let csv = format!("{header}end\n{}\n", "1,".repeat(1000) + "1");
    let error = Table::read(folder(MANIFEST, &csv).path()).expect_err("no column is there").to_string();
    assert!(error.contains("no column") && error.contains("and 981 more"), "{error}");
    assert!(error.chars().count() < 2000, "{error}");
}
