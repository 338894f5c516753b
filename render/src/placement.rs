//! Where the part stands in the scene.

use glam::{DQuat, DVec3};

use super::camera::Camera;

/// A rigid motion from the part's frame to the scene's.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Placement {
    /// Turns the part about its origin; of unit length.
    pub rotation: DQuat,
    /// Then moves it [m].
    pub translation: DVec3,
}

impl Placement {
    /// The part's frame is the scene's.
    pub const IDENTITY: Self = Self { rotation: DQuat::IDENTITY, translation: DVec3::ZERO };

    /// A point of the part in the scene [m].
    pub fn to_scene(&self, point: DVec3) -> DVec3 {
        self.rotation * point + self.translation
    }

    /// A point of the scene in the part's frame [m].
    pub fn to_part(&self, point: DVec3) -> DVec3 {
        self.rotation.inverse() * (point - self.translation)
    }

    /// A direction of the scene in the part's frame.
    pub fn direction_to_part(&self, direction: DVec3) -> DVec3 {
        self.rotation.inverse() * direction
    }

    /// A camera of the scene in the part's frame.
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
