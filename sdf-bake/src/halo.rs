//! A brick together with the voxels around it, copied into one dense cube.
//!
//! Stencils that extend beyond a brick read this cube instead of looking up each neighbour.

use glam::IVec3;

use crate::grid::{BRICK_SIDE, BRICK_VOXELS, BrickGrid, INSIDE, OUTSIDE, voxel_at};

/// Values φ [m] of a brick and of `margin` voxels on each side; z runs fastest.
pub struct Halo {
    /// Voxels along the side of the cube.
    pub side: usize,
    margin: usize,
    /// Signed distance [m], shape `[side, side, side]`.
    pub phi: Vec<f32>,
}

impl Halo {
    /// Index in `phi` of the voxel at `local` [voxels from the brick's first voxel, from `-margin`].
    pub fn at(&self, local: IVec3) -> usize {
        let l = local + self.margin as i32;
        (l.x as usize * self.side + l.y as usize) * self.side + l.z as usize
    }

    /// True if a voxel of the brick is a corner of a cell that the surface crosses.
    pub(crate) fn at_surface(&self, offset: usize) -> bool {
        let local = voxel_at(IVec3::ZERO, offset);
        let inside = |local: IVec3| self.phi[self.at(local)] < 0.0;
        (0..27).any(|i| inside(local + IVec3::new(i / 9 - 1, i / 3 % 3 - 1, i % 3 - 1)) != inside(local))
    }

    /// Offset in `phi` between neighbours along x, y and z.
    pub fn strides(&self) -> [usize; 3] {
        [self.side * self.side, self.side, 1]
    }
}

/// First copied voxel of a neighbour, its position in the cube, and the number of copied voxels.
fn overlap(step: i32, margin: usize) -> (usize, usize, usize) {
    match step {
        -1 => (BRICK_SIDE - margin, 0, margin),
        0 => (0, margin, BRICK_SIDE),
        _ => (0, margin + BRICK_SIDE, margin),
    }
}

impl BrickGrid {
    /// Copies a brick and `margin` (at most 8) voxels on each side of it.
    pub fn halo(&self, brick: IVec3, margin: usize) -> Halo {
        let side = BRICK_SIDE + 2 * margin;
        let mut halo = Halo { side, margin, phi: vec![0.0; side * side * side] };
        for i in 0..27 {
            self.copy_overlap(brick, IVec3::new(i / 9 - 1, i / 3 % 3 - 1, i % 3 - 1), &mut halo);
        }
        halo
    }

    /// True if another grid has the same values in a brick and `margin` (at most 8) voxels on each side of it.
    pub(crate) fn equals_around(&self, other: &Self, brick: IVec3, margin: usize) -> bool {
        (0..27).all(|i| {
            let step = IVec3::new(i / 9 - 1, i / 3 % 3 - 1, i % 3 - 1);
            let [(fx, _, nx), (fy, _, ny), (fz, _, nz)] = step.to_array().map(|s| overlap(s, margin));
            let [ours, theirs] = [self, other].map(|grid| (grid.slot(brick + step), grid.band, &grid.phi));
            if [ours.0, theirs.0].iter().all(|slot| [OUTSIDE, INSIDE].contains(slot)) {
                return ours.0 == theirs.0 && ours.1 == theirs.1;
            }
            let value = |(slot, band, phi): (u32, f32, &Vec<f32>), offset: usize| match slot {
                OUTSIDE => band,
                INSIDE => -band,
                slot => phi[slot as usize * BRICK_VOXELS + offset],
            };
            let offsets = (fx..fx + nx).flat_map(|x| (fy..fy + ny).map(move |y| x << 6 | y << 3));
            offsets.flat_map(|row| row + fz..row + fz + nz).all(|at| value(ours, at) == value(theirs, at))
        })
    }

    fn copy_overlap(&self, brick: IVec3, step: IVec3, halo: &mut Halo) {
        let slot = self.slot(brick + step);
        let axes = step.to_array().map(|s| overlap(s, halo.margin));
        let [(fx, tx, nx), (fy, ty, ny), (fz, tz, nz)] = axes;
        for x in 0..nx {
            for y in 0..ny {
                let to = ((tx + x) * halo.side + ty + y) * halo.side + tz;
                let row = &mut halo.phi[to..to + nz];
                match slot {
                    OUTSIDE => row.fill(self.band),
                    INSIDE => row.fill(-self.band),
                    slot => {
                        let from = slot as usize * BRICK_VOXELS + ((fx + x) << 6 | (fy + y) << 3 | fz);
                        row.copy_from_slice(&self.phi[from..from + nz]);
                    }
                }
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::DVec3;

    #[test]
    fn a_halo_holds_what_the_grid_says_voxel_by_voxel() {
        let ball = |p: DVec3| p.length() - 0.01;
        let grid = BrickGrid::from_distance(DVec3::splat(-0.01), DVec3::splat(0.01), 0.0005, 3.0, ball);
        for &brick in &grid.bricks {
            let halo = grid.halo(brick, 2);
            for i in 0..12 * 12 * 12 {
                let local = IVec3::new(i / 144, i / 12 % 12, i % 12) - 2;
                assert_eq!(halo.phi[halo.at(local)], grid.phi_at(brick * 8 + local), "brick {brick}, {local}");
            }
        }
    }
}
