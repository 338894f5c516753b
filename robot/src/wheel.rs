//! A wheel.

use glam::DVec3;
use serde::Serialize;

use super::tool::{Shape, cap};

/// A grinding wheel that cuts with its rim. It spins about its frame's y axis; its reference point is its centre.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Wheel {
    /// R [m], at mid width.
    pub radius: f64,
    /// b [m], along the axis.
    pub width: f64,
    /// Curvature of the rim along the axis, 1/R_c [1/m]: the radius at y is `R - y²/(2 R_c)`. 0 for a cylinder.
    pub crown: f64,
}

impl Wheel {
    /// A cylinder.
    pub const fn cylinder(radius: f64, width: f64) -> Self {
        Self { radius, width, crown: 0.0 }
    }
}

impl Shape for Wheel {
    #[inline(always)]
    fn depth(&self, at: DVec3) -> f64 {
        self.radius - 0.5 * self.crown * at.y * at.y - (at.x * at.x + at.z * at.z).sqrt()
    }

    #[inline(always)]
    fn within(&self, at: DVec3) -> f64 {
        0.5 * self.width - at.y.abs()
    }

    #[inline(always)]
    fn axis(&self) -> DVec3 {
        DVec3::Y
    }

    fn curvatures(&self) -> [f64; 2] {
        [1.0 / self.radius, 1.0 / self.radius + self.crown]
    }

    fn bulge(&self, along: f64, across: f64) -> f64 {
        (along / self.radius + across * self.crown) / 8.0
    }

    fn drop(&self) -> f64 {
        self.radius
    }

    fn half_footprint(&self, sink: f64) -> (f64, f64) {
        (cap(self.radius, sink), 0.5 * self.width)
    }

    #[inline]
    fn rim_radius(&self) -> f64 {
        self.radius
    }

    fn width(&self) -> f64 {
        self.width
    }

    fn sizes(&self) -> Vec<(&'static str, f64)> {
        vec![("wheel radius [m]", self.radius), ("wheel width [m]", self.width)]
    }
}
