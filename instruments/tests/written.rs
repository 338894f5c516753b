//! Maps that are written and read back.

mod common;

use std::path::Path;

use common::{NX, NY, PITCH, height, is_hole, read_bytes};
use glam::DVec2;
use instruments::surface::{Surface, Unwritable, write};

/// The map of all samples.
fn map() -> Surface {
    let value = |at: usize| if is_hole(at % NX, at / NX) { f64::NAN } else { height(at % NX, at / NX) };
    Surface {
        format: "X3P",
        nx: NX,
        ny: NY,
        pitch: Some(PITCH),
        origin: Some(DVec2::new(1e-3, -2e-3)),
        heights: (0..NX * NY).map(value).collect(),
        notes: Vec::new(),
    }
}

/// Writes a map and reads it back.
fn there_and_back(name: &str, map: &Surface) -> Surface {
    read_bytes(Path::new(name), &write(Path::new(name), map).unwrap())
}

/// Largest difference of two maps that miss the same pixels.
fn difference(one: &Surface, other: &Surface) -> f64 {
    let pairs = one.heights.iter().zip(&other.heights);
    pairs.fold(0.0, |worst: f64, (a, b)| {
        assert_eq!(a.is_nan(), b.is_nan());
        if a.is_nan() { worst } else { worst.max((a - b).abs()) }
    })
}

#[test]
fn what_is_written_is_read_back() {
    let map = map();
    let largest = map.heights.iter().copied().filter(|height| height.is_finite()).fold(0.0, f64::max);
    for (name, format, tolerance, pitch) in [
        ("map.x3p", "X3P", 0.0, 0.0),
        ("map.sur", "Digital Surf", largest * 2.0_f64.powi(-29), 1e-7),
        ("map.asc", "ESRI ASCII grid", largest * f64::EPSILON, 1e-15),
    ] {
        let found = there_and_back(name, &map);
        assert_eq!((found.format, found.nx, found.ny), (format, NX, NY));
        assert!((found.pitch.unwrap() / PITCH - 1.0).abs().max_element() <= pitch, "{name}: {:?}", found.pitch);
        assert!(difference(&map, &found) <= tolerance, "{name}: {:e}", difference(&map, &found));
        // A second time nothing changes any more.
        let again = there_and_back(name, &found);
        assert!(difference(&found, &again) <= if format == "ESRI ASCII grid" { tolerance } else { 0.0 }, "{name}");
    }
    let origin = there_and_back("map.asc", &map).origin.unwrap();
    assert!((origin - map.origin.unwrap()).length() < 1e-15);
}

#[test]
fn the_same_map_has_the_same_bytes() {
    for name in ["map.x3p", "map.sur", "map.asc"] {
        assert_eq!(write(Path::new(name), &map()).unwrap(), write(Path::new(name), &map()).unwrap());
    }
}

#[test]
fn a_level_map_and_one_of_holes() {
    let level = Surface { heights: vec![0.0; NX * NY], ..map() };
    let holes = Surface { heights: vec![f64::NAN; NX * NY], ..map() };
    for name in ["map.x3p", "map.sur", "map.asc"] {
        assert_eq!(difference(&level, &there_and_back(name, &level)), 0.0, "{name}");
    }
    assert_eq!(write(Path::new("map.sur"), &holes), Err(Unwritable::NoHeight));
    assert!(there_and_back("map.x3p", &holes).heights.iter().all(|height| height.is_nan()));
}

#[test]
fn what_cannot_be_written_is_refused() {
    let said = |name: &str, map: &Surface| write(Path::new(name), map).unwrap_err().to_string();
    assert!(said("map.stl", &map()).contains(".sur, .x3p and .asc"));
    assert!(said("map.sur", &Surface { pitch: None, ..map() }).contains("no pitch"));
    assert!(said("map.asc", &Surface { nx: 3, ..map() }).contains("3 x 17 pixels with 408 heights"));
}

/// Writes the map into the folder of `ROBOFIN_SAMPLES`, for `files/scripts/check.py`.
#[test]
#[ignore = "leaves files"]
fn maps_are_written_for_checks() {
    let folder = std::env::var_os("ROBOFIN_SAMPLES").expect("ROBOFIN_SAMPLES names a folder");
    for name in ["map.x3p", "map.sur", "map.asc"] {
        let file = Path::new(&folder).join(name);
        std::fs::write(&file, write(&file, &map()).unwrap()).unwrap();
    }
}
