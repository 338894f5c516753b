//! The edges of a triangle mesh, each with the triangles that share it.

use std::ops::Range;

use crate::Mesh;

/// One triangle's use of an edge.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct EdgeUse {
    /// Triangle index.
    pub triangle: u32,
    /// True if the triangle runs along the edge from its smaller to its larger vertex.
    pub forward: bool,
}

/// All undirected edges in the order of their vertices.
///
/// An edge with one use is a boundary edge; one with more than two uses is non-manifold. Triangles with a repeated
/// corner have edges from a vertex to itself; they must be removed first, as [`crate::clean::clean`] does.
#[derive(Clone, Debug, Default)]
pub struct EdgeMap {
    vertices: Vec<[u32; 2]>,
    /// Index of the first use of each edge, and one past the last.
    first: Vec<u32>,
    uses: Vec<EdgeUse>,
    of_triangle: Vec<[u32; 3]>,
}

impl EdgeMap {
    /// Collects the edges of a mesh in O(n log m) for n triangles, at most m of them at a vertex.
    pub fn new(mesh: &Mesh) -> Self {
        let (mut sides, ends) = sides_by_vertex(&mesh.triangles);
        let mut map = Self { of_triangle: vec![[0; 3]; mesh.triangles.len()], ..Self::default() };
        map.vertices.reserve(sides.len() / 2);
        map.first.reserve(sides.len() / 2 + 1);
        map.uses.reserve_exact(sides.len());
        let mut start = 0;
        for (low, end) in ends.into_iter().enumerate() {
            let sides = &mut sides[start..end as usize];
            start = end as usize;
            sides.sort_unstable();
            let mut last = None;
            for &Side { high, number } in sides.iter() {
                if last != Some(high) {
                    map.vertices.push([low as u32, high]);
                    map.first.push(map.uses.len() as u32);
                    last = Some(high);
                }
                let (triangle, side) = (number / 3, number as usize % 3);
                let corners = &mesh.triangles[triangle as usize];
                map.of_triangle[triangle as usize][side] = map.vertices.len() as u32 - 1;
                map.uses.push(EdgeUse { triangle, forward: corners[side] as usize == low });
            }
        }
        map.first.push(map.uses.len() as u32);
        map
    }

    /// Number of edges.
    pub fn len(&self) -> usize {
        self.vertices.len()
    }

    /// True if the mesh has no edges.
    pub fn is_empty(&self) -> bool {
        self.vertices.is_empty()
    }

    /// All edge indices.
    pub fn indices(&self) -> Range<usize> {
        0..self.len()
    }

    /// The two vertices of an edge, the smaller index first.
    pub fn vertices(&self, edge: usize) -> [u32; 2] {
        self.vertices[edge]
    }

    /// Triangles at an edge, in the order of their index.
    pub fn uses(&self, edge: usize) -> &[EdgeUse] {
        &self.uses[self.first[edge] as usize..self.first[edge + 1] as usize]
    }

    /// The edges of a triangle; the first runs from its first corner to its second.
    pub fn of_triangle(&self, triangle: usize) -> [u32; 3] {
        self.of_triangle[triangle]
    }

    /// Index of the edge between two vertices.
    pub fn find(&self, a: u32, b: u32) -> Option<usize> {
        self.vertices.binary_search(&[a.min(b), a.max(b)]).ok()
    }

    /// Number of edges with exactly one triangle.
    pub fn boundary_count(&self) -> usize {
        self.indices().filter(|&edge| self.uses(edge).len() == 1).count()
    }

    /// Number of edges with more than two triangles.
    pub fn non_manifold_count(&self) -> usize {
        self.indices().filter(|&edge| self.uses(edge).len() > 2).count()
    }

    /// True if equal numbers of triangles use the edge forward and backward.
    pub fn is_balanced(&self, edge: usize) -> bool {
        let uses = self.uses(edge);
        2 * uses.iter().filter(|u| u.forward).count() == uses.len()
    }

    /// Labels components of triangles that are connected across the edges for which `joins` returns true.
    ///
    /// Returns a label for each triangle and the number of labels, numbered in the order of their first triangle.
    pub fn components(&self, joins: impl Fn(&[EdgeUse]) -> bool) -> (Vec<u32>, usize) {
        let mut labels = vec![u32::MAX; self.of_triangle.len()];
        // Each edge is visited once; otherwise an edge of n triangles would cost n².
        let mut passed = vec![false; self.len()];
        let mut count = 0;
        let mut stack = Vec::new();
        for seed in 0..labels.len() {
            if labels[seed] != u32::MAX {
                continue;
            }
            labels[seed] = count;
            stack.push(seed);
            while let Some(triangle) = stack.pop() {
                let edges = self.of_triangle[triangle].map(|edge| edge as usize).into_iter();
                let edges = edges.filter(|&edge| !std::mem::replace(&mut passed[edge], true));
                for neighbour in edges.map(|edge| self.uses(edge)).filter(|uses| joins(uses)).flatten() {
                    let label = &mut labels[neighbour.triangle as usize];
                    if *label == u32::MAX {
                        *label = count;
                        stack.push(neighbour.triangle as usize);
                    }
                }
            }
            count += 1;
        }
        (labels, count as usize)
    }
}

/// A side of a triangle, at its smaller vertex.
#[derive(Clone, Copy, Default, PartialEq, Eq, PartialOrd, Ord)]
struct Side {
    /// Its larger vertex.
    high: u32,
    /// Three times the triangle's index, plus the index of the side.
    number: u32,
}

/// Sides of triangles by their smaller vertex, from a counting sort, and the end of each vertex's sides.
fn sides_by_vertex(triangles: &[[u32; 3]]) -> (Vec<Side>, Vec<u32>) {
    let vertices = triangles.iter().flatten().max().map_or(0, |&last| last as usize + 1);
    let ends_of = |[a, b, c]: [u32; 3]| [(a.min(b), a.max(b)), (b.min(c), b.max(c)), (c.min(a), c.max(a))];
    let mut places = vec![0u32; vertices];
    triangles.iter().flat_map(|&corners| ends_of(corners)).for_each(|(low, _)| places[low as usize] += 1);
    let mut total = 0;
    for place in &mut places {
        total += std::mem::replace(place, total);
    }
    let mut sides = vec![Side::default(); total as usize];
    for ((low, high), number) in triangles.iter().flat_map(|&corners| ends_of(corners)).zip(0..) {
        let place = &mut places[low as usize];
        sides[*place as usize] = Side { high, number };
        *place += 1;
    }
    (sides, places)
}
