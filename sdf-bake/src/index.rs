//! Maps the bricks of a box to slots in the pool: tiles of 8³ entries under a dense root.
//!
//! ```text
//!   root   ┌───┬───┬───┬───┐   a tile's number, or one side for all of its bricks
//!          │ ○ │ 0 │ 1 │ ● │
//!          └───┴─┼─┴─┼─┴───┘
//!   tiles      512  512        a brick's slot, or its side
//! ```
//!
//! A part of n bricks across has about n² bricks; of the n³ entries around it, the root stores one in 512. A wire one
//! brick thick along the diagonal of a box of 256³ bricks, 4.5 MB, needs 0.1 MB of root and 0.2 MB of tiles.

use glam::{IVec2, IVec3};
use rayon::prelude::*;

use crate::grid::{BRICK_SIDE, BRICK_VOXELS, INSIDE, OUTSIDE, voxel_at, voxel_offset};

/// Entries along the side of a tile: equal to the voxels along a brick's side, so that a brick's offset in its tile is
/// computed like a voxel's in its brick.
const TILE_SIDE: i32 = BRICK_SIDE as i32;
/// Entries in a tile.
const TILE_ENTRIES: usize = BRICK_VOXELS;

/// Slots of the bricks of a box, or [`OUTSIDE`] or [`INSIDE`]. Brick coordinates count from the lowest of the box.
#[derive(Clone, Debug, Default)]
pub struct BrickIndex {
    dims: IVec3,
    /// Tiles per axis.
    root_dims: IVec3,
    /// Number of each tile, or [`OUTSIDE`] or [`INSIDE`]; x runs slowest.
    root: Vec<u32>,
    tiles: Vec<[u32; TILE_ENTRIES]>,
}

/// Location of a brick's entry.
#[derive(Clone, Copy)]
struct Place {
    /// Index of its tile in the root.
    tile: usize,
    /// Index of the entry in the tile.
    entry: usize,
}

impl BrickIndex {
    /// An index of `dims` bricks per axis, entirely outside.
    pub fn new(dims: IVec3) -> Self {
        let root_dims: IVec3 = (dims + (TILE_SIDE - 1)) >> 3;
        let root = vec![OUTSIDE; root_dims.as_usizevec3().element_product()];
        Self { dims, root_dims, root, tiles: Vec::new() }
    }

    /// An index of `dims` bricks per axis with the given slots, x slowest.
    ///
    /// # Panics
    /// If there are more slots than bricks.
    pub fn from_dense(dims: IVec3, slots: &[u32]) -> Self {
        let mut index = Self::new(dims);
        for (entry, &slot) in slots.iter().enumerate() {
            index.set(entry_brick(entry, dims), slot);
        }
        index
    }

    /// Bricks per axis.
    pub fn dims(&self) -> IVec3 {
        self.dims
    }

    /// Memory size [bytes].
    pub fn bytes(&self) -> usize {
        size_of_val(&self.root[..]) + size_of_val(&self.tiles[..])
    }

    /// Location of a brick's entry; `None` outside the box.
    #[inline]
    fn place(&self, brick: IVec3) -> Option<Place> {
        let within = brick.as_uvec3().cmplt(self.dims.as_uvec3()).all();
        within.then(|| Place { tile: self.tile(brick >> 3), entry: voxel_offset(brick) })
    }

    /// Slot at a location, or [`OUTSIDE`] or [`INSIDE`].
    #[inline]
    fn at(&self, place: Place) -> u32 {
        match self.root[place.tile] {
            side @ (OUTSIDE | INSIDE) => side,
            tile => self.tiles[tile as usize][place.entry % TILE_ENTRIES],
        }
    }

    /// Slot of a brick, or [`OUTSIDE`] or [`INSIDE`]; outside beyond the box.
    #[inline]
    pub fn get(&self, brick: IVec3) -> u32 {
        self.place(brick).map_or(OUTSIDE, |place| self.at(place))
    }

    /// Sets a brick's slot, or [`OUTSIDE`] or [`INSIDE`].
    ///
    /// # Panics
    /// If the brick is outside the box.
    pub fn set(&mut self, brick: IVec3, slot: u32) {
        let place = self.place(brick).expect("a brick of the box");
        let is_so = slot >= INSIDE && self.root[place.tile] == slot;
        if !is_so {
            self.tile_mut(place.tile)[place.entry] = slot;
        }
    }

    /// Sets the bricks from `low` to below `high`, which must lie within the box, to one side: [`OUTSIDE`] or
    /// [`INSIDE`].
    pub fn fill(&mut self, low: IVec3, high: IVec3, side: u32) {
        for at in cells(low >> 3, (high + (TILE_SIDE - 1)) >> 3) {
            let (first, end): (IVec3, IVec3) = (at << 3, (at + 1) << 3);
            let tile = self.tile(at);
            if self.root[tile] == side {
                continue;
            }
            if low.cmple(first).all() && high.cmpge(end.min(self.dims)).all() {
                self.root[tile] = side;
                continue;
            }
            let entries = self.tile_mut(tile);
            cells(low.max(first), high.min(end)).for_each(|brick| entries[voxel_offset(brick)] = side);
        }
    }

    /// Frees the memory of tiles that are entirely on one side.
    pub fn tidy(&mut self) {
        let tiles = std::mem::take(&mut self.tiles);
        for root in self.root.iter_mut().filter(|root| **root < INSIDE) {
            let tile = &tiles[*root as usize];
            let side = tile[0];
            if side >= INSIDE && tile.iter().all(|&slot| slot == side) {
                *root = side;
            } else {
                *root = self.tiles.len() as u32;
                self.tiles.push(*tile);
            }
        }
        self.tiles.shrink_to_fit();
    }

    /// Slots of the bricks at (x, y), along z.
    pub fn row(&self, x: i32, y: i32) -> impl Iterator<Item = u32> + '_ {
        let runs = (0..self.root_dims.z).flat_map(move |z| {
            let first = IVec3::new(x, y, z << 3);
            match self.root[self.tile(first >> 3)] {
                side @ (OUTSIDE | INSIDE) => [side; BRICK_SIDE],
                tile => std::array::from_fn(|i| self.tiles[tile as usize][voxel_offset(first) + i]),
            }
        });
        runs.take(self.dims.z as usize)
    }

    /// Heights z of the bricks at (x, y) that are not outside, in order; none beyond the box.
    pub(crate) fn occupied(&self, x: i32, y: i32) -> impl Iterator<Item = i32> + '_ {
        let is_within = IVec2::new(x, y).as_uvec2().cmplt(self.dims.truncate().as_uvec2()).all();
        let tiles = 0..if is_within { self.root_dims.z } else { 0 };
        let filled = tiles.filter(move |&z| self.root[self.tile(IVec3::new(x >> 3, y >> 3, z))] != OUTSIDE);
        let bricks = filled.flat_map(|z| z << 3..(z + 1) << 3).take_while(|&z| z < self.dims.z);
        bricks.filter(move |&z| self.get(IVec3::new(x, y, z)) != OUTSIDE)
    }

    /// Slots of all bricks, x slowest: the dense array that the GPU binds.
    pub fn dense(&self) -> Vec<u32> {
        (0..self.dims.x).flat_map(|x| (0..self.dims.y).flat_map(move |y| self.row(x, y))).collect()
    }

    /// Slots of all bricks that have a slot, tile by tile.
    pub fn slots(&self) -> impl Iterator<Item = u32> + '_ {
        let tiles = self.root.iter().filter(|&&tile| tile < INSIDE).flat_map(|&tile| self.tiles[tile as usize]);
        tiles.filter(|&slot| slot < INSIDE)
    }

    /// Number of tiles, including those entirely on one side.
    pub fn tile_count(&self) -> usize {
        self.root.len()
    }

    /// Bricks of a tile that are entirely inside.
    pub fn inside_of(&self, tile: usize) -> impl Iterator<Item = IVec3> + '_ {
        let first: IVec3 = entry_brick(tile, self.root_dims) << 3;
        let entries = if self.root[tile] == OUTSIDE { 0..0 } else { 0..TILE_ENTRIES };
        let is_inside = move |&entry: &usize| self.at(Place { tile, entry }) == INSIDE;
        let bricks = entries.filter(is_inside).map(move |entry| first + voxel_at(IVec3::ZERO, entry));
        bricks.filter(|brick| brick.cmplt(self.dims).all())
    }

    /// Index of a tile in the root.
    #[inline]
    fn tile(&self, at: IVec3) -> usize {
        ((at.x * self.root_dims.y + at.y) * self.root_dims.z + at.z) as usize
    }

    /// Entries of a tile; created if the tile was entirely on one side.
    fn tile_mut(&mut self, tile: usize) -> &mut [u32; TILE_ENTRIES] {
        let root = &mut self.root[tile];
        if *root >= INSIDE {
            self.tiles.push([*root; TILE_ENTRIES]);
            *root = self.tiles.len() as u32 - 1;
        }
        &mut self.tiles[*root as usize]
    }
}

/// Equal if the bricks have equal slots, however they are stored.
impl PartialEq for BrickIndex {
    fn eq(&self, other: &Self) -> bool {
        let alike = |x: i32, y: i32| self.row(x, y).eq(other.row(x, y));
        self.dims == other.dims && (0..self.dims.x).all(|x| (0..self.dims.y).all(|y| alike(x, y)))
    }
}

/// Brick coordinates, relative to the first, of an index in a dense array; x runs slowest.
pub(crate) fn entry_brick(entry: usize, dims: IVec3) -> IVec3 {
    let entry = entry as i32;
    IVec3::new(entry / (dims.y * dims.z), entry / dims.z % dims.y, entry % dims.z)
}

/// Columns (x, y) of a box of bricks, in order.
pub(crate) fn columns(dims: IVec3) -> impl IndexedParallelIterator<Item = IVec2> {
    (0..dims.x * dims.y).into_par_iter().map(move |column| IVec2::new(column / dims.y, column % dims.y))
}

fn cells(low: IVec3, high: IVec3) -> impl Iterator<Item = IVec3> {
    let across = (low.x..high.x).flat_map(move |x| (low.y..high.y).map(move |y| (x, y)));
    across.flat_map(move |(x, y)| (low.z..high.z).map(move |z| IVec3::new(x, y, z)))
}

#[cfg(test)]
mod tests {
    use super::*;

    const DIMS: IVec3 = IVec3::new(21, 8, 19);

    fn all() -> impl Iterator<Item = IVec3> {
        cells(IVec3::splat(-1), DIMS + 1)
    }

    #[test]
    fn slots_are_found_where_they_were_put() {
        let (low, high) = (IVec3::new(3, 0, 2), IVec3::new(18, 8, 18));
        let within = |brick: IVec3| brick.cmpge(low).all() && brick.cmplt(high).all();
        // These are also tile numbers.
        let slot = |brick: IVec3| brick.element_sum() as u32 / 11;
        let is_brick = |brick: IVec3| within(brick) && brick.element_sum() % 11 == 0;
        let mut index = BrickIndex::new(DIMS);
        index.fill(low, high, INSIDE);
        all().filter(|&brick| is_brick(brick)).for_each(|brick| index.set(brick, slot(brick)));
        let expected = |brick: IVec3| match (is_brick(brick), within(brick)) {
            (true, _) => slot(brick),
            (_, true) => INSIDE,
            _ => OUTSIDE,
        };
        let check = |index: &BrickIndex| {
            all().for_each(|brick| assert_eq!(index.get(brick), expected(brick), "{brick}"));
            let dense: Vec<u32> = cells(IVec3::ZERO, DIMS).map(expected).collect();
            assert!(index.dense() == dense && BrickIndex::from_dense(DIMS, &dense) == *index);
            let inside = (0..index.tile_count()).flat_map(|tile| index.inside_of(tile)).count();
            assert_eq!(inside, all().filter(|&brick| expected(brick) == INSIDE).count());
            let rows = (-1..=DIMS.x).flat_map(|x| (-1..=DIMS.y).map(move |y| (x, y)));
            let occupied: Vec<IVec3> =
                rows.flat_map(|(x, y)| index.occupied(x, y).map(move |z| IVec3::new(x, y, z))).collect();
            assert!(occupied.into_iter().eq(all().filter(|&brick| expected(brick) != OUTSIDE)));
        };
        check(&index);
        index.tidy();
        check(&index);
    }

    #[test]
    fn tiles_on_one_side_take_no_memory() {
        let mut index = BrickIndex::new(DIMS);
        let root = index.bytes();
        index.fill(IVec3::ZERO, DIMS, INSIDE);
        index.fill(IVec3::ZERO, DIMS - 1, OUTSIDE);
        let mut filled = BrickIndex::new(DIMS);
        assert!(index != filled, "the highest bricks are inside");
        cells(IVec3::ZERO, DIMS).for_each(|brick| filled.set(brick, 7));
        cells(IVec3::ZERO, DIMS).for_each(|brick| filled.set(brick, OUTSIDE));
        assert_eq!(filled.bytes(), root + 9 * 4 * TILE_ENTRIES);
        filled.tidy();
        assert_eq!((filled.bytes(), filled == BrickIndex::new(DIMS)), (root, true));
    }
}
