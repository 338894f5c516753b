//! The triangles around a vertex, laid out by angle.
//!
//! ```text
//!       \  1  /           angles are counter-clockwise seen from outside,
//!      2 \   / 0           from the edge at which triangle 0 leaves the vertex
//!   -------o-------
//! ```

use sdf_bake::Mesh;

use super::TraceEnd;
use crate::topology::{EdgeNeighbour, Topology};

/// Limit on the triangles around a vertex, above that of any usable mesh.
const MOST_WEDGES: usize = 100_000;

struct Wedge {
    face: u32,
    corner: usize,
    /// Angle of the triangle's corner [rad].
    angle: f64,
    /// Angle between the normals across the edge to the next wedge [rad].
    turn: f64,
}

/// All wedges of an interior vertex, counter-clockwise.
pub(super) struct Fan {
    wedges: Vec<Wedge>,
}

/// A direction at the vertex.
pub(super) struct VertexDirection {
    pub(super) face: u32,
    pub(super) corner: usize,
    /// Angle [rad] from the edge of the triangle that starts at the corner.
    pub(super) angle: f64,
}

impl Fan {
    /// Collects the triangles around a corner; fails if the surface ends there.
    pub(super) fn around(mesh: &Mesh, topology: &Topology, face: u32, corner: usize) -> Result<Self, TraceEnd> {
        let mut fan = Self { wedges: Vec::new() };
        let mut at = (face, corner);
        while fan.wedges.len() < MOST_WEDGES {
            // The edge that ends at the corner is the one that starts there in the next triangle.
            let (next, turn) = match topology.across[at.0 as usize][(at.1 + 2) % 3] {
                EdgeNeighbour::Boundary => return Err(TraceEnd::Boundary),
                EdgeNeighbour::NonManifold => return Err(TraceEnd::NonManifold),
                EdgeNeighbour::Face { face, edge, turn } => ((face, usize::from(edge)), turn),
            };
            let corners = mesh.corners(at.0 as usize);
            let [here, after, before] = [0, 1, 2].map(|i| corners[(at.1 + i) % 3]);
            let (one, other) = (after - here, before - here);
            let angle = one.cross(other).length().atan2(one.dot(other));
            fan.wedges.push(Wedge { face: at.0, corner: at.1, angle, turn });
            if next == (face, corner) {
                return Ok(fan);
            }
            at = next;
        }
        Err(TraceEnd::Steps)
    }

    /// Returns the direction with half of the total angle on either side of `back` (Polthier & Schmies 1998, definition
    /// 3).
    ///
    /// `None` if both sides have an edge sharper than `sharp_angle`: a crease across the path.
    pub(super) fn opposite(&self, back: f64, sharp_angle: f64) -> Option<VertexDirection> {
        let whole: f64 = self.wedges.iter().map(|wedge| wedge.angle).sum();
        let wraps = back + 0.5 * whole >= whole;
        let mut left = if wraps { back - 0.5 * whole } else { back + 0.5 * whole };
        let last = self.wedges.len() - 1;
        let mut index = 0;
        while index < last && left > self.wedges[index].angle {
            left -= self.wedges[index].angle;
            index += 1;
        }
        let sharp = |wedges: &[Wedge]| wedges.iter().any(|wedge| wedge.turn.abs() > sharp_angle);
        let crease = !wraps && sharp(&self.wedges[..index]) && sharp(&self.wedges[index..]);
        let Wedge { face, corner, angle, .. } = self.wedges[index];
        (!crease).then(|| VertexDirection { face, corner, angle: left.clamp(0.0, angle) })
    }
}
