//! A grid ready to be looked at from any side.

use glam::{DVec3, Vec3};
use sdf_bake::BrickGrid;
use sdf_bake::grid::{BRICK_SIDE, INSIDE};

use super::occupancy::{Blocks, occupancy};

/// A grid and where in it rays can meet the surface. Made once for a state of the part, used for any number of rays.
#[derive(Clone, Debug)]
pub struct Field<'a> {
    /// The part.
    pub grid: &'a BrickGrid,
    /// Blocks of each brick with a voxel in the metal.
    pub(crate) metal: Vec<Blocks>,
    /// Blocks of each brick with a voxel outside.
    pub(crate) air: Vec<Blocks>,
    /// Box of the bricks that hold metal, from the lowest voxel of the index [voxels].
    pub(crate) metal_box: (Vec3, Vec3),
}

impl<'a> Field<'a> {
    /// Looks through the whole pool once.
    pub fn new(grid: &'a BrickGrid) -> Self {
        let (metal, air) = occupancy(grid);
        let occupied = grid.bricks.iter().zip(&metal).filter(|(_, blocks)| blocks.0 != 0).map(|(&brick, _)| brick);
        let inside = (0..grid.index.len()).filter(|&entry| grid.index[entry] == INSIDE).map(|entry| {
            let (y, z) = (grid.dims.y as usize, grid.dims.z as usize);
            grid.origin + glam::IVec3::new((entry / (y * z)) as i32, (entry / z % y) as i32, (entry % z) as i32)
        });
        let none = (glam::IVec3::MAX, glam::IVec3::MIN);
        let (low, high) = occupied.chain(inside).fold(none, |(low, high), brick| (low.min(brick), high.max(brick)));
        let voxels = |brick: glam::IVec3| ((brick - grid.origin) * BRICK_SIDE as i32).as_vec3();
        let metal_box = if low.cmple(high).all() {
            (voxels(low), voxels(high + glam::IVec3::ONE))
        } else {
            (Vec3::ZERO, Vec3::ZERO)
        };
        Self { grid, metal, air, metal_box }
    }

    /// Outward unit normal at a point [m] from differences two voxels wide, or `None` where φ is flat. They equal the
    /// voxels' central differences interpolated trilinearly, so unlike narrower ones they do not jump or kink from cell to
    /// cell.
    pub fn normal(&self, point: DVec3) -> Option<Vec3> {
        let grid = self.grid;
        let along = |axis: DVec3| grid.sample(point + axis * grid.voxel) - grid.sample(point - axis * grid.voxel);
        Vec3::new(along(DVec3::X), along(DVec3::Y), along(DVec3::Z)).try_normalize()
    }
}
