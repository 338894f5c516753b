//! A triangle laid flat: corner 0 at the origin, corner 1 on the x axis, corner 2 above it.

use glam::{DVec2, DVec3};
use sdf_bake::Mesh;

#[derive(Clone, Copy, Debug)]
pub(super) struct FlatFace {
    pub(super) face: u32,
    corners: [DVec2; 3],
    /// Unit direction of each edge; the inside is on its left.
    pub(super) along: [DVec2; 3],
    lengths: [f64; 3],
    space: [DVec3; 3],
    axes: [DVec3; 3],
    /// Distance [m] that rounding may put a point outside.
    pub(super) slack: f64,
}

impl FlatFace {
    /// `None` for a triangle without area.
    pub(super) fn new(mesh: &Mesh, face: u32) -> Option<Self> {
        let space @ [a, b, c] = mesh.corners(face as usize);
        let normal = (b - a).cross(c - a).try_normalize()?;
        let x = (b - a).try_normalize()?;
        let y = normal.cross(x);
        let corners = [DVec2::ZERO, DVec2::new((b - a).length(), 0.0), DVec2::new((c - a).dot(x), (c - a).dot(y))];
        let edges = [0, 1, 2].map(|i| corners[(i + 1) % 3] - corners[i]);
        let lengths = edges.map(DVec2::length);
        let proper = corners[2].y > 0.0 && lengths.iter().all(|length| *length > 0.0);
        proper.then(|| Self {
            face,
            corners,
            along: [0, 1, 2].map(|i| edges[i] / lengths[i]),
            lengths,
            space,
            axes: [x, y, normal],
            slack: 1e-13 * lengths.iter().fold(0.0, |max: f64, length| max.max(*length)),
        })
    }

    pub(super) fn start(&self, edge: usize) -> DVec2 {
        self.corners[edge]
    }

    pub(super) fn normal(&self) -> DVec3 {
        self.axes[2]
    }

    /// A direction in space, projected to the triangle's plane; `None` when it is along the normal.
    pub(super) fn flatten(&self, direction: DVec3) -> Option<DVec2> {
        DVec2::new(direction.dot(self.axes[0]), direction.dot(self.axes[1])).try_normalize()
    }

    pub(super) fn raise(&self, direction: DVec2) -> DVec3 {
        direction.x * self.axes[0] + direction.y * self.axes[1]
    }

    /// The point with the given weights.
    pub(super) fn lay(&self, weights: [f64; 3]) -> DVec2 {
        weights[1] * self.corners[1] + weights[2] * self.corners[2]
    }

    /// Weights of the corners, clamped to the triangle and summing to 1.
    pub(super) fn barycentric(&self, point: DVec2) -> [f64; 3] {
        let third = (point.y / self.corners[2].y).clamp(0.0, 1.0);
        let second = ((point.x - third * self.corners[2].x) / self.corners[1].x).clamp(0.0, 1.0 - third);
        [(1.0 - third - second).max(0.0), second, third]
    }

    pub(super) fn position(&self, weights: [f64; 3]) -> DVec3 {
        weights[0] * self.space[0] + weights[1] * self.space[1] + weights[2] * self.space[2]
    }

    /// Point and heading carried over an edge into the neighbour, where the same edge runs the other way.
    ///
    /// The angle to the edge is kept: this is what unfolding the two triangles into one plane does.
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
