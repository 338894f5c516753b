//! Seams: concave edges between faces or bodies, chained into lines along which a fillet weld can run.

use std::collections::BTreeMap;
use std::f64::consts::PI;

use glam::DVec3;
use sdf_bake::Mesh;

use crate::topology::{EdgeNeighbour, Topology};
use crate::trace::TracePoint;

/// Least angle [rad] between the normals of the two faces of a seam.
const LEAST_TURN: f64 = 0.52;
/// Greatest change of direction [rad] between consecutive edges of one seam.
const LARGEST_BEND: f64 = 0.52;

/// One edge of a seam.
#[derive(Clone, Copy, Debug)]
struct SeamEdge {
    /// The triangle to its left, which runs along it forwards, and the edge's index in that triangle.
    face: u32,
    edge: u8,
    ends: [u32; 2],
    length: f64,
    /// Unit bisector of the two normals.
    normal: DVec3,
    /// Angle between the faces, measured through open space [rad].
    opening: f64,
}

/// A chain of concave edges.
#[derive(Clone, Debug)]
pub struct Seam {
    edges: Vec<SeamEdge>,
    /// Arc length at the start of each edge, and the total [m].
    starts: Vec<f64>,
    /// True if it returns to its start.
    pub closed: bool,
}

/// Finds all seams of a part, in the order of their first triangle.
pub fn find_seams(mesh: &Mesh, topology: &Topology) -> Vec<Seam> {
    let edges = concave_edges(mesh, topology);
    let mut at_vertex: BTreeMap<u32, Vec<usize>> = BTreeMap::new();
    for (index, edge) in edges.iter().enumerate() {
        edge.ends.iter().for_each(|vertex| at_vertex.entry(*vertex).or_default().push(index));
    }
    let mut free = vec![true; edges.len()];
    let mut seams = Vec::new();
    for first in 0..edges.len() {
        if !free[first] {
            continue;
        }
        free[first] = false;
        let mut chain = vec![edges[first]];
        let forwards = |chain: &[SeamEdge]| chain.last().copied();
        while let Some(next) = forwards(&chain).and_then(|last| follower(mesh, &edges, &at_vertex, &mut free, &last)) {
            chain.push(next);
        }
        let turned = |edge: SeamEdge| SeamEdge { ends: [edge.ends[1], edge.ends[0]], ..edge };
        let mut back = Vec::new();
        let mut last = turned(chain[0]);
        while let Some(next) = follower(mesh, &edges, &at_vertex, &mut free, &last) {
            back.push(turned(next));
            last = next;
        }
        seams.push(Seam::of(back.into_iter().rev().chain(chain).collect()));
    }
    seams
}

/// Returns the unused edge that continues from the end of another without a corner, if there is exactly one candidate.
fn follower(
    mesh: &Mesh,
    edges: &[SeamEdge],
    at_vertex: &BTreeMap<u32, Vec<usize>>,
    free: &mut [bool],
    last: &SeamEdge,
) -> Option<SeamEdge> {
    let direction =
        |ends: [u32; 2]| (mesh.positions[ends[1] as usize] - mesh.positions[ends[0] as usize]).normalize_or_zero();
    let here = at_vertex.get(&last.ends[1])?;
    let [one, other] = here[..] else { return None };
    let next =
        if edges[one].ends == last.ends || edges[one].ends == [last.ends[1], last.ends[0]] { other } else { one };
    let found = edges[next];
    let ends = if found.ends[0] == last.ends[1] { found.ends } else { [found.ends[1], found.ends[0]] };
    let straight = direction(last.ends).dot(direction(ends)) > LARGEST_BEND.cos();
    (straight && std::mem::take(&mut free[next])).then_some(SeamEdge { ends, ..found })
}

fn concave_edges(mesh: &Mesh, topology: &Topology) -> Vec<SeamEdge> {
    let of_face = |(face, across): (usize, &[EdgeNeighbour; 3])| {
        let corners = mesh.triangles[face];
        let edge = move |edge: usize, across: EdgeNeighbour| match across {
            EdgeNeighbour::Face { face: other, turn, .. } if turn < -LEAST_TURN && face < other as usize => {
                let ends = [corners[edge], corners[(edge + 1) % 3]];
                let [from, to] = ends.map(|vertex| mesh.positions[vertex as usize]);
                let normal = (mesh.normal(face) + mesh.normal(other as usize)).try_normalize()?;
                let (face, edge, length) = (face as u32, edge as u8, from.distance(to));
                (length > 0.0).then_some(SeamEdge { face, edge, ends, length, normal, opening: PI + turn })
            }
            _ => None,
        };
        [0, 1, 2].map(|i| edge(i, across[i])).into_iter().flatten().collect::<Vec<_>>()
    };
    topology.across.iter().enumerate().flat_map(of_face).collect()
}

impl Seam {
    fn of(edges: Vec<SeamEdge>) -> Self {
        let mut starts = vec![0.0];
        for edge in &edges {
            starts.push(starts[starts.len() - 1] + edge.length);
        }
        let closed = edges.len() > 2 && edges[0].ends[0] == edges[edges.len() - 1].ends[1];
        Self { edges, starts, closed }
    }

    /// Total arc length [m].
    pub fn length(&self) -> f64 {
        self.starts[self.edges.len()]
    }

    /// Least and greatest angle between the faces [rad] over a stretch [m].
    pub fn openings(&self, [from, to]: [f64; 2]) -> [f64; 2] {
        let inside = |i: &usize| self.starts[*i + 1] > from && self.starts[*i] < to;
        let wraps = |i: &usize| self.closed && self.starts[*i] < to - self.length();
        let openings = (0..self.edges.len()).filter(|i| inside(i) || wraps(i)).map(|i| self.edges[i].opening);
        openings.fold([f64::INFINITY, 0.0], |[low, high], opening| [low.min(opening), high.max(opening)])
    }

    /// Returns the point at an arc length [m]; beyond the end of a closed seam it wraps around.
    pub fn point_at(&self, mesh: &Mesh, s: f64) -> TracePoint {
        let s = if self.closed { s.rem_euclid(self.length()) } else { s.clamp(0.0, self.length()) };
        let index = self.starts.partition_point(|start| *start <= s).clamp(1, self.edges.len()) - 1;
        let edge = &self.edges[index];
        let share = ((s - self.starts[index]) / edge.length).clamp(0.0, 1.0);
        let corners = mesh.triangles[edge.face as usize];
        let mut barycentric = [0.0; 3];
        for (vertex, weight) in edge.ends.into_iter().zip([1.0 - share, share]) {
            let corner = if corners[usize::from(edge.edge)] == vertex { edge.edge } else { (edge.edge + 1) % 3 };
            barycentric[usize::from(corner)] = weight;
        }
        let [from, to] = edge.ends.map(|vertex| mesh.positions[vertex as usize]);
        TracePoint {
            face: edge.face,
            barycentric,
            position: (1.0 - share) * from + share * to,
            tangent: (to - from) / edge.length,
            normal: edge.normal,
        }
    }
}
