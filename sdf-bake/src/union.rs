//! Union of two fields on one lattice, with labels of the body that gives the surface.

use crate::combine::{BLEND_REACH, Combination, Combine, CombineError, LatticeError, inherit};
use crate::grid::{BRICK_VOXELS, BrickGrid};
use crate::redistance::contains;

impl BrickGrid {
    /// Unites this field with `added` as [`BrickGrid::combined_with`] does. Label `id` is set where `added` is the
    /// nearer body, and in every voxel whose cell contains some of the material that `added` contributes.
    ///
    /// Elsewhere this grid's labels stay. Bricks deep inside `added` are kept, because their label is needed if the
    /// surface reaches them.
    ///
    /// # Errors
    /// [`LatticeError`] if voxel or band differ.
    pub fn united_with(&self, added: &BrickGrid, id: u16) -> Result<BrickGrid, LatticeError> {
        self.labelled_union(added, id, Combine::Union)
    }

    /// [`BrickGrid::united_with`], with the inner edges filled as by [`Combine::SmoothUnion`] of this radius [m].
    ///
    /// # Errors
    /// [`CombineError`] if voxel or band differ, or the radius is not 0 to 0.8 bands.
    pub fn blended_with(&self, added: &BrickGrid, id: u16, radius: f64) -> Result<BrickGrid, CombineError> {
        if !(0.0..=BLEND_REACH * f64::from(self.band)).contains(&radius) {
            return Err(CombineError::Blend { radius, band: self.band });
        }
        Ok(self.labelled_union(added, id, Combine::SmoothUnion { radius })?)
    }

    fn labelled_union(&self, added: &BrickGrid, id: u16, how: Combine) -> Result<BrickGrid, LatticeError> {
        let (mut union, from_added) = Combination::of(self, added, how)?.grid(true);
        let owned = |place: usize| contains(&from_added[place / BRICK_VOXELS], place % BRICK_VOXELS);
        union.inherit_scalars(self, added, &from_added);
        union.label = vec![0; union.phi.len()];
        if !self.label.is_empty() {
            union.label = inherit(&union, [(self, &self.label), (added, &[])], &from_added);
        }
        for (place, share) in union.difference_share(self).into_iter().enumerate() {
            if share > 0.0 || owned(place) {
                union.label[place] = id;
            }
        }
        union.release_uniform_bricks();
        union.index.tidy();
        Ok(union)
    }
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
        let mut coated = ball(left, 0.014);
        coated.dose = vec![0.25; coated.phi.len()];
        let union = coated.united_with(&ball(right, 0.0125), 3).unwrap();
        assert_eq!(union.sanity_check(), Ok(()));
        assert_eq!(union.label(left - DVec3::X * 0.014), 0);
        assert_eq!(union.label(right + DVec3::X * 0.0125), 3);
        assert!(union.sample(DVec3::ZERO) < 0.0);
        assert_eq!(union.label(right), 3, "the core of the added body keeps its label");
        assert_eq!(union.sample_dose(left - DVec3::X * 0.014), 0.25);
        assert_eq!(union.sample_dose(right + DVec3::X * 0.0125), 0.0, "what is added has no dose");
    }

    #[test]
    fn a_body_inside_another_adds_nothing() {
        let base = ball(DVec3::ZERO, 0.02);
        let union = base.united_with(&ball(DVec3::ZERO, 0.01), 1).unwrap();
        assert_eq!(union.phi, base.phi);
        assert!(union.label.iter().all(|&id| id == 0));
    }

    #[test]
    fn a_second_weld_leaves_the_first_its_label() {
        let base = ball(DVec3::ZERO, 0.012);
        let (one, two) = (ball(DVec3::X * 0.012, 0.004), ball(DVec3::Y * 0.012, 0.004));
        let welded = base.united_with(&one, 1).unwrap().united_with(&two, 2).unwrap();
        assert_eq!((welded.label(DVec3::X * 0.016), welded.label(DVec3::Y * 0.016)), (1, 2));
        assert_eq!(welded.label(DVec3::X * 0.014), 1, "also below the surface");
        assert_eq!(welded.label(DVec3::NEG_Z * 0.012), 0);
    }

    #[test]
    fn different_lattices_are_refused() {
        let base = ball(DVec3::ZERO, 0.02);
        let coarse = BrickGrid { voxel: 0.001, ..base.clone() };
        assert!(base.united_with(&coarse, 1).is_err());
    }
}
