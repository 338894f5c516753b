//! Formats that no free program writes: bytes made here, which surfalize and SurfaceTopography read with the same
//! result.

mod common;

use std::path::Path;

use common::{FULL, MapOf, NX, NY, PITCH, compare, encoders, read_bytes};

/// Height of a step of each file, and half of it [m].
const VK: f64 = 0.5e-10;
const ZON: f64 = 0.5e-9;

#[test]
fn measurements_of_makers_are_read() {
    let expected = [
        ("Sensofar PLUX", MapOf::Holes, 1e-12),
        ("Keyence VK", MapOf::Everything, VK),
        ("Keyence VK", MapOf::Everything, VK),
        ("Keyence ZON", MapOf::Holes, ZON),
        ("Keyence ZON", MapOf::Holes, ZON),
    ];
    for ((name, bytes), (format, map, rounding)) in encoders::all().into_iter().zip(expected) {
        let surface = read_bytes(Path::new(name), &bytes);
        assert_eq!((surface.format, surface.nx, surface.ny), (format, NX, NY), "{name}");
        let pitch = surface.pitch.unwrap();
        let expected = if format == "Keyence ZON" { glam::DVec2::splat(PITCH.x) } else { PITCH };
        assert!((pitch / expected - 1.0).abs().max_element() < 1e-9, "{name}: {pitch}");
        compare(name, &surface.heights, map, rounding + 1e-9 * FULL);
    }
}

#[test]
fn missing_pixels_of_a_zon_have_their_reasons() {
    let notes = read_bytes(Path::new("map.zon"), &encoders::zon(true)).notes;
    for words in ["pixels were not measured", "pixels were left out by the operator"] {
        assert!(notes.iter().any(|note| note.contains(words)), "{words} in {notes:?}");
    }
}
