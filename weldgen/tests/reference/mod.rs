//! Straightest geodesics in double-double arithmetic (about 32 digits), in space instead of planar coordinates: a
//! reference that shares neither rounding nor formulas with the tracer.

mod double;

use glam::DVec3;
use sdf_bake::Mesh;
use weldgen::topology::{EdgeNeighbour, Topology};
use weldgen::trace::TraceStart;

use double::{Double, Vector};

/// End of a straightest geodesic of a length [m]; `None` if it meets a vertex or the end of the surface.
pub(crate) fn geodesic_end(mesh: &Mesh, topology: &Topology, start: &TraceStart, length: f64) -> Option<DVec3> {
    let whole = start.barycentric.iter().fold(Double::of(0.0), |sum, weight| sum + Double::of(*weight));
    let corners = corners(mesh, start.face);
    let weighted = |i: usize| corners[i] * (Double::of(start.barycentric[i]) / whole);
    let normal = (corners[1] - corners[0]).cross(corners[2] - corners[0]).unit();
    let heading = Vector::of(start.heading);
    let mut at = Walk {
        face: start.face,
        entered: None,
        point: weighted(0) + weighted(1) + weighted(2),
        direction: (heading - normal * heading.dot(normal)).unit(),
    };
    let mut left = Double::of(length);
    loop {
        let (way, edge) = at.exit(mesh)?;
        if left.is_below(way) {
            return Some((at.point + at.direction * left).rounded());
        }
        at = at.across(mesh, topology, way, edge)?;
        left = left - way;
    }
}

fn corners(mesh: &Mesh, face: u32) -> [Vector; 3] {
    mesh.corners(face as usize).map(Vector::of)
}

/// A point of a face and a unit direction in its plane.
struct Walk {
    face: u32,
    entered: Option<usize>,
    point: Vector,
    direction: Vector,
}

impl Walk {
    /// Start of an edge of the face, unit vector along it, and unit vector from it into the face.
    fn edge(mesh: &Mesh, face: u32, edge: usize) -> (Vector, Vector, Vector) {
        let corners = corners(mesh, face);
        let [a, b, c] = [0, 1, 2].map(|i| corners[(edge + i) % 3]);
        let along = (b - a).unit();
        let normal = (b - a).cross(c - a).unit();
        (a, along, normal.cross(along))
    }

    /// Distance to the edge at which the line leaves the face, and that edge.
    fn exit(&self, mesh: &Mesh) -> Option<(Double, usize)> {
        let mut first: Option<(Double, usize)> = None;
        for edge in (0..3).filter(|edge| Some(*edge) != self.entered) {
            let (from, _, inwards) = Self::edge(mesh, self.face, edge);
            let closing = self.direction.dot(inwards);
            if !closing.is_below(Double::of(0.0)) {
                continue;
            }
            let way = (from - self.point).dot(inwards) / closing;
            if first.is_none_or(|(nearest, _)| way.is_below(nearest)) {
                first = Some((way, edge));
            }
        }
        first
    }

    fn across(&self, mesh: &Mesh, topology: &Topology, way: Double, edge: usize) -> Option<Self> {
        let EdgeNeighbour::Face { face, edge: there, .. } = topology.across[self.face as usize][edge] else {
            return None;
        };
        let (_, along, inwards) = Self::edge(mesh, self.face, edge);
        let (_, _, onwards) = Self::edge(mesh, face, usize::from(there));
        let (kept, turned) = (self.direction.dot(along), self.direction.dot(inwards));
        Some(Self {
            face,
            entered: Some(usize::from(there)),
            point: self.point + self.direction * way,
            direction: (along * kept - onwards * turned).unit(),
        })
    }
}
