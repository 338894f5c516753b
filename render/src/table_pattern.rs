//! Patterns of a table: boards of wood, brushed sheet with scratches, woven cloth. On the CPU only.

use std::f32::consts::PI;

use glam::{Vec2, Vec3};
use serde::{Deserialize, Serialize};

use super::material::Material;
use super::shade::smooth_step;
use super::texture::{cell, noise_at, unit};

/// Length of a board and of a brush's streak relative to their width.
const BOARD: f32 = 8.0;
const STREAK: f32 = 120.0;
/// Width of a joint between boards relative to that of a board.
const JOINT: f32 = 0.02;
/// Period of the grain relative to the width of a board, along it and across.
const GRAIN: Vec2 = Vec2::new(1.2, 0.04);
/// Greatest angle between a scratch and the streaks [rad].
const ASTRAY: f32 = 0.7;
/// Pixels for each period below which a pattern fades, so that it does not alias; at twice as many it is complete.
const LEAST_PIXELS: f32 = 2.0;

/// Type of a table's top.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum TableKind {
    /// Boards with grain and joints.
    Wood,
    /// Brushed steel with scratches.
    Steel,
    /// Plain weave.
    Cloth,
}

impl TableKind {
    /// All types.
    pub const ALL: [Self; 3] = [Self::Wood, Self::Steel, Self::Cloth];
}

/// Pattern of a table's top.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TablePattern {
    /// Type.
    pub kind: TableKind,
    /// Material, varied by the pattern.
    pub material: Material,
    /// Width of a board, of a streak or of a thread [m].
    pub period: f32,
    /// Angle of boards, streaks or threads about the vertical [rad].
    pub turn: f32,
    /// Position of the pattern [periods].
    pub offset: Vec2,
    /// Greatest relative change of the colour, 0 to 1.
    pub contrast: f32,
}

impl TablePattern {
    /// Material at a point of the table's plane [m]; `footprint`: size of a pixel there [m].
    #[inline(always)]
    pub(crate) fn material(&self, point: Vec2, footprint: f32) -> Material {
        let at = Vec2::from_angle(-self.turn).rotate(point) / self.period + self.offset;
        let pixel = footprint / self.period;
        let (value, roughness) = match self.kind {
            TableKind::Wood => wood(at, pixel),
            TableKind::Steel => steel(at, pixel),
            TableKind::Cloth => cloth(at, pixel),
        };
        Material {
            colour: self.material.colour * (1.0 + self.contrast * value.clamp(-1.0, 1.0)),
            roughness: (self.material.roughness + roughness).clamp(0.05, 1.0),
            ..self.material
        }
    }
}

/// Share of a pattern that can be seen where a pixel covers so much of its period.
#[inline(always)]
fn visible(pixel: f32) -> f32 {
    smooth_step(LEAST_PIXELS, 2.0 * LEAST_PIXELS, 1.0 / pixel.max(1e-6))
}

/// Noise of the plane, −1 to 1.
#[inline(always)]
fn noise(at: Vec2, layer: f32) -> f32 {
    noise_at(at.extend(layer))
}

/// Boards laid in half bond: each has its own tone and grain, with dark joints. Relative colour, change of roughness.
#[inline(always)]
fn wood(at: Vec2, pixel: f32) -> (f32, f32) {
    let row = at.y.floor();
    let along = at.x / BOARD + if row.rem_euclid(2.0) < 1.0 { 0.0 } else { 0.5 };
    let board = Vec2::new(along.floor(), row);
    let [tone, layer, _] = cell(board.extend(3.0)).map(unit);
    let grain = noise(at / GRAIN, 50.0 * layer) * visible(pixel / GRAIN.y);
    // Rings of the trunk, wider than the grain.
    let rings = noise(at / (6.0 * GRAIN), 50.0 * layer + 20.0);
    let from_edge = |share: f32| share.min(1.0 - share);
    let joint = from_edge(at.y - row).min(BOARD * from_edge(along - along.floor()));
    let width = JOINT.max(0.5 * pixel);
    let dark = (1.0 - smooth_step(0.5 * width, width, joint)) * (JOINT / width);
    let value = 0.35 * (2.0 * tone - 1.0) + 0.4 * grain + 0.3 * rings;
    (value * (1.0 - dark) - dark, 0.1 * grain + 0.1 * dark)
}

/// Streaks of a brush, and scratches that cross them.
#[inline(always)]
fn steel(at: Vec2, pixel: f32) -> (f32, f32) {
    let stretched = |at: Vec2, width: f32| at / Vec2::new(STREAK * width, width);
    let streaks =
        noise(stretched(at, 1.0), 0.0) * visible(pixel) + noise(stretched(at, 9.0), 7.0) * visible(pixel / 9.0);
    let scratch = |angle: f32, layer: f32| {
        let value = noise(stretched(Vec2::from_angle(angle).rotate(at), 4.0), layer);
        smooth_step(0.72, 0.8, value) * visible(pixel / 2.0)
    };
    let scratches = scratch(ASTRAY, 31.0).max(scratch(-0.4 * ASTRAY, 43.0));
    let stains = noise(at / 200.0, 61.0);
    (0.4 * streaks + 0.2 * stains + 0.5 * scratches, 0.08 * stains - 0.1 * scratches)
}

/// Threads that go over and under each other.
#[inline(always)]
fn cloth(at: Vec2, pixel: f32) -> (f32, f32) {
    let thread = at.floor();
    let within = at - thread;
    let is_warp = (thread.x + thread.y).rem_euclid(2.0) < 1.0;
    let (across, along) = if is_warp { (within.x, within.y) } else { (within.y, within.x) };
    let round = (PI * across).sin() * (0.5 + 0.5 * (PI * along).sin());
    let [tone, ..] =
        cell(Vec3::new(if is_warp { thread.x } else { thread.y }, f32::from(u8::from(is_warp)), 9.0)).map(unit);
    let folds = noise(at / 60.0, 5.0);
    let weave = (round - 0.45 + 0.5 * (tone - 0.5)) * visible(pixel);
    (0.8 * weave + 0.25 * folds, 0.0)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn pattern(kind: TableKind, period: f32) -> TablePattern {
        let material = Material { colour: Vec3::splat(0.3), roughness: 0.5, metallic: 0.0 };
        TablePattern { kind, material, period, turn: 0.3, offset: Vec2::new(3.3, -7.1), contrast: 0.5 }
    }

    /// Mean and standard deviation of the relative brightness along a line, in steps of a third of the period.
    fn spread(pattern: &TablePattern, footprint: f32) -> (f32, f32) {
        let value = |i: u16| {
            let point = Vec2::new(0.31, 0.17) * (pattern.period * f32::from(i));
            pattern.material(point, footprint).colour.y / pattern.material.colour.y
        };
        let mean = (0..4000).map(value).sum::<f32>() / 4000.0;
        (mean, ((0..4000).map(|i| (value(i) - mean).powi(2)).sum::<f32>() / 4000.0).sqrt())
    }

    #[test]
    fn patterns_vary_within_their_contrast_about_the_material() {
        for kind in TableKind::ALL {
            let (mean, deviation) = spread(&pattern(kind, 0.002), 1e-5);
            assert!((mean - 1.0).abs() < 0.15 && (0.03..0.4).contains(&deviation), "{kind:?}: {mean} ± {deviation}");
        }
    }

    #[test]
    fn threads_and_streaks_finer_than_pixels_fade() {
        for kind in [TableKind::Steel, TableKind::Cloth] {
            let [near, far] = [1e-5, 0.02].map(|footprint| spread(&pattern(kind, 0.002), footprint).1);
            assert!(far < 0.7 * near, "{kind:?}: {near} near, {far} far");
        }
    }

    #[test]
    fn boards_have_joints_as_far_apart_as_they_are_wide() {
        let boards = TablePattern { turn: 0.0, offset: Vec2::ZERO, ..pattern(TableKind::Wood, 0.1) };
        let dark = |y: f32| boards.material(Vec2::new(0.33, y), 1e-4).colour.y < 0.52 * 0.3;
        let joints: Vec<i32> = (1..10_000).filter(|&i| dark(1e-4 * i as f32) && !dark(1e-4 * (i - 1) as f32)).collect();
        assert_eq!(joints.len(), 10, "{joints:?}");
        assert!(joints.windows(2).all(|pair| (pair[1] - pair[0] - 1000).abs() < 20), "{joints:?}");
    }
}
