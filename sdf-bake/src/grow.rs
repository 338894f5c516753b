//! Adds bricks ahead of a surface that moves into the part, and releases those behind it.

use glam::IVec3;

use crate::grid::{BRICK_VOXELS, BrickGrid, INSIDE, OUTSIDE};

impl BrickGrid {
    /// Releases bricks that are entirely beyond the band; returns their number. Slots change; the order of bricks
    /// stays. Inside bricks with a weld label are kept, because the label is needed if the surface reaches them.
    pub fn release_uniform_bricks(&mut self) -> usize {
        let before = self.brick_count();
        let mut kept = 0;
        for slot in 0..before {
            let values = slot * BRICK_VOXELS..(slot + 1) * BRICK_VOXELS;
            let brick = self.bricks[slot];
            let beyond = |sign: f32| self.phi[values.clone()].iter().all(|&phi| phi * sign >= self.band);
            let labelled = self.label.get(values.clone()).is_some_and(|labels| labels.iter().any(|&id| id != 0));
            let state = if beyond(1.0) {
                OUTSIDE
            } else if !labelled && beyond(-1.0) {
                INSIDE
            } else {
                self.move_brick(slot, kept);
                kept += 1;
                kept as u32 - 1
            };
            if state != slot as u32 {
                self.set_slot(brick, state);
            }
        }
        self.truncate_pool(kept);
        before - kept
    }

    /// Slot of the brick at `brick` [bricks]. An inside brick without a slot gets one, filled with -band; `None`
    /// outside.
    pub fn open_inside_brick(&mut self, brick: IVec3) -> Option<u32> {
        match self.slot(brick) {
            OUTSIDE => None,
            INSIDE => Some(self.add_inside_brick(brick)),
            slot => Some(slot),
        }
    }

    fn add_inside_brick(&mut self, brick: IVec3) -> u32 {
        let slot = self.bricks.len() as u32;
        self.set_slot(brick, slot);
        self.bricks.push(brick);
        self.phi.resize(self.phi.len() + BRICK_VOXELS, -self.band);
        self.extend_channels();
        slot
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::DVec3;

    fn slab(height: f64) -> BrickGrid {
        let half = DVec3::new(0.01, 0.01, 0.02);
        BrickGrid::from_distance(-half, half, 0.0005, 3.0, move |p| p.z - height)
    }

    #[test]
    fn a_surface_that_sank_gets_bricks_below_it_filled_with_distances() {
        let mut grid = slab(0.001);
        let before = grid.brick_count();
        let sunk = 0.0006;
        for phi in &mut grid.phi {
            *phi = if phi.abs() < grid.band { (*phi + sunk as f32).min(grid.band) } else { *phi };
        }
        for brick in grid.bricks.clone().into_iter().filter(|brick| brick.z == 0) {
            assert_eq!(grid.open_inside_brick(brick - IVec3::Z), Some(grid.brick_count() as u32 - 1));
        }
        assert_eq!(grid.brick_count(), before + (grid.dims.x * grid.dims.y) as usize, "one layer below z = 0");
        grid.redistance(&(0..grid.brick_count() as u32).collect::<Vec<_>>());
        assert_eq!(grid.sanity_check(), Ok(()));
        let expected = slab(0.001 - sunk);
        for z in -8..10 {
            let (found, exact) = (grid.phi_at(IVec3::new(1, 1, z)), expected.phi_at(IVec3::new(1, 1, z)));
            assert!((found - exact).abs() < 1e-7, "voxel {z}: {found}, not {exact}");
        }
    }

    #[test]
    fn bricks_beyond_the_band_are_freed_and_their_side_is_remembered() {
        let mut grid = slab(0.001);
        let original = grid.clone();
        for brick in original.bricks.iter().filter(|b| b.z == 0) {
            grid.add_inside_brick(*brick - IVec3::Z);
        }
        let added = grid.brick_count() - original.brick_count();
        assert_eq!(grid.release_uniform_bricks(), added);
        assert_eq!(grid, original, "what was added empty is taken back");
    }
}
