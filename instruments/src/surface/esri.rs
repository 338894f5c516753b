//! ASCII grids of ESRI (Arc/Info): lines of keys, then rows from north to south.

use std::fmt::Write;

use files::input::quoted;
use glam::DVec2;

use super::numbers::{Numbers, Words, has_decimal_commas};
use super::write::{MapWriteError, pitch_of};
use super::{Format, Source, Surface, missing, shape};
use crate::misread::{Misread, Place};

const ACCEPTED: &str = "an ASCII grid with ncols, nrows, cellsize and one number for each cell is expected";
/// Value written for a missing height.
const NODATA: f64 = -9999.0;
/// Number of bytes from which the decimal mark is detected.
const SNIFFED: usize = 1 << 14;

/// ASCII grids of ESRI.
pub(super) struct EsriGrid;

impl Format for EsriGrid {
    fn name(&self) -> &'static str {
        "ESRI ASCII grid"
    }

    fn extensions(&self) -> &'static [&'static str] {
        &["asc", "agr"]
    }

    fn recognises(&self, source: &Source) -> bool {
        let first = Words::new(source.bytes, 0, 1).next();
        first.is_some_and(|word| word.eq_ignore_ascii_case(b"ncols") || word.eq_ignore_ascii_case(b"nrows"))
    }

    fn read(&self, source: &Source) -> Result<Surface, Misread> {
        let mut words = Words::new(source.bytes, 0, 1);
        let mut numbers = Numbers::new(has_decimal_commas(&source.bytes[..source.bytes.len().min(SNIFFED)]));
        read(&mut words, &mut numbers).map_err(|found| Place::line(source.file, words.line).bad(found, ACCEPTED))
    }
}

/// Values of the keys; lengths in the unit of the file.
#[derive(Default)]
struct Keys {
    columns: Option<f64>,
    rows: Option<f64>,
    cell: [Option<f64>; 2],
    corner: [Option<f64>; 2],
    /// True, for x and y, if the key gives the middle of the corner cell.
    is_centre: [bool; 2],
    nodata: Option<f64>,
}

impl Keys {
    /// Sets a key; returns false if it is unknown.
    fn set(&mut self, key: &str, value: f64) -> bool {
        let is_centre = key.ends_with("center") || key.ends_with("centre");
        match key {
            "ncols" => self.columns = Some(value),
            "nrows" => self.rows = Some(value),
            "cellsize" => self.cell = [Some(value); 2],
            "dx" => self.cell[0] = Some(value),
            "dy" => self.cell[1] = Some(value),
            "nodata_value" => self.nodata = Some(value),
            "xllcorner" | "xllcenter" | "xllcentre" => (self.corner[0], self.is_centre[0]) = (Some(value), is_centre),
            "yllcorner" | "yllcenter" | "yllcentre" => (self.corner[1], self.is_centre[1]) = (Some(value), is_centre),
            _ => return false,
        }
        true
    }

    /// Middle of the first cell along an axis, in the unit of the file.
    fn first(&self, axis: usize, cell: f64) -> Option<f64> {
        self.corner[axis].map(|corner| if self.is_centre[axis] { corner } else { corner + 0.5 * cell })
    }
}

fn read(words: &mut Words, numbers: &mut Numbers) -> Result<Surface, String> {
    let (keys, first) = read_keys(words, numbers)?;
    let missing_key = |name: &str| format!("no {name}");
    let side = |value: Option<f64>, name: &str| value.map(|value| value as u64).ok_or_else(|| missing_key(name));
    let (nx, ny) = shape::checked(side(keys.columns, "ncols")?, side(keys.rows, "nrows")?)?;
    let [dx, dy] = keys.cell;
    let (dx, dy) = (dx.ok_or_else(|| missing_key("cellsize"))?, dy.ok_or_else(|| missing_key("cellsize"))?);
    let pitch = shape::pitch(dx * 1e-3, dy * 1e-3)?;
    let mut heights = Vec::new();
    heights.extend(first);
    for word in words.by_ref().take(nx * ny - heights.len()) {
        let number = numbers.number(word).ok_or_else(|| bad_word(word))?;
        heights.push(number);
    }
    if heights.len() != nx * ny || !words.is_done() {
        let found = if words.is_done() { heights.len().to_string() } else { "more".to_owned() };
        return Err(format!("{found} heights where {nx} x {ny} are stated"));
    }
    let mut notes = vec![format!(
        "ESRI ASCII grid: {nx} x {ny} cells; the format has no unit: coordinates and heights are taken in mm"
    )];
    notes.extend(numbers.notes());
    notes.extend(missing::clear(&mut heights, keys.nodata));
    heights.iter_mut().for_each(|height| *height *= 1e-3);
    let origin = keys.first(0, dx).zip(keys.first(1, dy)).map(|(x, y)| DVec2::new(x, y) * 1e-3);
    let heights = shape::turned(heights, nx);
    Ok(Surface { format: EsriGrid.name(), nx, ny, pitch: Some(pitch), origin, heights, notes })
}

/// Reads the keys, and the first height, which ends them.
fn read_keys(words: &mut Words, numbers: &mut Numbers) -> Result<(Keys, Option<f64>), String> {
    let decimal_comma = numbers.decimal_comma;
    let mut keys = Keys::default();
    while let Some(word) = words.next() {
        let key = String::from_utf8_lossy(word).to_lowercase();
        if key.as_bytes().first().is_none_or(|c| !c.is_ascii_alphabetic()) || missing::is_word(word) {
            return Ok((keys, Some(numbers.number(word).ok_or_else(|| bad_word(word))?)));
        }
        let value = words.next().and_then(|value| Numbers::new(decimal_comma).number(value));
        let value = value.ok_or_else(|| format!("{} without a number", quoted(&key)))?;
        if !keys.set(&key, value) {
            return Err(format!("{} is no key", quoted(&key)));
        }
    }
    Ok((keys, None))
}

fn bad_word(word: &[u8]) -> String {
    format!("{} is not a number", quoted(&String::from_utf8_lossy(word)))
}

/// Writes a grid in millimetres, missing heights as -9999.
///
/// # Errors
/// [`MapWriteError`] without a pitch.
pub(super) fn write(surface: &Surface) -> Result<Vec<u8>, MapWriteError> {
    let pitch = pitch_of(surface)? * 1e3;
    let corner = surface.origin.unwrap_or(DVec2::ZERO) * 1e3 - 0.5 * pitch;
    let mut text = format!("ncols {}\nnrows {}\n", surface.nx, surface.ny);
    let cell =
        if pitch.x == pitch.y { format!("cellsize {}", pitch.x) } else { format!("dx {}\ndy {}", pitch.x, pitch.y) };
    let _ = write!(text, "xllcorner {}\nyllcorner {}\n{cell}\nNODATA_value {NODATA}\n", corner.x, corner.y);
    for row in surface.heights.chunks_exact(surface.nx).rev() {
        for (i, height) in row.iter().enumerate() {
            let height = if height.is_finite() { height * 1e3 } else { NODATA };
            let _ = write!(text, "{}{height}", if i > 0 { " " } else { "" });
        }
        text.push('\n');
    }
    Ok(text.into_bytes())
}
