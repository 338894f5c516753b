//! Mesh topology: each triangle's three edges and their neighbours.

use glam::DVec3;
use sdf_bake::Mesh;

/// Neighbour across an edge of a triangle.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum EdgeNeighbour {
    /// Exactly one other triangle, of the same orientation.
    Face {
        /// Index of the triangle.
        face: u32,
        /// Index of this edge in it: 0, 1 or 2.
        edge: u8,
        /// Angle between the two normals [rad]: positive over a convex edge, negative over a concave one, 0 if flat.
        turn: f64,
    },
    /// Nothing: the surface ends here.
    Boundary,
    /// More than one other triangle, or one of opposite orientation.
    NonManifold,
}

/// The edges of a mesh, per triangle.
///
/// Edge `e` of a triangle runs from its corner `e` to its corner `(e + 1) % 3`. Vertices must be shared: triangles that
/// only touch at equal coordinates are not neighbours.
#[derive(Clone, Debug)]
pub struct Topology {
    /// Neighbour across each edge, shape `[m, 3]`.
    pub across: Vec<[EdgeNeighbour; 3]>,
}

impl Topology {
    /// Pairs the edges of a mesh in time proportional to their number.
    pub fn new(mesh: &Mesh) -> Self {
        let normals: Vec<DVec3> = (0..mesh.triangles.len()).map(|face| mesh.normal(face)).collect();
        let mut across = vec![[EdgeNeighbour::NonManifold; 3]; mesh.triangles.len()];
        for group in sorted_sides(mesh).chunk_by(|a, b| a.vertices == b.vertices) {
            match *group {
                [one] => across[one.face as usize][usize::from(one.edge)] = EdgeNeighbour::Boundary,
                [one, other] if one.reversed != other.reversed => {
                    let turn = turn(mesh, one, [one, other].map(|side| normals[side.face as usize]));
                    for (here, there) in [(one, other), (other, one)] {
                        let link = EdgeNeighbour::Face { face: there.face, edge: there.edge, turn };
                        across[here.face as usize][usize::from(here.edge)] = link;
                    }
                }
                _ => {}
            }
        }
        Self { across }
    }
}

#[derive(Clone, Copy, Default, PartialEq, Eq, PartialOrd, Ord)]
struct Side {
    /// The two ends, lower index first.
    vertices: [u32; 2],
    face: u32,
    edge: u8,
    /// True if the triangle runs along the edge from the higher index to the lower.
    reversed: bool,
}

/// Returns all sides of all triangles in order: counting sort up to the lower vertex, comparison within it.
fn sorted_sides(mesh: &Mesh) -> Vec<Side> {
    let all = || mesh.triangles.iter().zip(0..).flat_map(|(corners, face)| sides(*corners, face));
    let mut ends = vec![0usize; mesh.positions.len() + 1];
    for side in all() {
        ends[side.vertices[0] as usize + 1] += 1;
    }
    for vertex in 1..ends.len() {
        ends[vertex] += ends[vertex - 1];
    }
    let mut next = ends.clone();
    let mut sorted = vec![Side::default(); 3 * mesh.triangles.len()];
    for side in all() {
        let place = &mut next[side.vertices[0] as usize];
        sorted[*place] = side;
        *place += 1;
    }
    for bucket in ends.windows(2) {
        sorted[bucket[0]..bucket[1]].sort_unstable();
    }
    sorted
}

fn sides(corners: [u32; 3], face: u32) -> [Side; 3] {
    [0u8, 1, 2].map(|edge| {
        let (from, to) = (corners[usize::from(edge)], corners[(usize::from(edge) + 1) % 3]);
        Side { vertices: [from.min(to), from.max(to)], face, edge, reversed: from > to }
    })
}

/// Signed angle [rad] from one triangle's normal to the other's about their edge, in the first triangle's direction.
fn turn(mesh: &Mesh, here: Side, [one, other]: [DVec3; 2]) -> f64 {
    let [from, to] = edge_ends(mesh, here.face, here.edge);
    one.cross(other).dot((to - from).normalize_or_zero()).atan2(one.dot(other))
}

/// Start and end [m] of an edge of a triangle.
fn edge_ends(mesh: &Mesh, face: u32, edge: u8) -> [DVec3; 2] {
    let corners = mesh.corners(face as usize);
    [corners[usize::from(edge)], corners[(usize::from(edge) + 1) % 3]]
}
