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
        let far = Entry { slot: OUTSIDE, to_metal: UNKNOWN, to_brick: UNKNOWN };
        let mut index = Self { entries: vec![far; (dims.x as usize + 2) * y * z], dims, steps: [y * z, z, 1] };
        let rows: Vec<usize> = index.rows().collect();
        let columns = (0..grid.dims.x).flat_map(|x| (0..grid.dims.y).map(move |y| (x, y)));
        for (&row, (x, y)) in rows.iter().zip(columns) {
            for (entry, slot) in index.entries[row..].iter_mut().zip(grid.index.row(x, y)) {
                let free = |is_free: bool| if is_free { UNKNOWN } else { 0 };
                let has_metal = slot != OUTSIDE && (slot == INSIDE || metal[slot as usize].0 != 0);
                *entry = Entry { slot, to_metal: free(!has_metal), to_brick: free(slot == OUTSIDE) };
            }
        }
        index.sweep(rows.iter().flat_map(|&row| row..row + dims.z as usize), |place, step| place - step);
        index.sweep(rows.iter().rev().flat_map(|&row| (row..row + dims.z as usize).rev()), |place, step| place + step);
        index.entries.iter_mut().filter(|entry| entry.to_brick == UNKNOWN).for_each(|entry| *entry = BEYOND);
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

    /// Sets each distance to at most one more than the least of the 13 neighbours that the sweep has passed.
    fn sweep(&mut self, places: impl Iterator<Item = usize>, back: impl Fn(usize, usize) -> usize) {
        let [x, y, z] = self.steps;
        let plane = [x - y - z, x - y, x - y + z, x - z, x, x + z, x + y - z, x + y, x + y + z];
        for place in places {
            let near = plane.into_iter().chain([y - z, y, y + z, z]).map(|step| self.entries[back(place, step)]);
            let Entry { to_metal, to_brick, .. } = self.entries[place];
            let (metal, brick) =
                near.fold((MOST_FREE - 1, MOST_FREE - 1), |(m, b), near| (m.min(near.to_metal), b.min(near.to_brick)));
            let entry = &mut self.entries[place];
            (entry.to_metal, entry.to_brick) = (to_metal.min(metal + 1), to_brick.min(brick + 1));
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
