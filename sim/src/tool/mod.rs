//! The tool: what presses on the workpiece, and where it stands.
//!
//! Every tool is known by two functions of a point in its own frame (y across the feed, z away from the part, x = y × z): how
//! deep the point lies below the working surface, and how far it lies within the working surface's border. Side
//! walls do not work.

mod mesh;
mod pose;

pub use mesh::MeshDepth;
pub use pose::{Frame, Placement, Pose};

use std::sync::Arc;

use glam::DVec3;
use sdf_bake::BrickGrid;
use serde::Serialize;

/// A grinding wheel whose rim works.
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

/// A flat disc that faces the part and spins about its own normal.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Pad {
    /// s [m].
    pub radius: f64,
}

/// A tool from a mesh, baked into a field of its own.
///
/// With the mesh itself its depth is exact; by the field alone it is linear between voxels, which rounds edges, and
/// ends at the band: bake that wider than the deepest press.
#[derive(Clone, Debug)]
pub struct FieldTool {
    /// The tool in its own frame, its lowest point at the origin, inside negative.
    pub field: Arc<BrickGrid>,
    /// Lowest corner of the tool's box in its own frame [m].
    pub low: DVec3,
    /// Highest corner [m].
    pub high: DVec3,
    /// The mesh itself in the tool's frame, if it has no walls inside.
    pub mesh: Option<Arc<MeshDepth>>,
}

/// What presses on the workpiece.
#[derive(Clone, Debug)]
pub enum Tool {
    /// A wheel that turns about the frame's y axis; its reference point is its centre.
    Wheel(Wheel),
    /// A disc that turns about the frame's z axis; its reference point is the centre of its face.
    Pad(Pad),
    /// A ball tip of a radius [m]; its reference point is its centre.
    Sphere(f64),
    /// Any shape; its reference point is the origin of its field.
    Field(FieldTool),
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

impl Tool {
    /// Curvature of the working surface round a wheel or a ball, and the sum of both principal curvatures [1/m]; 0 where it is flat
    /// or known as a field alone.
    pub fn curvatures(&self) -> [f64; 2] {
        match self {
            Self::Wheel(Wheel { radius, crown, .. }) => [1.0 / radius, 1.0 / radius + crown],
            Self::Sphere(radius) => [1.0 / radius, 2.0 / radius],
            Self::Pad(_) | Self::Field(_) => [0.0; 2],
        }
    }

    /// By how much a point of the surface lies deeper in the middle of a `way` [m] of the tool than the mean of both ends [m].
    pub fn bulge(&self, pose: &Pose, way: DVec3) -> f64 {
        let (along, across) = (way.dot(pose.frame.x).powi(2), way.dot(pose.frame.y).powi(2));
        match self {
            Self::Wheel(Wheel { radius, crown, .. }) => (along / radius + across * crown) / 8.0,
            Self::Sphere(radius) => (along + across) / (8.0 * radius),
            Self::Pad(_) | Self::Field(_) => 0.0,
        }
    }

    /// Depth [m] of a point of the tool's frame below the working surface, along that surface's normal.
    pub fn depth(&self, at: DVec3) -> f64 {
        match self {
            Self::Wheel(wheel) => wheel.radius - 0.5 * wheel.crown * at.y * at.y - (at.x * at.x + at.z * at.z).sqrt(),
            Self::Pad(_) => at.z,
            Self::Sphere(radius) => radius - at.length(),
            Self::Field(tool) => match &tool.mesh {
                Some(mesh) => mesh.depth(at, &tool.field),
                None => -f64::from(tool.field.sample(at)),
            },
        }
    }

    /// How far [m] a point of the tool's frame lies within the border of the working surface; negative beside it.
    pub fn within(&self, at: DVec3) -> f64 {
        match self {
            Self::Wheel(wheel) => 0.5 * wheel.width - at.y.abs(),
            Self::Pad(pad) => pad.radius - (at.x * at.x + at.y * at.y).sqrt(),
            Self::Sphere(_) | Self::Field(_) => f64::INFINITY,
        }
    }

    /// Distance [m] from the reference point down to the lowest point.
    pub fn drop(&self) -> f64 {
        match self {
            Self::Wheel(wheel) => wheel.radius,
            Self::Sphere(radius) => *radius,
            Self::Pad(_) | Self::Field(_) => 0.0,
        }
    }

    /// Half length along the feed and across it [m] of what can touch a surface `sink` [m] above the lowest point.
    pub fn half_footprint(&self, sink: f64) -> (f64, f64) {
        let cap = |radius: f64| (2.0 * radius * sink.min(radius)).sqrt().min(radius);
        match self {
            Self::Wheel(wheel) => (cap(wheel.radius), 0.5 * wheel.width),
            Self::Pad(pad) => (pad.radius, pad.radius),
            Self::Sphere(radius) => (cap(*radius), cap(*radius)),
            Self::Field(tool) => {
                let reach = tool.low.abs().max(tool.high.abs());
                (reach.x, reach.y)
            }
        }
    }

    /// Speed [m/s] of the working surface over the workpiece at a point of the tool's frame, for a `spindle` [rad/s] and a
    /// `feed` in the tool's frame [m/s]: `|ω × r + v_feed|`.
    #[inline(always)]
    pub fn slip_speed(&self, at: DVec3, spindle: f64, feed: DVec3) -> f64 {
        (self.axis().cross(at) * spindle + feed).length()
    }

    /// Axis of the spindle in the tool's frame.
    #[inline(always)]
    fn axis(&self) -> DVec3 {
        if matches!(self, Self::Wheel(_)) { DVec3::Y } else { DVec3::Z }
    }

    /// Radius [m] that turns a spindle speed into the nominal rim speed.
    pub fn rim_radius(&self) -> f64 {
        match self {
            Self::Wheel(wheel) => wheel.radius,
            Self::Pad(pad) => pad.radius,
            Self::Sphere(radius) => *radius,
            Self::Field(tool) => tool.low.abs().max(tool.high.abs()).truncate().max_element(),
        }
    }

    /// Width [m] across the feed.
    pub fn width(&self) -> f64 {
        match self {
            Self::Wheel(wheel) => wheel.width,
            Self::Pad(pad) => 2.0 * pad.radius,
            Self::Sphere(radius) => 2.0 * radius,
            Self::Field(tool) => tool.high.y - tool.low.y,
        }
    }

    /// The first size that is not positive and finite, with its name.
    pub fn bad_size(&self) -> Option<(&'static str, f64)> {
        let sizes = match self {
            Self::Wheel(wheel) => vec![("wheel radius [m]", wheel.radius), ("wheel width [m]", wheel.width)],
            Self::Pad(pad) => vec![("pad radius [m]", pad.radius)],
            Self::Sphere(radius) => vec![("sphere radius [m]", *radius)],
            Self::Field(tool) => vec![("tool field voxel [m]", tool.field.voxel)],
        };
        sizes.into_iter().find(|(_, size)| !(*size > 0.0 && size.is_finite()))
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
        // The lowest point of a wheel that turns about +y moves along -x.
        let wheel = Tool::from(Wheel::cylinder(0.05, 0.02));
        assert!(
            (wheel.slip_speed(DVec3::new(0.0, 0.0, -0.05), 600.0, DVec3::X * 0.005) - (30.0 - 0.005)).abs() < 1e-12
        );
        let pad = Tool::from(Pad { radius: 0.025 });
        let slip = pad.slip_speed(DVec3::new(0.003, 0.02, 0.0), 300.0, DVec3::X * 0.04);
        assert!((slip - (0.04f64 - 6.0).hypot(0.9)).abs() < 1e-12);
    }
}
