//! Follows a straight line over a strip of triangles, each in planar coordinates of the edge at which the line entered.
//!
//! ```text
//!           C                 A is the origin, B on the x axis; the line leaves
//!          / \ .             through BC if C is on its left, else through CA
//!         /  .\
//!        /  .  \
//!       A--o----B
//! ```

use glam::DVec2;
use sdf_bake::Mesh;

use crate::topology::{EdgeNeighbour, Topology};

/// Crossings closer than this to a corner are handled elsewhere, as a share of the edge.
const NEAR_CORNER: f64 = 1e-10;

/// A line at its entry to a triangle.
#[derive(Clone, Copy, Debug)]
pub(super) struct Entry {
    pub(super) face: u32,
    /// Index of the edge that it crossed.
    pub(super) edge: usize,
    /// Distance [m] from the start of that edge.
    pub(super) at: f64,
    /// Unit vector: along the edge, and away from it into the triangle.
    pub(super) heading: DVec2,
}

/// State at which [`follow`] stopped.
pub(super) struct FollowState {
    pub(super) entry: Entry,
    /// Length followed [m].
    pub(super) length: f64,
    pub(super) crossings: usize,
}

/// Limits on following a line: length, edge angle, crossings.
pub(super) struct Bounds {
    /// Length [m].
    pub(super) reach: f64,
    /// Edges whose normals differ by more than this [rad] are not crossed.
    pub(super) sharp_angle: f64,
    /// Greatest number of crossings.
    pub(super) most: usize,
}

/// Follows a straight line within its bounds, as long as it crosses whole triangles away from corners.
pub(super) fn follow((mesh, topology): (&Mesh, &Topology), mut entry: Entry, bounds: &Bounds) -> FollowState {
    let Bounds { reach, sharp_angle, most } = *bounds;
    let (mut length, mut crossings) = (0.0, 0);
    while crossings < most {
        let corners = mesh.corners(entry.face as usize);
        let [a, b, c] = [0, 1, 2].map(|i| corners[(entry.edge + i) % 3]);
        // The edge length is recomputed: that of the previous triangle would accumulate rounding errors.
        let base = (b - a).length();
        let along = (b - a) / base;
        let apex = DVec2::new((c - a).dot(along), along.cross(c - a).length());
        let point = DVec2::new(entry.at, 0.0);
        let by_second = entry.heading.perp_dot(apex - point) > 0.0;
        let from = if by_second { DVec2::new(base, 0.0) } else { apex };
        let side = if by_second { apex - from } else { -apex };
        let size = side.length();
        let out = -side.perp_dot(entry.heading) / size;
        let way = side.perp_dot(point - from) / size / out;
        let place = (point - from + way * entry.heading).dot(side) / size;
        let margin = NEAR_CORNER * (base + size);
        if !(way >= 0.0 && length + way < reach && place > margin && size - place > margin) {
            break;
        }
        let edge = (entry.edge + if by_second { 1 } else { 2 }) % 3;
        let EdgeNeighbour::Face { face, edge, turn } = topology.across[entry.face as usize][edge] else { break };
        if turn.abs() > sharp_angle {
            break;
        }
        let heading = DVec2::new(-entry.heading.dot(side) / size, out);
        entry = Entry { face, edge: usize::from(edge), at: size - place, heading };
        length += way;
        crossings += 1;
    }
    FollowState { entry, length, crossings }
}
