//! Oxides on bare steel: heat tint around welds, mill scale, rust. On the CPU only.

use glam::Vec3;

use super::deposit::Deposit;
use super::heat_tint::HeatTint;
use super::material::Blend;

/// Greatest share of the metal that a crust hides.
const MOST_HIDDEN: f32 = 0.92;
/// Dose above 1 at which an abrasive has removed the oxides that were below the coating.
const WORN: f32 = 1.0;

/// A crust in spots on the metal, more of it near welds.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Crust {
    /// Material and spots.
    pub spots: Deposit,
    /// Cover that is added at the fusion line; below zero where there is less of it.
    pub near_weld: f32,
    /// Distance from the fusion line over which that falls to 1/e [m].
    pub decay: f32,
}

/// Oxides of a part's metal; none by default.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Oxides {
    /// Interference colours around welds. Sanding beyond D = 1 thins the film.
    pub heat_tint: Option<HeatTint>,
    /// Mill scale, below the coating; sanding beyond D = 1 removes it.
    pub scale: Option<Crust>,
    /// Rust, formed after sanding.
    pub rust: Option<Crust>,
}

/// Where a sample lies.
pub(crate) struct OxidePlace {
    /// In the part's frame [m].
    pub(crate) point: Vec3,
    /// Distance from the nearest fusion line [m], infinite without a weld; 0 on weld metal.
    pub(crate) distance: f32,
    /// Cosine of the angle between normal and view.
    pub(crate) cosine: f32,
    /// Dose D.
    pub(crate) dose: f32,
}

impl Crust {
    /// Share of the metal that it hides.
    #[inline(always)]
    fn share(&self, place: &OxidePlace) -> f32 {
        let cover = self.spots.cover + self.near_weld * (-place.distance / self.decay).exp();
        MOST_HIDDEN * self.spots.share(place.point, cover.clamp(0.0, 1.0))
    }
}

impl Oxides {
    #[inline(always)]
    pub(crate) fn is_none(&self) -> bool {
        self.heat_tint.is_none() && self.scale.is_none() && self.rust.is_none()
    }

    /// Covers bare metal.
    #[inline(always)]
    pub(crate) fn over(&self, mut bare: Blend, place: &OxidePlace) -> Blend {
        let left = 1.0 - ((place.dose - 1.0) / WORN).clamp(0.0, 1.0);
        if let Some(tint) = &self.heat_tint {
            let thickness = left * tint.thickness(place.point, place.distance);
            bare.material.colour *= tint.colour(thickness, place.cosine);
        }
        if let Some(scale) = &self.scale {
            bare = scale.spots.laid(bare, left * scale.share(place));
        }
        if let Some(rust) = &self.rust {
            bare = rust.spots.laid(bare, rust.share(place));
        }
        bare
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::material::{GROUND_STEEL, Material};

    const RUST: Material = Material { colour: Vec3::new(0.3, 0.1, 0.03), roughness: 0.9, metallic: 0.0 };

    fn crust(cover: f32, near_weld: f32) -> Crust {
        let spots = Deposit { material: RUST, cover, period: 4e-3, offset: Vec3::splat(3.3) };
        Crust { spots, near_weld, decay: 5e-3 }
    }

    fn place(i: usize, distance: f32, dose: f32) -> OxidePlace {
        OxidePlace { point: Vec3::new(1.3e-4, 0.9e-4, 0.4e-4) * i as f32, distance, cosine: 1.0, dose }
    }

    /// Mean metallic response of 2000 places.
    fn metallic(oxides: &Oxides, distance: f32, dose: f32) -> f32 {
        let bare = Blend { material: GROUND_STEEL, ground: 1.0 };
        (0..2000).map(|i| oxides.over(bare, &place(i, distance, dose)).material.metallic).sum::<f32>() / 2000.0
    }

    #[test]
    fn scale_is_sanded_away_and_rust_is_not() {
        let scale = Oxides { scale: Some(crust(0.5, 0.0)), ..Oxides::default() };
        let rust = Oxides { rust: Some(crust(0.5, 0.0)), ..Oxides::default() };
        let mean = |oxides: &Oxides, dose: f32| metallic(oxides, f32::INFINITY, dose);
        assert!(mean(&scale, 1.0) < 0.7 && mean(&scale, 1.0) > 0.3, "{}", mean(&scale, 1.0));
        assert!((mean(&scale, 2.0) - 1.0).abs() < 1e-6);
        assert_eq!(mean(&rust, 1.0), mean(&rust, 2.0));
        assert_eq!(mean(&Oxides::default(), 1.0), 1.0);
    }

    #[test]
    fn a_crust_gathers_where_the_weld_is() {
        let rust = Oxides { rust: Some(crust(0.1, 0.6)), ..Oxides::default() };
        let [near, far] = [1e-3, 30e-3].map(|distance| metallic(&rust, distance, 1.0));
        assert!(near < far - 0.2, "{near} and {far}");
    }

    #[test]
    fn tint_colours_what_is_near_and_not_yet_sanded() {
        let oxides = Oxides { heat_tint: Some(HeatTint::new(50e-9, 5e-3)), ..Oxides::default() };
        let bare = Blend { material: GROUND_STEEL, ground: 0.0 };
        let colour = |distance: f32, dose: f32| oxides.over(bare, &place(3, distance, dose)).material.colour;
        let (blue, straw) = (colour(0.0, 1.0), colour(4e-3, 1.0));
        assert!(blue.z > blue.x && straw.x > straw.z, "{blue} {straw}");
        assert_eq!(colour(f32::INFINITY, 1.0), GROUND_STEEL.colour);
        assert_eq!(colour(0.0, 2.0), GROUND_STEEL.colour);
    }
}
