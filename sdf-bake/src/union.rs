//! Union of two fields on one lattice, remembering which body made the surface.

use glam::IVec3;
use thiserror::Error;

use crate::grid::{BRICK_SIDE, BRICK_VOXELS, BrickGrid, INSIDE, OUTSIDE};
use crate::implicit::entry_brick;

/// Two grids that do not share a lattice.
#[derive(Clone, Copy, Debug, Error, PartialEq)]
#[error("the grids differ: voxel {voxels:?} m, band {bands:?} m; both must be equal")]
pub struct LatticeError {
    /// Voxels of the two grids [m].
    pub voxels: [f64; 2],
    /// Bands of the two grids [m].
    pub bands: [f32; 2],
}

impl BrickGrid {
    /// The union of this field and `added`, `min(φ, φ_added)`, labelled `id` where `added` is the nearer body.
    ///
    /// Labels of this grid stay elsewhere. Bricks deep inside `added` are kept, because their label says what
    /// an opened surface would show.
    ///
    /// # Errors
    /// [`LatticeError`] when voxel or band differ.
    pub fn united_with(&self, added: &BrickGrid, id: u16) -> Result<BrickGrid, LatticeError> {
        if self.voxel != added.voxel || self.band != added.band {
            return Err(LatticeError { voxels: [self.voxel, added.voxel], bands: [self.band, added.band] });
        }
        let origin = self.origin.min(added.origin);
        let dims = (self.origin + self.dims).max(added.origin + added.dims) - origin;
        let mut union = BrickGrid::empty(self.voxel, self.band, origin, dims);
        for entry in 0..union.index.len() {
            let brick = origin + entry_brick(entry, dims);
            match (self.slot(brick), added.slot(brick)) {
                (OUTSIDE, OUTSIDE) => {}
                (INSIDE, _) => union.index[entry] = INSIDE,
                _ => union.push_united(entry, brick, self, added, id),
            }
        }
        Ok(union)
    }

    fn push_united(&mut self, entry: usize, brick: IVec3, base: &BrickGrid, added: &BrickGrid, id: u16) {
        let (phi, label) = united_brick(brick, base, added, id);
        let labelled = label.iter().any(|&id| id != 0);
        if phi.iter().all(|&phi| phi >= self.band) {
            return;
        }
        if !labelled && phi.iter().all(|&phi| phi <= -self.band) {
            self.index[entry] = INSIDE;
            return;
        }
        self.index[entry] = self.bricks.len() as u32;
        self.bricks.push(brick);
        self.phi.extend_from_slice(&phi);
        self.label.extend_from_slice(&label);
    }

    /// φ of a whole brick [m], also where no brick is.
    pub(crate) fn brick_phi(&self, brick: IVec3) -> [f32; BRICK_VOXELS] {
        match self.slot(brick) {
            OUTSIDE => [self.band; BRICK_VOXELS],
            INSIDE => [-self.band; BRICK_VOXELS],
            slot => {
                let first = slot as usize * BRICK_VOXELS;
                std::array::from_fn(|offset| self.phi[first + offset])
            }
        }
    }
}

fn united_brick(
    brick: IVec3,
    base: &BrickGrid,
    added: &BrickGrid,
    id: u16,
) -> ([f32; BRICK_VOXELS], [u16; BRICK_VOXELS]) {
    let (mut phi, extra) = (base.brick_phi(brick), added.brick_phi(brick));
    let mut label = [0u16; BRICK_VOXELS];
    for offset in 0..BRICK_VOXELS {
        label[offset] = base.label_at(brick * BRICK_SIDE as i32 + crate::grid::voxel_at(IVec3::ZERO, offset));
        if extra[offset] < phi[offset] {
            phi[offset] = extra[offset];
            label[offset] = id;
        }
    }
    (phi, label)
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::DVec3;

    fn ball(centre: DVec3, radius: f64) -> BrickGrid {
        let (low, high) = (centre - radius, centre + radius);
        BrickGrid::from_distance(low, high, 0.0005, 3.0, |p| p.distance(centre) - radius)
    }

    #[test]
    fn each_surface_point_knows_its_body() {
        let (left, right) = (DVec3::new(-0.01, 0.001, 0.0), DVec3::new(0.011, 0.0, 0.002));
        let union = ball(left, 0.014).united_with(&ball(right, 0.0125), 3).unwrap();
        assert_eq!(union.sanity_check(), Ok(()));
        assert_eq!(union.label(left - DVec3::X * 0.014), 0);
        assert_eq!(union.label(right + DVec3::X * 0.0125), 3);
        assert!(union.sample(DVec3::ZERO) < 0.0);
        assert_eq!(union.label(right), 3, "the core of the added body keeps its label");
    }

    #[test]
    fn a_body_inside_another_adds_nothing() {
        let base = ball(DVec3::ZERO, 0.02);
        let union = base.united_with(&ball(DVec3::ZERO, 0.01), 1).unwrap();
        assert_eq!(union.phi, base.phi);
        assert!(union.label.iter().all(|&id| id == 0));
    }

    #[test]
    fn different_lattices_are_refused() {
        let base = ball(DVec3::ZERO, 0.02);
        let coarse = BrickGrid { voxel: 0.001, ..base.clone() };
        assert!(base.united_with(&coarse, 1).is_err());
    }
}
