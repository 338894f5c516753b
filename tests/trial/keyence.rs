//! Height exports of an instrument instead of plain grids.

use std::fmt::Write as _;
use std::fs;
use std::path::Path;

use trials::trial::{ScanFrame, Trial, read_heights};

use crate::files::{bead, edit, folder, noted, pixels, refused};

/// Returns an export in the layout of the VR series, heights in `unit` per metre.
fn export(keys: [&str; 5], unit: (&str, f64), rows: usize) -> String {
    let [calibration, horizontal, vertical, unit_key, title] = keys;
    let mut text = String::new();
    for (key, value) in [("Measured date", "2024/01/31 10:00:00"), ("Model", "VR-6000"), ("File version", "1000")] {
        let _ = write!(text, "\"{key}\",\"{value}\"\r\n");
    }
    let _ = write!(text, "\"{calibration}\",\"250.000\",\"um\"\r\n\"Output image data\",\"Height\"\r\n");
    let _ = write!(text, "\"{horizontal}\",\"61\"\r\n\"{vertical}\",\"33\"\r\n\"Minimum value\",\"0.000\"\r\n");
    let _ = write!(text, "\"{unit_key}\",\"{}\"\r\n\"Reference data name\",\"\"\r\n\r\n\"{title}\"\r\n", unit.0);
    for j in 0..rows {
        let cell = |i: usize| match (i, j) {
            (0 | 60, _) | (_, 0 | 32) => "\"\"".to_owned(),
            _ => format!("\"{:.3}\"", bead(pixels().position(i, j)) * unit.1),
        };
        text += &(0..61).map(cell).collect::<Vec<_>>().join(",");
        text += "\r\n";
    }
    text
}

const ENGLISH: [&str; 5] = ["XY Calibration", "Horizontal", "Vertical", "Unit", "Height"];
const GERMAN: [&str; 5] = ["XY-Justierung", "Horizont.", "Vertikal", "Einheit", "Höhe"];

fn read(text: &str, place: &Path) -> Result<trials::trial::Read<sdf_bake::HeightMap>, trials::trial::TrialError> {
    let file = place.join("scan.csv");
    fs::write(&file, text).unwrap();
    read_heights(&file, ScanFrame { origin: Some(pixels().origin), pitch: Some(0.3e-3), ..ScanFrame::default() })
}

#[test]
fn an_export_is_read_in_any_language_unit_and_separator() {
    let place = tempfile::tempdir().unwrap();
    let texts = [
        export(ENGLISH, ("mm", 1e3), 33),
        export(GERMAN, ("um", 1e6), 33),
        export(GERMAN, ("mm", 1e3), 33).replace(',', ";").replace('.', ","),
        export(ENGLISH, ("mm", 1e3), 33).replace('"', ""),
        export(ENGLISH, ("mm", 1e3), 33).replace("\"250.000\",\"um\"", "\"0.250 mm\""),
    ];
    for (k, text) in texts.iter().enumerate() {
        let scan = read(text, place.path()).unwrap_or_else(|error| panic!("export {k}: {error}"));
        assert!((scan.content.pixels.pitch - 0.25e-3).abs() < 1e-12, "export {k}");
        assert_eq!((scan.content.pixels.nx, scan.content.pixels.ny), (61, 33), "export {k}");
        assert_eq!(scan.content.missing(), 2 * (61 + 33) - 4, "export {k}");
        let height = scan.content.height(30, 16);
        assert!((height - bead(pixels().position(30, 16))).abs() < 0.6e-6, "export {k}: {height}");
        assert!(scan.notes.iter().any(|note| note.contains("pitch of 0.25 mm is used")), "{:?}", scan.notes);
    }
}

#[test]
fn a_short_export_is_noted_and_an_optical_one_refused() {
    let place = tempfile::tempdir().unwrap();
    let scan = read(&export(ENGLISH, ("mm", 1e3), 30), place.path()).unwrap();
    assert!(scan.notes.iter().any(|note| note.contains("promise 33 rows, the file has 30")), "{:?}", scan.notes);
    let optical = export(ENGLISH, ("mm", 1e3), 33)
        .replace("\"Output image data\",\"Height\"", "\"Output image data\",\"Optical\"");
    assert!(read(&optical, place.path()).unwrap_err().to_string().contains("optical image"));
    let endless = export(ENGLISH, ("mm", 1e3), 0);
    assert!(read(&endless, place.path()).is_err());
}

#[test]
fn a_trial_may_be_scanned_with_exports() {
    let folder = folder();
    for (name, scale) in [("before.csv", 1.0), ("before_repeat.csv", 1.001), ("pass1_after.csv", 0.97)] {
        fs::write(folder.path().join(name), export(ENGLISH, ("mm", scale * 1e3), 33)).unwrap();
    }
    let trial = noted(folder.path(), &["before.csv", "Keyence export: 61 x 33 pixels"]);
    assert_eq!(trial.scans.before.pixels, pixels());
    assert_eq!(Trial::read(folder.path()).unwrap().scans.before.pixels.pitch, 0.25e-3);
    edit(folder.path(), "pass1_after.csv", |text| text.replace("250.000", "251.000"));
    refused(folder.path(), &["pass1_after.csv", "0.251 mm", "0.25 mm"]);
}
