//! Texts in the formats of people and programs.

mod common;

use std::fmt::Write;
use std::path::{Path, PathBuf};

use common::{read_bytes, sample};
use glam::DVec2;
use instruments::surface::{self, Source, Surface, Window};

fn read(name: &str, text: &str) -> Surface {
    read_bytes(Path::new(name), text.as_bytes())
}

/// Heights [mm].
fn millimetres(surface: &Surface) -> Vec<f64> {
    surface.heights.iter().map(|height| (height * 1e9).round() * 1e-6).collect()
}

fn assert_note(surface: &Surface, words: &str) {
    assert!(surface.notes.iter().any(|note| note.contains(words)), "{words} in {:?}", surface.notes);
}

#[test]
fn three_columns_are_points_and_more_are_a_grid() {
    let list = "0,0,1\n1,0,2\n0,2,3\n1,2,4\n0,4,5\n1,4,6\n";
    let points = read("a.csv", list);
    assert_eq!((points.format, points.nx, points.ny), ("list of x, y, z", 2, 3));
    assert_eq!(millimetres(&points), [1.0, 2.0, 3.0, 4.0, 5.0, 6.0]);
    assert!((points.pitch.unwrap() - DVec2::new(1e-3, 2e-3)).length() < 1e-15);
    let holes = read("a.csv", ",,1\n,2,\n,,3\n4,,\n1,2,3\n");
    assert_eq!((holes.format, holes.nx, holes.ny), ("plain grid", 3, 5));
    let grid = read("a.csv", "0,0,1,1\n1,0,2,1\n0,2,3,1\n1,2,4,1\n");
    assert_eq!((grid.format, grid.nx, grid.ny, grid.pitch), ("plain grid", 4, 4, None));
}

#[test]
fn separators_and_decimals_of_a_list() {
    for text in [
        "0,0,1.5\n1,0,2\n0,1,3\n1,1,4\n",
        "0 0 1.5\n1 0 2\n0 1 3\n1 1 4",
        "  0.0   0.0   1.5\r\n  1.0   0.0   2.0\r\n  0.0   1.0   3.0\r\n  1.0   1.0   4.0\r\n",
        "0\t0\t1.5\n1\t0\t2\n0\t1\t3\n1\t1\t4\n",
        "0;0;1,5\n1;0;2,0\n0;1;3,0\n1;1;4,0\n",
        "0,0 0,0 1,5\n1,0 0,0 2,0\n0,0 1,0 3,0\n1,0 1,0 4,0\n",
        "0, 0, 1.5\n1, 0, 2\n0, 1, 3\n1, 1, 4\n",
        "\u{feff}\"x\",\"y\",\"z\"\n\"0\",\"0\",\"1.5\"\n\"1\",\"0\",\"2\"\n\"0\",\"1\",\"3\"\n\"1\",\"1\",\"4\"\n",
        "4\n0 0 1.5\n1 0 2\n0 1 3\n1 1 4\n",
        "//X Y Z\n0 0 1.5\n1 0 2\n0 1 3\n1 1 4\n",
    ] {
        let points = read("a.txt", text);
        assert_eq!((points.format, points.nx, points.ny), ("list of x, y, z", 2, 2), "{text}");
        assert_eq!(millimetres(&points), [1.5, 2.0, 3.0, 4.0], "{text}");
    }
}

#[test]
fn units_and_names_of_a_list() {
    for (text, step) in [
        ("x [um], y [um], z [um]\n", 1e-6),
        ("# x(m) y(m) z(m)\n", 1.0),
        ("X_mm,Y_mm,Z_mm\n", 1e-3),
        ("# unit: µm\n", 1e-6),
        ("x,y,z\n", 1e-3),
    ] {
        let points = read("a.csv", &format!("{text}0,0,1\n1,0,2\n0,1,3\n1,1,4\n"));
        let pitch = points.pitch.unwrap();
        assert!((pitch / step - 1.0).abs().max_element() < 1e-12, "{text}: {pitch}");
        assert!((points.heights[3] / step - 4.0).abs() < 1e-12, "{text}");
    }
    let named = read("a.csv", "z [um],quality,x [mm],y [mm]\n5,1,0,0\n6,1,1,0\n7,1,0,1\n8,1,1,1\n");
    assert_eq!(named.format, "list of x, y, z");
}

#[test]
fn words_and_numbers_for_a_missing_height() {
    for word in ["-9999", "-32768", "1.70141e38", "1e38", "BAD", "***", "NaN", "---"] {
        let points = read("a.csv", &format!("0,0,1\n1,0,2\n0,1,{word}\n1,1,4\n"));
        assert!(points.heights[2].is_nan() && points.heights[3].is_finite(), "{word}");
        assert_note(&points, "1 cells say");
    }
    let empty = read("a.csv", "0,0,1\n1,0,2\n0,1,\n1,1,4\n");
    assert!(empty.heights[2].is_nan());
    assert_note(&empty, "1 cells say nothing");
}

#[test]
fn a_cloud_becomes_pixels() {
    let mut text = String::new();
    for k in 0..4000_u32 {
        // The golden ratio spreads points evenly (Weyl 1916).
        let (x, y) = ((f64::from(k) * 0.618_033_988_749_9).fract() * 10.0, f64::from(k) / 400.0);
        let _ = writeln!(text, "{x:.5} {y:.5} {:.5}", 0.1 * x + 0.2 * y);
    }
    let file = PathBuf::from("cloud.xyz");
    let window = Window { origin: Some(DVec2::splat(2e-3)), pitch: Some(0.5e-3), shape: Some((10, 12)) };
    for window in [Window::default(), window] {
        let cloud = surface::read(&Source { file: &file, bytes: text.as_bytes(), window }).unwrap();
        assert_note(&cloud, "points on no grid");
        let (pitch, origin) = (cloud.pitch.unwrap().x, cloud.origin.unwrap());
        let mut missing = 0;
        for (at, height) in cloud.heights.iter().enumerate() {
            let place = origin + DVec2::new((at % cloud.nx) as f64, (at / cloud.nx) as f64) * pitch;
            missing += usize::from(height.is_nan());
            assert!(height.is_nan() || (height - (0.1 * place.x + 0.2 * place.y)).abs() < 0.3 * pitch, "{place}");
        }
        assert!(missing * 100 <= cloud.heights.len(), "{missing} of {}", cloud.heights.len());
    }
    let beside = Window { origin: Some(DVec2::splat(1.0)), ..window };
    let error = surface::read(&Source { file: &file, bytes: text.as_bytes(), window: beside }).unwrap_err();
    assert!(error.to_string().contains("the surface spans x 0.00 to 10.00 mm"), "{error}");
}

#[test]
fn a_grid_with_blanks_and_comments() {
    let grid = read("a.txt", "# heights\n1.0 2.0   3.0 nan\n4.0 5.0 6.0 -9999\n7 8 9 1\n7 8 9 1\n7 8 9 1\n");
    assert_eq!((grid.format, grid.nx, grid.ny), ("plain grid", 4, 5));
    assert_eq!(millimetres(&grid)[4..7], [4.0, 5.0, 6.0]);
    assert!(grid.heights[3].is_nan() && grid.heights[7].is_nan());
    assert_note(&grid, "cells are separated by blanks; mm are assumed");
}

#[test]
fn errors_name_the_place() {
    for (name, text, words) in [
        (
            "a.xyz",
            "0 0 1\n1 0 2\n0 1 3\n1 1 4\n".repeat(20) + "1 1 word\n",
            "line 81, column 3: \"word\" is not a number",
        ),
        ("a.asc", "ncols 2\nnrows 2\ncellsize 1\n1 2 3 x\n".to_owned(), "line 4: \"x\" is not a number"),
        ("a.asc", "ncols 2\nnrows 2\ncellsize 1\n1 2 3\n".to_owned(), "3 heights where 2 x 2 are stated"),
        ("a.sdf", "aISO-1.0\nNumPoints = 2\n*\n".to_owned(), "no numprofiles in the header"),
    ] {
        let error = surface::read(&Source { file: Path::new(name), bytes: text.as_bytes(), window: Window::default() });
        let error = error.unwrap_err().to_string();
        assert!(error.contains(words), "{words} in {error}");
    }
}

#[test]
fn formats_have_names_and_extensions() {
    let names: Vec<_> = surface::formats().collect();
    for (name, extensions) in surface::extensions() {
        assert!(names.contains(&name) && !extensions.is_empty());
        assert!(
            extensions.iter().all(|extension| extension.chars().all(|c| c.is_ascii_lowercase() || c.is_ascii_digit()))
        );
    }
    assert_eq!(names.last(), Some(&"plain grid"));
}

/// The export of a real instrument, which is not part of this repository.
#[test]
fn an_export_of_a_real_instrument() {
    let shared = std::env::var_os("ROBOFIN_SHARED").map_or_else(|| sample("../../../../shared"), PathBuf::from);
    let file = shared.join("data/measured/vr6000_crop_Height.csv");
    if !file.exists() {
        eprintln!("NOT TESTED: {} is absent; ROBOFIN_SHARED names another folder", file.display());
        return;
    }
    let map = common::read(&file);
    assert_eq!((map.format, map.nx, map.ny), ("Keyence export", 160, 120));
    assert!((map.pitch.unwrap() - DVec2::splat(7.413e-6)).length() < 1e-15);
    let missing = map.heights.iter().filter(|height| height.is_nan()).count();
    assert_eq!(missing, 10_043);
    assert!(map.heights[..160].iter().all(|height| height.is_nan()));
}
