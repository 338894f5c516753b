//! The index of a grid with a border of empty bricks, and the distance around each brick that a ray can skip.
//!
//! ```text
//!   3 3 3 3 3      every entry stores the size of the free cube of bricks around it (Chebyshev distance, in two
//! sweeps:
//!   2 2 2 2 2      Rosenfeld & Pfaltz 1966), so a ray crosses it in one step
//!   1 1 1 1 2
//!   0 0 0 1 2      0: the brick must be examined
//! ```

use glam::{IVec3, UVec3};
use sdf_bake::BrickGrid;
use sdf_bake::grid::{INSIDE, OUTSIDE};

use super::occupancy::Blocks;

/// Greatest counted free distance [bricks]; a larger one would shorten few rays.
const MOST_FREE: u8 = 100;

/// Distance before the sweeps; after them it remains only at the border.
const UNKNOWN: u8 = u8::MAX;

/// One brick of the index.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Entry {
    /// Slot in the pool, [`OUTSIDE`] or [`INSIDE`].
    pub(crate) slot: u32,
    /// Distance from this brick to the nearest with metal [bricks], diagonal steps counted as one; 0 if this one has
    /// metal.
    pub(crate) to_metal: u8,
    /// Distance to the nearest brick that is not outside [bricks].
    pub(crate) to_brick: u8,
}

/// Entry used beyond the border.
pub(crate) const BEYOND: Entry = Entry { slot: OUTSIDE, to_metal: 1, to_brick: 1 };

/// Entries of all bricks of a grid and of a border one brick wide. Brick coordinates count from the grid's first brick.
#[derive(Clone, Debug)]
pub(crate) struct Index {
    entries: Vec<Entry>,
    dims: UVec3,
    /// Offset from an entry to the next along each axis.
    pub(crate) steps: [usize; 3],
}

impl Index {
    /// `metal`: blocks of each brick that contain a voxel inside the metal.
    pub(crate) fn new(grid: &BrickGrid, metal: &[Blocks]) -> Self {
        let dims = grid.dims.as_uvec3();
        let (y, z) = (dims.y as usize + 2, dims.z as usize + 2);
        let count = (dims.x as usize + 2) * y * z;
        let mut index = Self { entries: Vec::new(), dims, steps: [y * z, z, 1] };
        let (mut slots, mut to_metal, mut to_brick) =
            (vec![OUTSIDE; count], vec![UNKNOWN; count], vec![UNKNOWN; count]);
        let columns = (0..grid.dims.x).flat_map(|x| (0..grid.dims.y).map(move |y| (x, y)));
        for (row, (x, y)) in index.rows().zip(columns) {
            for (place, slot) in (row..).zip(grid.index.row(x, y)).filter(|(_, slot)| *slot != OUTSIDE) {
                let has_metal = slot == INSIDE || metal[slot as usize].0 != 0;
                (slots[place], to_brick[place]) = (slot, 0);
                to_metal[place] = if has_metal { 0 } else { UNKNOWN };
            }
        }
        [&mut to_metal, &mut to_brick].into_iter().for_each(|distances| index.spread(distances));
        let distances = to_metal.into_iter().zip(to_brick);
        let entry = |(slot, (to_metal, to_brick))| Entry { slot, to_metal, to_brick };
        let swept = |entry: Entry| if entry.to_brick == UNKNOWN { BEYOND } else { entry };
        index.entries = slots.into_iter().zip(distances).map(entry).map(swept).collect();
        index
    }

    /// Number of entries, border included.
    pub(crate) fn len(&self) -> usize {
        self.entries.len()
    }

    /// First entry of each row of the grid along z.
    fn rows(&self) -> impl Iterator<Item = usize> + use<> {
        let ([x, y, z], dims) = (self.steps, self.dims.as_usizevec3());
        (1..=dims.x).flat_map(move |i| (1..=dims.y).map(move |j| i * x + j * y + z))
    }

    /// Spreads the distances from their zeros, in a sweep along the rows and one back.
    fn spread(&self, distances: &mut [u8]) {
        let [x, y, _] = self.steps;
        let passed = [x + y, x, x - y, y];
        let mut least = vec![0; self.dims.z as usize];
        let rows: Vec<usize> = self.rows().collect();
        for &row in &rows {
            nearest_of(distances, &mut least, passed.map(|step| row - step));
            lower(distances[row..].iter_mut().zip(&least));
        }
        for &row in rows.iter().rev() {
            nearest_of(distances, &mut least, passed.map(|step| row + step));
            lower(distances[row..row + least.len()].iter_mut().zip(&least).rev());
        }
    }

    /// Index of a brick's entry, or `None` beyond the border. The next entry along each axis also exists.
    #[inline]
    pub(crate) fn place(&self, brick: IVec3) -> Option<usize> {
        let (at, dims, [x, y, _]) = ((brick + 1).as_uvec3(), self.dims, self.steps);
        let within = at.x <= dims.x && at.y <= dims.y && at.z <= dims.z;
        within.then(|| at.x as usize * x + at.y as usize * y + at.z as usize)
    }

    /// Entry of a brick.
    #[inline]
    pub(crate) fn entry(&self, brick: IVec3) -> Entry {
        self.place(brick).map_or(BEYOND, |place| self.entries[place])
    }

    /// Entry at an index.
    #[inline]
    pub(crate) fn at(&self, place: usize) -> Entry {
        self.entries[place]
    }

    /// Slot at an index.
    #[inline]
    pub(crate) fn slot(&self, place: usize) -> u32 {
        self.entries[place].slot
    }
}

/// Least distance among the entries of other rows beside each entry of a row, up to one step along it.
fn nearest_of(distances: &[u8], least: &mut [u8], rows: [usize; 4]) {
    least.fill(MOST_FREE - 1);
    for first in rows.into_iter().flat_map(|row| [row - 1, row, row + 1]) {
        for (least, near) in least.iter_mut().zip(&distances[first..]) {
            *least = (*least).min(*near);
        }
    }
}

/// Sets each distance of a row to at most one more than the least beside it and the one before it.
fn lower<'d>(row: impl Iterator<Item = (&'d mut u8, &'d u8)>) {
    let mut before = UNKNOWN;
    for (distance, least) in row {
        *distance = (*distance).min((*least).min(before) + 1);
        before = *distance;
    }
}

#[cfg(test)]
mod tests {
    use glam::DVec3;

    use super::*;
    use crate::occupancy::occupancy;

    #[test]
    fn the_free_cube_reaches_to_the_nearest_brick_that_is_not_free() {
        let half = DVec3::new(0.03, 0.02, 0.016);
        let shape = |p: DVec3| ((p - DVec3::new(-0.018, 0.004, 0.0)).length() - 0.007).min(p.x.abs().max(p.y) - 0.001);
        let grid = BrickGrid::from_distance(-half, half, 0.0005, 3.0, shape);
        let metal = occupancy(&grid).0;
        let index = Index::new(&grid, &metal);
        let all = || {
            (0..grid.dims.element_product())
                .map(|i| IVec3::new(i / (grid.dims.y * grid.dims.z), i / grid.dims.z % grid.dims.y, i % grid.dims.z))
        };
        let slot = |brick: IVec3| grid.slot(brick + grid.origin);
        let has_metal = |brick: IVec3| match slot(brick) {
            OUTSIDE => false,
            INSIDE => true,
            slot => metal[slot as usize].0 != 0,
        };
        let nearest = |from: IVec3, counts: &dyn Fn(IVec3) -> bool| {
            all().filter(|brick| counts(*brick)).map(|brick| (brick - from).abs().max_element()).min().unwrap()
        };
        let mut farthest = 0;
        for brick in all() {
            let entry = index.entry(brick);
            assert_eq!(entry.slot, slot(brick));
            assert_eq!(i32::from(entry.to_metal), nearest(brick, &has_metal), "metal from {brick}");
            assert_eq!(i32::from(entry.to_brick), nearest(brick, &|brick| slot(brick) != OUTSIDE), "from {brick}");
            farthest = farthest.max(entry.to_brick);
        }
        assert!(farthest > 1, "{farthest}");
        for beyond in [IVec3::splat(-2), grid.dims] {
            assert_eq!((index.place(beyond), index.entry(beyond).slot), (None, OUTSIDE));
        }
    }
}
