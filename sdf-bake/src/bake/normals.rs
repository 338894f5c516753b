//! Sign from angle-weighted normals.
//!
//! A point is outside if it lies on the outer side of the normal at its closest surface point: the face's own normal,
//! on an edge the sum of its two faces' normals, at a vertex the sum of its faces' normals weighted by their angles
//! (Bærentzen & Aanæs 2005). This holds for closed, consistently oriented surfaces that do not intersect themselves or
//! one another.

use glam::DVec3;

use crate::Mesh;
use crate::clean::EdgeMap;
use crate::query::MeshQuery;

/// Barycentric coordinates below this are on an edge or a vertex.
const ON_EDGE: f64 = 1e-9;

pub(super) struct Normals<'a> {
    mesh: &'a Mesh,
    edges: &'a EdgeMap,
    query: MeshQuery,
    /// Angle-weighted normal of each vertex.
    vertices: Vec<DVec3>,
}

/// Reason why normals can give wrong signs on a surface, if any.
pub(super) fn doubt(mesh: &Mesh, edges: &EdgeMap) -> Option<String> {
    let count = |is_so: &dyn Fn(usize) -> bool| edges.indices().filter(|&edge| is_so(edge)).count();
    let open = edges.boundary_count();
    let shared = edges.non_manifold_count();
    let turned = count(&|edge| edges.uses(edge).len() == 2 && !edges.is_balanced(edge));
    let flat = (0..mesh.triangles.len()).filter(|&t| mesh.normal(t) == DVec3::ZERO).count();
    [
        (open, "boundary edges"),
        (shared, "edges of more than two triangles"),
        (turned, "edges where orientations disagree"),
        (flat, "triangles without a normal"),
    ]
    .iter()
    .find(|(count, _)| *count > 0)
    .map(|(count, what)| format!("the surface has {count} {what}"))
}

impl<'a> Normals<'a> {
    /// - `mesh`: a mesh for which [`doubt`] is `None`
    pub(super) fn new(mesh: &'a Mesh, edges: &'a EdgeMap) -> Self {
        let mut vertices = vec![DVec3::ZERO; mesh.positions.len()];
        for (t, corners) in mesh.triangles.iter().enumerate() {
            let positions = mesh.corners(t);
            for (i, &vertex) in corners.iter().enumerate() {
                let [here, next, last] = [0, 1, 2].map(|step| positions[(i + step) % 3]);
                vertices[vertex as usize] += (next - here).angle_between(last - here) * mesh.normal(t);
            }
        }
        Self { mesh, edges, query: MeshQuery::new(mesh), vertices }
    }

    /// True if a point [m] is inside.
    pub(super) fn is_inside(&self, point: DVec3) -> bool {
        let closest = self.query.closest(point);
        let triangle = closest.triangle as usize;
        let on: Vec<usize> = (0..3).filter(|&i| closest.barycentric[i] > ON_EDGE).collect();
        let normal = match on[..] {
            [corner] => self.vertices[self.mesh.triangles[triangle][corner] as usize],
            [first, second] => {
                let side = if second == first + 1 { first } else { second };
                let edge = self.edges.of_triangle(triangle)[side] as usize;
                self.edges.uses(edge).iter().map(|u| self.mesh.normal(u.triangle as usize)).sum()
            }
            _ => self.mesh.normal(triangle),
        };
        (point - closest.point).dot(normal) < 0.0
    }
}
