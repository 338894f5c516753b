//! A triangle in planar coordinates: corner 0 at the origin, corner 1 on the x axis, corner 2 above it.

use glam::{DVec2, DVec3};
use sdf_bake::Mesh;

use super::strip::Entry;

#[derive(Clone, Copy, Debug)]
pub(super) struct FlatFace {
    pub(super) face: u32,
    corners: [DVec2; 3],
    /// Unit direction of each edge; the inside is on its left.
    pub(super) along: [DVec2; 3],
    lengths: [f64; 3],
    space: [DVec3; 3],
    /// Greatest distance [m] by which rounding may put a point outside.
    pub(super) slack: f64,
}

/// Distance from a corner, in multiples of [`FlatFace::slack`], up to which a point is at the corner.
const CORNER_SLACKS: f64 = 100.0;
/// Rounding error of a heading along an edge [rad].
const ALONG_EDGE: f64 = 1e-9;

impl FlatFace {
    /// Flattens a triangle; `None` if it has no area.
    pub(super) fn new(mesh: &Mesh, face: u32) -> Option<Self> {
        let space @ [a, b, c] = mesh.corners(face as usize);
        let base = (b - a).length();
        let apex = DVec2::new((c - a).dot(b - a), (b - a).cross(c - a).length()) / base;
        if !(base > 0.0 && apex.y > 0.0 && apex.is_finite()) {
            return None;
        }
        let corners = [DVec2::ZERO, DVec2::new(base, 0.0), apex];
        let lengths = [base, (apex - corners[1]).length(), apex.length()];
        let along = [DVec2::X, (apex - corners[1]) / lengths[1], -apex / lengths[2]];
        let slack = 1e-13 * lengths.iter().fold(0.0, |max: f64, length| max.max(*length));
        Some(Self { face, corners, along, lengths, space, slack })
    }

    /// Unit vectors in space: along the first edge, perpendicular to it towards the third corner, and out of the part.
    pub(super) fn axes(&self) -> [DVec3; 3] {
        let [a, b, c] = self.space;
        let normal = (b - a).cross(c - a).normalize();
        let x = (b - a) / self.lengths[0];
        [x, normal.cross(x), normal]
    }

    pub(super) fn start(&self, edge: usize) -> DVec2 {
        self.corners[edge]
    }

    /// Returns the end of an edge at which a point of the edge lies, if any.
    pub(super) fn corner_at(&self, edge: usize, point: DVec2) -> Option<usize> {
        let reach = (CORNER_SLACKS * self.slack).powi(2);
        let near = |corner: &usize| point.distance_squared(self.corners[*corner]) <= reach;
        [edge, (edge + 1) % 3].into_iter().find(near)
    }

    /// Angle [rad] from the edge that starts at a corner to a direction; `None` unless it points into the triangle.
    pub(super) fn angle_within(&self, corner: usize, direction: DVec2) -> Option<f64> {
        let (first, last) = (self.along[corner], -self.along[(corner + 2) % 3]);
        let angle_to = |other: DVec2| first.perp_dot(other).atan2(first.dot(other));
        let angle = angle_to(direction);
        (-ALONG_EDGE..=angle_to(last) + ALONG_EDGE).contains(&angle).then_some(angle)
    }

    /// Returns a corner, and the direction at this angle [rad] from the edge that starts there.
    pub(super) fn ray_from(&self, corner: usize, angle: f64) -> (DVec2, DVec2) {
        (self.corners[corner], DVec2::from_angle(angle).rotate(self.along[corner]))
    }

    /// Projects a direction in space to the triangle's plane; `None` if it is along the normal.
    pub(super) fn flatten(&self, direction: DVec3) -> Option<DVec2> {
        let [x, y, _] = self.axes();
        DVec2::new(direction.dot(x), direction.dot(y)).try_normalize()
    }

    /// Point with the given barycentric coordinates.
    pub(super) fn lay(&self, weights: [f64; 3]) -> DVec2 {
        weights[1] * self.corners[1] + weights[2] * self.corners[2]
    }

    /// Barycentric coordinates of a point, clamped to the triangle and summing to 1.
    pub(super) fn barycentric(&self, point: DVec2) -> [f64; 3] {
        let third = (point.y / self.corners[2].y).clamp(0.0, 1.0);
        let second = ((point.x - third * self.corners[2].x) / self.corners[1].x).clamp(0.0, 1.0 - third);
        [(1.0 - third - second).max(0.0), second, third]
    }

    pub(super) fn position(&self, weights: [f64; 3]) -> DVec3 {
        weights[0] * self.space[0] + weights[1] * self.space[1] + weights[2] * self.space[2]
    }

    /// Converts a point of an edge and a heading to coordinates relative to that edge.
    pub(super) fn entry(&self, edge: usize, point: DVec2, heading: DVec2) -> Entry {
        let along = self.along[edge];
        let at = (point - self.corners[edge]).dot(along);
        Entry { face: self.face, edge, at, heading: DVec2::new(along.dot(heading), along.perp_dot(heading)) }
    }

    /// Inverse of [`FlatFace::entry`].
    pub(super) fn at_entry(&self, entry: Entry) -> (DVec2, DVec2) {
        let along = self.along[entry.edge];
        (self.corners[entry.edge] + entry.at * along, along.rotate(entry.heading).normalize())
    }

    /// Transfers point and heading across an edge to the neighbour, where the same edge runs in the opposite direction.
    ///
    /// The angle to the edge is preserved, which is equivalent to unfolding the two triangles into one plane.
    pub(super) fn unfold(
        &self,
        edge: usize,
        point: DVec2,
        heading: DVec2,
        next: &Self,
        next_edge: usize,
    ) -> (DVec2, DVec2) {
        let share = ((point - self.corners[edge]).dot(self.along[edge]) / self.lengths[edge]).clamp(0.0, 1.0);
        let (across, along) = (self.along[edge].perp_dot(heading), self.along[edge].dot(heading));
        let direction = next.along[next_edge];
        let entered = next.corners[next_edge] + (1.0 - share) * next.lengths[next_edge] * direction;
        (entered, (-along * direction - across * direction.perp()).normalize())
    }
}
