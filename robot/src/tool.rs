//! The tool that presses on the workpiece. Each shape has a file of its own.

use glam::DVec3;

use super::{FieldTool, Pad, Sphere, Wheel};

/// Geometry of a tool in its own frame.
pub trait Shape {
    /// Depth [m] of a point below the working surface, along that surface's normal.
    fn depth(&self, at: DVec3) -> f64;

    /// Distance [m] of a point inside the border of the working surface; negative outside, infinite without a border.
    #[inline]
    fn within(&self, _at: DVec3) -> f64 {
        f64::INFINITY
    }

    /// Axis of the spindle.
    #[inline(always)]
    fn axis(&self) -> DVec3 {
        DVec3::Z
    }

    /// Curvature of the working surface along the circumference of a wheel or ball, and the sum of both principal
    /// curvatures [1/m]; 0 if the surface is flat or known only as a field.
    fn curvatures(&self) -> [f64; 2] {
        [0.0; 2]
    }

    /// Bulge [m]: excess of the depth of a surface point in the middle of a tool motion over the mean of both ends.
    /// `along` and `across` are the squared components of the motion along x and y [m²].
    fn bulge(&self, _along: f64, _across: f64) -> f64 {
        0.0
    }

    /// Distance [m] from the reference point down to the lowest point.
    fn drop(&self) -> f64 {
        0.0
    }

    /// Half length along the feed and across it [m] of the part of the tool that can touch a surface `sink` [m] above
    /// the lowest point.
    fn half_footprint(&self, sink: f64) -> (f64, f64);

    /// Radius [m] that multiplies the spindle speed to give the nominal rim speed.
    fn rim_radius(&self) -> f64;

    /// Width [m] across the feed.
    fn width(&self) -> f64;

    /// Sizes that must be positive and finite, with their names.
    fn sizes(&self) -> Vec<(&'static str, f64)>;
}

/// Half width [m] of a ball or wheel of a radius [m] at a height of `sink` [m] above its lowest point.
pub(crate) fn cap(radius: f64, sink: f64) -> f64 {
    (2.0 * radius * sink.min(radius)).sqrt().min(radius)
}

/// A tool of any known shape.
#[derive(Clone, Debug, PartialEq)]
pub enum Tool {
    /// A wheel that spins about the frame's y axis; its reference point is its centre.
    Wheel(Wheel),
    /// A disc that spins about the frame's z axis; its reference point is the centre of its face.
    Pad(Pad),
    /// A ball tip; its reference point is its centre.
    Sphere(Sphere),
    /// Arbitrary shape; its reference point is the origin of its field.
    Field(FieldTool),
}

/// Names of a shape's sizes [m] in one-line notation, and its tool of given sizes.
pub(crate) type Notation = (&'static [&'static str], fn(&[f64]) -> Tool);

impl Tool {
    /// Shapes with a one-line notation, by name.
    pub(crate) const NOTATIONS: [(&str, Notation); 3] = [
        ("wheel", (&["radius", "width"], |sizes| Wheel::cylinder(sizes[0], sizes[1]).into())),
        ("pad", (&["radius"], |sizes| Pad { radius: sizes[0] }.into())),
        ("sphere", (&["radius"], |sizes| Sphere { radius: sizes[0] }.into())),
    ];
}

impl From<Wheel> for Tool {
    fn from(wheel: Wheel) -> Self {
        Self::Wheel(wheel)
    }
}

impl From<Pad> for Tool {
    fn from(pad: Pad) -> Self {
        Self::Pad(pad)
    }
}

impl From<Sphere> for Tool {
    fn from(sphere: Sphere) -> Self {
        Self::Sphere(sphere)
    }
}

impl Tool {
    #[inline(always)]
    fn shape(&self) -> &dyn Shape {
        match self {
            Self::Wheel(wheel) => wheel,
            Self::Pad(pad) => pad,
            Self::Sphere(sphere) => sphere,
            Self::Field(tool) => tool,
        }
    }

    /// As [`Shape::depth`].
    #[inline]
    pub fn depth(&self, at: DVec3) -> f64 {
        match self {
            Self::Wheel(wheel) => wheel.depth(at),
            Self::Pad(pad) => pad.depth(at),
            Self::Sphere(sphere) => sphere.depth(at),
            Self::Field(tool) => tool.depth(at),
        }
    }

    /// As [`Shape::within`].
    #[inline]
    pub fn within(&self, at: DVec3) -> f64 {
        match self {
            Self::Wheel(wheel) => wheel.within(at),
            Self::Pad(pad) => pad.within(at),
            Self::Sphere(sphere) => sphere.within(at),
            Self::Field(tool) => tool.within(at),
        }
    }

    /// Axis of the spindle in the tool's frame.
    #[inline(always)]
    fn axis(&self) -> DVec3 {
        match self {
            Self::Wheel(wheel) => wheel.axis(),
            Self::Pad(pad) => pad.axis(),
            Self::Sphere(sphere) => sphere.axis(),
            Self::Field(tool) => tool.axis(),
        }
    }

    /// Speed [m/s] of the working surface over the workpiece at a point of the tool's frame, for a `spindle` [rad/s]
    /// and a `feed` in the tool's frame [m/s]: `|ω × r + v_feed|`.
    #[inline(always)]
    pub fn slip_speed(&self, at: DVec3, spindle: f64, feed: DVec3) -> f64 {
        self.slip_velocity(at, spindle, feed).length()
    }

    /// The velocity itself, in the tool's frame [m/s].
    #[inline(always)]
    pub fn slip_velocity(&self, at: DVec3, spindle: f64, feed: DVec3) -> DVec3 {
        self.axis().cross(at) * spindle + feed
    }

    /// As [`Shape::curvatures`].
    pub fn curvatures(&self) -> [f64; 2] {
        self.shape().curvatures()
    }

    /// As [`Shape::bulge`].
    pub fn bulge(&self, along: f64, across: f64) -> f64 {
        self.shape().bulge(along, across)
    }

    /// As [`Shape::drop`].
    pub fn drop(&self) -> f64 {
        self.shape().drop()
    }

    /// As [`Shape::half_footprint`].
    pub fn half_footprint(&self, sink: f64) -> (f64, f64) {
        self.shape().half_footprint(sink)
    }

    /// As [`Shape::rim_radius`].
    #[inline]
    pub fn rim_radius(&self) -> f64 {
        match self {
            Self::Wheel(wheel) => wheel.rim_radius(),
            Self::Pad(pad) => pad.rim_radius(),
            Self::Sphere(sphere) => sphere.rim_radius(),
            Self::Field(tool) => tool.rim_radius(),
        }
    }

    /// As [`Shape::width`].
    pub fn width(&self) -> f64 {
        self.shape().width()
    }

    /// The first size that is not positive and finite, with its name.
    pub fn bad_size(&self) -> Option<(&'static str, f64)> {
        self.shape().sizes().into_iter().find(|(_, size)| !(*size > 0.0 && size.is_finite()))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn depth_is_measured_from_the_working_surface_and_ends_at_its_border() {
        let wheel = Tool::from(Wheel { radius: 0.05, width: 0.02, crown: 2.0 });
        assert!((wheel.depth(DVec3::new(0.0, 0.3, -0.049)) - (0.001 - 0.09)).abs() < 1e-12);
        assert!((wheel.within(DVec3::new(0.0, -0.004, 0.0)) - 0.006).abs() < 1e-15);
        let pad = Tool::from(Pad { radius: 0.025 });
        assert_eq!(pad.depth(DVec3::new(0.01, 0.0, 2e-5)), 2e-5);
        assert!(pad.within(DVec3::new(0.02, 0.02, 0.0)) < 0.0);
    }

    #[test]
    fn slip_is_the_sum_of_turning_and_feed() {
        // The lowest point of a wheel that spins about +y moves along -x.
        let wheel = Tool::from(Wheel::cylinder(0.05, 0.02));
        assert!(
            (wheel.slip_speed(DVec3::new(0.0, 0.0, -0.05), 600.0, DVec3::X * 0.005) - (30.0 - 0.005)).abs() < 1e-12
        );
        let pad = Tool::from(Pad { radius: 0.025 });
        let slip = pad.slip_speed(DVec3::new(0.003, 0.02, 0.0), 300.0, DVec3::X * 0.04);
        assert!((slip - (0.04f64 - 6.0).hypot(0.9)).abs() < 1e-12);
    }
}
