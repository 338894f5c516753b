//! A tool of arbitrary shape.

use std::sync::Arc;

use glam::DVec3;
use sdf_bake::BrickGrid;

use super::MeshDepth;
use super::tool::Shape;

/// A tool from a mesh, baked into a distance field. Its reference point is the origin of its field.
///
/// With the mesh its depth is exact. From the field alone the depth is linear between voxels, which rounds edges, and
/// clamped to the band: bake the band wider than the deepest press.
#[derive(Clone, Debug)]
pub struct FieldTool {
    /// The tool in its own frame, its lowest point at the origin, inside negative.
    pub field: Arc<BrickGrid>,
    /// Lowest corner of the tool's box in its own frame [m].
    pub low: DVec3,
    /// Highest corner [m].
    pub high: DVec3,
    /// The mesh in the tool's frame, if it has no internal walls.
    pub mesh: Option<Arc<MeshDepth>>,
}

impl PartialEq for FieldTool {
    /// True if both share the same baked field; two separate equal fields count as different.
    fn eq(&self, other: &Self) -> bool {
        Arc::ptr_eq(&self.field, &other.field)
    }
}

impl Shape for FieldTool {
    fn depth(&self, at: DVec3) -> f64 {
        match &self.mesh {
            Some(mesh) => mesh.depth(at, &self.field),
            None => -f64::from(self.field.sample(at)),
        }
    }

    fn half_footprint(&self, _: f64) -> (f64, f64) {
        let reach = self.low.abs().max(self.high.abs());
        (reach.x, reach.y)
    }

    fn rim_radius(&self) -> f64 {
        self.low.abs().max(self.high.abs()).truncate().max_element()
    }

    fn width(&self) -> f64 {
        self.high.y - self.low.y
    }

    fn sizes(&self) -> Vec<(&'static str, f64)> {
        vec![("tool field voxel [m]", self.field.voxel)]
    }
}
