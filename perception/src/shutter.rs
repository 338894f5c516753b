//! Drawn rolling shutter of a placement: the motion of the camera from the first row to the last.

use glam::{DQuat, DVec3};
use random::Stream;
use render::RollingShutter;
use serde::{Deserialize, Serialize};

/// Share of the placements whose camera moves.
const SHARE: f64 = 0.5;
/// Greatest displacement of the picture between first and last row, relative to its height, by translation and by
/// rotation: 6 and 3 pixels of 480.
const MOST_SKEW: [f64; 2] = [6.0 / 480.0, 3.0 / 480.0];
/// Greatest roll about the camera's axis [rad].
const MOST_ROLL: f64 = 0.01;

/// Motion of the camera while the rows of an image are exposed, in the camera's frame of OpenCV: x to the right, y down,
/// z ahead. The stored camera is that of the middle row.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct ShutterDraw {
    /// Motion of the centre of projection from the first row to the last [m].
    pub shift_m: DVec3,
    /// Rotation from the first row to the last, as a vector along its axis [rad].
    pub turn: DVec3,
}

impl ShutterDraw {
    /// Draws the motion of a placement's camera, if it moves. `slope`: tangent of half the vertical field of view;
    /// `depth`: of the workpiece's middle [m].
    pub(crate) fn draw(slope: f64, depth: f64, stream: &mut Stream) -> Option<Self> {
        let moves = stream.happens(SHARE);
        let mut vector = |most: DVec3| most * DVec3::from_array(std::array::from_fn(|_| stream.between([-1.0, 1.0])));
        let [shift, turn] = MOST_SKEW.map(|share| 2.0 * slope * share);
        let draw =
            Self { shift_m: vector(DVec3::splat(shift * depth)), turn: vector(DVec3::new(turn, turn, MOST_ROLL)) };
        moves.then_some(draw)
    }

    /// The shutter for the renderer. `axes`: of the camera, to the right, up and ahead, in the scene's frame.
    pub(crate) fn shutter(&self, [right, up, forward]: [DVec3; 3]) -> RollingShutter {
        let in_scene = |vector: DVec3| right * vector.x - up * vector.y + forward * vector.z;
        RollingShutter { shift: in_scene(self.shift_m), turn: in_scene(self.turn) }
    }

    /// A point in the frame of the middle row's camera [m], as the camera of a row sees it. `down`: position of the row
    /// from the top, 0 to 1.
    pub(crate) fn seen_from_row(&self, point: DVec3, down: f64) -> DVec3 {
        let share = down - 0.5;
        DQuat::from_scaled_axis(-self.turn * share) * (point - self.shift_m * share)
    }
}
