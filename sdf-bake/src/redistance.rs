//! Makes φ a distance again after the surface moved, without moving the surface.
//!
//! Voxels nearer to the surface than [`KEPT_VOXELS`] are unchanged, so the zero set of the trilinear field does not
//! move, however often this runs. All others, which no cell with a sign change touches, are recomputed outwards from
//! them: |∇φ| = 1 with second-order upwind differences (Sethian 1999, "Level Set Methods and Fast Marching Methods",
//! ch. 8.7), solved by Jacobi passes over bricks. The result does not depend on the order of bricks or the number of
//! threads.

use glam::IVec3;
use rayon::prelude::*;

use crate::grid::{BRICK_VOXELS, BrickGrid, voxel_at};
use crate::halo::Halo;

/// Distance from the surface up to which redistancing changes nothing [voxels]. Corners of cells that the surface
/// crosses are within the cell's diagonal, √3.
pub const KEPT_VOXELS: f64 = 1.75;

/// A set of voxels of a brick: word x, bit 8 y + z.
pub(crate) type VoxelSet = [u64; 8];

/// True if a set contains the voxel at `offset` in its brick.
pub(crate) fn contains(set: &VoxelSet, offset: usize) -> bool {
    set[offset >> 6] >> (offset & 63) & 1 != 0
}

/// Adds the voxel at `offset`.
pub(crate) fn insert(set: &mut VoxelSet, offset: usize) {
    set[offset >> 6] |= 1 << (offset & 63);
}

impl BrickGrid {
    /// Recomputes φ beyond [`KEPT_VOXELS`] in the bricks in `slots`; other bricks are read, but not written.
    pub fn redistance(&mut self, slots: &[u32]) {
        let kept = (KEPT_VOXELS * self.voxel) as f32;
        self.relax(slots, kept, |_, _, phi| phi.abs() > kept);
    }

    /// Recomputes φ of the given voxels of the bricks in `slots` from the voxels around them.
    pub(crate) fn redistance_voxels(&mut self, slots: &[u32], voxels: &[VoxelSet]) {
        self.relax(slots, 0.0, |nth, offset, _| contains(&voxels[nth], offset));
    }

    /// Solves |∇φ| = 1 at the voxels for which `free` returns true, given the brick's index in `slots`, the voxel's
    /// offset and φ. No solution is below `least` [m].
    fn relax(&mut self, slots: &[u32], least: f32, free: impl Fn(usize, usize, f32) -> bool + Sync) {
        let settled = 1e-4 * self.voxel as f32;
        // A pass propagates distances by at least one voxel, and a diagonal takes two passes.
        let passes = (2.0 * f64::from(self.band) / self.voxel).ceil() as usize + 2;
        for _ in 0..passes {
            let solve =
                |(nth, &slot): (usize, &u32)| self.solve_brick(slot, least, |offset, phi: f32| free(nth, offset, phi));
            let solved: Vec<(Vec<f32>, f32)> = slots.par_iter().enumerate().map(solve).collect();
            let mut largest = 0f32;
            for (&slot, (values, change)) in slots.iter().zip(&solved) {
                let at = slot as usize * BRICK_VOXELS;
                self.phi[at..at + BRICK_VOXELS].copy_from_slice(values);
                largest = largest.max(*change);
            }
            if largest <= settled {
                return;
            }
        }
    }

    /// Computes new values of a brick; returns them and the greatest change [m].
    fn solve_brick(&self, slot: u32, least: f32, free: impl Fn(usize, f32) -> bool) -> (Vec<f32>, f32) {
        let mut halo = self.halo(self.bricks[slot as usize], 2);
        let mut values = Vec::with_capacity(BRICK_VOXELS);
        let mut change = 0f32;
        for offset in 0..BRICK_VOXELS {
            let at = halo.at(voxel_at(IVec3::ZERO, offset));
            let old = halo.phi[at];
            if free(offset, old) {
                let new = eikonal(&halo, at, self.voxel as f32).clamp(least, self.band).copysign(old);
                change = change.max((new - old).abs());
                halo.phi[at] = new;
            }
            values.push(halo.phi[at]);
        }
        (values, change)
    }
}

/// Distance [m] at a voxel for which |∇φ| = 1, given the values around it.
fn eikonal(halo: &Halo, at: usize, voxel: f32) -> f32 {
    let side = halo.phi[at].signum();
    let mut axes = halo.strides().map(|stride| upwind(halo, at, stride, side));
    axes.sort_by(|a, b| a.0.total_cmp(&b.0));
    // Σ w² (d - t)² = h² over the axes whose upwind value t lies below d.
    let (mut a, mut b, mut c) = (0f32, 0f32, -voxel * voxel);
    let mut distance = f32::INFINITY;
    for (t, w) in axes {
        if distance <= t {
            break;
        }
        a += w * w;
        b += w * w * t;
        c += w * w * t * t;
        let root = b * b - a * c;
        if root < 0.0 {
            break;
        }
        distance = (b + root.sqrt()) / a;
    }
    distance
}

/// Upwind value t [m] and weight w of one axis, such that |∂φ| ≈ w (d - t)/h: second order if φ decreases monotonically
/// over the two voxels towards the surface, otherwise first order.
fn upwind(halo: &Halo, at: usize, stride: usize, side: f32) -> (f32, f32) {
    let (below, above) = (side * halo.phi[at - stride], side * halo.phi[at + stride]);
    let (first, second) = if below < above {
        (below, side * halo.phi[at - 2 * stride])
    } else {
        (above, side * halo.phi[at + 2 * stride])
    };
    if second < first { ((4.0 * first - second) / 3.0, 1.5) } else { (first, 1.0) }
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::DVec3;

    fn torus(p: DVec3) -> f64 {
        DVec3::new(p.x.hypot(p.y) - 0.01, p.z, 0.0).length() - 0.004
    }

    fn torus_grid() -> BrickGrid {
        let half = DVec3::new(0.014, 0.014, 0.004);
        BrickGrid::from_distance(-half, half, 0.0005, 4.0, torus)
    }

    fn all_slots(grid: &BrickGrid) -> Vec<u32> {
        (0..grid.brick_count() as u32).collect()
    }

    #[test]
    fn a_band_that_was_wiped_out_is_rebuilt_to_a_few_hundredths_of_a_voxel() {
        let (mut grid, exact) = (torus_grid(), torus_grid());
        for phi in &mut grid.phi {
            if phi.abs() > KEPT_VOXELS as f32 * 0.0005 {
                *phi = grid.band.copysign(*phi);
            }
        }
        grid.redistance(&all_slots(&grid));
        let worst = grid.phi.iter().zip(&exact.phi).map(|(a, b)| (a - b).abs()).fold(0f32, f32::max);
        println!("largest error of a rebuilt band: {:.4} voxels", worst / 0.0005);
        assert!(worst < 0.03 * 0.0005, "{worst}");
    }

    #[test]
    fn a_thousand_redistancings_do_not_move_the_surface() {
        let mut grid = torus_grid();
        let (slots, before) = (all_slots(&grid), grid.clone());
        for _ in 0..1000 {
            grid.redistance(&slots);
        }
        let kept = KEPT_VOXELS as f32 * 0.0005;
        for (new, old) in grid.phi.iter().zip(&before.phi) {
            assert!(old.abs() > kept || new == old, "{old} became {new}");
        }
        let change = grid.volume() / before.volume() - 1.0;
        println!("volume change after 1000 redistancings: {change:.1e}");
        assert!(change.abs() < 5e-4);
    }
}
