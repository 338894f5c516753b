//! Winding number of any point of a closed surface, by counting crossings of the upward ray from the point.
//!
//! The rule is that of `columns.rs`, for points off the lattice; no ray slips through an edge (`crossing.rs`).

use std::time::Duration;

use glam::{DVec3, Vec3A};
use obvhs::BvhBuildParams;
use obvhs::aabb::Aabb;
use obvhs::bvh2::Bvh2;
use obvhs::bvh2::builder::build_bvh2;

use super::skin::Corners;
use crate::crossing::crossing_above;

/// Triangles in a hierarchy of boxes.
pub(super) struct BoxTree {
    /// Corners [m].
    pub(super) triangles: Vec<Corners>,
    /// Offset subtracted from all coordinates before conversion to f32 [m].
    centre: DVec3,
    /// Each triangle's box in f32, enlarged by more than the rounding.
    boxes: Vec<Aabb>,
    tree: Bvh2,
}

impl BoxTree {
    /// - `tolerance`: triangles with at most this distance between them intersect [m]
    pub(super) fn new(triangles: Vec<Corners>, tolerance: f64) -> Self {
        let corners = triangles.iter().flatten();
        let (low, high) = corners.fold((DVec3::INFINITY, DVec3::NEG_INFINITY), |(l, h), &p| (l.min(p), h.max(p)));
        let centre = if triangles.is_empty() { DVec3::ZERO } else { low.midpoint(high) };
        let margin = tolerance + 1e-6 * (high - low).length();
        let outer_box = |corners: &Corners| {
            let [a, b, c] = corners.map(|corner| (corner - centre).as_vec3());
            Aabb::new(Vec3A::from(a.min(b).min(c)) - margin as f32, Vec3A::from(a.max(b).max(c)) + margin as f32)
        };
        let boxes: Vec<Aabb> = triangles.iter().map(outer_box).collect();
        let tree = match boxes.is_empty() {
            true => Bvh2::default(),
            false => build_bvh2(&boxes, BvhBuildParams::fast_build(), &mut Duration::default()),
        };
        Self { triangles, centre, boxes, tree }
    }

    /// Calls `visit` with every triangle whose box meets that of triangle `t`, including `t` itself.
    pub(super) fn near(&self, t: usize, visit: impl FnMut(usize)) {
        self.within(self.boxes[t], visit);
    }

    /// Winding number at a point [m] that is not on the surface, if the triangles form a closed surface.
    pub(super) fn winding_number(&self, point: DVec3) -> i32 {
        let low = Vec3A::from((point - self.centre).as_vec3());
        let mut winding = 0;
        self.within(Aabb::new(low, low.with_z(f32::INFINITY)), |t| {
            winding += crossing_above(&self.triangles[t], point);
        });
        winding
    }

    fn within(&self, bounds: Aabb, mut visit: impl FnMut(usize)) {
        self.tree.aabb_traverse(bounds, |tree, node| {
            let node = &tree.nodes[node as usize];
            let leaves = &tree.primitive_indices[node.first_index as usize..][..node.prim_count as usize];
            let met = leaves.iter().map(|&leaf| leaf as usize).filter(|&t| self.boxes[t].intersect_aabb(&bounds));
            met.for_each(&mut visit);
            true
        });
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::bake::WindingTree;
    use crate::mesh::tests::{cuboid, uv_sphere};

    #[test]
    fn crossings_above_give_the_winding_number_of_nested_and_overlapping_bodies() {
        let mut mesh = uv_sphere(0.02, 40, 20);
        mesh.append(&uv_sphere(0.015, 30, 15));
        mesh.append(&cuboid(DVec3::new(0.0, -0.01, -0.01), DVec3::new(0.03, 0.01, 0.01)));
        let corners: Vec<Corners> = (0..mesh.triangles.len()).map(|t| mesh.corners(t)).collect();
        let (boxes, tree) = (BoxTree::new(corners.clone(), 0.0), WindingTree::of(corners));
        let mut seen = [0; 4];
        for i in 0..2000 {
            let t = f64::from(i);
            let point = DVec3::new((t * 0.7).sin(), (t * 1.3).cos(), (t * 0.37).sin()) * 0.032;
            let winding = boxes.winding_number(point);
            assert_eq!(f64::from(winding), tree.winding_number(point).round(), "at {point}");
            seen[winding as usize] += 1;
        }
        assert!(seen.iter().all(|&count| count > 0), "{seen:?}");
    }

    #[test]
    fn rays_through_edges_and_vertices_cross_once() {
        let mesh = cuboid(DVec3::ZERO, DVec3::ONE);
        let boxes = BoxTree::new((0..12).map(|t| mesh.corners(t)).collect(), 0.0);
        for i in 0..9 {
            let (x, y) = (f64::from(i % 3) * 0.5, f64::from(i / 3) * 0.5);
            // Of two opposite sides one counts as inside.
            let inside = i32::from(x < 1.0 && y < 1.0);
            let found = [-0.5, 0.5, 1.5].map(|z| boxes.winding_number(DVec3::new(x, y, z)));
            assert_eq!(found, [0, inside, 0], "at ({x}, {y})");
        }
    }
}
