//! Materials of a surface and their finish.

use glam::Vec3;

use super::lanes::{LANES, Lanes, Points};
use super::marks::Marks;
use super::oxides::Oxides;
use super::shade::smooth_step;
use super::texture::Texture;

/// Share of weld metal at which the weld's appearance starts, and at which it is complete.
pub(crate) const WELD_BORDER: (f32, f32) = (0.35, 0.65);

/// Doses at which the primer starts to show through the coating, and at which the coating is gone.
const PRIMER_FROM: (f32, f32) = (0.3, 0.6);
/// Doses at which metal starts to show through the primer, and at which the primer is gone.
const METAL_FROM: (f32, f32) = (0.65, 0.95);

/// A microfacet material (Burley 2012, metallic-roughness).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Material {
    /// Linear RGB: diffuse albedo of a nonmetal, reflectance of a metal at normal incidence.
    pub colour: Vec3,
    /// Perceptual roughness, 0 to 1; the width of the microfacet distribution is its square.
    pub roughness: f32,
    /// 0 for paint, 1 for bare metal.
    pub metallic: f32,
}

impl Material {
    /// Interpolates colour, roughness and metallic response, with share `share` of `other` (0 to 1).
    #[inline(always)]
    pub fn mixed(self, other: Self, share: f32) -> Self {
        Self {
            colour: self.colour.lerp(other.colour, share),
            roughness: self.roughness + (other.roughness - self.roughness) * share,
            metallic: self.metallic + (other.metallic - self.metallic) * share,
        }
    }
}

/// Rolled steel with dull grey mill scale.
pub const ROLLED_STEEL: Material = Material { colour: Vec3::new(0.40, 0.41, 0.43), roughness: 0.52, metallic: 0.9 };
/// Weld metal as solidified: smooth, with heat tint.
pub const FRESH_WELD: Material = Material { colour: Vec3::new(0.47, 0.41, 0.35), roughness: 0.34, metallic: 1.0 };
/// Steel bared by an abrasive.
pub const GROUND_STEEL: Material = Material { colour: Vec3::new(0.63, 0.62, 0.61), roughness: 0.36, metallic: 1.0 };
/// A blue-green primer.
pub const PRIMER: Material = Material { colour: Vec3::new(0.045, 0.135, 0.150), roughness: 0.48, metallic: 0.0 };

/// The materials of a part and the conditions under which each is visible.
#[derive(Clone, Debug, PartialEq)]
pub struct Appearance {
    /// Untouched base metal.
    pub metal: Material,
    /// Untouched weld metal.
    pub weld: Material,
    /// Ground metal: metal from which depth or coating was removed.
    pub ground: Material,
    /// The coating; visible where the dose D is below 1. `None` for a bare part.
    pub coating: Option<Material>,
    /// Grinding marks of ground metal.
    pub marks: Marks,
    /// Removed depth from which metal looks ground [m].
    pub ground_depth: f32,
    /// Layer between coating and metal, visible where little coating is left. On the CPU only.
    pub primer: Option<Material>,
    /// Variation of all materials of the part. On the CPU only.
    pub texture: Option<Texture>,
    /// Oxides of the metal. On the CPU only.
    pub oxides: Oxides,
}

impl Default for Appearance {
    fn default() -> Self {
        Self {
            metal: ROLLED_STEEL,
            weld: FRESH_WELD,
            ground: GROUND_STEEL,
            coating: None,
            marks: Marks::default(),
            ground_depth: 5e-6,
            primer: None,
            texture: None,
            oxides: Oxides::default(),
        }
    }
}

/// Material at a point and its share of ground metal.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Blend {
    pub(crate) material: Material,
    /// Share of ground metal, 0 to 1.
    pub(crate) ground: f32,
}

/// Materials of a tile's samples.
pub(crate) struct MaterialLanes {
    colour: Points,
    roughness: Lanes,
    metallic: Lanes,
    /// Share of ground metal, as in [`Blend`].
    pub(crate) ground: Lanes,
}

impl MaterialLanes {
    /// Black in all lanes.
    pub(crate) const NONE: Self =
        Self { colour: Points::ZERO, roughness: [0.0; LANES], metallic: [0.0; LANES], ground: [0.0; LANES] };

    #[inline(always)]
    pub(crate) fn set(&mut self, lane: usize, Blend { material, ground }: Blend) {
        self.colour.set(lane, material.colour);
        (self.roughness[lane], self.metallic[lane], self.ground[lane]) =
            (material.roughness, material.metallic, ground);
    }

    #[inline(always)]
    pub(crate) fn get(&self, lane: usize) -> Material {
        let (roughness, metallic) = (self.roughness[lane], self.metallic[lane]);
        Material { colour: self.colour.get(lane), roughness, metallic }
    }

    #[inline(always)]
    pub(crate) fn blend(&self, lane: usize) -> Blend {
        Blend { material: self.get(lane), ground: self.ground[lane] }
    }
}

impl Appearance {
    /// Mixes coated and exposed appearance, through a primer if there is one.
    ///
    /// - `bare`: [`Appearance::bare`], perhaps with oxides
    /// - `exposed`: shares of exposed metal, 0 to 1
    /// - `removed`: as in [`Samples`](super::gbuffer_lanes::Samples)
    #[inline(always)]
    pub(crate) fn blends(&self, bare: &MaterialLanes, exposed: &Lanes, removed: &Lanes) -> MaterialLanes {
        let mut blends = MaterialLanes::NONE;
        // The choice holds for all lanes, so it is made once.
        match self.coating {
            None => (0..LANES).for_each(|i| blends.set(i, self.uncoated(bare.get(i), removed[i]))),
            Some(coating) => (0..LANES).for_each(|i| blends.set(i, self.coated(coating, bare.blend(i), exposed[i]))),
        }
        blends
    }

    /// Metal without a coating: below one it is ground where a tool has removed metal or coating.
    ///
    /// - `weld_share`, `removed`: as in [`Samples`](super::gbuffer_lanes::Samples)
    #[inline(always)]
    pub(crate) fn bare(&self, weld_share: &Lanes, removed: &Lanes) -> MaterialLanes {
        let mut bare = MaterialLanes::NONE;
        if self.coating.is_some() {
            for i in 0..LANES {
                // An orbital pad marks all metal that it lays bare.
                let ground = if self.marks.orbit.is_some() { 1.0 } else { self.ground_share(removed[i]) };
                bare.set(i, Blend { material: self.ground, ground });
            }
        } else {
            for i in 0..LANES {
                let weld = smooth_step(WELD_BORDER.0, WELD_BORDER.1, weld_share[i]);
                bare.set(i, Blend { material: self.metal.mixed(self.weld, weld), ground: 0.0 });
            }
        }
        bare
    }

    /// True if some metal can be seen where the coating has this dose.
    #[inline(always)]
    pub(crate) fn shows_metal(&self, dose: f32) -> bool {
        self.coating.is_none() || self.metal_share(dose.clamp(0.0, 1.0)) > 0.0
    }

    /// Share of metal that is visible through the primer.
    #[inline(always)]
    fn metal_share(&self, exposed: f32) -> f32 {
        if self.primer.is_some() { smooth_step(METAL_FROM.0, METAL_FROM.1, exposed) } else { exposed }
    }

    #[inline(always)]
    fn ground_share(&self, removed: f32) -> f32 {
        smooth_step(0.0, self.ground_depth, removed)
    }

    #[inline(always)]
    fn uncoated(&self, bare: Material, removed: f32) -> Blend {
        let ground = self.ground_share(removed);
        Blend { material: bare.mixed(self.ground, ground), ground }
    }

    #[inline(always)]
    fn coated(&self, coating: Material, bare: Blend, exposed: f32) -> Blend {
        let bottom = match self.primer {
            None => coating,
            Some(primer) => coating.mixed(primer, smooth_step(PRIMER_FROM.0, PRIMER_FROM.1, exposed)),
        };
        let metal = self.metal_share(exposed);
        Blend { material: bottom.mixed(bare.material, metal), ground: bare.ground * metal }
    }
}
