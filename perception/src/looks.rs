//! Domain randomisation of a photograph's appearance: dust, clear coat, textures, marks, primer, oxides, studio light,
//! optics, compression. Each look has its own random stream, so switching one off changes nothing else in a scene.

use glam::{DVec2, DVec3};
use random::Stream;
use render::{Deposit, LightPanel, Material, Optics, Texture, outward};
use serde::{Deserialize, Serialize};

use crate::look::Look;
use crate::oxide_draws::{HeatTintDraw, RustDraw};
use crate::table_draw::TableDraw;

/// The looks of one image; those that were left out are absent.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct LookDraws {
    /// Variation of the workpiece's materials.
    pub part: Option<TextureDraw>,
    /// Variation of the table's material.
    pub table: Option<TextureDraw>,
    /// Swirl marks.
    pub swirl: Option<SwirlDraw>,
    /// Colour of the primer, linear RGB.
    pub primer: Option<DVec3>,
    /// Luminous panels.
    pub panels: Vec<PanelDraw>,
    /// Lens and motion.
    pub optics: Option<OpticsDraw>,
    /// Quality of the JPEG through which the picture went, 0 to 100.
    pub jpeg_quality: Option<u8>,
    /// Roughness of a clear coat.
    pub clear_coat: Option<f64>,
    /// Dust.
    pub dust: Option<DustDraw>,
    /// Heat tint around welds.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub heat_tint: Option<HeatTintDraw>,
    /// Rust and mill scale on bare metal.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub rust: Option<RustDraw>,
    /// Pattern of the table.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub table_pattern: Option<TableDraw>,
}

/// Dust in spots.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct DustDraw {
    /// Linear RGB.
    pub colour: DVec3,
    /// Share of a level surface that it covers.
    pub cover: f64,
    /// Period of the spots [m].
    pub period_m: f64,
    /// Position of the pattern [periods].
    pub offset: DVec3,
}

/// Variation of a material.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct TextureDraw {
    /// Period along each axis of the part's frame [m].
    pub period_m: DVec3,
    /// Position of the pattern [periods].
    pub offset: DVec3,
    /// Greatest relative change of the colour.
    pub contrast: f64,
    /// Greatest change of the roughness.
    pub roughness: f64,
}

/// Marks of an orbital pad.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct SwirlDraw {
    /// Radius of the orbit [m].
    pub orbit_m: f64,
    /// Width of a groove [m].
    pub width_m: f64,
    /// Slope of the flanks.
    pub slope: f64,
    /// Anisotropy of the metal, 0 to 1.
    pub anisotropy: f64,
}

/// A luminous rectangle.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct PanelDraw {
    /// Unit vector from the scene to its middle.
    pub towards: DVec3,
    /// Unit vector along its first side.
    pub across: DVec3,
    /// Tangents of its half angles.
    pub half: DVec2,
    /// Radiance, linear RGB.
    pub radiance: DVec3,
}

/// Lens and motion.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct OpticsDraw {
    /// Aperture as in [`Optics::aperture`], for a picture 480 pixels high [pixels m].
    pub aperture: f64,
    /// Depth of sharp points relative to that of the workpiece's middle.
    pub focus: f64,
    /// Motion during the exposure, for a picture 480 pixels high [pixels].
    pub motion: DVec2,
    /// Share of the light that is lost in the corners.
    pub vignetting: f64,
    /// Gain of each channel.
    pub balance: DVec3,
}

/// Height of the picture for which defocus and motion are drawn [pixels].
const DRAWN_HEIGHT: f64 = 480.0;

impl LookDraws {
    /// Draws the given looks of an image; clutter, spatter and tool belong to the placement.
    pub(crate) fn draw(looks: &[Look], seed: u64) -> Self {
        let mut draws = Self::default();
        for &look in looks {
            let stream = &mut Stream::of(seed, look.name());
            match look {
                Look::Texture => {
                    draws.part = Some(TextureDraw::of_part(stream));
                    draws.table = Some(TextureDraw::of_table(stream));
                }
                Look::Swirl => draws.swirl = Some(SwirlDraw::draw(stream)),
                Look::Primer => draws.primer = stream.happens(0.6).then(|| primer(stream)),
                Look::Studio => draws.panels = (0..1 + stream.below(3)).map(|_| PanelDraw::draw(stream)).collect(),
                Look::Optics => draws.optics = Some(OpticsDraw::draw(stream)),
                Look::Compression => draws.jpeg_quality = Some(stream.between([55.0, 96.0]) as u8),
                Look::ClearCoat => {
                    draws.clear_coat = stream.happens(0.4).then(|| stream.ratio_between([0.05, 0.25]));
                }
                Look::Dust => draws.dust = stream.happens(0.5).then(|| DustDraw::draw(stream)),
                Look::HeatTint => draws.heat_tint = stream.happens(0.6).then(|| HeatTintDraw::draw(stream)),
                Look::Rust => draws.rust = stream.happens(0.5).then(|| RustDraw::draw(stream)),
                Look::Table => draws.table_pattern = stream.happens(0.75).then(|| TableDraw::draw(stream)),
                Look::Clutter | Look::Spatter | Look::Tool => {}
            }
        }
        draws
    }
}

/// Draws the colour of a primer: grey, red oxide or beige.
fn primer(stream: &mut Stream) -> DVec3 {
    let colour = [DVec3::splat(1.0), DVec3::new(1.5, 0.5, 0.35), DVec3::new(1.2, 1.05, 0.8)][stream.below(3)];
    colour * stream.ratio_between([0.08, 0.35])
}

impl TextureDraw {
    /// Stains of centimetres, or orange peel of millimetres.
    fn of_part(stream: &mut Stream) -> Self {
        let period = stream.ratio_between([2e-3, 30e-3]);
        Self {
            period_m: DVec3::splat(period),
            offset: offset(stream),
            contrast: stream.between([0.03, 0.25]),
            roughness: stream.between([0.0, 0.2]),
        }
    }

    /// Grain along x or y, or stains.
    fn of_table(stream: &mut Stream) -> Self {
        let period = stream.ratio_between([1.5e-3, 40e-3]);
        let along = stream.ratio_between([5.0, 60.0]);
        let stretch = [DVec3::ONE, DVec3::new(along, 1.0, along), DVec3::new(1.0, along, along)][stream.below(3)];
        Self {
            period_m: period * stretch,
            offset: offset(stream),
            contrast: stream.between([0.05, 0.6]),
            roughness: stream.between([0.0, 0.25]),
        }
    }

    pub(crate) fn texture(self) -> Texture {
        Texture {
            period: self.period_m.as_vec3(),
            offset: self.offset.as_vec3(),
            contrast: self.contrast as f32,
            roughness: self.roughness as f32,
        }
    }
}

/// Position of a pattern; so small that coordinates keep their digits.
pub(crate) fn offset(stream: &mut Stream) -> DVec3 {
    DVec3::from_array(std::array::from_fn(|_| stream.between([-100.0, 100.0])))
}

impl SwirlDraw {
    fn draw(stream: &mut Stream) -> Self {
        Self {
            orbit_m: stream.between([2.0e-3, 6.0e-3]),
            width_m: stream.ratio_between([0.1e-3, 0.5e-3]),
            slope: stream.between([0.05, 0.3]),
            anisotropy: stream.between([0.2, 0.8]),
        }
    }
}

impl DustDraw {
    fn draw(stream: &mut Stream) -> Self {
        let warmth = stream.between([0.0, 0.4]);
        let colour = stream.ratio_between([0.06, 0.45]) * DVec3::new(1.0, 1.0 - 0.4 * warmth, 1.0 - warmth);
        Self {
            colour,
            cover: stream.between([0.0, 0.35]),
            period_m: stream.ratio_between([2e-3, 50e-3]),
            offset: offset(stream),
        }
    }

    pub(crate) fn deposit(&self) -> Deposit {
        Deposit {
            material: Material { colour: self.colour.as_vec3(), roughness: 0.9, metallic: 0.0 },
            cover: self.cover as f32,
            period: self.period_m as f32,
            offset: self.offset.as_vec3(),
        }
    }
}

impl PanelDraw {
    fn draw(stream: &mut Stream) -> Self {
        let towards = outward(stream.between([0.0, std::f64::consts::TAU]), stream.between([0.35, 1.5]));
        let (sine, cosine) = stream.between([0.0, std::f64::consts::PI]).sin_cos();
        let side = towards.any_orthonormal_vector();
        let warmth = stream.between([-0.15, 0.2]);
        let radiance = stream.ratio_between([0.5, 4.0]) * DVec3::new(1.0 + warmth, 1.0, 1.0 - warmth);
        Self {
            towards,
            across: side * cosine + towards.cross(side) * sine,
            half: DVec2::new(stream.between([0.05, 0.6]), stream.between([0.05, 0.3])),
            radiance,
        }
    }

    pub(crate) fn panel(&self) -> LightPanel {
        LightPanel {
            towards: self.towards,
            across: self.across,
            half: self.half.as_vec2().to_array(),
            radiance: self.radiance.as_vec3(),
        }
    }
}

impl OpticsDraw {
    fn draw(stream: &mut Stream) -> Self {
        let (sine, cosine) = stream.between([0.0, std::f64::consts::TAU]).sin_cos();
        Self {
            aperture: stream.between([0.0, 8.0]),
            focus: stream.between([0.93, 1.07]),
            motion: stream.between([0.0, 2.0]) * DVec2::new(cosine, sine),
            vignetting: stream.between([0.0, 0.4]),
            balance: DVec3::new(stream.between([0.85, 1.15]), 1.0, stream.between([0.85, 1.15])),
        }
    }

    /// The optics for a picture of `height` pixels with the workpiece's middle at `depth` [m].
    pub(crate) fn optics(&self, height: usize, depth: f64) -> Optics {
        let scale = height as f64 / DRAWN_HEIGHT;
        Optics {
            // Drawn for a workpiece at 1 m: nearer ones are focused with the same relative blur.
            aperture: (self.aperture * scale * depth) as f32,
            focus: (self.focus * depth) as f32,
            motion: (self.motion * scale).as_vec2(),
            vignetting: self.vignetting as f32,
            balance: self.balance.as_vec3(),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_look_that_is_left_out_changes_no_other() {
        let all = LookDraws::draw(&Look::ALL, 7);
        for left_out in Look::ALL {
            let others: Vec<Look> = Look::ALL.into_iter().filter(|&look| look != left_out).collect();
            let draws = LookDraws::draw(&others, 7);
            let keep = |look: Look| look != left_out;
            assert_eq!(draws.part, all.part.filter(|_| keep(Look::Texture)));
            assert_eq!(draws.swirl, all.swirl.filter(|_| keep(Look::Swirl)));
            assert_eq!(draws.primer, all.primer.filter(|_| keep(Look::Primer)));
            assert_eq!(draws.panels.is_empty(), !keep(Look::Studio));
            assert_eq!(draws.optics, all.optics.filter(|_| keep(Look::Optics)));
            assert_eq!(draws.jpeg_quality, all.jpeg_quality.filter(|_| keep(Look::Compression)));
            assert_eq!(draws.clear_coat, all.clear_coat.filter(|_| keep(Look::ClearCoat)));
            assert_eq!(draws.dust, all.dust.filter(|_| keep(Look::Dust)));
            assert_eq!(draws.heat_tint, all.heat_tint.filter(|_| keep(Look::HeatTint)));
            assert_eq!(draws.rust, all.rust.filter(|_| keep(Look::Rust)));
            assert_eq!(draws.table_pattern, all.table_pattern.filter(|_| keep(Look::Table)));
        }
        assert_eq!(LookDraws::draw(&[], 7), LookDraws::default());
    }

    #[test]
    fn sides_of_panels_are_unit_vectors_across() {
        for seed in 0..50 {
            for panel in LookDraws::draw(&[Look::Studio], seed).panels {
                assert!(panel.towards.dot(panel.across).abs() < 1e-12 && (panel.across.length() - 1.0).abs() < 1e-12);
            }
        }
    }
}
