//! Height maps of instruments and people.
//!
//! [`read`] tests the formats in `FORMATS` in turn, by the file's content and, for formats without a signature, its
//! name. A format is a file of this folder with one type that implements `Format`; adding one takes a file and a line
//! here.
//!
//! Maps are right-handed, seen from above: pixel (i, j) of `[ny, nx]` lies at `origin + (i, j) · pitch`.

mod archive;
mod axis;
mod bytes;
mod cloud;
mod e57;
mod element;
mod esri;
mod gwy;
mod gwy_object;
mod gwy_text;
mod keyence;
mod keyence_vk;
mod lzf;
mod mesh;
mod missing;
mod npy;
mod numbers;
mod pcd;
pub mod plain_grid;
mod plux;
mod ply_points;
mod records;
mod sdf;
mod shape;
mod spaced;
mod sur;
mod tiff;
mod tiff_scale;
mod unit;
mod window;
mod write;
mod x3p;
mod x3p_write;
mod xyz;
mod xyz_layout;
mod zon;

use std::path::Path;

use glam::DVec2;
use sdf_bake::{HeightMap, PixelGrid};

use crate::misread::Misread;
pub use write::{MapWriteError, write};

/// Maximum number of pixels of a map.
const MOST_PIXELS: usize = 1 << 28;

/// The formats in the order in which they are tested. Those with a signature come first. Among the zip files, X3P takes
/// those that the others reject. Among the texts, those with key lines come before lists, and a plain grid, which any
/// table may be, comes last.
const FORMATS: [&dyn Format; 18] = [
    &sur::DigitalSurf,
    &sdf::SurfaceData,
    &gwy::Gwyddion,
    &keyence_vk::KeyenceVk,
    &zon::KeyenceZon,
    &npy::NumpyArray,
    &plux::Plux,
    &x3p::X3p,
    &tiff::Tiff,
    &e57::E57,
    &pcd::PointCloudData,
    &ply_points::PlyPoints,
    &mesh::Mesh,
    &esri::EsriGrid,
    &gwy_text::GwyddionText,
    &xyz::PointList,
    &keyence::KeyenceExport,
    &plain_grid::PlainGrid,
];

/// A file format of height maps.
trait Format: Sync {
    /// Name for messages.
    fn name(&self) -> &'static str;

    /// File extensions in lower case, without the dot.
    fn extensions(&self) -> &'static [&'static str];

    /// True if a file is of this format.
    fn recognises(&self, source: &Source) -> bool;

    /// Reads a file of this format.
    fn read(&self, source: &Source) -> Result<Surface, Misread>;
}

/// A file to be read, and the pixels for formats that have none of their own.
#[derive(Clone, Copy, Debug)]
pub struct Source<'a> {
    /// Its name.
    pub file: &'a Path,
    /// Its content.
    pub bytes: &'a [u8],
    /// Pixels for formats without pixels, such as meshes and clouds.
    pub window: Window,
}

/// The pixels at which a surface without pixels is sampled; `None` values follow from the surface.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Window {
    /// x, y of the first pixel [m].
    pub origin: Option<DVec2>,
    /// Distance between pixels [m].
    pub pitch: Option<f64>,
    /// Pixels along x and y.
    pub shape: Option<(usize, usize)>,
}

/// A height map of a file.
#[derive(Clone, Debug, PartialEq)]
pub struct Surface {
    /// Name of the file's format.
    pub format: &'static str,
    /// Pixels along x.
    pub nx: usize,
    /// Pixels along y.
    pub ny: usize,
    /// Distance between pixels along x and along y [m]; `None` if the file does not give it.
    pub pitch: Option<DVec2>,
    /// x, y of the first pixel [m]; `None` if the file does not give it.
    pub origin: Option<DVec2>,
    /// Heights [m], NaN where missing, shape `[ny, nx]`.
    pub heights: Vec<f64>,
    /// Notes on the interpretation, in sentences.
    pub notes: Vec<String>,
}

impl Surface {
    /// Its size in one line, for messages.
    pub fn summary(&self) -> String {
        let known = || self.heights.iter().copied().filter(|height| height.is_finite());
        let (low, high) = known().fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), h| (low.min(h), high.max(h)));
        let share = 100.0 * (1.0 - known().count() as f64 / self.heights.len().max(1) as f64);
        let pitch = self.pitch.map_or("no distance between them".to_owned(), |pitch| {
            let [x, y] = [pitch.x * 1e3, pitch.y * 1e3].map(|pitch| (pitch * 1e6).round() / 1e6);
            if x == y { format!("{x} mm apart") } else { format!("{x} x {y} mm apart") }
        });
        let heights = format!("heights from {:.4} to {:.4} mm", low * 1e3, high * 1e3);
        format!("{} x {} pixels, {pitch}, {share:.1} % missing, {heights}", self.nx, self.ny)
    }

    /// A map on square pixels.
    fn on(format: &'static str, map: HeightMap, notes: Vec<String>) -> Self {
        let PixelGrid { origin, pitch, nx, ny } = map.pixels;
        Self { format, nx, ny, pitch: Some(DVec2::splat(pitch)), origin: Some(origin), heights: map.heights, notes }
    }
}

/// Reads a height map.
///
/// # Errors
/// [`Misread`] with the place in the file.
pub fn read(source: &Source) -> Result<Surface, Misread> {
    let plain: &dyn Format = &plain_grid::PlainGrid;
    FORMATS.into_iter().find(|format| format.recognises(source)).unwrap_or(plain).read(source)
}

/// Names of the supported formats.
pub fn formats() -> impl Iterator<Item = &'static str> {
    FORMATS.into_iter().map(|format| format.name())
}

/// Names of the supported formats, with their file extensions: lower case, without the dot.
pub fn extensions() -> impl Iterator<Item = (&'static str, &'static [&'static str])> {
    FORMATS.into_iter().map(|format| (format.name(), format.extensions()))
}
