//! Tables: finishing trials with one row of settings and removal per contact, such as force, speed, time and removed
//! depth (`finishing-table/1`).
//!
//! Flow of the data: [`Table::read`] reads `table.toml` (`manifest`), finds its columns in the CSV (`columns`), reads
//! the cells (`read`, `missing`), orders the rows (`arrange`, `order`), draws the held-out rows (`held_out`) and checks
//! the plausibility of the units (`plausible`). All is SI here; other units stay in the files.

mod arrange;
mod columns;
mod held_out;
mod manifest;
mod missing;
mod order;
mod plausible;
mod read;

use std::path::{Path, PathBuf};

use effects::{Dimension, Process};

pub use manifest::{TABLE_FILE, TABLE_FORMAT};

use crate::trial::{Covariate, Role, TrialError};

/// Measured quantity of the removal.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Removed {
    /// A depth: the recession of the surface.
    Depth,
    /// A volume, or a mass with the density.
    Volume,
}

/// A state that a column measures, such as hours of use or a temperature.
#[derive(Clone, Debug, PartialEq)]
pub struct Usage {
    /// Key of the column in the table's manifest: `usage`, or a user-defined name.
    pub key: String,
    /// Name of the column.
    pub name: String,
    /// Dimension of its unit.
    pub dimension: Dimension,
    /// The unit as the file writes it.
    pub unit: String,
    /// SI value of one unit, and of the file's zero.
    pub scale: (f64, f64),
}

/// One row: one contact with constant settings. A quantity that the table does not give is `None` in every row.
#[derive(Clone, Debug, PartialEq)]
pub struct Row {
    /// Line in the CSV, from 1.
    pub line: u64,
    /// Time since the first row began [s], if the order is given by date.
    pub began: Option<f64>,
    /// Normal force [N].
    pub force: Option<f64>,
    /// Mean pressure of the contact [Pa], if the table gives it or the contact's area.
    pub pressure: Option<f64>,
    /// Sliding speed [m/s].
    pub speed: Option<f64>,
    /// Duration of the contact [s].
    pub duration: Option<f64>,
    /// Mean removed depth [m/s] or volume [m³/s] per time; `None` if it was not measured in this row.
    pub removal_rate: Option<f64>,
    /// Index in [`Table::groups`].
    pub group: usize,
    /// Index in [`Table::tools`].
    pub tool: usize,
    /// True if the tool was dressed or replaced before this row.
    pub fresh: bool,
    /// Split: calibration rows are fitted, held-out rows are not.
    pub role: Role,
    /// Values of [`Table::usage`] [SI].
    pub usage: Vec<f64>,
}

/// A table with all its rows.
#[derive(Clone, Debug, PartialEq)]
pub struct Table {
    /// Folder from which it was read.
    pub folder: PathBuf,
    /// Its name.
    pub name: String,
    /// Process: grinding or sanding.
    pub process: Process,
    /// Area of the contact [m²].
    pub area: Option<f64>,
    /// Radius of the tool [m].
    pub radius: Option<f64>,
    /// Thickness of the coating [m].
    pub coating: Option<f64>,
    /// Kind of the rows' removal.
    pub removed: Removed,
    /// Names of the recipes; one empty name if the table gives none.
    pub groups: Vec<String>,
    /// Names of the tools; one empty name if the table gives none.
    pub tools: Vec<String>,
    /// States that columns measure.
    pub usage: Vec<Usage>,
    /// Rows in order of time, or in the order of the file.
    pub rows: Vec<Row>,
    /// True if the order of the rows is that of time.
    pub in_time: bool,
    /// Relative standard deviation of a row's removal, if the table states it.
    pub noise: Option<f64>,
    /// Further numerical columns, one value per row, NaN where the cell is empty.
    pub covariates: Vec<Covariate>,
    /// Notes on the interpretation of the files, one sentence each.
    pub notes: Vec<String>,
}

impl Table {
    /// Reads a folder with a `table.toml` and its CSV.
    ///
    /// # Errors
    /// [`TrialError`] with file, line and column, the value found and the values accepted.
    pub fn read(folder: &Path) -> Result<Self, TrialError> {
        read::read(folder)
    }
}
