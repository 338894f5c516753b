//! Formats that no free program writes: bytes made here, which surfalize and SurfaceTopography read equally.

mod common;

use std::path::Path;

use common::{FULL, MapOf, NX, NY, PITCH, compare, encoders, read_bytes};

/// Height of a step of each file, and half of it [m].
const VK: f64 = 0.5e-10;
const ZON: f64 = 0.5e-9;

#[test]
fn measurements_of_makers_are_read() {
    for (name, bytes, format, map, rounding) in [
        ("map.plux", encoders::plux(), "Sensofar PLUX", MapOf::Holes, 1e-12),
        ("map.vk4", encoders::vk4(), "Keyence VK", MapOf::Everything, VK),
        ("map.vk6", encoders::vk6(), "Keyence VK", MapOf::Everything, VK),
        ("map.zon", encoders::zon(false), "Keyence ZON", MapOf::Holes, ZON),
        ("packed.zon", encoders::zon(true), "Keyence ZON", MapOf::Holes, ZON),
    ] {
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

/// Writes the bytes into the folder of `ROBOFIN_SAMPLES`, for `files/scripts/check.py`.
#[test]
#[ignore = "leaves files"]
fn encoded_files_are_written_for_checks() {
    let folder = std::env::var_os("ROBOFIN_SAMPLES").expect("ROBOFIN_SAMPLES names a folder");
    for (name, bytes) in [
        ("map.plux", encoders::plux()),
        ("map.vk4", encoders::vk4()),
        ("map.vk6", encoders::vk6()),
        ("map.zon", encoders::zon(false)),
        ("packed.zon", encoders::zon(true)),
    ] {
        std::fs::write(Path::new(&folder).join(name), bytes).unwrap();
    }
}
