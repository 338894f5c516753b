//! Welding: one vertex for each position.
//!
//! Equal positions are merged first. A tolerance is then applied to vertices on boundary edges only, because it serves
//! to close cracks between neighbours. A closed surface is unchanged, even with thin walls or short edges, and so is a
//! face that closes no crack. Two ends of an edge are never merged.

use std::collections::HashMap;

use glam::{DVec3, I64Vec3};

use super::EdgeMap;
use crate::Mesh;

/// Greatest gap that is closed, relative to the bounding box's diagonal.
const RELATIVE_TOLERANCE: f64 = 1e-6;

/// Greatest number of groups in a cube, and of vertices in a group, more than cracks make. Above it the tolerance is
/// too coarse for the part, and further vertices stay unmerged.
const MAX_GROUPS: usize = 8;
const MAX_MEMBERS: usize = 16;

/// Merges vertices at equal positions; returns the number of removed vertices.
pub(super) fn merge_equal(mesh: &mut Mesh) -> usize {
    let mut first_at = HashMap::with_capacity(mesh.positions.len());
    let mut kept = Vec::new();
    let mut target = Vec::with_capacity(mesh.positions.len());
    for &position in &mesh.positions {
        // Adding zero turns -0 into 0.
        let bits = (position + DVec3::ZERO).to_array().map(f64::to_bits);
        target.push(*first_at.entry(bits).or_insert_with(|| {
            kept.push(position);
            kept.len() as u32 - 1
        }));
    }
    let merged = mesh.positions.len() - kept.len();
    mesh.positions = kept;
    redirect(mesh, &target);
    merged
}

/// Merges boundary vertices closer than the tolerance if that closes an edge; returns the number of merged vertices and
/// the tolerance [m].
///
/// The merged vertices stay in `positions`, unused. In the order of their index, each vertex joins the nearest earlier
/// one within reach, so chains do not drift. Faces that only come close at a corner do not move: moving one would close
/// nothing and change the distance.
pub(super) fn close_cracks(mesh: &mut Mesh) -> (usize, f64) {
    let tolerance = RELATIVE_TOLERANCE * mesh.diagonal();
    let edges = EdgeMap::new(mesh);
    let mut on_boundary: Vec<u32> =
        edges.indices().filter(|&e| edges.uses(e).len() == 1).flat_map(|e| edges.vertices(e)).collect();
    on_boundary.sort_unstable();
    on_boundary.dedup();
    let mut target: Vec<u32> = (0..mesh.positions.len() as u32).collect();
    let mut clusters = Clusters { mesh, edges: &edges, tolerance, cells: HashMap::new(), members: HashMap::new() };
    for &vertex in &on_boundary {
        if let Some(representative) = clusters.join(vertex) {
            target[vertex as usize] = representative;
        }
    }
    let closes = closing_vertices(&edges, &target);
    let mut merged = 0;
    for vertex in on_boundary {
        let target = &mut target[vertex as usize];
        if !closes[vertex as usize] {
            *target = vertex;
        }
        merged += usize::from(*target != vertex);
    }
    redirect(mesh, &target);
    (merged, tolerance)
}

/// Marks the vertices at the ends of boundary edges that coincide with another boundary edge.
fn closing_vertices(edges: &EdgeMap, target: &[u32]) -> Vec<bool> {
    let mut joined: HashMap<[u32; 2], Vec<usize>> = HashMap::new();
    for edge in edges.indices().filter(|&edge| edges.uses(edge).len() == 1) {
        let mut ends = edges.vertices(edge).map(|vertex| target[vertex as usize]);
        ends.sort_unstable();
        joined.entry(ends).or_default().push(edge);
    }
    let mut closes = vec![false; target.len()];
    for &edge in joined.values().filter(|edges| edges.len() > 1).flatten() {
        edges.vertices(edge).iter().for_each(|&vertex| closes[vertex as usize] = true);
    }
    closes
}

fn redirect(mesh: &mut Mesh, target: &[u32]) {
    for triangle in &mut mesh.triangles {
        *triangle = triangle.map(|vertex| target[vertex as usize]);
    }
}

/// Groups of close vertices, found through a hash grid with a cell size of one tolerance.
struct Clusters<'a> {
    mesh: &'a Mesh,
    edges: &'a EdgeMap,
    tolerance: f64,
    /// Representatives in each cube.
    cells: HashMap<I64Vec3, Vec<u32>>,
    /// Vertices of each representative's group.
    members: HashMap<u32, Vec<u32>>,
}

impl Clusters<'_> {
    /// Adds a vertex to the nearest group within reach and returns its representative, or starts a group.
    fn join(&mut self, vertex: u32) -> Option<u32> {
        let position = self.mesh.positions[vertex as usize];
        let cell = (position / self.tolerance).floor().as_i64vec3();
        let nearest = (0..27)
            .map(|i| cell + I64Vec3::new(i % 3 - 1, i / 3 % 3 - 1, i / 9 - 1))
            .filter_map(|cell| self.cells.get(&cell))
            .flatten()
            .map(|&other| (position.distance(self.mesh.positions[other as usize]), other))
            .filter(|&(distance, other)| distance <= self.tolerance && self.may_join(vertex, other))
            .min_by(|a, b| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1)));
        match nearest {
            Some((_, representative)) => self.members.entry(representative).or_default().push(vertex),
            None => {
                let groups = self.cells.entry(cell).or_default();
                if groups.len() < MAX_GROUPS {
                    groups.push(vertex);
                    self.members.insert(vertex, vec![vertex]);
                }
            }
        }
        nearest.map(|(_, representative)| representative)
    }

    fn may_join(&self, vertex: u32, representative: u32) -> bool {
        let members = &self.members[&representative];
        members.len() < MAX_MEMBERS && members.iter().all(|&member| self.edges.find(vertex, member).is_none())
    }
}
