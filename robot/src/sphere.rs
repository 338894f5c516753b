//! A ball tip.

use glam::DVec3;
use serde::Serialize;

use super::tool::{Shape, cap};

/// A ball tip. Its reference point is its centre.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Sphere {
    /// [m]
    pub radius: f64,
}

impl Shape for Sphere {
    #[inline]
    fn depth(&self, at: DVec3) -> f64 {
        self.radius - at.length()
    }

    fn curvatures(&self) -> [f64; 2] {
        [1.0 / self.radius, 2.0 / self.radius]
    }

    fn bulge(&self, along: f64, across: f64) -> f64 {
        (along + across) / (8.0 * self.radius)
    }

    fn drop(&self) -> f64 {
        self.radius
    }

    fn half_footprint(&self, sink: f64) -> (f64, f64) {
        (cap(self.radius, sink), cap(self.radius, sink))
    }

    #[inline]
    fn rim_radius(&self) -> f64 {
        self.radius
    }

    fn width(&self) -> f64 {
        2.0 * self.radius
    }

    fn sizes(&self) -> Vec<(&'static str, f64)> {
        vec![("sphere radius [m]", self.radius)]
    }
}
