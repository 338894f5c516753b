//! Byte layout of a `.nvdb` file, version 32.4, little-endian.
//!
//! ```text
//! file:  FileHeader  (FileMeta name\0)×grids  payload×grids
//! grid:  GridData TreeData RootData RootTile×n  upper×n  lower×n  Leaf×n     all 32-byte multiples
//! ```
//!
//! Both value types written here (Float, Int32) are four bytes wide with statistics in f32, so one layout serves both;
//! a value is stored as its bits (`u32`). An inner node has no struct of its own because its table is too large for the
//! stack; [`Level`] gives the offsets of its parts.
//!
//! Source: K. Museth, "NanoVDB: a GPU-friendly and portable VDB data structure for real-time rendering and
//! simulation", SIGGRAPH Talks 2021, and the public headers of NanoVDB 32.4.2.

use bytemuck::{Pod, Zeroable};

const _: () = assert!(cfg!(target_endian = "little"), "NanoVDB files are little-endian");

/// Magic number at the start of a file and of a grid.
pub(super) const MAGIC: u64 = u64::from_le_bytes(*b"NanoVDB0");
/// Magic number of a grid from newer 32.x writers, with the same node layout.
pub(super) const MAGIC_NEWER_GRID: u64 = u64::from_le_bytes(*b"NanoVDB1");
/// Magic number of a file from newer 32.x writers.
pub(super) const MAGIC_NEWER_FILE: u64 = u64::from_le_bytes(*b"NanoVDB2");

/// Length of a grid's name, including the terminating zero [bytes].
pub(super) const NAME_BYTES: usize = 256;

/// Major, minor and patch number in 11, 11 and 10 bits.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Pod, Zeroable)]
#[repr(transparent)]
pub(super) struct Version(pub(super) u32);

impl Version {
    /// The version written here.
    pub(super) const WRITTEN: Self = Self::new(32, 4, 2);
    /// The last version whose checksum is one CRC per node.
    pub(super) const LAST_NODE_CHECKSUM: Self = Self::new(32, 6, 0);

    pub(super) const fn new(major: u32, minor: u32, patch: u32) -> Self {
        Self(major << 21 | minor << 10 | patch)
    }

    pub(super) const fn major(self) -> u32 {
        self.0 >> 21
    }

    pub(super) const fn minor(self) -> u32 {
        self.0 >> 10 & 0x7ff
    }
}

/// Bits of [`GridData::flags`].
pub(super) mod flags {
    pub(crate) const BBOX: u32 = 1 << 1;
    pub(crate) const MIN_MAX: u32 = 1 << 2;
    pub(crate) const AVERAGE: u32 = 1 << 3;
    pub(crate) const STD_DEVIATION: u32 = 1 << 4;
    pub(crate) const BREADTH_FIRST: u32 = 1 << 5;

    /// Node flag: a renderer may skip the node.
    pub(crate) const NODE_SKIP: u8 = 1;
    /// Node flag: the node holds active values.
    pub(crate) const NODE_ACTIVE: u8 = 2;
}

/// Head of a file segment.
#[derive(Clone, Copy, Debug, Pod, Zeroable)]
#[repr(C)]
pub(super) struct FileHeader {
    pub(super) magic: u64,
    pub(super) version: Version,
    pub(super) grid_count: u16,
    pub(super) codec: u16,
}

/// Entry for a grid in a file's table before the payloads; the grid's name and a zero follow.
#[derive(Clone, Copy, Debug, Pod, Zeroable)]
#[repr(C)]
pub(super) struct FileMeta {
    /// Bytes of the grid in memory.
    pub(super) grid_size: u64,
    /// Bytes of the payload in the file.
    pub(super) file_size: u64,
    pub(super) name_key: u64,
    pub(super) voxel_count: u64,
    pub(super) grid_type: u32,
    pub(super) grid_class: u32,
    /// World bounding box [m].
    pub(super) world_bbox: [f64; 6],
    /// Index bounding box, inclusive [voxels].
    pub(super) index_bbox: [i32; 6],
    /// Voxel size [m].
    pub(super) voxel_size: [f64; 3],
    /// Length of the name, including the terminating zero [bytes].
    pub(super) name_size: u32,
    /// Numbers of leaves, lower nodes, upper nodes, roots.
    pub(super) node_count: [u32; 4],
    /// Numbers of active tiles of lower nodes, upper nodes, root.
    pub(super) tile_count: [u32; 3],
    pub(super) codec: u16,
    pub(super) padding: u16,
    pub(super) version: Version,
}

/// Map from index space [voxels] to world space [m], row by row, in both precisions.
#[derive(Clone, Copy, Debug, Pod, Zeroable)]
#[repr(C)]
pub(super) struct Map {
    pub(super) matrix_f: [f32; 9],
    pub(super) inverse_f: [f32; 9],
    pub(super) translation_f: [f32; 3],
    pub(super) taper_f: f32,
    pub(super) matrix: [f64; 9],
    pub(super) inverse: [f64; 9],
    pub(super) translation: [f64; 3],
    pub(super) taper: f64,
}

/// Head of a grid.
#[derive(Clone, Copy, Debug, Pod, Zeroable)]
#[repr(C)]
pub(super) struct GridData {
    pub(super) magic: u64,
    pub(super) checksum: u64,
    pub(super) version: Version,
    pub(super) flags: u32,
    pub(super) grid_index: u32,
    pub(super) grid_count: u32,
    pub(super) grid_size: u64,
    pub(super) name: [u8; NAME_BYTES],
    pub(super) map: Map,
    pub(super) world_bbox: [f64; 6],
    pub(super) voxel_size: [f64; 3],
    pub(super) grid_class: u32,
    pub(super) grid_type: u32,
    pub(super) blind_offset: i64,
    pub(super) blind_count: u32,
    pub(super) data0: u32,
    pub(super) data1: u64,
    pub(super) data2: u64,
}

/// Tree data; follows [`GridData`].
#[derive(Clone, Copy, Debug, Pod, Zeroable)]
#[repr(C)]
pub(super) struct TreeData {
    /// Offsets from this struct to the first leaf, lower node, upper node and the root [bytes].
    pub(super) node_offset: [u64; 4],
    pub(super) node_count: [u32; 3],
    pub(super) tile_count: [u32; 3],
    pub(super) voxel_count: u64,
}

/// Least, greatest, mean and standard deviation of the active values below a node.
#[derive(Clone, Copy, Debug, Pod, Zeroable)]
#[repr(C)]
pub(super) struct Stats {
    pub(super) min: u32,
    pub(super) max: u32,
    pub(super) average: f32,
    pub(super) deviation: f32,
}

/// The root; `table_size` [`RootTile`]s follow.
#[derive(Clone, Copy, Debug, Pod, Zeroable)]
#[repr(C)]
pub(super) struct RootData {
    pub(super) bbox: [i32; 6],
    pub(super) table_size: u32,
    pub(super) background: u32,
    pub(super) stats: Stats,
    pub(super) padding: [u64; 2],
}

/// An entry of the root: an upper node, or one value for its 4096³ voxels.
#[derive(Clone, Copy, Debug, Pod, Zeroable)]
#[repr(C)]
pub(super) struct RootTile {
    pub(super) key: u64,
    /// Offset from the root to the upper node [bytes]; 0 for a value.
    pub(super) child: i64,
    pub(super) state: u32,
    pub(super) value: u32,
    pub(super) padding: u64,
}

/// Head of an inner node.
#[derive(Clone, Copy, Debug, Pod, Zeroable)]
#[repr(C)]
pub(super) struct NodeHead {
    pub(super) bbox: [i32; 6],
    pub(super) flags: u64,
}

/// A node of 8³ voxels; z runs fastest, as in a brick.
#[derive(Clone, Copy, Debug, Pod, Zeroable)]
#[repr(C)]
pub(super) struct Leaf {
    pub(super) bbox_min: [i32; 3],
    pub(super) bbox_extent: [u8; 3],
    pub(super) flags: u8,
    pub(super) active: [u64; 8],
    pub(super) stats: Stats,
    pub(super) values: [u32; 512],
}

/// Bytes of a leaf.
pub(super) const LEAF_BYTES: usize = size_of::<Leaf>();

/// An inner node: head, active mask, child mask, statistics, table of 8-byte cells.
#[derive(Clone, Copy, Debug)]
pub(super) struct Level {
    /// Binary logarithm of the cells along an axis.
    pub(super) log2: u32,
    /// Binary logarithm of the voxels along an axis.
    pub(super) voxels_log2: u32,
}

/// Lower node: 16³ leaves.
pub(super) const LOWER: Level = Level { log2: 4, voxels_log2: 7 };
/// Upper node: 32³ lower nodes.
pub(super) const UPPER: Level = Level { log2: 5, voxels_log2: 12 };

impl Level {
    pub(super) const fn cells(self) -> usize {
        1 << (3 * self.log2)
    }

    pub(super) const fn active_at(self) -> usize {
        size_of::<NodeHead>()
    }

    pub(super) const fn children_at(self) -> usize {
        self.active_at() + self.cells() / 8
    }

    pub(super) const fn stats_at(self) -> usize {
        self.children_at() + self.cells() / 8
    }

    pub(super) const fn table_at(self) -> usize {
        (self.stats_at() + size_of::<Stats>()).next_multiple_of(32)
    }

    pub(super) const fn bytes(self) -> usize {
        self.table_at() + 8 * self.cells()
    }
}

const _: () = assert!(size_of::<FileHeader>() == 16 && size_of::<FileMeta>() == 176);
const _: () = assert!(size_of::<Map>() == 264 && size_of::<GridData>() == 672 && size_of::<TreeData>() == 64);
const _: () = assert!(size_of::<RootData>() == 64 && size_of::<RootTile>() == 32);
const _: () = assert!(UPPER.bytes() == 270_400 && LOWER.bytes() == 33_856 && LEAF_BYTES == 2_144);

/// Key of a root entry from the coordinates of its upper node [upper nodes].
pub(super) fn root_key(upper: glam::IVec3) -> u64 {
    let part = |c: i32| u64::from((c as u32) << UPPER.voxels_log2 >> UPPER.voxels_log2);
    part(upper.z) | part(upper.y) << 21 | part(upper.x) << 42
}

/// Coordinates of an upper node [upper nodes] from its key; `None` for an invalid key.
pub(super) fn root_coordinates(key: u64) -> Option<glam::IVec3> {
    let part = |shift: u32| ((key >> shift & 0xf_ffff) << UPPER.voxels_log2) as u32 as i32 >> UPPER.voxels_log2;
    let upper = glam::IVec3::new(part(42), part(21), part(0));
    (root_key(upper) == key).then_some(upper)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn root_keys_of_negative_coordinates_come_back() {
        for upper in [glam::IVec3::ZERO, glam::IVec3::new(-1, 3, -524_288), glam::IVec3::splat(524_287)] {
            assert_eq!(root_coordinates(root_key(upper)), Some(upper));
        }
        assert_eq!(root_coordinates(1 << 20), None);
    }
}
