//! Extent of the contact in the tool's frame, and the height field's window that contains it.

use glam::DVec3;
pub(crate) use shaders::constants::MARGIN;

use crate::height_field::{Facing, Window};
use crate::pose::Pose;
use robot::Tool;

/// Least and greatest x and y of the contact in the tool's frame [m].
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Extent {
    /// Along the tool's x.
    pub x: (f64, f64),
    /// Along the tool's y.
    pub y: (f64, f64),
}

impl Extent {
    /// Largest contact of a tool that sinks in by `sink` [m].
    pub fn of(tool: &Tool, sink: f64) -> Self {
        let (x, y) = tool.half_footprint(sink);
        Self { x: (-x, x), y: (-y, y) }
    }

    /// The extent grown by a quarter and two pitches, to the whole tool at most; `None` if it was that large already.
    pub fn grown(&self, tool: &Tool, pitch: f64) -> Option<Self> {
        let (x, y) = tool.half_footprint(f64::INFINITY);
        let whole = |(low, high): (f64, f64), most: f64| low <= -most && high >= most;
        let grow = |(low, high): (f64, f64), most: f64| {
            let more = 0.25 * (high - low) + 2.0 * pitch;
            ((low - more).max(-most), (high + more).min(most))
        };
        let covered = whole(self.x, x) && whole(self.y, y);
        (!covered).then(|| Self { x: grow(self.x, x), y: grow(self.y, y) })
    }

    /// Union of two extents.
    pub(crate) fn joined(&self, other: &Self) -> Self {
        let join = |one: (f64, f64), other: (f64, f64)| (one.0.min(other.0), one.1.max(other.1));
        Self { x: join(self.x, other.x), y: join(self.y, other.y) }
    }

    /// Its corners below a tool, as (u, v, up) [m].
    fn corners(&self, tool: &Tool, pose: &Pose, facing: Facing) -> [DVec3; 4] {
        let bottom = pose.centre - pose.frame.z * tool.drop();
        [(self.x.0, self.y.0), (self.x.0, self.y.1), (self.x.1, self.y.0), (self.x.1, self.y.1)]
            .map(|(x, y)| facing.height_field(bottom + pose.frame.x * x + pose.frame.y * y))
    }

    /// The window that contains the contact at all `poses`, and its lowest corner [m up].
    pub fn window(&self, tool: &Tool, poses: &[Pose], facing: Facing, pitch: f64) -> (Window, f64) {
        let corners: Vec<DVec3> = poses.iter().flat_map(|pose| self.corners(tool, pose, facing)).collect();
        let lowest = corners.iter().map(|corner| corner.z).fold(f64::INFINITY, f64::min);
        (Window::around(corners.into_iter(), pitch, MARGIN), lowest)
    }
}
