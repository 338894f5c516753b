//! Round trips of maps: written and read back.

mod common;

use std::path::Path;

use common::{NX, NY, PITCH, map, read_bytes};
use instruments::surface::{MapWriteError, Surface, write};

/// Writes a map and reads it back.
fn there_and_back(name: &str, map: &Surface) -> Surface {
    read_bytes(Path::new(name), &write(Path::new(name), map).unwrap())
}

/// Largest difference of two maps with the same missing pixels.
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
        // A second round trip changes nothing.
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
    assert_eq!(write(Path::new("map.sur"), &holes), Err(MapWriteError::NoHeight));
    assert!(there_and_back("map.x3p", &holes).heights.iter().all(|height| height.is_nan()));
}

#[test]
fn what_cannot_be_written_is_refused() {
    let said = |name: &str, map: &Surface| write(Path::new(name), map).unwrap_err().to_string();
    assert!(said("map.stl", &map()).contains(".sur, .x3p and .asc"));
    assert!(said("map.sur", &Surface { pitch: None, ..map() }).contains("no pitch"));
    assert!(said("map.asc", &Surface { nx: 3, ..map() }).contains("3 x 17 pixels with 408 heights"));
}

/// The inversion flag and 16-bit heights, in a file of this crate.
#[test]
fn variants_of_digital_surf() {
    let plain = there_and_back("map.sur", &map());
    let bytes = write(Path::new("map.sur"), &map()).unwrap();
    let at = |map: &Surface, i: usize, j: usize| map.heights[j * NX + i];
    for inverted in 1..=3 {
        let mut changed = bytes.clone();
        changed[290] = inverted;
        let found = read_bytes(Path::new("map.sur"), &changed);
        let (i, j) = (if inverted == 2 { NX - 2 } else { 1 }, if inverted == 3 { NY - 3 } else { 2 });
        assert_eq!(at(&found, i, j), -at(&plain, 1, 2), "inverted {inverted}");
    }
    let mut short = bytes[..512].to_vec();
    short[98] = 16;
    // Steps of a nanometre, the lowest 0, missing ones -2.
    short[100..104].copy_from_slice(&0_i32.to_le_bytes());
    short[128..132].copy_from_slice(&1e-3_f32.to_le_bytes());
    let step = |height: &f64| if height.is_nan() { -2 } else { (height * 1e9).round() as i16 };
    short.extend(map().heights.chunks_exact(NX).rev().flatten().flat_map(|height| step(height).to_le_bytes()));
    assert!(difference(&map(), &read_bytes(Path::new("map.sur"), &short)) < 0.51e-9);
}

#[test]
fn surfaces_of_triangles_are_known_by_their_content() {
    let obj = "v 0 0 1\nv 2 0 1\nv 0 2 1\nv 2 2 1\nf 1 2 3\nf 2 4 3\n";
    let facets = ["0 0 1,2 0 1,0 2 1", "2 0 1,2 2 1,0 2 1"];
    let mut text = "solid s\n".to_owned();
    let mut binary = vec![0; 80];
    binary.extend(2_u32.to_le_bytes());
    for facet in facets {
        text += "facet normal 0 0 1\nouter loop\n";
        binary.extend([0; 12]);
        for corner in facet.split(',') {
            text += &format!("vertex {corner}\n");
            let numbers = corner.split(' ').flat_map(|number| number.parse::<f32>().unwrap().to_le_bytes());
            binary.extend(numbers);
        }
        text += "endloop\nendfacet\n";
        binary.extend([0; 2]);
    }
    text += "endsolid s\n";
    for bytes in [obj.as_bytes(), text.as_bytes(), &binary] {
        let surface = read_bytes(Path::new("scan"), bytes);
        assert_eq!((surface.format, surface.nx), ("mesh", 2));
        assert!(surface.heights.iter().all(|height| (height - 1e-3).abs() < 1e-12));
    }
}
