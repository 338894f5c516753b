//! The tool: a grinding wheel whose cylindrical face works, and where it stands.

use glam::DVec3;
use serde::Serialize;

/// A rigid cylinder that turns about its axis. Its side faces do not work.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Wheel {
    /// R [m].
    pub radius: f64,
    /// b [m], along the axis.
    pub width: f64,
}

/// Where a wheel stands in the workpiece's frame.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Pose {
    /// Centre of the wheel [m].
    pub centre: DVec3,
    /// Approach axis, unit, out of the part: the tool presses against it and lifts along it.
    pub approach: DVec3,
    /// Axis about which the wheel turns, unit.
    pub axis: DVec3,
}

impl Pose {
    /// The pose lifted by `travel` [m] along the approach axis.
    pub fn lifted(&self, travel: f64) -> Self {
        Self { centre: self.centre + self.approach * travel, ..*self }
    }

    /// Feed direction, unit: across the wheel's axis and the approach axis.
    pub fn feed(&self) -> DVec3 {
        self.axis.cross(self.approach).normalize()
    }

    /// Approach axis seen by the working face, unit: across the wheel's axis.
    pub fn radial_approach(&self) -> DVec3 {
        self.approach.reject_from_normalized(self.axis).normalize()
    }
}

impl Wheel {
    /// The point of the working face that reaches furthest against the approach axis, at mid width [m].
    pub fn lowest(&self, pose: &Pose) -> DVec3 {
        pose.centre - pose.radial_approach() * self.radius
    }

    /// Vector from the wheel's axis to a point [m], across the axis.
    pub fn radial(&self, pose: &Pose, point: DVec3) -> DVec3 {
        (point - pose.centre).reject_from_normalized(pose.axis)
    }

    /// Depth [m] of a point below the working face, -φ of the endless cylinder: positive inside.
    pub fn depth(&self, pose: &Pose, point: DVec3) -> f64 {
        self.radius - self.radial(pose, point).length()
    }

    /// Share of a strip `span` [m] wide, centred `axial` [m] from mid width, that lies under the face.
    pub fn cover(&self, axial: f64, span: f64) -> f64 {
        ((0.5 * self.width - axial.abs()) / span + 0.5).clamp(0.0, 1.0)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn depth_is_measured_from_the_face_and_cover_ends_at_the_width() {
        let wheel = Wheel { radius: 0.05, width: 0.02 };
        let pose = Pose { centre: DVec3::new(0.1, 0.0, 0.05), approach: DVec3::Z, axis: DVec3::Y };
        assert_eq!(pose.feed(), DVec3::X);
        assert!((wheel.lowest(&pose) - DVec3::new(0.1, 0.0, 0.0)).length() < 1e-15);
        assert!((wheel.depth(&pose, DVec3::new(0.1, 0.3, 0.001)) - 0.001).abs() < 1e-15);
        assert!(wheel.depth(&pose, DVec3::new(0.11, 0.0, 0.0)) < 0.0);
        assert_eq!([0.0, 0.01, 0.0105].map(|axial| wheel.cover(axial, 0.001)), [1.0, 0.5, 0.0]);
    }

    #[test]
    fn a_tilted_wheel_is_lowest_on_its_lower_side() {
        let wheel = Wheel { radius: 0.05, width: 0.02 };
        let axis = DVec3::new(0.0, 0.01f64.cos(), -0.01f64.sin());
        let pose = Pose { centre: DVec3::ZERO, approach: DVec3::Z, axis };
        let lowest = wheel.lowest(&pose);
        assert!((wheel.depth(&pose, lowest)).abs() < 1e-15);
        assert!((lowest.y + 0.05 * 0.01f64.sin()).abs() < 1e-15, "{lowest}");
    }
}
