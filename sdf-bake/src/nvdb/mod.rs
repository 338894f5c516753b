//! NanoVDB files (`.nvdb`): the cache of baked fields, and exchange with other programs.
//!
//! A VDB is a tree of three levels below its root: upper nodes of 32³ lower nodes of 16³ leaves of 8³ voxels (K. Museth
//! 2013). NanoVDB stores that tree in one buffer without pointers (K. Museth 2021). A brick of [`BrickGrid`] is a leaf,
//! value for value, so writing is a copy plus the upper levels. Outside the bricks, a node holds one *tile* value for a
//! whole cell: −band inside, +band outside. So any sampler can distinguish inside from outside everywhere.
//!
//! [`write_field`] and [`NvdbFile::to_field`] store and restore a field with all its channels; [`write()`] takes any
//! choice of grids. [`write()`] writes version 32.4 of the format; [`read()`] accepts 32.x from any writer, Float and
//! Int32, uncompressed or zip. `docs/nanovdb.md` lists the programs that were tested.
//!
//! ```
//! use glam::DVec3;
//! use sdf_bake::BrickGrid;
//! use sdf_bake::nvdb::{Codec, GridRef, read, write};
//!
//! let low = DVec3::splat(-0.01);
//! let ball = BrickGrid::from_distance(low, -low, 0.001, 3.0, |p| p.length() - 0.01);
//! let bytes = write(&[GridRef::LevelSet { name: "phi", grid: &ball }], Codec::None)?;
//! let back = read(&bytes)?.grid("phi").unwrap().to_bricks()?;
//! assert_eq!(back.phi, ball.phi);
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```

mod bricks;
mod bytes;
mod channels;
mod checksum;
mod encode;
mod error;
mod field;
mod layout;
mod nodes;
mod read;
mod summary;
mod topology;
mod tree;
mod write;

pub use channels::{PHI, WELD_ID, write_field};
pub use error::{BricksError, NvdbError, WriteError};
pub use read::{HEAD_BYTES, grids_in, read};
pub use tree::{Checksum, GridClass, NvdbFile, NvdbGrid, Tile, Tree, Values};
pub use write::write;

use crate::grid::BrickGrid;

/// Compression of payloads in a file.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Codec {
    /// Uncompressed: fast, and read by every program.
    None,
    /// One zlib stream per payload: about a third of the size for a level set, and several times slower to write.
    Zip,
}

impl Codec {
    fn number(self) -> u16 {
        match self {
            Self::None => 0,
            Self::Zip => 1,
        }
    }
}

/// A channel of a brick grid, to be written as one NanoVDB grid.
#[derive(Clone, Copy, Debug)]
pub enum GridRef<'a> {
    /// φ [m] as a Float level set: background is the band, voxels with |φ| < band are active.
    LevelSet {
        /// Name in the file, at most 255 bytes.
        name: &'a str,
        /// The field.
        grid: &'a BrickGrid,
    },
    /// Weld ids as an Int32 grid: background 0, labelled voxels are active.
    Labels {
        /// Name in the file, at most 255 bytes.
        name: &'a str,
        /// The field whose `label` is written.
        grid: &'a BrickGrid,
    },
    /// Another channel as a Float fog volume: background 0, voxels that are not 0 are active.
    Density {
        /// Name in the file, at most 255 bytes.
        name: &'a str,
        /// The field to whose bricks the values belong.
        grid: &'a BrickGrid,
        /// Values in the order of `grid.phi`, shape `[bricks, 512]`.
        values: &'a [f32],
    },
}

impl<'a> GridRef<'a> {
    fn name(&self) -> &'a str {
        match self {
            Self::LevelSet { name, .. } | Self::Labels { name, .. } | Self::Density { name, .. } => name,
        }
    }
}
