//! Exact depth below a mesh, whose field alone would round its edges because it is linear between voxels.

use std::fmt;

use glam::DVec3;
use sdf_bake::bake::WindingTree;
use sdf_bake::query::MeshQuery;
use sdf_bake::{BrickGrid, Mesh};

/// Distance from the mesh up to which the mesh is used [voxels of the field].
const NEAR: f64 = 4.0;
/// Maximum error of a value between a distance field's voxels [voxels]: the root of Σ f(1-f) over the axes, and
/// rounding.
const ROUGH: f64 = 0.87;

/// A closed mesh without internal walls, prepared for depth queries.
pub struct MeshDepth {
    query: MeshQuery,
    winding: WindingTree,
}

impl fmt::Debug for MeshDepth {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("MeshDepth").finish_non_exhaustive()
    }
}

impl MeshDepth {
    /// Prepares a mesh.
    pub fn new(mesh: &Mesh) -> Self {
        Self { query: MeshQuery::new(mesh), winding: WindingTree::new(mesh) }
    }

    /// Depth [m] of a point below the surface. Its baked `field` gives the sign away from the surface. Far outside, the
    /// depth is a bound: the gap is larger.
    pub(crate) fn depth(&self, at: DVec3, field: &BrickGrid) -> f64 {
        let rough = f64::from(field.sample(at));
        if rough > NEAR * field.voxel {
            return field.voxel - rough;
        }
        let distance = self.query.closest(at).distance;
        let is_sure = rough.abs() > ROUGH * field.voxel;
        let is_inside = if is_sure { rough < 0.0 } else { self.winding.winding_number(at) > 0.5 };
        if is_inside { distance } else { -distance }
    }
}

#[cfg(test)]
mod tests {
    use sdf_bake::{BakeOptions, SignChoice, bake};

    use super::*;

    #[test]
    fn a_box_keeps_its_edges_between_voxels() {
        let (low, high) = (DVec3::new(-0.0051, -0.0032, 0.0), DVec3::new(0.0049, 0.0037, 0.004));
        let corner = |i: usize| {
            let side = |bit: usize, low: f64, high: f64| if i >> bit & 1 == 0 { low } else { high };
            DVec3::new(side(0, low.x, high.x), side(1, low.y, high.y), side(2, low.z, high.z))
        };
        let quads = [[0, 2, 3, 1], [4, 5, 7, 6], [0, 1, 5, 4], [2, 6, 7, 3], [0, 4, 6, 2], [1, 3, 7, 5]];
        let triangles = quads.iter().flat_map(|&[a, b, c, d]| [[a, b, c], [a, c, d]]).collect();
        let mesh = Mesh { positions: (0..8).map(corner).collect(), triangles };
        let options = BakeOptions { voxel: 5e-4, band_voxels: 8.0, sign: SignChoice::Auto, shell: None };
        let (field, _) = bake(&mesh, &options).expect("a box");
        let depths = MeshDepth::new(&mesh);
        let exact = |p: DVec3| {
            let q = (p - 0.5 * (low + high)).abs() - 0.5 * (high - low);
            -(q.max(DVec3::ZERO).length() + q.max_element().min(0.0))
        };
        let (mut of_mesh, mut of_field) = (0f64, 0f64);
        for i in 0..4000 {
            let t = |k: usize| (i * k % 997) as f64 / 997.0 * 1.2 - 0.1;
            let at = low + (high - low) * DVec3::new(t(131), t(277), 0.3 * t(419));
            of_mesh = of_mesh.max((depths.depth(at, &field) - exact(at)).abs());
            of_field = of_field.max((-f64::from(field.sample(at)) - exact(at)).abs());
        }
        println!("depth off by {of_mesh:.1e} m by the mesh, {of_field:.1e} m by the field");
        assert!(of_mesh < 1e-12 && of_field > 2e-5);
    }
}
