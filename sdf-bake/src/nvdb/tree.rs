//! A NanoVDB grid as read: leaves, tiles and the map to world space.

use glam::{DVec3, IVec3};

/// A cube of equal values without a leaf, other than inactive background.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Tile<V> {
    /// Lowest voxel of the cube [voxels].
    pub voxel: IVec3,
    /// Binary logarithm of the cube's side [voxels]: 3, 7 or 12.
    pub side_log2: u32,
    /// Value throughout the cube.
    pub value: V,
    /// True if its voxels are active.
    pub active: bool,
}

/// The values of a grid.
#[derive(Clone, Debug, PartialEq)]
pub struct Tree<V> {
    /// Value outside leaves and tiles.
    pub background: V,
    /// Leaves, in units of 8 voxels, in the order of the file.
    pub leaves: Vec<IVec3>,
    /// Active voxels of each leaf, one bit each: word x, bit 8 y + z.
    pub active: Vec<[u64; 8]>,
    /// Values, z fastest, shape `[leaves, 512]`.
    pub values: Vec<V>,
    /// Cubes of equal values.
    pub tiles: Vec<Tile<V>>,
}

impl<V> Tree<V> {
    /// Number of active voxels in leaves and tiles.
    pub fn active_voxels(&self) -> u64 {
        let in_leaves: u64 = self.active.iter().flatten().map(|word| u64::from(word.count_ones())).sum();
        let tiles = self.tiles.iter().filter(|tile| tile.active);
        tiles.map(|tile| 1u64 << (3 * tile.side_log2)).fold(in_leaves, u64::saturating_add)
    }
}

/// The values of a grid, by type.
#[derive(Clone, Debug, PartialEq)]
pub enum Values {
    /// Single precision.
    Float(Tree<f32>),
    /// Integers.
    Int32(Tree<i32>),
}

/// Class of a grid as the file states it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum GridClass {
    /// Unspecified.
    Unknown,
    /// A narrow band of signed distances.
    LevelSet,
    /// A density.
    FogVolume,
    /// Another of NanoVDB's classes, by its number.
    Other(u32),
}

/// Result of comparing a grid's checksum with its bytes.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Checksum {
    /// The checksum agrees.
    Matches,
    /// The checksum differs: the grid was changed after it was written.
    Differs,
    /// The writer omitted the checksum.
    Absent,
    /// The writer is newer than 32.6 and computes the checksum in a way that is not implemented here.
    Unknown,
}

/// One grid of a file.
#[derive(Clone, Debug, PartialEq)]
pub struct NvdbGrid {
    /// Its name.
    pub name: String,
    /// Its class.
    pub class: GridClass,
    /// Distance between voxels [m, or the unit of the writer's world].
    pub voxel: f64,
    /// Position of voxel (0, 0, 0) in the world [m].
    pub translation: DVec3,
    /// Lowest and highest active voxel as the file states them; `None` if nothing is active.
    pub index_bbox: Option<(IVec3, IVec3)>,
    /// Box of the active voxels as the file states it [m].
    pub world_bbox: Option<(DVec3, DVec3)>,
    /// Number of active voxels, counted.
    pub active_voxels: u64,
    /// Result of the checksum.
    pub checksum: Checksum,
    /// The values.
    pub values: Values,
}

/// A `.nvdb` file.
#[derive(Clone, Debug, PartialEq)]
pub struct NvdbFile {
    /// Its grids, in order.
    pub grids: Vec<NvdbGrid>,
}

impl NvdbFile {
    /// Returns the first grid of a name.
    pub fn grid(&self, name: &str) -> Option<&NvdbGrid> {
        self.grids.iter().find(|grid| grid.name == name)
    }
}
