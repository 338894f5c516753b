//! Closed meshes from rings of points.

use glam::DVec3;
use sdf_bake::Mesh;

/// Lofts a surface over rings with equal numbers of points, closed by a tip at each end. Normals point outwards if the
/// rings run counter-clockwise seen from the last tip.
pub(crate) fn loft(rings: &[Vec<DVec3>], [first, last]: [DVec3; 2]) -> Mesh {
    let around = rings.first().map_or(0, Vec::len) as u32;
    let mut positions = vec![first, last];
    positions.extend(rings.iter().flatten());
    let vertex = |ring: usize, i: u32| 2 + ring as u32 * around + i % around;
    let mut triangles = Vec::new();
    for i in 0..around {
        triangles.push([0, vertex(0, i + 1), vertex(0, i)]);
        triangles.push([1, vertex(rings.len() - 1, i), vertex(rings.len() - 1, i + 1)]);
        for ring in 1..rings.len() {
            let [near, far] = [ring - 1, ring].map(|ring| [vertex(ring, i), vertex(ring, i + 1)]);
            triangles.extend([[near[0], near[1], far[1]], [near[0], far[1], far[0]]]);
        }
    }
    Mesh { positions, triangles }
}
