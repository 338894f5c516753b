//! Drawn oxides of bare steel: heat tint, mill scale, rust.

use glam::DVec3;
use random::Stream;
use render::{Crust, Deposit, HeatTint, Material, Oxides};
use serde::{Deserialize, Serialize};

use crate::looks::offset;

/// Heat tint around welds.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct HeatTintDraw {
    /// Thickness of the oxide film at the fusion line [m].
    pub thickest_m: f64,
    /// Distance over which it falls to 1/e [m].
    pub decay_m: f64,
}

/// Rust and mill scale, at least one of them.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct RustDraw {
    /// Rust, more of it near welds.
    pub rust: Option<CrustDraw>,
    /// Mill scale, burnt away near welds.
    pub scale: Option<CrustDraw>,
}

/// A crust in spots.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct CrustDraw {
    /// Linear RGB.
    pub colour: DVec3,
    /// Roughness, 0 to 1.
    pub roughness: f64,
    /// Share of the metal with spots, far from welds.
    pub cover: f64,
    /// Share that is added at the fusion line.
    pub near_weld: f64,
    /// Distance from the fusion line over which that falls to 1/e [m].
    pub decay_m: f64,
    /// Period of the spots [m].
    pub period_m: f64,
    /// Position of the pattern [periods].
    pub offset: DVec3,
}

impl HeatTintDraw {
    pub(crate) fn draw(stream: &mut Stream) -> Self {
        Self { thickest_m: stream.ratio_between([40e-9, 120e-9]), decay_m: stream.ratio_between([4e-3, 14e-3]) }
    }
}

impl RustDraw {
    pub(crate) fn draw(stream: &mut Stream) -> Self {
        let [rusty, scaly] = [0.7, 0.5].map(|share| stream.happens(share));
        Self {
            rust: rusty.then(|| CrustDraw::rust(stream)),
            scale: (scaly || !rusty).then(|| CrustDraw::scale(stream)),
        }
    }
}

impl CrustDraw {
    /// From the orange of fresh rust to the brown of old rust.
    fn rust(stream: &mut Stream) -> Self {
        let age = stream.between([0.0, 1.0]);
        let colour = DVec3::new(0.36, 0.13, 0.03).lerp(DVec3::new(0.10, 0.045, 0.025), age);
        Self {
            colour,
            roughness: stream.between([0.75, 0.95]),
            cover: stream.between([0.05, 0.5]),
            near_weld: stream.between([0.0, 0.5]),
            decay_m: stream.ratio_between([3e-3, 15e-3]),
            period_m: stream.ratio_between([2e-3, 20e-3]),
            offset: offset(stream),
        }
    }

    /// Blue grey; the heat of a weld cracks it off.
    fn scale(stream: &mut Stream) -> Self {
        let grey = stream.ratio_between([0.04, 0.14]);
        Self {
            colour: grey * DVec3::new(0.9, 0.96, 1.1),
            roughness: stream.between([0.35, 0.7]),
            cover: stream.between([0.1, 0.6]),
            near_weld: -stream.between([0.2, 0.8]),
            decay_m: stream.ratio_between([3e-3, 10e-3]),
            period_m: stream.ratio_between([4e-3, 40e-3]),
            offset: offset(stream),
        }
    }

    fn crust(&self) -> Crust {
        let material = Material { colour: self.colour.as_vec3(), roughness: self.roughness as f32, metallic: 0.0 };
        let (cover, period) = (self.cover as f32, self.period_m as f32);
        let spots = Deposit { material, cover, period, offset: self.offset.as_vec3() };
        Crust { spots, near_weld: self.near_weld as f32, decay: self.decay_m as f32 }
    }
}

/// Oxides for the renderer.
pub(crate) fn oxides(tint: Option<&HeatTintDraw>, rust: Option<&RustDraw>) -> Oxides {
    let crust = |of: fn(&RustDraw) -> Option<CrustDraw>| rust.and_then(of).map(|draw| draw.crust());
    Oxides {
        heat_tint: tint.map(|tint| HeatTint::new(tint.thickest_m as f32, tint.decay_m as f32)),
        scale: crust(|rust| rust.scale),
        rust: crust(|rust| rust.rust),
    }
}
