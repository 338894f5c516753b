//! Text exports of Keyence's VR series, in all known variants.

mod common;

use std::fmt::Write;
use std::path::Path;

use common::{FULL, MapOf, NX, NY, compare, height, is_hole, read_bytes};
use instruments::surface::{self, Source, Window};

const ENGLISH: [&str; 5] = ["XY Calibration", "Horizontal", "Vertical", "Unit", "Height"];
const GERMAN: [&str; 5] = ["XY-Justierung", "Horizont.", "Vertikal", "Einheit", "Höhe"];

/// An export with heights in `unit` per metre, rows from the lowest y.
fn export(keys: [&str; 5], (unit, per_metre): (&str, f64)) -> String {
    let [calibration, horizontal, vertical, unit_key, title] = keys;
    let mut text =
        "\"Measured date\",\"2024/01/31\"\r\n\"Model\",\"VR-6000\"\r\n\"File version\",\"1000\"\r\n".to_owned();
    let _ = write!(text, "\"{calibration}\",\"5.000\",\"um\"\r\n\"Output image data\",\"Height\"\r\n");
    let _ = write!(text, "\"{horizontal}\",\"{NX}\"\r\n\"{vertical}\",\"{NY}\"\r\n\"{unit_key}\",\"{unit}\"\r\n");
    let _ = write!(text, "\"Reference data name\",\"\"\r\n\r\n\"{title}\"\r\n");
    for j in 0..NY {
        let cell = |i| if is_hole(i, j) { "\"\"".to_owned() } else { format!("\"{:.9}\"", height(i, j) * per_metre) };
        text += &(0..NX).map(cell).collect::<Vec<_>>().join(",");
        text += "\r\n";
    }
    text
}

#[test]
fn exports_in_any_language_unit_and_separator() {
    for (k, text) in [
        export(ENGLISH, ("mm", 1e3)),
        export(GERMAN, ("um", 1e6)),
        export(GERMAN, ("mm", 1e3)).replace(',', ";").replace('.', ","),
        export(ENGLISH, ("mm", 1e3)).replace('"', ""),
        export(ENGLISH, ("mm", 1e3)).replace("\"5.000\",\"um\"", "\"0.005 mm\""),
    ]
    .into_iter()
    .enumerate()
    {
        let map = read_bytes(Path::new("scan.csv"), text.as_bytes());
        assert_eq!((map.format, map.nx, map.ny), ("Keyence export", NX, NY), "export {k}");
        assert!((map.pitch.unwrap() / 5e-6 - 1.0).abs().max_element() < 1e-12, "export {k}");
        compare(&format!("export {k}"), &map.heights, MapOf::Holes, 0.6e-12 + 1e-9 * FULL);
    }
}

#[test]
fn the_optical_image_beside_an_export_is_refused() {
    let text =
        export(ENGLISH, ("mm", 1e3)).replace("\"Output image data\",\"Height\"", "\"Output image data\",\"Optical\"");
    let source = Source { file: Path::new("scan.csv"), bytes: text.as_bytes(), window: Window::default() };
    let error = surface::read(&source).unwrap_err().to_string();
    assert!(error.contains("optical image"), "{error}");
}
