//! Poses of a tool.

use glam::{DMat3, DVec3};

use effects::PoseChange;
use robot::Tool;

/// Axes of a tool in the workpiece's frame, orthonormal.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Frame {
    /// y × z: along the feed or opposite to it.
    pub x: DVec3,
    /// Across the feed; the axis of a wheel.
    pub y: DVec3,
    /// Away from the part; the axis of a pad.
    pub z: DVec3,
}

impl Frame {
    /// A wheel's frame: y is its axis, z is the approach axis made orthogonal to it.
    pub fn about(axis: DVec3, approach: DVec3) -> Self {
        let z = approach.reject_from_normalized(axis).normalize();
        Self { x: axis.cross(z), y: axis, z }
    }

    /// A pad's frame: z is its face's normal, x is `forward` made orthogonal to it.
    pub fn facing(normal: DVec3, forward: DVec3) -> Self {
        let along = forward.reject_from_normalized(normal);
        let x = if along.length() > 1e-9 { along.normalize() } else { normal.any_orthonormal_vector() };
        Self { x, y: normal.cross(x), z: normal }
    }

    /// The frame turned by `roll` [rad] about its x and `pitch` [rad] about its y axis.
    pub fn tilted(&self, roll: f64, pitch: f64) -> Self {
        if roll == 0.0 && pitch == 0.0 {
            return *self;
        }
        let turn = self.matrix() * DMat3::from_rotation_x(roll) * DMat3::from_rotation_y(pitch);
        Self { x: turn.x_axis, y: turn.y_axis, z: turn.z_axis }
    }

    /// The axes as columns: transforms from the tool's to the workpiece's coordinates.
    pub fn matrix(&self) -> DMat3 {
        DMat3::from_cols(self.x, self.y, self.z)
    }
}

/// Pose of a tool in the workpiece's frame.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Pose {
    /// The tool's reference point [m].
    pub centre: DVec3,
    /// Unit, out of the part: the controller presses against it and lifts along it.
    pub approach: DVec3,
    /// The tool's axes.
    pub frame: Frame,
}

impl Pose {
    /// The pose lifted by `travel` [m] along the approach axis.
    pub fn lifted(&self, travel: f64) -> Self {
        Self { centre: self.centre + self.approach * travel, ..*self }
    }

    /// The pose with a model's offset and tilt.
    pub fn changed(&self, change: &PoseChange) -> Self {
        let frame = self.frame.tilted(change.roll, change.pitch);
        let [x, y, z] = change.offset;
        Self { centre: self.centre + self.frame.matrix() * DVec3::new(x, y, z), frame, ..*self }
    }

    /// Transforms a point of the workpiece's frame [m] into the tool's.
    pub fn local(&self, point: DVec3) -> DVec3 {
        let from = point - self.centre;
        DVec3::new(from.dot(self.frame.x), from.dot(self.frame.y), from.dot(self.frame.z))
    }
}

/// A tool at a pose, at rest or sweeping about it.
#[derive(Clone, Copy, Debug)]
pub struct Placement<'a> {
    /// The tool.
    pub tool: &'a Tool,
    /// Its pose.
    pub pose: Pose,
    /// Its sweep [m], half before and half after the pose; zero at rest.
    pub sweep: DVec3,
}

impl<'a> Placement<'a> {
    /// A tool at rest.
    pub fn still(tool: &'a Tool, pose: Pose) -> Self {
        Self { tool, pose, sweep: DVec3::ZERO }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_wheel_that_turns_about_y_feeds_along_x_and_tilts_about_its_axes() {
        let frame = Frame::about(DVec3::Y, DVec3::Z);
        assert_eq!((frame.x, frame.z), (DVec3::X, DVec3::Z));
        let rolled = frame.tilted(0.01, 0.0);
        assert!((rolled.y - DVec3::new(0.0, 0.01f64.cos(), 0.01f64.sin())).length() < 1e-15);
        let pose = Pose { centre: DVec3::ONE, approach: DVec3::Z, frame: rolled };
        assert!((pose.local(DVec3::ONE + rolled.y * 0.3) - DVec3::Y * 0.3).length() < 1e-15);
    }
}
