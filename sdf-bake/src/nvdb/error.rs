//! Errors of writing a file, of reading one, and of converting what was read.

use thiserror::Error;

/// Reason why grids were not written.
#[derive(Clone, Debug, PartialEq, Error)]
pub enum WriteError {
    /// No grid, or more grids than the format's counter allows.
    #[error("{0} grids for one file; give between 1 and 65535")]
    GridCount(usize),
    /// A name that NanoVDB cannot store.
    #[error("{0:?} cannot name a grid; give 1 to 255 bytes without a zero byte")]
    Name(String),
    /// An array whose length does not match the bricks.
    #[error("grid {name:?} has {values} values, its bricks need {expected}")]
    Values {
        /// The grid.
        name: String,
        /// Values found.
        values: usize,
        /// 512 for each brick.
        expected: usize,
    },
    /// An inconsistent brick grid.
    #[error("grid {name:?}: {what}")]
    Grid {
        /// The grid.
        name: String,
        /// The inconsistency.
        what: String,
    },
}

/// Reason why bytes were not read as a `.nvdb` file.
#[derive(Clone, Debug, PartialEq, Error)]
pub enum NvdbError {
    /// The file ends too early.
    #[error("the file ends inside {what}: bytes {at} to {end} of {length}; it is truncated")]
    Truncated {
        /// Part that was being read.
        what: &'static str,
        /// Start of this part [bytes].
        at: u64,
        /// End of this part [bytes].
        end: u64,
        /// Length of the file [bytes].
        length: u64,
    },
    /// Not a NanoVDB file or grid.
    #[error("{what} begins with {found:?}, not \"NanoVDB0\"; a .nvdb file is expected")]
    Magic {
        /// The file or a grid.
        what: &'static str,
        /// The first eight bytes.
        found: String,
    },
    /// An unsupported major version.
    #[error("NanoVDB version {major}.{minor}; versions 32.x are read: rewrite the file with one of them")]
    Version {
        /// Major version.
        major: u32,
        /// Minor version.
        minor: u32,
    },
    /// An unsupported codec.
    #[error("codec {0}; none and zip are read: rewrite the file with one of them")]
    Codec(&'static str),
    /// An unsupported value type.
    #[error("grid {grid:?} holds {found} values; Float and Int32 are read")]
    ValueType {
        /// The grid.
        grid: String,
        /// NanoVDB's name of the type.
        found: &'static str,
    },
    /// A map from index to world space other than a uniform scale and a translation.
    #[error("grid {grid:?} has a map that turns, shears or stretches; a uniform scale and a translation are read")]
    Map {
        /// The grid.
        grid: String,
    },
    /// A compressed grid that does not decompress to the size that the file states.
    #[error("grid {grid:?} does not unpack: {reason}; the file is damaged")]
    Unzip {
        /// The grid.
        grid: String,
        /// Error of zlib.
        reason: String,
    },
    /// An invalid size, count or offset of a grid.
    #[error("grid {grid:?}: {what}; the file is damaged")]
    Structure {
        /// The grid.
        grid: String,
        /// The fault.
        what: String,
    },
}

/// Reason why a grid that was read cannot be converted to bricks or to a channel.
#[derive(Clone, Debug, PartialEq, Error)]
pub enum BricksError {
    /// The file lacks a grid.
    #[error("no grid {wanted:?}; the file holds {found:?}")]
    Missing {
        /// Name of the missing grid.
        wanted: &'static str,
        /// Names of the file's grids.
        found: Vec<String>,
    },
    /// The grid has a different kind.
    #[error("grid {grid:?} is a {found}; {expected} is needed")]
    Kind {
        /// The grid.
        grid: String,
        /// Its class and value type.
        found: String,
        /// Kind that is accepted.
        expected: &'static str,
    },
    /// A grid whose voxel (0, 0, 0) is not at the origin of its world.
    #[error("grid {grid:?} is moved by {translation} m; bricks need voxel (0, 0, 0) at the origin")]
    Translation {
        /// The grid.
        grid: String,
        /// Position of voxel (0, 0, 0) [m].
        translation: glam::DVec3,
    },
    /// Too much empty space between the bricks.
    #[error("grid {grid:?} has {leaves} bricks spread over {entries} index entries; the limit is {limit}")]
    Sparse {
        /// The grid.
        grid: String,
        /// Bricks.
        leaves: usize,
        /// Number of bricks in the box around them.
        entries: u128,
        /// Greatest accepted number of entries.
        limit: u128,
    },
    /// A value that bricks cannot store.
    #[error("grid {grid:?}, voxel {voxel}: {what}")]
    Value {
        /// The grid.
        grid: String,
        /// Voxel of the value.
        voxel: glam::IVec3,
        /// Description of the value.
        what: String,
    },
}
