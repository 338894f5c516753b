//! A grid ready to be looked at from any side.

use glam::{DVec3, IVec3, Vec3};
use sdf_bake::BrickGrid;
use sdf_bake::grid::{BRICK_SIDE, BRICK_VOXELS, INSIDE, OUTSIDE, cell_corner, trilinear, voxel_offset};

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
    /// Lowest voxel of the index [voxels].
    pub(crate) lowest: DVec3,
}

impl<'a> Field<'a> {
    /// Looks through the whole pool once.
    pub fn new(grid: &'a BrickGrid) -> Self {
        let (metal, air) = occupancy(grid);
        let occupied = grid.bricks.iter().zip(&metal).filter(|(_, blocks)| blocks.0 != 0).map(|(&brick, _)| brick);
        let inside = (0..grid.index.len()).filter(|&entry| grid.index[entry] == INSIDE).map(|entry| {
            let (y, z) = (grid.dims.y as usize, grid.dims.z as usize);
            grid.origin + IVec3::new((entry / (y * z)) as i32, (entry / z % y) as i32, (entry % z) as i32)
        });
        let none = (IVec3::MAX, IVec3::MIN);
        let (low, high) = occupied.chain(inside).fold(none, |(low, high), brick| (low.min(brick), high.max(brick)));
        let voxels = |brick: IVec3| ((brick - grid.origin) * BRICK_SIDE as i32).as_vec3();
        let metal_box =
            if low.cmple(high).all() { (voxels(low), voxels(high + IVec3::ONE)) } else { (Vec3::ZERO, Vec3::ZERO) };
        let lowest = (grid.origin * BRICK_SIDE as i32).as_dvec3();
        Self { grid, metal, air, metal_box, lowest }
    }

    /// A point [m] in voxels from the lowest voxel of the index.
    pub(crate) fn in_voxels(&self, point: DVec3) -> Vec3 {
        (point / self.grid.voxel - self.lowest).as_vec3()
    }

    /// Slot of a brick counted from the first of the index, [`OUTSIDE`] or [`INSIDE`].
    #[inline]
    pub(crate) fn slot(&self, brick: IVec3) -> u32 {
        let (at, dims) = (brick.as_uvec3(), self.grid.dims.as_uvec3());
        if at.x >= dims.x || at.y >= dims.y || at.z >= dims.z {
            return OUTSIDE;
        }
        self.grid.index[((at.x * dims.y + at.y) * dims.z + at.z) as usize]
    }

    /// φ [m] at the eight corners of a cell, z fastest; its lowest corner is counted from the lowest voxel of the index.
    #[inline]
    pub(crate) fn cell_phi(&self, corner: IVec3) -> [f32; 8] {
        let local = corner & 7;
        if local.x == 7 || local.y == 7 || local.z == 7 {
            return std::array::from_fn(|i| self.phi_at(corner + cell_corner(i)));
        }
        match self.slot(corner >> 3) {
            OUTSIDE => [self.grid.band; 8],
            INSIDE => [-self.grid.band; 8],
            slot => {
                let from = slot as usize * BRICK_VOXELS + voxel_offset(corner);
                let phi = &self.grid.phi[from..from + 74];
                [phi[0], phi[1], phi[8], phi[9], phi[64], phi[65], phi[72], phi[73]]
            }
        }
    }

    fn phi_at(&self, voxel: IVec3) -> f32 {
        match self.slot(voxel >> 3) {
            OUTSIDE => self.grid.band,
            INSIDE => -self.grid.band,
            slot => self.grid.phi[slot as usize * BRICK_VOXELS + voxel_offset(voxel)],
        }
    }

    /// Positions in the pool of the eight corners of a cell, z fastest; `None` where no brick is.
    pub(crate) fn cell_places(&self, corner: IVec3) -> [Option<usize>; 8] {
        let place = |voxel: IVec3| match self.slot(voxel >> 3) {
            OUTSIDE | INSIDE => None,
            slot => Some(slot as usize * BRICK_VOXELS + voxel_offset(voxel)),
        };
        std::array::from_fn(|i| place(corner + cell_corner(i)))
    }

    /// φ [m] at a point in voxels from the lowest voxel of the index, trilinear.
    #[inline]
    pub(crate) fn phi(&self, at: Vec3) -> f32 {
        let corner = at.floor();
        trilinear(&self.cell_phi(corner.as_ivec3()), at - corner)
    }

    /// Outward unit normal at a point in voxels from differences two voxels wide, or `None` where φ is flat. They equal
    /// the voxels' central differences interpolated trilinearly, so unlike narrower ones they do not jump or kink from
    /// cell to cell.
    pub(crate) fn normal(&self, at: Vec3) -> Option<Vec3> {
        let along = |axis: Vec3| self.phi(at + axis) - self.phi(at - axis);
        Vec3::new(along(Vec3::X), along(Vec3::Y), along(Vec3::Z)).try_normalize()
    }
}
