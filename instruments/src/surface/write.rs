//! Writing of height maps for MountainsMap, Gwyddion and others.

use std::path::Path;

use glam::DVec2;
use thiserror::Error;

use super::{Surface, esri, sur, x3p_write};

/// Error of a map that cannot be written.
#[derive(Debug, Error, PartialEq, Eq)]
pub enum MapWriteError {
    /// The extension belongs to no supported format.
    #[error("{name}: no height map is written with this extension; .sur, .x3p and .asc are")]
    Extension {
        /// The file name.
        name: String,
    },
    /// The pixels have no pitch.
    #[error("the map states no pitch; a distance between pixels is needed")]
    NoPitch,
    /// All heights are missing.
    #[error("every pixel is missing; at least one height is needed")]
    NoHeight,
    /// Shape and number of heights differ.
    #[error("a map of {nx} x {ny} pixels with {heights} heights; one height for each pixel is needed")]
    Shape {
        /// Pixels along x.
        nx: usize,
        /// Pixels along y.
        ny: usize,
        /// Number of heights.
        heights: usize,
    },
    /// The zip cannot be created.
    #[error("the zip cannot be made: {0}")]
    Zip(String),
}

/// The bytes of a file with a map, in the format of the file's extension: `.sur`, `.x3p` or `.asc`.
///
/// X3P keeps every bit of each height. ESRI's ASC holds millimetres, so a height may change by rounding. SUR has
/// integer steps of a power of two micrometres, at most 2⁻²⁹ of the largest height, and 32-bit pitches.
///
/// # Errors
/// [`MapWriteError`]
pub fn write(file: &Path, surface: &Surface) -> Result<Vec<u8>, MapWriteError> {
    let extension = file.extension().map(|extension| extension.to_string_lossy().to_lowercase());
    let write = match extension.as_deref() {
        Some("sur") => sur::write,
        Some("x3p") => x3p_write::write,
        Some("asc") => esri::write,
        _ => return Err(MapWriteError::Extension { name: file.display().to_string() }),
    };
    let Surface { nx, ny, .. } = *surface;
    let heights = surface.heights.len();
    if nx.checked_mul(ny) != Some(heights) || heights == 0 || nx.max(ny) > i32::MAX as usize {
        return Err(MapWriteError::Shape { nx, ny, heights });
    }
    write(surface)
}

/// The pitch of a map [m].
pub(super) fn pitch_of(surface: &Surface) -> Result<DVec2, MapWriteError> {
    surface.pitch.filter(|pitch| pitch.is_finite() && pitch.cmpgt(DVec2::ZERO).all()).ok_or(MapWriteError::NoPitch)
}
