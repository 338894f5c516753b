//! Height maps and masks as plain grids: one row per y, one cell per x, an empty cell for a missing value.

use super::{Format, Source, Surface, missing, spaced};
use crate::misread::{Misread, Place};
use crate::text_table::{TextRow, TextTable};

/// A table whose cells are heights in millimetres.
pub(super) struct PlainGrid;

impl Format for PlainGrid {
    fn name(&self) -> &'static str {
        "plain grid"
    }

    fn extensions(&self) -> &'static [&'static str] {
        &["csv", "txt", "dat", "tsv"]
    }

    fn recognises(&self, source: &Source) -> bool {
        TextTable::parse(source.file, source.bytes.into()).is_ok()
    }

    fn read(&self, source: &Source) -> Result<Surface, Misread> {
        let mut grid = Grid::read(&spaced::table(source)?)?;
        grid.notes.extend(missing::clear(&mut grid.values, None));
        let heights = grid.values.iter().map(|height| height * 1e-3).collect();
        let Grid { nx, ny, notes, .. } = grid;
        Ok(Surface { format: self.name(), nx, ny, pitch: None, origin: None, heights, notes })
    }
}

/// A grid of numbers, NaN where a cell is empty.
pub struct Grid {
    /// Cells in a row.
    pub nx: usize,
    /// Rows.
    pub ny: usize,
    /// Shape `[ny, nx]`.
    pub values: Vec<f64>,
    /// Notes on unusual content, in sentences.
    pub notes: Vec<String>,
}

/// Collects the rows of a grid, and notes on unusual content.
#[derive(Default)]
pub(super) struct GridRows {
    nx: Option<usize>,
    values: Vec<f64>,
    words: usize,
    cut_row: Option<(u64, usize)>,
    leading_zeros: usize,
    fractions: usize,
}

impl Grid {
    /// Reads a whole table as a grid.
    ///
    /// # Errors
    /// [`Misread`] if rows differ in length or a cell is not a number.
    pub fn read(table: &TextTable) -> Result<Self, Misread> {
        let mut rows = GridRows::default();
        table.rows(|row| rows.push(row).map(|()| true))?;
        rows.finish(table)
    }
}

impl GridRows {
    /// Adds a row; a shorter one must be the last.
    pub(super) fn push(&mut self, row: &TextRow) -> Result<(), Misread> {
        let nx = *self.nx.get_or_insert(row.len());
        if let Some((line, found)) = self.cut_row {
            return Err(row.place(0).at_line(line).bad(
                format!("{found} cells where the first row has {nx}"),
                "as many cells in every row are expected",
            ));
        }
        if row.len() > nx {
            return Err(row.place(nx).bad(
                format!("{} cells where the first row has {nx}", row.len()),
                "as many cells in every row are expected",
            ));
        }
        let cut = row.len() < nx;
        // The last cell of a truncated row may be incomplete.
        let whole = if cut { row.len().saturating_sub(1) } else { nx };
        for column in 0..whole {
            self.push_cell(row, column)?;
        }
        if cut {
            self.values.resize(self.values.len() + nx - whole, f64::NAN);
            self.cut_row = Some((row.line, row.len()));
        }
        Ok(())
    }

    fn push_cell(&mut self, row: &TextRow, column: usize) -> Result<(), Misread> {
        let cell = row.cell(column);
        self.fractions += usize::from(cell.contains(&b'.') || cell.contains(&b','));
        self.leading_zeros += usize::from(cell.len() > 1 && cell[0] == b'0' && cell[1].is_ascii_digit());
        let value = row.number(column)?;
        let value = match value {
            Some(value) if !value.is_finite() => {
                self.words += 1;
                f64::NAN
            }
            other => other.unwrap_or(f64::NAN),
        };
        self.values.push(value);
        Ok(())
    }

    /// The grid, if the rows form one.
    pub(super) fn finish(self, table: &TextTable) -> Result<Grid, Misread> {
        let nx = self.nx.unwrap_or(0);
        let ny = self.values.len().checked_div(nx).unwrap_or(0);
        let place = || Place::file(table.file());
        if nx < 2 || ny < 2 {
            return Err(place().bad(format!("{ny} rows of {nx} cells"), "a grid of at least 2 x 2 cells is expected"));
        }
        if self.fractions == 0 && self.leading_zeros > 0 {
            let found = "decimals are written with commas, which also separate the cells";
            return Err(place().bad(found, "decimal points, or semicolons between the cells, are expected"));
        }
        let mut notes = table.notes.clone();
        if self.words > 0 {
            notes.push(format!("{} cells say NaN or infinity: read as missing", self.words));
        }
        match self.cut_row {
            Some((line, found)) if !table.ends_within_a_line() => {
                return Err(Place::line(table.file(), line).bad(
                    format!("{found} cells where the first row has {nx}"),
                    "as many cells in every row are expected",
                ));
            }
            Some((line, found)) => notes.push(format!(
                "line {line} is cut short after {found} of {nx} cells: the cut cell and the rest of the row are missing"
            )),
            None => {}
        }
        Ok(Grid { nx, ny, values: self.values, notes })
    }
}
