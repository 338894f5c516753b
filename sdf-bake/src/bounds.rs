//! Bounding box of the zero set.

use glam::{DVec3, IVec3};
use rayon::prelude::*;

use crate::grid::{BRICK_VOXELS, BrickGrid, INSIDE, OUTSIDE, voxel_at};
use crate::redistance::VoxelSet;

const STEPS: [IVec3; 6] = [IVec3::X, IVec3::NEG_X, IVec3::Y, IVec3::NEG_Y, IVec3::Z, IVec3::NEG_Z];
/// Voxels of a plane x with the lowest y, and with the lowest z.
const LOWEST_Y: u64 = 0xff;
const LOWEST_Z: u64 = 0x0101_0101_0101_0101;

impl BrickGrid {
    /// Lowest and highest corner [m] of the box around {φ = 0}, from its crossings with the lattice's edges; `None`
    /// without a surface.
    pub fn surface_bounds(&self) -> Option<(DVec3, DVec3)> {
        let join = |a: Option<(DVec3, DVec3)>, b: Option<(DVec3, DVec3)>| match (a, b) {
            (Some(a), Some(b)) => Some((a.0.min(b.0), a.1.max(b.1))),
            (a, b) => a.or(b),
        };
        let inside: Vec<VoxelSet> = self.phi.par_chunks(BRICK_VOXELS).map(voxels_inside).collect();
        (0..self.bricks.len()).into_par_iter().map(|slot| self.brick_crossings(&inside, slot)).reduce(|| None, join)
    }

    /// Lowest and highest voxel [m] among those closer to the surface than half a voxel's diagonal; `None` if there are
    /// none. To within that half diagonal it is the box of the whole surface, including tips and fins thinner than a
    /// voxel.
    pub fn near_surface_bounds(&self) -> Option<(DVec3, DVec3)> {
        let reach = (0.5 * 3f64.sqrt() * self.voxel) as f32;
        let near = self.phi.iter().enumerate().filter(|(_, phi)| phi.abs() <= reach);
        let voxels = near.map(|(at, _)| voxel_at(self.bricks[at / BRICK_VOXELS], at % BRICK_VOXELS));
        let (low, high) = voxels.fold(None, |bounds: Option<(IVec3, IVec3)>, v| {
            let (low, high) = bounds.unwrap_or((v, v));
            Some((low.min(v), high.max(v)))
        })?;
        Some((self.position(low), self.position(high)))
    }

    /// Box of the crossings of the edges that start inside the metal in a brick. `inside`: voxels with φ < 0 by slot.
    fn brick_crossings(&self, inside: &[VoxelSet], slot: usize) -> Option<(DVec3, DVec3)> {
        let brick = self.bricks[slot];
        let mut bounds: Option<(DVec3, DVec3)> = None;
        for step in STEPS {
            let beside = match self.slot(brick + step) {
                OUTSIDE => [0; 8],
                INSIDE => [u64::MAX; 8],
                other => inside[other as usize],
            };
            let beyond = shifted(&inside[slot], &beside, step);
            for x in 0..8 {
                let mut crossed = inside[slot][x] & !beyond[x];
                while crossed != 0 {
                    let offset = 64 * x + crossed.trailing_zeros() as usize;
                    let crossing = self.crossing(slot, offset, step);
                    let (low, high) = bounds.unwrap_or((crossing, crossing));
                    bounds = Some((low.min(crossing), high.max(crossing)));
                    crossed &= crossed - 1;
                }
            }
        }
        bounds
    }

    /// Crossing of the edge from a voxel inside to the next one along `step` [m].
    fn crossing(&self, slot: usize, offset: usize, step: IVec3) -> DVec3 {
        let voxel = voxel_at(self.bricks[slot], offset);
        let (phi, beyond) = (self.phi[slot * BRICK_VOXELS + offset], self.phi_at(voxel + step));
        let along = f64::from(phi / (phi - beyond));
        self.position(voxel) + step.as_dvec3() * (along * self.voxel)
    }
}

fn voxels_inside(phi: &[f32]) -> VoxelSet {
    let plane = |values: &[f32]| values.iter().rev().fold(0u64, |bits, &phi| bits << 1 | u64::from(phi < 0.0));
    std::array::from_fn(|x| plane(&phi[64 * x..64 * (x + 1)]))
}

/// Set of the voxels whose neighbour along `step` is in `own`, or in `beside` beyond the brick's border.
fn shifted(own: &VoxelSet, beside: &VoxelSet, step: IVec3) -> VoxelSet {
    std::array::from_fn(|x| match step.to_array() {
        [1, ..] => {
            if x < 7 {
                own[x + 1]
            } else {
                beside[0]
            }
        }
        [-1, ..] => {
            if x > 0 {
                own[x - 1]
            } else {
                beside[7]
            }
        }
        [_, 1, _] => own[x] >> 8 | (beside[x] & LOWEST_Y) << 56,
        [_, -1, _] => own[x] << 8 | beside[x] >> 56,
        [_, _, 1] => own[x] >> 1 & !(LOWEST_Z << 7) | (beside[x] & LOWEST_Z) << 7,
        _ => own[x] << 1 & !LOWEST_Z | beside[x] >> 7 & LOWEST_Z,
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_ball_is_boxed_within_a_hundredth_of_a_voxel() {
        let centre = DVec3::new(0.0011, -0.0407, 0.02);
        let (low, high) = (centre - 0.013, centre + 0.013);
        let grid = BrickGrid::from_distance(low, high, 0.0004, 3.0, |p| p.distance(centre) - 0.013);
        let (found_low, found_high) = grid.surface_bounds().unwrap();
        assert!((found_low - low).abs().max_element() < 0.03 * grid.voxel, "{found_low} against {low}");
        assert!((found_high - high).abs().max_element() < 0.03 * grid.voxel, "{found_high} against {high}");
    }

    #[test]
    fn the_box_is_that_of_all_crossed_edges_also_between_bricks() {
        // Lobes whose tips lie in different bricks, off the lattice.
        for i in 0..40 {
            let axis = DVec3::new(f64::from(i).sin(), f64::from(3 * i).cos(), f64::from(7 * i).sin());
            let centre = 3e-3 * axis;
            let low = DVec3::splat(-0.009);
            let shape = |p: DVec3| (p.distance(centre) - 0.003).min(p.distance(-centre) - 0.0013 - 1e-4 * f64::from(i));
            let grid = BrickGrid::from_distance(low, -low, 0.0003, 3.0, shape);
            let mut expected = (DVec3::INFINITY, DVec3::NEG_INFINITY);
            for place in (0..grid.phi.len()).filter(|&place| grid.phi[place] < 0.0) {
                for step in STEPS {
                    if grid.phi_at(grid.voxel_of(place) + step) >= 0.0 {
                        let at = grid.crossing(place / BRICK_VOXELS, place % BRICK_VOXELS, step);
                        expected = (expected.0.min(at), expected.1.max(at));
                    }
                }
            }
            assert_eq!(grid.surface_bounds(), Some(expected));
        }
    }

    #[test]
    fn a_fin_thinner_than_a_voxel_is_near_the_surface_though_not_crossed_by_the_lattice() {
        let (low, high) = (DVec3::new(-0.01, -0.01, 0.00011), DVec3::new(0.01, 0.01, 0.00019));
        let grid = BrickGrid::from_distance(low, high, 0.0004, 3.0, |p| {
            let q = (p - 0.5 * (low + high)).abs() - 0.5 * (high - low);
            q.max(DVec3::ZERO).length() + q.max_element().min(0.0)
        });
        assert_eq!(grid.surface_bounds(), None);
        let (found_low, found_high) = grid.near_surface_bounds().unwrap();
        assert!((found_low - low).abs().max((found_high - high).abs()).max_element() < 0.87 * grid.voxel);
    }

    #[test]
    fn nothing_has_no_bounds() {
        assert_eq!(BrickGrid::empty(0.1, 0.3, IVec3::ZERO, IVec3::ONE).surface_bounds(), None);
    }
}
