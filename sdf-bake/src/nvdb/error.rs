//! What can be wrong with a file or with what is to become one.

use thiserror::Error;

/// Why grids were not written.
#[derive(Clone, Debug, PartialEq, Error)]
pub enum WriteError {
    /// The file would hold no grid, or more than its counter can count.
    #[error("{0} grids for one file; give between 1 and 65535")]
    GridCount(usize),
    /// A name NanoVDB cannot hold.
    #[error("{0:?} cannot name a grid; give 1 to 255 bytes without a zero byte")]
    Name(String),
    /// An array does not fit the bricks.
    #[error("grid {name:?} has {values} values, its bricks need {expected}")]
    Values {
        /// The grid.
        name: String,
        /// Values found.
        values: usize,
        /// 512 for each brick.
        expected: usize,
    },
    /// A brick grid that contradicts itself.
    #[error("grid {name:?}: {what}")]
    Grid {
        /// The grid.
        name: String,
        /// What was found.
        what: String,
    },
}
