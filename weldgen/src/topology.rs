//! Who is whose neighbour: each triangle's three edges and what lies across them.

use glam::DVec3;
use sdf_bake::Mesh;

/// What lies across an edge of a triangle.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Across {
    /// Exactly one other triangle, turned the same way round.
    Face {
        /// Index of the triangle.
        face: u32,
        /// Which of its edges this is: 0, 1 or 2.
        edge: u8,
        /// Angle between the two normals [rad]: positive over a convex edge, negative in a concave one, 0 when flat.
        turn: f64,
    },
    /// Nothing: the surface ends here.
    Boundary,
    /// More than one other triangle, or one that is turned the other way round.
    NonManifold,
}

/// The edges of a mesh, per triangle.
///
/// Edge `e` of a triangle runs from its corner `e` to its corner `(e + 1) % 3`. Vertices must be shared: triangles
/// that only touch at equal coordinates are not neighbours.
#[derive(Clone, Debug)]
pub struct Topology {
    /// What lies across each edge, shape `[m, 3]`.
    pub across: Vec<[Across; 3]>,
}

impl Topology {
    /// Pairs the edges of a mesh; O(m log m).
    pub fn new(mesh: &Mesh) -> Self {
        let mut sides: Vec<Side> =
            mesh.triangles.iter().zip(0..).flat_map(|(corners, face)| sides(*corners, face)).collect();
        sides.sort_unstable();
        let mut across = vec![[Across::NonManifold; 3]; mesh.triangles.len()];
        for group in sides.chunk_by(|a, b| a.vertices == b.vertices) {
            match *group {
                [one] => across[one.face as usize][usize::from(one.edge)] = Across::Boundary,
                [one, other] if one.reversed != other.reversed => {
                    for (here, there) in [(one, other), (other, one)] {
                        let turn = turn(mesh, here, there);
                        let link = Across::Face { face: there.face, edge: there.edge, turn };
                        across[here.face as usize][usize::from(here.edge)] = link;
                    }
                }
                _ => {}
            }
        }
        Self { across }
    }
}

#[derive(Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
struct Side {
    /// The two ends, lower index first.
    vertices: [u32; 2],
    face: u32,
    edge: u8,
    /// Whether the triangle walks the edge from the higher index to the lower.
    reversed: bool,
}

fn sides(corners: [u32; 3], face: u32) -> [Side; 3] {
    [0u8, 1, 2].map(|edge| {
        let (from, to) = (corners[usize::from(edge)], corners[(usize::from(edge) + 1) % 3]);
        Side { vertices: [from.min(to), from.max(to)], face, edge, reversed: from > to }
    })
}

/// Signed angle [rad] from one triangle's normal to the other's about their edge.
fn turn(mesh: &Mesh, here: Side, there: Side) -> f64 {
    let [from, to] = edge_ends(mesh, here.face, here.edge);
    let (one, other) = (mesh.normal(here.face as usize), mesh.normal(there.face as usize));
    one.cross(other).dot((to - from).normalize_or_zero()).atan2(one.dot(other))
}

/// Start and end [m] of an edge of a triangle.
fn edge_ends(mesh: &Mesh, face: u32, edge: u8) -> [DVec3; 2] {
    let corners = mesh.corners(face as usize);
    [corners[usize::from(edge)], corners[(usize::from(edge) + 1) % 3]]
}
