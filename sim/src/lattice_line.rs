//! The signed distance along one lattice line, and where that leaves the material.

use glam::IVec3;
use sdf_bake::BrickGrid;
use sdf_bake::grid::{BRICK_VOXELS, INSIDE, OUTSIDE, voxel_offset};

use crate::crossing::way_to_zero;
use crate::sheet::Facing;

/// Voxels by which a column is followed upwards out of the material.
const CLIMB: i32 = 400;

/// φ along one lattice line.
pub(crate) struct LatticeLine<'a> {
    grid: &'a BrickGrid,
    facing: Facing,
    place: (i32, i32),
    /// Brick whose slot is known, and the slot.
    brick: i32,
    slot: u32,
}

impl<'a> LatticeLine<'a> {
    pub(crate) fn new(grid: &'a BrickGrid, facing: Facing, i: i32, j: i32) -> Self {
        Self { grid, facing, place: (i, j), brick: i32::MIN, slot: OUTSIDE }
    }

    /// φ [m] at `k` voxels up.
    pub(crate) fn phi(&mut self, k: i32) -> f32 {
        let voxel = self.facing.voxel(self.place.0, self.place.1, k);
        match self.slot_of(voxel) {
            OUTSIDE => self.grid.band,
            INSIDE => -self.grid.band,
            slot => self.grid.phi[slot as usize * BRICK_VOXELS + voxel_offset(voxel)],
        }
    }

    fn slot_of(&mut self, voxel: IVec3) -> u32 {
        let brick = self.facing.along(voxel) >> 3;
        if brick != self.brick {
            (self.brick, self.slot) = (brick, self.grid.slot(voxel >> 3));
        }
        self.slot
    }

    /// Height [voxels] at which the line leaves the material, met first from voxel `from`: upwards out of it, or
    /// downwards to voxel `least`.
    pub(crate) fn surface(&mut self, from: i32, least: i32) -> Option<f64> {
        let voxel = self.grid.voxel as f32;
        let stride = |phi: f32| ((phi.abs() / voxel) as i32).max(1);
        let (mut k, top) = (from, from.saturating_add(CLIMB));
        let mut phi = self.phi(k);
        while phi < 0.0 {
            k += stride(phi);
            if k > top {
                return None;
            }
            phi = self.phi(k);
        }
        // φ is a distance, so no crossing lies within φ of k.
        loop {
            if k < least {
                return None;
            }
            let below = k - stride(phi);
            let next = self.phi(below);
            if next < 0.0 {
                return Some(self.crossing(below, k));
            }
            (k, phi) = (below, next);
        }
    }

    /// Root of φ between a voxel in the material and one above it [voxels].
    fn crossing(&mut self, mut below: i32, above: i32) -> f64 {
        while below + 1 < above && self.phi(below + 1) < 0.0 {
            below += 1;
        }
        let values = [-1, 0, 1, 2].map(|step| f64::from(self.phi(below + step)));
        f64::from(below) + way_to_zero(values, self.grid.band.into())
    }
}
