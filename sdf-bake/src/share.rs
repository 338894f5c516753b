//! Share of each voxel's cell that is in the difference of two parts: an antialiased label.

use glam::{IVec3, Vec3};
use rayon::prelude::*;

use crate::grid::{BRICK_VOXELS, BrickGrid, cell_corner, trilinear, voxel_at};
use crate::volume::{Nodes, difference_fraction};

impl BrickGrid {
    /// Share (0 to 1) of each voxel's cell, half a voxel to every side, that is inside this part and outside `minus`.
    ///
    /// Values are in the order of `phi`, shape `[bricks, 512]`. Their sum times the volume of a voxel is
    /// [`BrickGrid::difference_volume`], if the difference lies within this grid's bricks.
    pub fn difference_share(&self, minus: &BrickGrid) -> Vec<f32> {
        let share = |&brick: &IVec3| {
            if self.is_alike(minus, brick) {
                return vec![0.0; BRICK_VOXELS];
            }
            let (kept, cut) = (Nodes::of(self, brick, 1), Nodes::of(minus, brick, 1));
            (0..BRICK_VOXELS).map(|offset| voxel_share(voxel_at(IVec3::ZERO, offset), &kept, &cut)).collect()
        };
        self.bricks.par_iter().map(share).collect::<Vec<Vec<f32>>>().concat()
    }
}

/// Mean over the eight octants of a voxel's cell, each of which lies in one cell of nodes.
fn voxel_share(voxel: IVec3, kept: &Nodes, cut: &Nodes) -> f32 {
    let sum: f64 = (0..8)
        .map(|octant| {
            let upper = cell_corner(octant);
            let cell = voxel - 1 + upper;
            if !kept.is_below(cut, cell) {
                return 0.0;
            }
            let (kept, cut) = (kept.corners(cell), cut.corners(cell));
            if kept.iter().all(|&phi| phi >= 0.0) || cut.iter().all(|&phi| phi < 0.0) {
                return 0.0;
            }
            let start = 0.5 * (1 - upper).as_vec3();
            difference_fraction(&part_of_cell(&kept, start), &part_of_cell(&cut, start))
        })
        .sum();
    (sum / 8.0) as f32
}

/// Values of the interpolant at the corners of the half-size cell that starts at `start`.
fn part_of_cell(corners: &[f32; 8], start: Vec3) -> [f32; 8] {
    std::array::from_fn(|i| trilinear(corners, start + 0.5 * cell_corner(i).as_vec3()))
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::DVec3;

    #[test]
    fn the_shares_add_up_to_the_difference_on_a_lattice_plane_too() {
        let slab = |top: f64| {
            let (low, high) = (DVec3::new(-0.01, -0.01, -0.002), DVec3::new(0.01, 0.01, top));
            BrickGrid::from_distance(low, high, 0.0005, 3.0, move |p| {
                let q = (p - 0.5 * (low + high)).abs() - 0.5 * (high - low);
                q.max(DVec3::ZERO).length() + q.max_element().min(0.0)
            })
        };
        // The lower slab's top lies exactly in a layer of voxels, where counting voxels is wrong by half a layer.
        let (thick, thin) = (slab(0.00413), slab(0.002));
        let share = thick.difference_share(&thin);
        let sum = share.iter().map(|&s| f64::from(s)).sum::<f64>() * thick.voxel.powi(3);
        let volume = thick.difference_volume(&thin);
        assert!((sum / volume - 1.0).abs() < 1e-3, "{sum} against {volume}");
        assert!((volume / (0.02 * 0.02 * 0.00213) - 1.0).abs() < 0.01, "{volume}");
        assert!(share.iter().all(|s| (0.0..=1.0).contains(s)));
    }
}
