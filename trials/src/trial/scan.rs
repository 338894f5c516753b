//! A scan of a workpiece; the file's format is recognised by its content, not by its name.

use std::path::Path;

use files::input::{self, MOST_MESH_BYTES};
use glam::DVec2;
use instruments::surface::plain_grid::Grid;
use instruments::surface::{self, Source, Surface, Window};
use instruments::text_table::TextTable;
use sdf_bake::{HeightMap, PixelGrid};
use serde::{Deserialize, Serialize};

use super::error::{Place, TrialError};
use super::resample;
use crate::measure::median;

/// Slope between neighbouring pixels that the majority of no surface has [1].
const MOST_SLOPE: f64 = 2.0;
/// Difference of neighbouring pixels that noise alone may cause [m].
const NOISE: f64 = 4e-6;
/// Relative difference of two pitches for a note.
const PITCH_NOTE: f64 = 1e-3;

/// Maximum height range of a scan of a weld [m].
const MOST_SPAN: f64 = 1.0;

/// Reflection of scans within their own area, applied first.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Mirror {
    /// No reflection.
    #[default]
    None,
    /// The cells of each row are reversed.
    X,
    /// The rows are reversed.
    Y,
}

impl Mirror {
    /// Reflects the values of a grid, shape `[ny, nx]`.
    fn turn<T>(self, values: &mut [T], nx: usize) {
        match self {
            Self::None => {}
            Self::X => values.chunks_mut(nx).for_each(<[T]>::reverse),
            Self::Y => {
                values.reverse();
                values.chunks_mut(nx).for_each(<[T]>::reverse);
            }
        }
    }
}

/// Pixels of scans, as far as they are known before reading.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct ScanFrame {
    /// x, y of the first pixel [m], for files without it or in another frame.
    pub origin: Option<DVec2>,
    /// Distance between pixels [m], for files without it.
    pub pitch: Option<f64>,
    /// Pixels of the scan before, at which scans with other pixels are resampled.
    pub like: Option<PixelGrid>,
    /// Reflection of all scans.
    pub mirror: Mirror,
}

impl ScanFrame {
    /// The same for the scans after one with known pixels.
    pub(super) fn like(self, pixels: &PixelGrid) -> Self {
        Self { like: Some(*pixels), ..self }
    }
}

/// Pixels that show substrate after sanding.
#[derive(Clone, Debug, PartialEq)]
pub struct ExposureMask {
    /// The pixels.
    pub pixels: PixelGrid,
    /// True if exposed; `None` if the optics gave no value; shape `[ny, nx]`.
    pub exposed: Vec<Option<bool>>,
}

/// A label for each pixel: 0 base metal, 1 weld metal.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct LabelMap {
    /// The pixels.
    pub pixels: PixelGrid,
    /// Shape `[ny, nx]`; 0 where the file has none.
    pub labels: Vec<u16>,
}

/// Content read from a file, with notes on its interpretation.
#[derive(Clone, Debug)]
pub struct Read<T> {
    /// The content.
    pub content: T,
    /// Notes on the interpretation of unusual files, in sentences.
    pub notes: Vec<String>,
}

impl<T> Read<T> {
    /// The same with its content converted.
    pub(super) fn converted<U>(self, content: impl FnOnce(T) -> U) -> Read<U> {
        Read { content: content(self.content), notes: self.notes }
    }
}

/// Reads a height map in any format of [`instruments::surface`].
///
/// # Errors
/// [`TrialError`] with the place in the file.
pub fn read_heights(file: &Path, frame: ScanFrame) -> Result<Read<HeightMap>, TrialError> {
    let bytes = input::read(file, MOST_MESH_BYTES)?;
    let window = Window {
        origin: frame.origin.or(frame.like.map(|pixels| pixels.origin)),
        pitch: frame.like.map(|pixels| pixels.pitch).or(frame.pitch),
        shape: frame.like.map(|pixels| (pixels.nx, pixels.ny)),
    };
    let mut surface = surface::read(&Source { file, bytes: &bytes, window })?;
    let mut notes = std::mem::take(&mut surface.notes);
    frame.mirror.turn(&mut surface.heights, surface.nx);
    let map = placed(file, surface, frame, &mut notes)?;
    check_heights(file, &map)?;
    Ok(Read { content: map, notes })
}

/// A surface on square pixels in the frame of the scans; resampled at those of the scan before if both have positions
/// of their own.
fn placed(file: &Path, surface: Surface, frame: ScanFrame, notes: &mut Vec<String>) -> Result<HeightMap, TrialError> {
    let missing = |key: &str, what: &str| {
        let found = format!("the file states no {what}, and trial.toml has no {key}");
        Place::file(file).bad::<TrialError>(found, format!("{key} in [scan] is needed"))
    };
    let usual = frame.like.map(|pixels| pixels.pitch).or(frame.pitch).map(DVec2::splat);
    let pitch = surface.pitch.or(usual).ok_or_else(|| missing("pitch_mm", "distance between pixels"))?;
    if let Some(given) = frame.pitch.filter(|given| (pitch.x / given - 1.0).abs() > PITCH_NOTE) {
        notes.push(format!(
            "the file's pitch of {} mm is used, not pitch_mm = {} of trial.toml",
            pitch.x * 1e3,
            given * 1e3
        ));
    }
    let own = surface.origin.filter(|_| frame.origin.is_none());
    let origin = own.or(frame.origin).or(frame.like.map(|pixels| pixels.origin));
    let origin = origin.ok_or_else(|| missing("origin_mm", "place of its first pixel"))?;
    let map = resample::Placed { origin, pitch, nx: surface.nx, ny: surface.ny, heights: surface.heights };
    let pixels = match frame.like.filter(|_| own.is_some()) {
        Some(pixels) => pixels,
        None => map.square(),
    };
    if !map.is_on(&pixels) {
        notes.push(format!(
            "{} x {} pixels of {} x {} mm from x {} mm, y {} mm on are brought onto {} x {} pixels of {} mm",
            map.nx,
            map.ny,
            pitch.x * 1e3,
            pitch.y * 1e3,
            origin.x * 1e3,
            origin.y * 1e3,
            pixels.nx,
            pixels.ny,
            pixels.pitch * 1e3
        ));
    }
    Ok(map.on(pixels))
}

/// Refuses maps without heights, and maps whose unit cannot be the assumed one.
fn check_heights(file: &Path, map: &HeightMap) -> Result<(), TrialError> {
    if map.missing() == map.heights.len() {
        return Err(Place::file(file).bad("every cell is empty", "heights in mm are expected"));
    }
    let nx = map.pixels.nx;
    // A bead is level along itself, so the steeper of the two directions counts.
    let steps = |stride: usize| {
        let pairs = map.heights.iter().zip(&map.heights[stride..]).enumerate();
        let within = pairs.filter(|(at, _)| stride > 1 || at % nx + 1 < nx);
        within.map(|(_, (a, b))| (b - a).abs()).filter(|step| step.is_finite()).collect::<Vec<f64>>()
    };
    let step = [1, nx].map(|stride| median(steps(stride)).unwrap_or(0.0)).into_iter().fold(0.0, f64::max);
    let slope = step / map.pixels.pitch;
    if slope <= MOST_SLOPE + NOISE / map.pixels.pitch {
        return check_span(file, map);
    }
    Err(Place::file(file).bad(
        format!(
            "half of all neighbouring pixels, {} mm apart, differ by {:.3} mm or more",
            map.pixels.pitch * 1e3,
            step * 1e3
        ),
        "heights in mm are expected: these look like µm",
    ))
}

/// Refuses a height range larger than that of any workpiece.
fn check_span(file: &Path, map: &HeightMap) -> Result<(), TrialError> {
    let seen = map.heights.iter().filter(|height| height.is_finite());
    let (low, high) = seen.fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), z| (low.min(*z), high.max(*z)));
    if high - low > MOST_SPAN {
        return Err(Place::file(file).bad(
            format!("the heights go from {:?} to {:?} mm", 1e3 * low, 1e3 * high),
            "heights within a metre are expected: does one of these mark a missing pixel? Leave such cells empty",
        ));
    }
    Ok(())
}

/// Reads an exposure mask: 1 exposed, 0 coated, empty unknown.
///
/// # Errors
/// [`TrialError`] with the place in the file.
pub fn read_exposure(file: &Path, frame: ScanFrame) -> Result<Read<ExposureMask>, TrialError> {
    let (pixels, grid) = read_integers(file, frame, 1.0, "0 for coated, 1 for exposed, or an empty cell")?;
    let exposed = grid.values.iter().map(|&value| (!value.is_nan()).then_some(value == 1.0)).collect();
    Ok(Read { content: ExposureMask { pixels, exposed }, notes: grid.notes })
}

/// Reads a label map: a whole number for each pixel.
///
/// # Errors
/// [`TrialError`] with the place in the file.
pub fn read_labels(file: &Path, frame: ScanFrame) -> Result<Read<LabelMap>, TrialError> {
    let accepted = "a whole number from 0 to 65535, 0 for base metal";
    let (pixels, mut grid) = read_integers(file, frame, f64::from(u16::MAX), accepted)?;
    let missing = grid.values.iter().filter(|value| value.is_nan()).count();
    if missing > 0 {
        grid.notes.push(format!("{missing} pixels have no label: taken as 0, base metal"));
    }
    let labels = grid.values.iter().map(|&value| if value.is_nan() { 0 } else { value as u16 }).collect();
    Ok(Read { content: LabelMap { pixels, labels }, notes: grid.notes })
}

fn read_integers(file: &Path, frame: ScanFrame, most: f64, accepted: &str) -> Result<(PixelGrid, Grid), TrialError> {
    let mut grid = Grid::read(&TextTable::read(file)?)?;
    let good = |value: f64| value.is_nan() || ((0.0..=most).contains(&value) && value.fract() == 0.0);
    if let Some(at) = grid.values.iter().position(|&value| !good(value)) {
        let place = Place::cell(file, (at / grid.nx + 1) as u64, at % grid.nx + 1);
        return Err(place.bad(format!("{} is found", grid.values[at]), format!("{accepted} is expected")));
    }
    frame.mirror.turn(&mut grid.values, grid.nx);
    let like = frame.like;
    let bad =
        |key: &str| Place::file(file).bad::<TrialError>(format!("a mask without {key}"), "it is needed in [scan]");
    let pitch = like.map(|pixels| pixels.pitch).or(frame.pitch).ok_or_else(|| bad("pitch_mm"))?;
    let origin = frame.origin.or(like.map(|pixels| pixels.origin)).ok_or_else(|| bad("origin_mm"))?;
    Ok((PixelGrid { origin, pitch, nx: grid.nx, ny: grid.ny }, grid))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_mirror_reverses_the_cells_of_each_row_or_the_rows() {
        let turned = |mirror: Mirror| {
            let mut values = [1, 2, 3, 4, 5, 6];
            mirror.turn(&mut values, 3);
            values
        };
        assert_eq!(turned(Mirror::None), [1, 2, 3, 4, 5, 6]);
        assert_eq!(turned(Mirror::X), [3, 2, 1, 6, 5, 4]);
        assert_eq!(turned(Mirror::Y), [4, 5, 6, 1, 2, 3]);
    }
}
