//! A pad.

use glam::DVec3;
use serde::Serialize;

use super::tool::Shape;

/// A flat disc that faces the part. It spins about its frame's z axis; its reference point is the centre of its face.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Pad {
    /// s [m].
    pub radius: f64,
}

impl Shape for Pad {
    #[inline(always)]
    fn depth(&self, at: DVec3) -> f64 {
        at.z
    }

    #[inline(always)]
    fn within(&self, at: DVec3) -> f64 {
        self.radius - (at.x * at.x + at.y * at.y).sqrt()
    }

    fn half_footprint(&self, _: f64) -> (f64, f64) {
        (self.radius, self.radius)
    }

    #[inline]
    fn rim_radius(&self) -> f64 {
        self.radius
    }

    fn width(&self) -> f64 {
        2.0 * self.radius
    }

    fn sizes(&self) -> Vec<(&'static str, f64)> {
        vec![("pad radius [m]", self.radius)]
    }
}
