//! Dust over the materials of a scene. On the CPU only.

use glam::Vec3;

use super::material::{Blend, Material};
use super::shade::smooth_step;
use super::texture::noise_at;

/// Half the range of the noise in which the layer goes from absent to complete.
const FEATHER: f32 = 0.3;

/// A layer that lies in spots on everything that faces up.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Deposit {
    /// Material of the layer.
    pub material: Material,
    /// Share of a level surface that it covers, 0 to 1.
    pub cover: f32,
    /// Period of the spots [m].
    pub period: f32,
    /// Position of the pattern [periods].
    pub offset: Vec3,
}

impl Deposit {
    /// Share of the layer on a surface at a point [m]; `facing_up`: cosine of the angle between its normal and the
    /// vertical.
    #[inline(always)]
    pub(crate) fn share_on(&self, point: Vec3, facing_up: f32) -> f32 {
        self.share(point, self.cover) * facing_up.max(0.0)
    }

    /// Share of the layer at a point [m] where its spots have this mean cover.
    #[inline(always)]
    pub(crate) fn share(&self, point: Vec3, cover: f32) -> f32 {
        let level = 1.0 - 2.0 * cover;
        smooth_step(level - FEATHER, level + FEATHER, noise_at(point / self.period + self.offset))
    }

    /// Lays a share of the layer over a surface.
    #[inline(always)]
    pub(crate) fn laid(&self, under: Blend, share: f32) -> Blend {
        Blend { material: under.material.mixed(self.material, share), ground: under.ground * (1.0 - share) }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::material::{GROUND_STEEL, PRIMER};

    #[test]
    fn dust_lies_in_spots_on_what_faces_up() {
        let dust = Deposit { material: PRIMER, cover: 0.5, period: 5e-3, offset: Vec3::splat(3.3) };
        let bare = Blend { material: GROUND_STEEL, ground: 1.0 };
        let ground = |point: Vec3, up: f32| dust.laid(bare, dust.share_on(point, up)).ground;
        let places = || (0..2000).map(|i| Vec3::new(1.3e-4, 0.9e-4, 0.4e-4) * i as f32);
        assert!(places().all(|point| ground(point, 0.0) == 1.0 && ground(point, -0.7) == 1.0));
        let mean = places().map(|point| 1.0 - ground(point, 1.0)).sum::<f32>() / 2000.0;
        assert!((mean - 0.5).abs() < 0.15, "{mean}");
        assert!(places().any(|point| ground(point, 1.0) < 0.05) && places().any(|point| ground(point, 1.0) > 0.95));
    }
}
