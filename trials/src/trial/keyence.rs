//! Height exports of Keyence's VR series ("ImageDataCsv"): key and value lines, a title, then one line per image row.
//!
//! The keys are localised, so that pitch and unit are found by their form: the first key whose value is a length with
//! its unit is the pixel pitch, the key whose value is a unit alone is the unit of the heights.

use super::error::{Place, TrialError};
use super::height_csv::{Grid, GridRows};
use super::table::{Row, Table};

/// Most lines of keys before the heights.
const MOST_KEYS: usize = 60;
/// Cells of a key line: key, value, unit.
const KEY_CELLS: usize = 3;

/// What the key lines say.
#[derive(Default)]
struct Keys {
    pitch: Option<f64>,
    unit: Option<f64>,
    title: Option<String>,
    optical: bool,
    lines: usize,
    /// Whole numbers among the values: columns and rows are two of them.
    counts: Vec<usize>,
}

/// A height map with its own pitch and unit.
pub(super) struct Export {
    /// Pixel pitch [m].
    pub(super) pitch: f64,
    /// Heights [m].
    pub(super) grid: Grid,
}

/// Whether a table begins with key lines as such an export does.
pub(super) fn is_export(table: &Table) -> Result<bool, TrialError> {
    let (mut lines, mut key_lines) = (0, 0);
    table.rows(|row| {
        lines += 1;
        let is_key = row.len() <= KEY_CELLS && !row.cell(0).is_empty() && row.number(0).is_err();
        key_lines += usize::from(is_key);
        Ok(lines < 5)
    })?;
    Ok(key_lines >= 4)
}

/// Reads an export.
pub(super) fn read(table: &Table) -> Result<Export, TrialError> {
    let mut keys = Keys::default();
    let mut rows = GridRows::default();
    table.rows(|row| {
        if keys.title.is_none() {
            keys.read(row)?;
        } else {
            rows.push(row)?;
        }
        Ok(true)
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
        unit_name(unit)
    ));
    Ok(Export { pitch, grid })
}

impl Keys {
    /// Takes in one line before the heights.
    fn read(&mut self, row: &Row) -> Result<(), TrialError> {
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
        let unit = unit_of(if attached.is_empty() { &third } else { attached });
        match (number, unit) {
            (Some(number), Some(unit)) if self.pitch.is_none() && number > 0.0 => self.pitch = Some(number * unit),
            (None, Some(unit)) if self.unit.is_none() => self.unit = Some(unit),
            (Some(number), None) if number >= 2.0 && number.fract() == 0.0 => self.counts.push(number as usize),
            _ => {}
        }
        Ok(())
    }

    /// Says so where the grid has fewer rows than the keys promise.
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

/// Metres in a unit of length.
fn unit_of(text: &str) -> Option<f64> {
    match text {
        "m" => Some(1.0),
        "mm" => Some(1e-3),
        // The last is the sign of micro in an encoding other than UTF-8.
        "um" | "µm" | "μm" | "\u{fffd}m" => Some(1e-6),
        "nm" => Some(1e-9),
        _ => None,
    }
}

fn unit_name(unit: f64) -> &'static str {
    ["m", "mm", "µm", "nm"].into_iter().find(|name| unit_of(name) == Some(unit)).unwrap_or("m")
}
