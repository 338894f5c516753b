//! Bounding box of the zero set.

use glam::{DVec3, IVec3};
use rayon::prelude::*;

use crate::grid::{BRICK_VOXELS, BrickGrid, voxel_at};

const STEPS: [IVec3; 6] = [IVec3::X, IVec3::NEG_X, IVec3::Y, IVec3::NEG_Y, IVec3::Z, IVec3::NEG_Z];

impl BrickGrid {
    /// Lowest and highest corner [m] of the box around {φ = 0}, from its crossings with the lattice's edges; `None`
    /// without a surface.
    pub fn surface_bounds(&self) -> Option<(DVec3, DVec3)> {
        let join = |a: Option<(DVec3, DVec3)>, b: Option<(DVec3, DVec3)>| match (a, b) {
            (Some(a), Some(b)) => Some((a.0.min(b.0), a.1.max(b.1))),
            (a, b) => a.or(b),
        };
        (0..self.bricks.len()).into_par_iter().map(|slot| self.brick_crossings(slot)).reduce(|| None, join)
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

    fn brick_crossings(&self, slot: usize) -> Option<(DVec3, DVec3)> {
        let mut bounds: Option<(DVec3, DVec3)> = None;
        for offset in 0..BRICK_VOXELS {
            let phi = self.phi[slot * BRICK_VOXELS + offset];
            if phi >= 0.0 {
                continue;
            }
            let voxel = voxel_at(self.bricks[slot], offset);
            for step in STEPS {
                let beyond = self.phi_at(voxel + step);
                if beyond >= 0.0 {
                    let along = f64::from(phi / (phi - beyond));
                    let crossing = self.position(voxel) + step.as_dvec3() * (along * self.voxel);
                    let (low, high) = bounds.unwrap_or((crossing, crossing));
                    bounds = Some((low.min(crossing), high.max(crossing)));
                }
            }
        }
        bounds
    }
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
