//! Blocks of each brick in which a ray can meet the surface: one bit per block of 2³ cells.
//!
//! ```text
//!   signs of 8³ voxels ─▶ cells with a voxel of the wanted sign ─▶ blocks of 2³ cells ─▶ 64 bits per brick
//! ```
//!
//! A trilinear cell without a corner inside the metal contains no zero of φ. A block whose bit is not set is therefore
//! crossed in one step, and no thin wall is missed. Twin of `occupancy.wgsl`.

use glam::IVec3;
use rayon::prelude::*;
use sdf_bake::BrickGrid;
use sdf_bake::grid::{BRICK_SIDE, BRICK_VOXELS, INSIDE, OUTSIDE};

/// Bits of the blocks in the first cube of 4³ cells.
const QUAD: u64 = 0x0033_0033;

/// Blocks of a brick, bit 16 x + 4 y + z for the block at (x, y, z).
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(crate) struct Blocks(pub(crate) u64);

impl Blocks {
    /// log₂ of the side [cells] of the largest aligned cube around a cell of the brick in which no bit is set; 0 if the
    /// cell's own bit is set.
    pub(crate) fn clear_shift(self, cell: IVec3) -> i32 {
        if self.0 == 0 {
            return 3;
        }
        let block: IVec3 = (cell & 7) >> 1;
        let quad: IVec3 = block >> 1;
        if self.0 & QUAD << (32 * quad.x + 8 * quad.y + 2 * quad.z) == 0 {
            return 2;
        }
        i32::from(self.0 >> (16 * block.x + 4 * block.y + block.z) & 1 == 0)
    }
}

/// Signs of a brick's voxels: bit 8 y + z of plane x is set for a voxel of the wanted sign.
type Planes = [u64; BRICK_SIDE];

/// For every brick of the pool, the blocks with a voxel inside the metal (φ ≤ 0), and those with a voxel outside (φ >
/// 0).
pub(crate) fn occupancy(grid: &BrickGrid) -> (Vec<Blocks>, Vec<Blocks>) {
    let metal: Vec<Planes> = grid.phi.par_chunks(BRICK_VOXELS).map(metal_planes).collect();
    grid.bricks.par_iter().map(|&brick| brick_blocks(grid, &metal, brick)).unzip()
}

fn metal_planes(phi: &[f32]) -> Planes {
    let plane = |values: &[f32]| values.iter().rev().fold(0u64, |bits, &phi| bits << 1 | u64::from(phi <= 0.0));
    std::array::from_fn(|x| plane(&phi[64 * x..64 * (x + 1)]))
}

fn brick_blocks(grid: &BrickGrid, metal: &[Planes], brick: IVec3) -> (Blocks, Blocks) {
    let around: [Planes; 8] =
        std::array::from_fn(|i| match grid.slot(brick + IVec3::new(i as i32 >> 2, i as i32 >> 1 & 1, i as i32 & 1)) {
            OUTSIDE => [0; BRICK_SIDE],
            INSIDE => [u64::MAX; BRICK_SIDE],
            slot => metal[slot as usize],
        });
    (blocks(&around), blocks(&around.map(|planes| planes.map(|bits| !bits))))
}

/// Blocks with a cell that has a voxel of the wanted sign, from the planes of a brick and of its seven higher
/// neighbours.
fn blocks(around: &[Planes; 8]) -> Blocks {
    // Voxels of plane x combined with their higher neighbours along y and z.
    let cells_of_plane = |x: usize| {
        let from = if x < BRICK_SIDE { 0 } else { 4 };
        let plane = |i: usize| around[from + i][x % BRICK_SIDE];
        let along_z =
            |low: u64, high: u64| low | low >> 1 & 0x7f7f_7f7f_7f7f_7f7f | (high & 0x0101_0101_0101_0101) << 7;
        let (low, high) = (along_z(plane(0), plane(1)), along_z(plane(2), plane(3)));
        low | low >> 8 | high << 56
    };
    let planes: [u64; BRICK_SIDE + 1] = std::array::from_fn(cells_of_plane);
    let of_slab = |x: usize| sixteen(planes[2 * x] | planes[2 * x + 1] | planes[2 * x + 2]);
    Blocks((0..4).rev().fold(0, |bits, x| bits << 16 | of_slab(x)))
}

/// Reduces 8 × 8 cells to 4 × 4 blocks: bit 4 y + z.
fn sixteen(cells: u64) -> u64 {
    let pairs = cells | cells >> 8;
    let pairs = (pairs | pairs >> 1) & 0x0055_0055_0055_0055;
    let nibbles = (pairs | pairs >> 1) & 0x0033_0033_0033_0033;
    let nibbles = (nibbles | nibbles >> 2) & 0x000f_000f_000f_000f;
    let bytes = (nibbles | nibbles >> 12) & 0x0000_00ff_0000_00ff;
    (bytes | bytes >> 24) & 0xffff
}

#[cfg(test)]
mod tests {
    use glam::DVec3;
    use sdf_bake::grid::cell_corner;

    use super::*;

    #[test]
    fn a_bit_is_set_where_a_cell_of_the_block_has_such_a_corner() {
        let half = DVec3::new(0.011, 0.008, 0.0013);
        let distance = |p: DVec3| ((p.length() - 0.009).abs() - 0.0004).max(-p.z - 0.0021);
        let grid = BrickGrid::from_distance(-half, half, 0.0005, 3.0, distance);
        let (metal, air) = occupancy(&grid);
        let mut checked = [0; 2];
        for (slot, &brick) in grid.bricks.iter().enumerate() {
            for block in 0..64 {
                let at = IVec3::new(block >> 4, block >> 2 & 3, block & 3);
                let low = brick * 8 + at * 2;
                let corners = (0..27).map(|i| low + IVec3::new(i / 9, i / 3 % 3, i % 3));
                let in_metal: Vec<bool> = corners.map(|voxel| grid.phi_at(voxel) <= 0.0).collect();
                let expected = [in_metal.contains(&true), in_metal.contains(&false)];
                for (side, blocks) in [metal[slot], air[slot]].into_iter().enumerate() {
                    assert_eq!(blocks.0 >> block & 1 == 1, expected[side], "side {side}, brick {brick}, block {at}");
                    checked[side] += usize::from(expected[side]);
                }
            }
        }
        assert!(checked[0] > 100 && checked[0] < 32 * grid.bricks.len() && checked[1] > 1000, "{checked:?}");
    }

    #[test]
    fn the_clear_cube_is_the_largest_that_holds_no_bit() {
        for bit in [0, 5, 21, 38, 63] {
            let blocks = Blocks(1 << bit);
            let set = IVec3::new(bit >> 4, bit >> 2 & 3, bit & 3);
            for cell in (0..8).flat_map(|x| (0..64).map(move |i| IVec3::new(x, i >> 3, i & 7))) {
                let expected = if cell >> 1 == set {
                    0
                } else if cell >> 2 == set >> 1 {
                    1
                } else {
                    2
                };
                assert_eq!(blocks.clear_shift(cell - 8 * cell_corner(7)), expected, "cell {cell}, bit {bit}");
            }
        }
        assert_eq!(Blocks(0).clear_shift(IVec3::ZERO), 3);
    }
}
