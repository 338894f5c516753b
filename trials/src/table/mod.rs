//! Tables: finishing trials of which only rows are known, such as force, speed, time and removed depth
//! (`finishing-table/1`).
//!
//! The road of the data: [`Table::read`] reads `table.toml` (`manifest`), finds its columns in the CSV (`columns`), reads
//! the cells (`read`, `missing`), puts the rows in order (`arrange`, `order`), draws those held out (`held_out`) and checks their
//! units (`plausible`). All is SI here; other units stay in the files.

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

/// What was measured of the removal.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Removed {
    /// A depth: the surface receded by it.
    Depth,
    /// A volume, or a mass and the density.
    Volume,
}

/// A state that a column measures, such as hours of use or a temperature.
#[derive(Clone, Debug, PartialEq)]
pub struct Usage {
    /// Key under which the table declares it: `usage`, or a name of the user's own.
    pub key: String,
    /// Name of the column.
    pub name: String,
    /// What it is measured in.
    pub dimension: Dimension,
    /// The unit as the file writes it.
    pub unit: String,
    /// SI value of one such unit, and of zero in the file.
    pub scale: (f64, f64),
}

/// One row: a piece of work with one setting. Quantities that the table does not give are `None` in every row.
#[derive(Clone, Debug, PartialEq)]
pub struct Row {
    /// Line in the CSV, from 1.
    pub line: u64,
    /// Time since the first row began [s], where the order is by date.
    pub began: Option<f64>,
    /// Normal force [N].
    pub force: Option<f64>,
    /// Mean pressure of the contact [Pa], where the table gives it or the contact's area.
    pub pressure: Option<f64>,
    /// Sliding speed [m/s].
    pub speed: Option<f64>,
    /// How long the tool worked [s].
    pub duration: Option<f64>,
    /// Mean of the removed depth [m/s] or volume [m³/s] per time; `None`: not measured in this row.
    pub removal_rate: Option<f64>,
    /// Place among [`Table::groups`].
    pub group: usize,
    /// Place among [`Table::tools`].
    pub tool: usize,
    /// Whether the tool was dressed or renewed before this row.
    pub fresh: bool,
    /// Whether a fit may see what was removed.
    pub role: Role,
    /// Values of [`Table::usage`] [SI].
    pub usage: Vec<f64>,
}

/// A table with all its rows.
#[derive(Clone, Debug, PartialEq)]
pub struct Table {
    /// Where it was read.
    pub folder: PathBuf,
    /// Its name.
    pub name: String,
    /// What the tool does.
    pub process: Process,
    /// Area of the contact [m²].
    pub area: Option<f64>,
    /// Radius of the tool [m].
    pub radius: Option<f64>,
    /// Thickness of the coating [m].
    pub coating: Option<f64>,
    /// What the rows' removal rate is a rate of.
    pub removed: Removed,
    /// Recipes; one without a name where the table has none.
    pub groups: Vec<String>,
    /// Tools; one without a name where the table has none.
    pub tools: Vec<String>,
    /// States that columns measure.
    pub usage: Vec<Usage>,
    /// Rows in order of time, or as the file has them.
    pub rows: Vec<Row>,
    /// Whether the order of the rows is that of time.
    pub in_time: bool,
    /// Standard deviation of a row's removal over the removal, where the table states it.
    pub noise: Option<f64>,
    /// Further columns of numbers, one value per row, NaN where the cell is empty.
    pub covariates: Vec<Covariate>,
    /// What was understood of the files, one sentence each.
    pub notes: Vec<String>,
}

impl Table {
    /// Reads a folder with a `table.toml` and its CSV.
    ///
    /// # Errors
    /// [`TrialError`] with file, line and column, what was found and what would be accepted.
    pub fn read(folder: &Path) -> Result<Self, TrialError> {
        read::read(folder)
    }
}
