//! Pose of the part in the scene.

use glam::{DQuat, DVec3};

use super::camera::Camera;

/// A rigid transform from the part's frame to the scene's.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Placement {
    /// Rotation about the part's origin, a unit quaternion.
    pub rotation: DQuat,
    /// Translation after the rotation [m].
    pub translation: DVec3,
}

impl Placement {
    /// Identity: the part's frame equals the scene's.
    pub const IDENTITY: Self = Self { rotation: DQuat::IDENTITY, translation: DVec3::ZERO };

    /// Transforms a point from the part's frame to the scene's [m].
    pub fn to_scene(&self, point: DVec3) -> DVec3 {
        self.rotation * point + self.translation
    }

    /// Transforms a point from the scene's frame to the part's [m].
    pub fn to_part(&self, point: DVec3) -> DVec3 {
        self.rotation.inverse() * (point - self.translation)
    }

    /// Transforms a direction from the scene's frame to the part's.
    pub fn direction_to_part(&self, direction: DVec3) -> DVec3 {
        self.rotation.inverse() * direction
    }

    /// Transforms a camera from the scene's frame to the part's.
    pub(crate) fn camera_to_part(&self, camera: &Camera) -> Camera {
        Camera {
            eye: self.to_part(camera.eye),
            right: self.direction_to_part(camera.right),
            up: self.direction_to_part(camera.up),
            forward: self.direction_to_part(camera.forward),
            ..*camera
        }
    }
}
