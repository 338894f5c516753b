//! The map in all sample files, and its comparison.

#![allow(dead_code, reason = "each test uses a part")]

pub mod encoders;

use std::path::{Path, PathBuf};

use glam::DVec2;
use instruments::surface::{self, Source, Surface, Window};

/// Pixels along x and y.
pub const NX: usize = 24;
pub const NY: usize = 17;
/// Distance between pixels [m].
pub const PITCH: DVec2 = DVec2::new(5e-6, 4e-6);
/// Height range of the map, rounded up [m].
pub const FULL: f64 = 2.5e-5;

/// Selects which of the pixels a file holds.
#[derive(Clone, Copy, PartialEq)]
pub enum MapOf {
    Holes,
    Everything,
}

/// Height of a pixel [m], as in `files/scripts/shape.py`.
pub fn height(i: usize, j: usize) -> f64 {
    let (i, j) = (i as f64, j as f64);
    1e-6 * (0.3 * i + 0.5 * j + 2.0 * (0.7 * i).sin() + (0.9 * j).cos() + 0.02 * i * j)
}

/// True if a pixel is missing.
pub fn is_hole(i: usize, j: usize) -> bool {
    (7 * i + 11 * j).is_multiple_of(37)
}

/// The map of all samples, in a frame of its own.
pub fn map() -> Surface {
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

/// A sample file.
pub fn sample(name: &str) -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/files").join(name)
}

/// Reads a file without a window.
pub fn read(file: &Path) -> Surface {
    let bytes = std::fs::read(file).unwrap_or_else(|error| panic!("{}: {error}", file.display()));
    read_bytes(file, &bytes)
}

/// Reads bytes under a file's name without a window.
pub fn read_bytes(file: &Path, bytes: &[u8]) -> Surface {
    let source = Source { file, bytes, window: Window::default() };
    surface::read(&source).unwrap_or_else(|error| panic!("{error}"))
}

/// Compares heights [m] with those of the map.
pub fn compare(file: &str, heights: &[f64], map: MapOf, tolerance: f64) {
    assert_eq!(heights.len(), NX * NY, "{file}");
    let mut worst = 0.0_f64;
    for (at, found) in heights.iter().enumerate() {
        let (i, j) = (at % NX, at / NX);
        if map == MapOf::Holes && is_hole(i, j) {
            assert!(found.is_nan(), "{file}: {found} at the hole {i}, {j}");
            continue;
        }
        let difference = (found - height(i, j)).abs();
        assert!(difference <= tolerance, "{file}: {found} at {i}, {j} where {} is expected", height(i, j));
        worst = worst.max(difference);
    }
    println!("{file}: heights differ by at most {worst:e} m");
}
