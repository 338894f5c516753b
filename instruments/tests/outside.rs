//! Files written by other programs: one map in all formats, made by `files/scripts/make.py`.

mod common;

use common::{FULL, MapOf, NX, NY, PITCH, compare, height, is_hole, read, sample};
use glam::DVec2;

/// Tolerance of a height beyond the rounding of the format, as a share of the height range.
const EXACT: f64 = 1e-9;

/// A sample, its format, and the rounding of its heights [m].
struct Sample {
    file: &'static str,
    format: &'static str,
    rounding: f64,
    /// True if holes are missing in the file.
    map: MapOf,
}

const fn holes(file: &'static str, format: &'static str, rounding: f64) -> Sample {
    Sample { file, format, rounding, map: MapOf::Holes }
}

/// Gwyddion writes heights under a mask.
const fn full(file: &'static str, format: &'static str, rounding: f64) -> Sample {
    Sample { file, format, rounding, map: MapOf::Everything }
}

const SAMPLES: [Sample; 28] = [
    holes("gwyfile.gwy", "Gwyddion", 0.0),
    holes("gwyddion.gwy", "Gwyddion", 0.0),
    // Single precision of the step; six and five digits.
    full("gwyddion.sur", "Digital Surf", 1e-12),
    full("gwyddion.sdf", "SDF", 5e-11),
    full("gwyddion.txt", "Gwyddion text", 5e-10),
    // Single precision of the header's step and offset.
    holes("surfalize.sur", "Digital Surf", 1e-12),
    holes("surfalize_packed.sur", "Digital Surf", 1e-12),
    holes("surfalize_binary.sdf", "SDF", 0.0),
    holes("surfalize_text.sdf", "SDF", 1e-15),
    holes("points_comma.csv", "list of x, y, z", 0.0),
    holes("points_blank.xyz", "list of x, y, z", 0.0),
    holes("points_header.txt", "list of x, y, z", 0.0),
    holes("points_mixed.csv", "list of x, y, z", 0.0),
    holes("points_decimal_comma.txt", "list of x, y, z", 0.0),
    holes("points_shuffled.csv", "list of x, y, z", 0.0),
    holes("c_order.npy", "NumPy array", 0.0),
    holes("fortran_big_endian.npy", "NumPy array", 0.0),
    holes("several.npz", "NumPy array", 0.0),
    holes("points.npy", "NumPy array", 0.0),
    holes("float.tif", "TIFF", 1e-12),
    holes("imagej_16_bit.tif", "TIFF", 1e-9),
    // Single precision.
    holes("pye57.e57", "E57", 1e-12),
    holes("pypcd4_ascii.pcd", "PCD", 1e-11),
    holes("pypcd4_binary.pcd", "PCD", 0.0),
    holes("pypcd4_packed.pcd", "PCD", 0.0),
    holes("plyfile_text.ply", "PLY points", 0.0),
    holes("plyfile_little.ply", "PLY points", 0.0),
    holes("plyfile_big.ply", "PLY points", 0.0),
];

#[test]
fn one_map_is_read_from_files_of_other_programs() {
    for Sample { file, format, rounding, map } in SAMPLES {
        let surface = read(&sample(file));
        assert_eq!((surface.format, surface.nx, surface.ny), (format, NX, NY), "{file}");
        if let Some(pitch) = surface.pitch {
            assert!((pitch / PITCH - 1.0).abs().max_element() < 1e-6, "{file}: {pitch}");
        } else {
            assert_eq!(format, "NumPy array", "{file} has a pitch");
        }
        compare(file, &surface.heights, map, rounding + EXACT * FULL);
    }
}

#[test]
fn an_ascii_grid_of_gdal_begins_in_the_north() {
    let surface = read(&sample("gdal.asc"));
    assert_eq!(surface.format, "ESRI ASCII grid");
    assert!((surface.pitch.unwrap() / DVec2::splat(PITCH.x) - 1.0).abs().max_element() < 1e-9);
    let corner = DVec2::new(1e-3, 2e-3) + DVec2::splat(0.5 * PITCH.x);
    assert!((surface.origin.unwrap() - corner).length() < 1e-12);
    compare("gdal.asc", &surface.heights, MapOf::Holes, EXACT * FULL);
    assert!(surface.notes.iter().any(|note| note.contains("cells say -9999.0")), "{:?}", surface.notes);
}

/// Its rows are read in the order of the file, as ISO 25178-72 says, while surfalize begins at the top.
#[test]
fn x3p_of_surfalize_is_the_mirror_image_of_its_other_files() {
    let surface = read(&sample("surfalize.x3p"));
    assert_eq!(surface.format, "X3P");
    let turned: Vec<f64> = surface.heights.chunks_exact(NX).rev().flatten().copied().collect();
    compare("surfalize.x3p", &turned, MapOf::Holes, EXACT * FULL);
}

/// Gwyddion writes metres without a unit, and y downwards.
#[test]
fn points_of_gwyddion_are_a_mirror_image_in_metres() {
    let surface = read(&sample("gwyddion.xyz"));
    assert_eq!((surface.nx, surface.ny), (NX, NY));
    let metres = surface.heights.chunks_exact(NX).rev().flatten().map(|height| height * 1e3);
    compare("gwyddion.xyz", &metres.collect::<Vec<_>>(), MapOf::Everything, 5e-10 + EXACT * FULL);
}

#[test]
fn notes_name_the_channel_the_units_and_the_missing_words() {
    let holes = (0..NX * NY).filter(|at| is_hole(at % NX, at / NX)).count();
    for (file, words) in [
        ("gwyfile.gwy", "channel 3 \"Height\" is read, the first with heights of 2".to_owned()),
        ("gwyfile.gwy", format!("{holes} pixels under the mask: read as missing")),
        ("points_comma.csv", "no unit is stated: mm are assumed".to_owned()),
        ("points_blank.xyz", format!("{holes} cells say \"nan\": read as missing")),
        ("points_header.txt", "x in µm, y in µm, z in µm".to_owned()),
        ("points_mixed.csv", "x in mm, y in mm, z in nm".to_owned()),
        ("points_decimal_comma.txt", format!("{holes} cells say text of 3 characters: read as missing")),
        ("c_order.npy", "mm are assumed".to_owned()),
        ("imagej_16_bit.tif", format!("{holes} cells say 9999.0: read as missing")),
        ("pypcd4_binary.pcd", "mm are assumed".to_owned()),
        ("surfalize_text.sdf", format!("{holes} cells say \"BAD\": read as missing")),
    ] {
        let notes = read(&sample(file)).notes;
        assert!(notes.iter().any(|note| note.contains(&words)), "{file}: {words} in {notes:?}");
    }
    assert!(height(0, 0).is_finite());
}
