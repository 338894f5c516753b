//! What can be wrong with a file, with what is to become one, and with what was read.

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

/// Why bytes were not read as a `.nvdb` file.
#[derive(Clone, Debug, PartialEq, Error)]
pub enum NvdbError {
    /// The file ends too early.
    #[error("the file ends inside {what}: bytes {at} to {end} of {length}; it is truncated")]
    Truncated {
        /// What was being read.
        what: &'static str,
        /// Where it begins [bytes].
        at: u64,
        /// Where it would end [bytes].
        end: u64,
        /// Bytes there are.
        length: u64,
    },
    /// No NanoVDB file or grid.
    #[error("{what} begins with {found:?}, not \"NanoVDB0\"; a .nvdb file is expected")]
    Magic {
        /// The file or a grid.
        what: &'static str,
        /// The first eight bytes.
        found: String,
    },
    /// Another major version.
    #[error("NanoVDB version {major}.{minor}; versions 32.x are read, write the file anew with such a version")]
    Version {
        /// Major version.
        major: u32,
        /// Minor version.
        minor: u32,
    },
    /// A codec that is not read.
    #[error("codec {0}; none and zip are read, write the file anew with one of them")]
    Codec(&'static str),
    /// A value type that is not read.
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
    /// A compressed grid that does not unpack to what the file promises.
    #[error("grid {grid:?} does not unpack: {reason}; the file is damaged")]
    Unzip {
        /// The grid.
        grid: String,
        /// What zlib found.
        reason: String,
    },
    /// A size, count or offset that the grid cannot have.
    #[error("grid {grid:?}: {what}; the file is damaged")]
    Structure {
        /// The grid.
        grid: String,
        /// What was found.
        what: String,
    },
}

/// Why a grid that was read cannot become bricks or a channel of bricks.
#[derive(Clone, Debug, PartialEq, Error)]
pub enum BricksError {
    /// The file lacks a grid.
    #[error("no grid {wanted:?}; the file holds {found:?}")]
    Missing {
        /// The grid looked for.
        wanted: &'static str,
        /// Names of the grids there are.
        found: Vec<String>,
    },
    /// The grid holds something else.
    #[error("grid {grid:?} is a {found}; {expected} is needed")]
    Kind {
        /// The grid.
        grid: String,
        /// Its class and value type.
        found: String,
        /// What would be accepted.
        expected: &'static str,
    },
    /// A world that does not begin at voxel (0, 0, 0).
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
        /// Bricks that the box around them would hold.
        entries: u128,
        /// Entries that would be accepted.
        limit: u128,
    },
    /// A value that the bricks cannot hold.
    #[error("grid {grid:?}, voxel {voxel}: {what}")]
    Value {
        /// The grid.
        grid: String,
        /// Where.
        voxel: glam::IVec3,
        /// What was found there.
        what: String,
    },
}
