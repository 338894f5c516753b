//! The border of a tool's working surface, and the part of a cell under it.

use std::ops::Range;

use glam::DVec3;

use crate::clipped_cell::wet_share;
use crate::height_field::HeightField;
use crate::pose::{Placement, Pose};
use crate::region::Region;
use robot::Tool;

/// Cosine of a pad's tilt against the columns below which whole rows are searched for its cells.
const MOST_TILTED: f64 = 0.5;

/// A tool's frame in the coordinates of a height field (u, v, up).
pub(crate) struct HeightFieldFrame {
    pub(super) centre: DVec3,
    pub(super) x: DVec3,
    pub(super) y: DVec3,
    pub(super) z: DVec3,
}

impl HeightFieldFrame {
    pub(crate) fn new(pose: &Pose, height_field: &HeightField) -> Self {
        let [centre, x, y, z] =
            [pose.centre, pose.frame.x, pose.frame.y, pose.frame.z].map(|v| height_field.facing.height_field(v));
        Self { centre, x, y, z }
    }

    /// Transforms a point of the height field into the tool's frame.
    #[inline(always)]
    pub(crate) fn local(&self, point: DVec3) -> DVec3 {
        self.turned(point - self.centre)
    }

    /// True if a point's height does not change its x and y in the tool's frame.
    pub(crate) fn is_upright(&self) -> bool {
        self.x.z == 0.0 && self.y.z == 0.0
    }

    /// Rotates a vector of the height field into the tool's frame.
    #[inline(always)]
    pub(super) fn turned(&self, v: DVec3) -> DVec3 {
        DVec3::new(self.x.dot(v), self.y.dot(v), self.z.dot(v))
    }
}

/// Share of a cell under the working surface in a sweep, and its mean time.
#[derive(Clone, Copy)]
pub(super) struct Cover {
    pub(super) share: f64,
    /// As in [`super::ContactCells::lag`].
    pub(super) lag: f64,
}

/// The border of a tool's working surface over a height field.
pub(super) struct Border<'a> {
    pub(super) tool: &'a Tool,
    pub(super) frame: HeightFieldFrame,
    /// Sweep of the tool [m, u v up].
    pub(super) sweep: DVec3,
    /// Distance by which a pad sinks in over the sweep, the same everywhere [m].
    pub(super) sinking: f64,
    /// Distance from the border beyond which a cell is entirely inside or outside it [m].
    pub(super) near: f64,
    /// Radius of a pad's border [m].
    pub(super) rim: f64,
    /// Squared radii between which a pad's border may cross a cell [m²].
    pub(super) ring: (f64, f64),
}

impl<'a> Border<'a> {
    pub(super) fn new(place: &Placement<'a>, height_field: &HeightField) -> Self {
        let (tool, frame) = (place.tool, HeightFieldFrame::new(&place.pose, height_field));
        let sweep = height_field.facing.height_field(place.sweep);
        // Half a cell's diagonal, plus the contribution of a slope of one.
        let near = height_field.pitch + 0.5 * sweep.length();
        let rim = tool.rim_radius();
        let inner = rim - near;
        let ring = (inner * inner.abs(), (rim + near).powi(2));
        let sinking = if matches!(tool, Tool::Pad(_)) { -frame.z.dot(sweep) } else { 0.0 };
        Self { tool, frame, sweep, sinking, near, rim, ring }
    }

    /// Distance that a pad sinks in or out on either side of the sweep's middle [m].
    #[inline(always)]
    pub(super) fn sunk(&self) -> f64 {
        0.5 * self.sinking.abs()
    }

    /// Cover of a column's cell over the sweep.
    #[inline]
    pub(super) fn cover(&self, height_field: &HeightField, line: usize) -> Cover {
        let at = self.frame.local(height_field.point(line));
        let (is_within, is_near) = match self.tool {
            Tool::Pad(_) => {
                let square = at.x * at.x + at.y * at.y;
                (square <= self.ring.0, square > self.ring.0 && square < self.ring.1)
            }
            tool => {
                let within = tool.within(at);
                (within > 0.0, within.abs() < self.near)
            }
        };
        if is_near { self.crossed(at, height_field, line) } else { Cover { share: f64::from(is_within), lag: 0.0 } }
    }

    /// The same for a cell that the border may cross. `at` is its middle in the tool's frame [m].
    fn crossed(&self, at: DVec3, height_field: &HeightField, line: usize) -> Cover {
        let slope = height_field.slope[line];
        match self.tool {
            Tool::Wheel(_) => {
                self.cover_within(self.tool.within(at), self.frame.y * -at.y.signum(), slope, 0.5 * height_field.pitch)
            }
            _ => self.disc_cover(at, slope, height_field.pitch),
        }
    }

    /// The same for a pad and the `slope` of a cell.
    #[inline(always)]
    pub(super) fn disc_cover(&self, at: DVec3, slope: [f64; 2], pitch: f64) -> Cover {
        let off = (at.x * at.x + at.y * at.y).sqrt();
        let outward = -1.0 / off;
        let per_way = if off > 0.0 { outward } else { 0.0 };
        let inward = (self.frame.x * at.x + self.frame.y * at.y) * per_way;
        self.cover_within(self.rim - off, inward, slope, 0.5 * pitch)
    }

    /// Cover of a cell of half side `half` [m]. Its middle lies `within` [m] inside the border; `inward` is the
    /// border's normal.
    #[inline(always)]
    pub(super) fn cover_within(&self, within: f64, inward: DVec3, [slope_u, slope_v]: [f64; 2], half: f64) -> Cover {
        let swept = 0.5 * self.sweep.dot(inward);
        let own = ((inward.x + inward.z * slope_u).abs() * half, (inward.y + inward.z * slope_v).abs() * half);
        let spans = swept_spans(own, swept.abs());
        let share = wet_share(within, spans);
        // Exact for a point: it is under the surface from one end of the sweep until the border crosses it.
        let lag = -0.5 * (1.0 - share) * swept / (spans.0 * spans.0 + swept * swept).sqrt();
        Cover { share, lag: if swept == 0.0 { 0.0 } else { lag } }
    }

    /// Columns of a region's row that contain every cell under a pad. Beyond them the pad's border cannot cross a cell,
    /// whatever the surface's height.
    pub(super) fn columns(&self, height_field: &HeightField, region: &Region, row: usize) -> Range<usize> {
        let Region { columns, .. } = region;
        let (centre, upright) = (self.frame.centre, self.frame.z.z);
        if !matches!(self.tool, Tool::Pad(_)) || upright < MOST_TILTED {
            return columns.clone();
        }
        let (low, high) = height_field.levels();
        let tall = (high - centre.z).max(centre.z - low).max(0.0);
        let tilt = self.frame.z.x.hypot(self.frame.z.y);
        let reach = (self.rim + self.near + if tilt > 0.0 { tall * tilt } else { 0.0 }) / upright;
        let [low_u, low_v] = height_field.window.low.map(f64::from);
        let off = (low_u + row as f64) * height_field.pitch - centre.x;
        let half = (reach * reach - off * off).max(0.0).sqrt();
        let place = |v: f64| v / height_field.pitch - low_v;
        let first = (place(centre.y - half).floor().max(0.0) as usize).clamp(columns.start, columns.end);
        first..(place(centre.y + half).ceil().max(0.0) as usize + 1).clamp(first, columns.end)
    }
}

/// Spans of a cell swept by `swept` [m] on either side of its middle. With a sweep, one span has the variance of the
/// cell's own two, the other is the sweep.
#[inline(always)]
pub(super) fn swept_spans((a, b): (f64, f64), swept: f64) -> (f64, f64) {
    let own = (a * a + b * b).sqrt();
    if swept == 0.0 { (a, b) } else { (own, swept) }
}
