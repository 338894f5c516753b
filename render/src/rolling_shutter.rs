//! Rolling shutter: the rows of an image are exposed one after the other while the camera moves. On the CPU only.

use glam::{DQuat, DVec3};

use super::camera::Camera;
use super::lanes::LANES;
use super::placement::Placement;
use super::rays::{ImagePositions, Rays};

/// Small uniform motion of a camera from the exposure of the first row to that of the last. The camera's pose is that
/// of the middle row.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct RollingShutter {
    /// Motion of the centre of projection [m].
    pub shift: DVec3,
    /// Rotation about the centre of projection, as a vector along its axis [rad].
    pub turn: DVec3,
}

impl RollingShutter {
    /// Returns the camera as it is when a row is exposed. `down`: position of the row from the top, 0 to 1.
    pub fn camera(&self, middle: &Camera, down: f64) -> Camera {
        let (shift, turn) = self.pose(down);
        Camera {
            eye: middle.eye + shift,
            right: turn * middle.right,
            up: turn * middle.up,
            forward: turn * middle.forward,
            ..*middle
        }
    }

    /// Motion [m] and rotation from the middle row to a row.
    fn pose(&self, down: f64) -> (DVec3, DQuat) {
        let share = down - 0.5;
        (self.shift * share, DQuat::from_scaled_axis(self.turn * share))
    }

    /// The same motion in the part's frame.
    pub(crate) fn to_part(self, placement: &Placement) -> Self {
        let [shift, turn] = [self.shift, self.turn].map(|vector| placement.direction_to_part(vector));
        Self { shift, turn }
    }

    /// Moves the rays of the middle row's camera to their rows.
    pub(crate) fn displace(&self, rays: &mut Rays, at: &ImagePositions, camera: &Camera) {
        for lane in (0..LANES).filter(|&lane| at.wanted[lane]) {
            let (shift, turn) = self.pose(at.down[lane]);
            let origin = camera.eye + shift + turn * (rays.origin(lane) - camera.eye);
            rays.set(lane, origin, turn * rays.direction(lane));
        }
    }
}

#[cfg(test)]
mod tests {
    use sdf_bake::BrickGrid;

    use super::*;
    use crate::material::PRIMER;
    use crate::{Raster, Scene, Table};

    #[test]
    fn each_row_is_that_of_a_camera_at_rest_in_the_pose_of_the_row() {
        let half = DVec3::new(0.02, 0.012, 0.008);
        let distance = |p: DVec3| (p.abs() - half).max_element();
        let part = BrickGrid::from_distance(-half, half, 0.5e-3, 3.0, distance);
        let camera = Camera::framing(-half, half, -0.9, 0.6, 4.0 / 3.0);
        let shutter = RollingShutter { shift: DVec3::new(4e-3, -2e-3, 1e-3), turn: DVec3::new(0.01, -0.02, 0.03) };
        let table = Some(Table { height: -0.008, material: PRIMER, texture: None, pattern: None });
        let still = Scene { table, ..Scene::new(&part) };
        let scene = Scene { shutter: Some(shutter), ..still.clone() };
        let raster = Raster { width: 64, height: 48, samples_per_side: 1 };
        let (moving, rest) = (scene.photograph(&camera, &raster), still.photograph(&camera, &raster));
        for y in 0..48 {
            let row = 64 * y..64 * (y + 1);
            let frame = still.photograph(&shutter.camera(&camera, (y as f64 + 0.5) / 48.0), &raster);
            assert_eq!(moving.seen[row.clone()], frame.seen[row.clone()], "row {y}");
            for pixel in row {
                let (found, expected) = (moving.depth[pixel], frame.depth[pixel]);
                assert!(found == expected || (found - expected).abs() < 1e-5, "{found} and {expected} in row {y}");
                assert!((moving.colour[pixel] - frame.colour[pixel]).length() < 0.02, "row {y}");
            }
        }
        assert_ne!(moving.seen, rest.seen);
    }
}
