//! Bricks from a distance function: reference fields for tests, tools and simple parts.

use glam::{DVec3, IVec3};
use rayon::prelude::*;

use crate::grid::{BRICK_SIDE, BRICK_VOXELS, BrickGrid, INSIDE, voxel_at};
use crate::index::columns;

impl BrickGrid {
    /// Samples a signed distance function on the lattice.
    ///
    /// - `low`, `high`: box [m] that contains the whole surface; bricks are made up to one band beyond it
    /// - `voxel`: distance between voxels [m]
    /// - `band_voxels`: truncation distance [voxels]
    /// - `distance`: signed distance [m] at a point [m], negative inside, 1-Lipschitz
    pub fn from_distance(
        low: DVec3,
        high: DVec3,
        voxel: f64,
        band_voxels: f64,
        distance: impl Fn(DVec3) -> f64 + Sync,
    ) -> Self {
        let band = band_voxels * voxel;
        let brick_size = BRICK_SIDE as f64 * voxel;
        let first = ((low - band) / brick_size).floor().as_ivec3();
        let last = ((high + band) / brick_size).floor().as_ivec3();
        let dims = last - first + 1;
        Self::from_bricks((voxel, band), first, dims, |brick| fill(brick, (voxel, band as f32), &distance))
    }

    /// Calls `fill` for every brick of a box, on all threads, and collects the results in index order.
    ///
    /// - `lattice`: voxel and band [m]
    /// - `first`, `dims`: the box [bricks]
    pub(crate) fn from_bricks(
        lattice: (f64, f64),
        first: IVec3,
        dims: IVec3,
        fill: impl Fn(IVec3) -> BrickContents + Sync,
    ) -> Self {
        let mut grid = Self::empty(lattice.0, lattice.1 as f32, first, dims);
        let filled = columns(dims).flat_map_iter(|column| {
            let bricks = (0..dims.z).map(move |z| first + column.extend(z));
            bricks.map(|brick| (brick, fill(brick))).filter(|(_, filled)| !matches!(filled, BrickContents::Outside))
        });
        let filled: Vec<(IVec3, BrickContents)> = filled.collect();
        let pooled = filled.iter().filter(|(_, filled)| matches!(filled, BrickContents::Band(_))).count();
        grid.phi.reserve_exact(pooled * BRICK_VOXELS);
        for (brick, filled) in filled {
            match filled {
                BrickContents::Outside => {}
                BrickContents::Inside => grid.set_slot(brick, INSIDE),
                BrickContents::Band(values) => {
                    grid.set_slot(brick, grid.bricks.len() as u32);
                    grid.bricks.push(brick);
                    grid.phi.extend_from_slice(values.as_slice());
                }
            }
        }
        grid.index.tidy();
        grid
    }
}

/// Contents of a brick.
pub(crate) enum BrickContents {
    Outside,
    Inside,
    Band(Box<[f32; BRICK_VOXELS]>),
}

impl BrickContents {
    /// Makes a brick from values [m] by offset, truncated at the band [m].
    #[inline(always)]
    pub(crate) fn of(value: impl Fn(usize) -> f32, band: f32) -> Self {
        let mut values = Box::new([0f32; BRICK_VOXELS]);
        for (offset, phi) in values.iter_mut().enumerate() {
            *phi = value(offset).clamp(-band, band);
        }
        let beyond = |sign: f32| values.iter().all(|&phi| phi * sign >= band);
        if beyond(1.0) {
            Self::Outside
        } else if beyond(-1.0) {
            Self::Inside
        } else {
            Self::Band(values)
        }
    }
}

fn fill(brick: IVec3, (voxel, band): (f64, f32), distance: &(impl Fn(DVec3) -> f64 + Sync)) -> BrickContents {
    let centre = (brick.as_dvec3() * BRICK_SIDE as f64 + 3.5) * voxel;
    let reach = 3.5 * 3f64.sqrt() * voxel + f64::from(band);
    let at_centre = distance(centre);
    if at_centre > reach {
        return BrickContents::Outside;
    }
    if at_centre < -reach {
        return BrickContents::Inside;
    }
    BrickContents::of(|offset| distance(voxel_at(brick, offset).as_dvec3() * voxel) as f32, band)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_ball_is_sampled_to_second_order_and_known_everywhere() {
        let ball = |p: DVec3| p.length() - 0.02;
        let grid = BrickGrid::from_distance(DVec3::splat(-0.02), DVec3::splat(0.02), 0.0005, 3.0, ball);
        assert_eq!(grid.sanity_check(), Ok(()));
        assert_eq!(grid.sample(DVec3::ZERO), -grid.band);
        assert_eq!(grid.sample(DVec3::splat(1.0)), grid.band);
        for i in 0..200 {
            let turn = f64::from(i) * 2.399963;
            let z = 1.0 - 2.0 * (f64::from(i) + 0.5) / 200.0;
            let direction = DVec3::new((1.0 - z * z).sqrt() * turn.cos(), (1.0 - z * z).sqrt() * turn.sin(), z);
            let (phi, gradient) = grid.sample_gradient(direction * 0.0203);
            assert!((f64::from(phi) - 0.0003).abs() < 5e-6, "φ is {phi}");
            assert!((gradient.as_dvec3() - direction).length() < 0.04, "the gradient is {gradient} along {direction}");
        }
    }
}
