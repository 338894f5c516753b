//! Beads: cross-sections, their closed forms, and the mesh swept along a weld curve.
//!
//! ```text
//!            .--'''--.            z = H (1 − (2y/w)²)
//!         .-'         '-.
//!   -----o---------------o-----   the surface: the toes are w apart
//!       /                 \
//!      '-------------------'      z = −root: flat, inside the part
//! ```

mod sweep;

use std::f64::consts::PI;

use serde::{Deserialize, Serialize};

pub use sweep::{BeadError, sweep};

/// The outline of a bead's cross-section above the surface.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum BeadShape {
    /// `z = H (1 − (2y/w)²)`, the usual model of a bead on plate.
    #[default]
    Parabolic,
}

/// A bead's cross-section, relative to the tangent plane at its centreline: y to the left, z out of the part.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct BeadProfile {
    /// Distance between the toes on flat ground, w [m].
    pub width: f64,
    /// Height of the crown above the surface, H [m].
    pub height: f64,
    /// The outline.
    pub shape: BeadShape,
}

impl BeadProfile {
    /// A parabolic bead of the given width and height [m].
    pub fn parabolic(width: f64, height: f64) -> Self {
        Self { width, height, shape: BeadShape::Parabolic }
    }

    /// Height z [m] of the outline at `y` [m] from the centreline; negative beyond the toes.
    pub fn height_at(&self, y: f64) -> f64 {
        match self.shape {
            BeadShape::Parabolic => self.height * (1.0 - (2.0 * y / self.width).powi(2)),
        }
    }

    /// Distance y [m] from the centreline at which the outline has sunk to `-depth` [m].
    pub fn half_width_at(&self, depth: f64) -> f64 {
        match self.shape {
            BeadShape::Parabolic => 0.5 * self.width * (1.0 + depth / self.height).sqrt(),
        }
    }

    /// Area [m²] of the section between the outline and `z = -root_depth` [m].
    pub fn section_area(&self, root_depth: f64) -> f64 {
        match self.shape {
            BeadShape::Parabolic => 4.0 / 3.0 * self.half_width_at(root_depth) * (self.height + root_depth),
        }
    }

    /// Volume [m³] of the bead on flat ground: the section along `length` [m], and half of its solid of revolution at
    /// each end.
    ///
    /// By Pappus' theorem the length is that of the path of the section's centroid; a symmetric section's centroid is
    /// on the centreline, so curvature within the plane changes nothing.
    pub fn swept_volume(&self, length: f64, root_depth: f64) -> f64 {
        let radius = self.half_width_at(root_depth);
        let caps = match self.shape {
            BeadShape::Parabolic => 0.5 * PI * radius * radius * (self.height + root_depth),
        };
        self.section_area(root_depth) * length + caps
    }
}
