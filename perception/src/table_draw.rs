//! Drawn patterns of the table: wood, steel, cloth.

use glam::{DVec2, DVec3};
use random::Stream;
use render::{Material, TableKind, TablePattern};
use serde::{Deserialize, Serialize};

/// A table with a pattern, in place of the plain one.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct TableDraw {
    /// Type.
    pub kind: TableKind,
    /// Linear RGB; reflectance of steel.
    pub colour: DVec3,
    /// Roughness, 0 to 1.
    pub roughness: f64,
    /// Width of a board, of a streak or of a thread [m].
    pub period_m: f64,
    /// Angle of boards, streaks or threads about the vertical [rad].
    pub turn: f64,
    /// Position of the pattern [periods].
    pub offset: DVec2,
    /// Greatest relative change of the colour, 0 to 1.
    pub contrast: f64,
}

impl TableDraw {
    pub(crate) fn draw(stream: &mut Stream) -> Self {
        let kind = TableKind::ALL[stream.below(TableKind::ALL.len())];
        let colour = match kind {
            TableKind::Wood => {
                let redness = stream.between([0.0, 1.0]);
                DVec3::new(1.0, 0.68, 0.40).lerp(DVec3::new(1.0, 0.5, 0.28), redness)
                    * stream.ratio_between([0.06, 0.5])
            }
            TableKind::Steel => DVec3::new(1.0, 1.01, 1.03) * stream.between([0.25, 0.6]),
            TableKind::Cloth => DVec3::from_array(std::array::from_fn(|_| stream.ratio_between([0.02, 0.6]))),
        };
        let (roughness, period_m, contrast) = match kind {
            TableKind::Wood => ([0.35, 0.8], [35e-3, 140e-3], [0.3, 0.7]),
            TableKind::Steel => ([0.2, 0.5], [0.2e-3, 0.8e-3], [0.1, 0.5]),
            TableKind::Cloth => ([0.85, 0.98], [0.6e-3, 4e-3], [0.2, 0.7]),
        };
        Self {
            kind,
            colour,
            roughness: stream.between(roughness),
            period_m: stream.ratio_between(period_m),
            turn: stream.between([0.0, std::f64::consts::TAU]),
            offset: DVec2::new(stream.between([-100.0, 100.0]), stream.between([-100.0, 100.0])),
            contrast: stream.between(contrast),
        }
    }

    pub(crate) fn pattern(self) -> TablePattern {
        let metallic = f32::from(u8::from(self.kind == TableKind::Steel));
        TablePattern {
            kind: self.kind,
            material: Material { colour: self.colour.as_vec3(), roughness: self.roughness as f32, metallic },
            period: self.period_m as f32,
            turn: self.turn as f32,
            offset: self.offset.as_vec2(),
            contrast: self.contrast as f32,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn all_types_are_drawn_and_only_steel_is_a_metal() {
        let draws: Vec<TableDraw> = (0..60).map(|seed| TableDraw::draw(&mut Stream::of(seed, "table"))).collect();
        for kind in TableKind::ALL {
            assert!(draws.iter().filter(|draw| draw.kind == kind).count() > 8, "{kind:?}");
        }
        for draw in draws {
            assert_eq!(draw.pattern().material.metallic > 0.0, draw.kind == TableKind::Steel);
            assert!(draw.colour.min_element() > 0.0 && draw.colour.max_element() < 0.7);
        }
    }
}
