//! Height exports of Keyence's VR series ("ImageDataCsv"): key and value lines, a title, then one line per image row.
//!
//! The keys are localised, so pitch and unit are recognised by their form: the first key with a length and a unit is
//! the pixel pitch, the key with a unit alone is the unit of the heights.

use glam::DVec2;

use super::plain_grid::{Grid, GridRows};
use super::{Format, Source, Surface, spaced, unit};
use crate::misread::{Misread, Place};
use crate::text_table::{TextRow, TextTable};

/// Maximum number of key lines before the heights.
const MOST_KEYS: usize = 60;
/// Cells of a key line: key, value, unit.
const KEY_CELLS: usize = 3;

/// Contents of the key lines.
#[derive(Default)]
struct Keys {
    pitch: Option<f64>,
    unit: Option<f64>,
    title: Option<String>,
    optical: bool,
    lines: usize,
    /// Integers among the values; columns and rows are two of them.
    counts: Vec<usize>,
}

/// Text exports of Keyence's VR series.
pub(super) struct KeyenceExport;

impl Format for KeyenceExport {
    fn name(&self) -> &'static str {
        "Keyence export"
    }

    fn extensions(&self) -> &'static [&'static str] {
        &["csv"]
    }

    fn recognises(&self, source: &Source) -> bool {
        let table = TextTable::parse(source.file, source.bytes.into());
        !spaced::is_spaced(source.bytes) && table.is_ok_and(|table| is_export(&table).unwrap_or(false))
    }

    fn read(&self, source: &Source) -> Result<Surface, Misread> {
        let (pitch, grid) = read(&TextTable::parse(source.file, source.bytes.into())?)?;
        Ok(Surface {
            format: self.name(),
            nx: grid.nx,
            ny: grid.ny,
            pitch: Some(DVec2::splat(pitch)),
            origin: None,
            heights: grid.values,
            notes: grid.notes,
        })
    }
}

/// True if a table begins with key lines of such an export.
fn is_export(table: &TextTable) -> Result<bool, Misread> {
    let (mut lines, mut key_lines) = (0, 0);
    table.rows(|row| {
        lines += 1;
        let is_key = row.len() <= KEY_CELLS && !row.cell(0).is_empty() && row.number(0).is_err();
        key_lines += usize::from(is_key);
        Ok::<_, Misread>(lines < 5)
    })?;
    Ok(key_lines >= 4)
}

/// Pixel pitch [m] and heights [m] of an export.
fn read(table: &TextTable) -> Result<(f64, Grid), Misread> {
    let mut keys = Keys::default();
    let mut rows = GridRows::default();
    table.rows(|row| {
        if keys.title.is_none() {
            keys.read(row)?;
        } else {
            rows.push(row)?;
        }
        Ok::<_, Misread>(true)
    })?;
    let place = || Place::file(table.file());
    const ACCEPTED: &str = "a height export with its pixel pitch (\"XY Calibration\") and \"Unit\" is expected";
    if keys.title.is_none() {
        return Err(place().bad("key lines without a line \"Height\" and heights below", ACCEPTED));
    }
    if keys.optical || keys.unit.is_none() {
        return Err(place().bad("no unit of height: this looks like the optical image beside a height file", ACCEPTED));
    }
    let (Some(pitch), Some(unit)) = (keys.pitch, keys.unit) else {
        return Err(place().bad("no pixel pitch with a unit in the key lines", ACCEPTED));
    };
    let mut grid = rows.finish(table)?;
    keys.note_counts(&mut grid);
    for value in &mut grid.values {
        *value *= unit;
    }
    grid.notes.push(format!(
        "Keyence export: {} x {} pixels, pitch {} µm, heights in {}; rows are taken in the order of the file, y rising",
        grid.nx,
        grid.ny,
        pitch * 1e6,
        unit::name(unit)
    ));
    Ok((pitch, grid))
}

impl Keys {
    /// Reads one line before the heights.
    fn read(&mut self, row: &TextRow) -> Result<(), Misread> {
        self.lines += 1;
        if self.lines > MOST_KEYS {
            return Err(row.place(0).bad(
                format!("{MOST_KEYS} key lines and no heights"),
                "a line \"Height\" and the heights below it are expected",
            ));
        }
        if row.len() == 1 {
            self.title = Some(row.text(0));
            return Ok(());
        }
        let (value, third) = (row.text(1), row.text(2));
        let key = row.text(0).to_lowercase();
        let names_output = ["output", "ausgabe", "bild"].iter().any(|word| key.contains(word));
        self.optical |= names_output && value.to_lowercase().contains("opti");
        let (number, attached) = number_and_unit(&value);
        let unit = unit::metres(if attached.is_empty() { &third } else { attached });
        match (number, unit) {
            (Some(number), Some(unit)) if self.pitch.is_none() && number > 0.0 => self.pitch = Some(number * unit),
            (None, Some(unit)) if self.unit.is_none() => self.unit = Some(unit),
            (Some(number), None) if number >= 2.0 && number.fract() == 0.0 => self.counts.push(number as usize),
            _ => {}
        }
        Ok(())
    }

    /// Adds a note if the grid has fewer rows than the keys state.
    fn note_counts(&self, grid: &mut Grid) {
        let columns = self.counts.iter().position(|&count| count == grid.nx);
        if let Some(&rows) = columns.and_then(|at| self.counts.get(at + 1)).filter(|&&rows| rows != grid.ny) {
            grid.notes.push(format!("the key lines promise {rows} rows, the file has {}", grid.ny));
        }
    }
}

/// Splits "47.242 um" into the number and the rest.
fn number_and_unit(text: &str) -> (Option<f64>, &str) {
    let end = text.find(|c: char| !(c.is_ascii_digit() || ".,+-".contains(c))).unwrap_or(text.len());
    (text[..end].replace(',', ".").parse().ok(), text[end..].trim())
}
