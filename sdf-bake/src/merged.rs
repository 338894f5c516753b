//! Defects that keep a surface from being a manifold once equal positions are merged.

use std::collections::HashMap;

use glam::DVec3;

use crate::Mesh;

/// Defects of a surface as a closed manifold, once vertices at equal positions are merged.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Merged {
    /// Edges that triangles do not use exactly once in each direction.
    pub uneven_edges: usize,
    /// Triangles without area.
    pub flat_triangles: usize,
}

impl Merged {
    /// Merges the vertices of a surface and counts its defects.
    pub fn of(surface: &Mesh) -> Self {
        let mut known: HashMap<[u64; 3], u32> = HashMap::with_capacity(surface.positions.len());
        let mut place = |position: &DVec3| {
            let next = known.len() as u32;
            *known.entry(position.to_array().map(|x| (x + 0.0).to_bits())).or_insert(next)
        };
        let places: Vec<u32> = surface.positions.iter().map(&mut place).collect();
        let mut passes: HashMap<(u32, u32), [u32; 2]> = HashMap::new();
        for corners in &surface.triangles {
            let [a, b, c] = corners.map(|corner| places[corner as usize]);
            for (from, to) in [(a, b), (b, c), (c, a)] {
                passes.entry((from.min(to), from.max(to))).or_default()[usize::from(from > to)] += 1;
            }
        }
        let is_flat = |triangle: &usize| surface.doubled_area_normal(*triangle) == DVec3::ZERO;
        Self {
            uneven_edges: passes.values().filter(|ways| **ways != [1, 1]).count(),
            flat_triangles: (0..surface.triangles.len()).filter(is_flat).count(),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn is_manifold(surface: &Mesh) -> bool {
        Merged::of(surface) == Merged::default()
    }

    /// A tetrahedron whose triangles have separate vertices.
    fn tetrahedron(corners: [DVec3; 4]) -> Mesh {
        let sides = [[0, 2, 1], [0, 1, 3], [1, 2, 3], [2, 0, 3]];
        let positions = sides.iter().flatten().map(|&corner| corners[corner]).collect();
        Mesh { positions, triangles: (0..4).map(|side| [3 * side, 3 * side + 1, 3 * side + 2]).collect() }
    }

    #[test]
    fn a_surface_is_closed_only_if_its_merged_edges_have_two_triangles() {
        let [a, b] = [DVec3::ZERO, DVec3::Z];
        let one = tetrahedron([a, DVec3::X, DVec3::Y, b]);
        assert!(is_manifold(&one), "a closed surface whose triangles share no vertex");
        let mut open = one.clone();
        open.triangles.pop();
        assert!(!is_manifold(&open), "an open one");
        let mut crowded = one.clone();
        crowded.append(&tetrahedron([a, -DVec3::X, -DVec3::Y, b]));
        assert!(!is_manifold(&crowded), "two bodies that share an edge, which has four triangles");
        let mut flapped = one;
        let [p, q, r] = [0, 1, 2].map(|corner| flapped.positions[corner]);
        let first = flapped.positions.len() as u32;
        flapped.positions.extend([p, q, r, p, r, q]);
        flapped.triangles.extend([[first, first + 1, first + 2], [first + 3, first + 4, first + 5]]);
        assert!(!is_manifold(&flapped), "a fold of two triangles on a face");
    }

    #[test]
    fn a_triangle_without_area_is_found() {
        let mut surface = tetrahedron([DVec3::ZERO, DVec3::X, DVec3::Y, DVec3::Z]);
        surface.positions[0] = 0.5 * (surface.positions[1] + surface.positions[2]);
        assert_eq!(Merged::of(&surface).flat_triangles, 1);
    }
}
