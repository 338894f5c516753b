//! The edges of a triangle mesh, each with the triangles that share it.

use std::ops::Range;

use crate::Mesh;

/// One triangle's use of an edge.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct EdgeUse {
    /// Triangle index.
    pub triangle: u32,
    /// Whether the triangle passes the edge from its smaller to its larger vertex.
    pub forward: bool,
}

/// All undirected edges in the order of their vertices.
///
/// An edge with one use is a boundary edge, with more than two uses a non-manifold one. Triangles with a repeated
/// corner have edges from a vertex to itself; drop them first ([`crate::clean::clean`] does).
#[derive(Clone, Debug, Default)]
pub struct EdgeMap {
    vertices: Vec<[u32; 2]>,
    /// First use of each edge, and one past the last.
    first: Vec<u32>,
    uses: Vec<EdgeUse>,
    of_triangle: Vec<[u32; 3]>,
}

impl EdgeMap {
    /// Collects the edges of a mesh in O(n log n).
    pub fn new(mesh: &Mesh) -> Self {
        let mut sides: Vec<(u64, u32)> = Vec::with_capacity(3 * mesh.triangles.len());
        for (t, corners) in mesh.triangles.iter().enumerate() {
            for side in 0..3 {
                let (a, b) = (corners[side], corners[(side + 1) % 3]);
                sides.push((key(a, b), 3 * t as u32 + side as u32));
            }
        }
        sides.sort_unstable();
        let mut map = Self { of_triangle: vec![[0; 3]; mesh.triangles.len()], ..Self::default() };
        map.uses.reserve_exact(sides.len());
        let mut last = None;
        for (key, side) in sides {
            if last != Some(key) {
                map.vertices.push([(key >> 32) as u32, key as u32]);
                map.first.push(map.uses.len() as u32);
                last = Some(key);
            }
            let (triangle, side) = (side / 3, side as usize % 3);
            let from = mesh.triangles[triangle as usize][side];
            map.of_triangle[triangle as usize][side] = map.vertices.len() as u32 - 1;
            map.uses.push(EdgeUse { triangle, forward: u64::from(from) == key >> 32 });
        }
        map.first.push(map.uses.len() as u32);
        map
    }

    /// Number of edges.
    pub fn len(&self) -> usize {
        self.vertices.len()
    }

    /// Whether the mesh has no edges.
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

    /// The triangles at an edge, in the order of their index.
    pub fn uses(&self, edge: usize) -> &[EdgeUse] {
        &self.uses[self.first[edge] as usize..self.first[edge + 1] as usize]
    }

    /// The edges of a triangle; the first runs from its first corner to its second.
    pub fn of_triangle(&self, triangle: usize) -> [u32; 3] {
        self.of_triangle[triangle]
    }

    /// The edge between two vertices.
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

    /// Whether as many triangles pass the edge forward as backward.
    pub fn is_balanced(&self, edge: usize) -> bool {
        let uses = self.uses(edge);
        2 * uses.iter().filter(|u| u.forward).count() == uses.len()
    }

    /// Labels triangles that hang together across the edges for which `joins` holds.
    ///
    /// Returns a label for each triangle and the number of labels; labels are numbered by their first triangle.
    pub fn components(&self, joins: impl Fn(&[EdgeUse]) -> bool) -> (Vec<u32>, usize) {
        let mut labels = vec![u32::MAX; self.of_triangle.len()];
        // Each edge once, or an edge of n triangles costs n².
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

fn key(a: u32, b: u32) -> u64 {
    u64::from(a.min(b)) << 32 | u64::from(a.max(b))
}
