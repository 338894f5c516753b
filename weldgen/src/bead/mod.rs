//! Beads: cross-sections, their closed forms, and the mesh swept along a weld curve.
//!
//! ```text
//!            .--'''--.            z = H (1 − (2y/w)²)
//!         .-'         '-.
//!   -----o---------------o-----   the surface: the toes are w apart
//!       /                 \
//!      '-------------------'      z = −root: flat, inside the part
//! ```

pub(crate) mod defect;
mod form;
pub(crate) mod loft;
mod sweep;

use std::f64::consts::{FRAC_PI_2, PI};

use serde::{Deserialize, Serialize};

pub use defect::{Defect, DefectKind};
pub(crate) use form::WIDEST_GROOVE;
pub use form::{BeadForm, Crater, FormRequest, MOST_DEFECTS, MOST_HOLES, Ripples, Weave};
pub use sweep::{BeadError, sweep, sweep_formed};

/// The outline of a bead's cross-section above the surface.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum BeadShape {
    /// `z = H (1 − (2y/w)²)`, the usual model of a bead on plate.
    #[default]
    Parabolic,
    /// The arc of a circle through toes and crown; H at most w/2.
    CircularSegment,
    /// `|2y/w|ⁿ + (z/H)ⁿ = 1` with n = 2.5: a flat crown and steep toes, as in a cold weld.
    Superellipse,
    /// In a corner: a parabola between toes that lie on both faces, above the chord (convex) or below it (concave).
    Fillet,
}

/// Exponent of the superellipse.
const EXPONENT: f64 = 2.5;
/// Segments of an outline from the crown to a toe.
const HALF_SEGMENTS: usize = 16;
/// Segments of an outline between a toe and the end of the root.
const ROOT_SEGMENTS: usize = 2;

/// A bead's cross-section, relative to the centreline: y to the left, z out of the part.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct BeadProfile {
    /// Distance between the toes, w [m].
    pub width: f64,
    /// Height of the crown above the centreline, H [m]; the throat of a fillet.
    pub height: f64,
    /// The outline.
    pub shape: BeadShape,
    /// Height of the toes above the centreline [m]: 0 on a face; in a corner, the height at which they meet the walls.
    pub toe_height: f64,
}

impl BeadProfile {
    /// A parabolic bead of the given width and height [m].
    pub fn parabolic(width: f64, height: f64) -> Self {
        Self::on_face(BeadShape::Parabolic, width, height)
    }

    /// A bead on a face, of the given width and height [m].
    pub fn on_face(shape: BeadShape, width: f64, height: f64) -> Self {
        Self { width, height, shape, toe_height: 0.0 }
    }

    /// A fillet in a corner.
    ///
    /// - `opening`: angle between the walls [rad]
    /// - `convexity`: rise of its face above the chord between the toes [widths]; concave below 0
    pub fn fillet(width: f64, opening: f64, convexity: f64) -> Self {
        let toe_height = 0.5 * width / (0.5 * opening).tan();
        Self { width, height: toe_height + convexity * width, shape: BeadShape::Fillet, toe_height }
    }

    /// Height z [m] of the outline at `y` [m] from the centreline. Parabola and circle continue below the toes.
    pub fn height_at(&self, y: f64) -> f64 {
        let (share, rise) = ((2.0 * y / self.width).abs(), self.height - self.toe_height);
        self.toe_height
            + match self.shape {
                BeadShape::Parabolic => rise * (1.0 - share * share),
                BeadShape::Fillet => rise * (1.0 - share * share).max(0.0),
                BeadShape::CircularSegment => self.circle_height(y),
                BeadShape::Superellipse => rise * (1.0 - share.powf(EXPONENT)).max(0.0).powf(1.0 / EXPONENT),
            }
    }

    /// Radius of the circle through toes and crown [m].
    fn circle_radius(&self) -> f64 {
        (0.25 * self.width * self.width + self.height * self.height) / (2.0 * self.height)
    }

    fn circle_height(&self, y: f64) -> f64 {
        let radius = self.circle_radius();
        (radius * radius - y * y).max(0.0).sqrt() - (radius - self.height)
    }

    /// Contact angle [rad]: angle between the surface and the outline at a toe on a face.
    pub fn toe_angle(&self) -> f64 {
        match self.shape {
            BeadShape::Parabolic => (4.0 * self.height / self.width).atan(),
            BeadShape::CircularSegment => 2.0 * (2.0 * self.height / self.width).atan(),
            BeadShape::Superellipse => FRAC_PI_2,
            BeadShape::Fillet => {
                let half_opening = (0.5 * self.width).atan2(self.toe_height);
                FRAC_PI_2 - half_opening + (4.0 * (self.height - self.toe_height) / self.width).atan()
            }
        }
    }

    /// Radius r [m] of the field's smooth union (`sdf_bake::Combine::SmoothUnion`) that rounds the toes to a radius of
    /// at least `toe_radius` [m].
    ///
    /// Between two planes at the toe angle α the blend is a parabola, (φ+ψ)/2 = r/4 + (φ−ψ)²/(4r); its least radius of
    /// curvature is r cos(α/2) / (2 sin²(α/2)).
    pub fn blend_radius(&self, toe_radius: f64) -> f64 {
        let half_angle = 0.5 * self.toe_angle();
        2.0 * toe_radius * half_angle.sin().powi(2) / half_angle.cos()
    }

    /// Distance y [m] from the centreline that the bead reaches at a root depth [m].
    pub fn half_width_at(&self, depth: f64) -> f64 {
        let toe = 0.5 * self.width;
        match self.shape {
            BeadShape::Parabolic => toe * (1.0 + depth / self.height).sqrt(),
            BeadShape::CircularSegment => {
                let (radius, below) = (self.circle_radius(), self.circle_radius() - self.height - depth);
                (radius * radius - below.max(0.0).powi(2)).sqrt()
            }
            BeadShape::Superellipse => toe,
            // The outline continues into both walls to the root's depth.
            BeadShape::Fillet => toe + depth,
        }
    }

    /// Points (y, z) [m] of the left half of the outline, from the crown to the end of the root.
    pub(crate) fn half_outline(&self, root_depth: f64) -> Vec<(f64, f64)> {
        let (toe, base) = (0.5 * self.width, self.half_width_at(root_depth));
        let above = (0..=HALF_SEGMENTS).map(|i| {
            let share = i as f64 / HALF_SEGMENTS as f64;
            match self.shape {
                // Even steps in the angle, because the outline is vertical at the toe.
                BeadShape::Superellipse => {
                    let (sin, cos) = (FRAC_PI_2 * share).sin_cos();
                    let power = 2.0 / EXPONENT;
                    (toe * sin.powf(power), self.height * if i == HALF_SEGMENTS { 0.0 } else { cos.powf(power) })
                }
                _ => (toe * share, self.height_at(toe * share)),
            }
        });
        let below = (1..=ROOT_SEGMENTS).map(|i| {
            let share = i as f64 / ROOT_SEGMENTS as f64;
            let y = toe + (base - toe) * share;
            match self.shape {
                BeadShape::Parabolic => (y, self.height_at(y)),
                BeadShape::Fillet => (y, self.toe_height),
                BeadShape::CircularSegment | BeadShape::Superellipse => {
                    let z = -root_depth * share;
                    (self.half_width_at(-z), z)
                }
            }
        });
        above.chain(below).collect()
    }

    /// Area [m²] of the section down to the root.
    ///
    /// A parabola's is 4/3 b (H + root), with b half the width of its base; those of the others are areas of polygons.
    pub fn section_area(&self, root_depth: f64) -> f64 {
        if self.shape == BeadShape::Parabolic {
            return 4.0 / 3.0 * self.half_width_at(root_depth) * (self.height + root_depth);
        }
        let mut half = self.half_outline(root_depth);
        half.push((0.0, -root_depth));
        let doubled: f64 = (0..half.len()).map(|i| cross(half[i], half[(i + 1) % half.len()])).sum();
        doubled.abs()
    }

    /// Volume [m³] of the bead on a flat surface: the section swept along `length` [m], and half of its solid of
    /// revolution at each end.
    ///
    /// By Pappus' theorem the relevant length is that of the path of the section's centroid. A symmetric section's
    /// centroid is on the centreline, so curvature within the plane changes nothing.
    pub fn swept_volume(&self, length: f64, root_depth: f64) -> f64 {
        self.section_area(root_depth) * length + self.end_volume(root_depth)
    }

    /// Volume [m³] of both ends: one revolution of half the section about the normal; for a fillet, the section
    /// shrinking along a half ellipse.
    fn end_volume(&self, root_depth: f64) -> f64 {
        match self.shape {
            BeadShape::Parabolic => 0.5 * PI * self.half_width_at(root_depth).powi(2) * (self.height + root_depth),
            BeadShape::Fillet => 2.0 * self.section_area(root_depth) * 0.5 * self.width * 2.0 / 3.0,
            _ => {
                let mut half = self.half_outline(root_depth);
                half.push((0.0, -root_depth));
                // Pappus and Guldin, edge by edge: 2π times the moment about the axis.
                let moments = (0..half.len()).map(|i| {
                    let (one, other) = (half[i], half[(i + 1) % half.len()]);
                    cross(one, other) * (one.0 + other.0) / 6.0
                });
                2.0 * PI * moments.sum::<f64>().abs()
            }
        }
    }
}

fn cross(a: (f64, f64), b: (f64, f64)) -> f64 {
    a.0 * b.1 - a.1 * b.0
}
