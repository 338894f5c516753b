//! Nesting of closed shells, by counting crossings of a vertical ray.

use glam::DVec3;

use crate::Mesh;
use crate::crossing::crossing_above;

/// Returns, for each shell, the outermost closed shell that contains it, if any.
///
/// - `shells`: triangle indices of each shell, none empty
/// - `closed`: true for shells that enclose a volume; open shells contain nothing and lie in nothing
pub(super) fn outermost_containers(mesh: &Mesh, shells: &[Vec<usize>], closed: &[bool]) -> Vec<Option<usize>> {
    let boxes: Vec<_> = shells.iter().map(|triangles| bounds(mesh, triangles)).collect();
    let containers: Vec<Vec<usize>> = (0..shells.len())
        .map(|shell| {
            if !closed[shell] {
                return Vec::new();
            }
            let p = sample_point(mesh, &shells[shell]);
            let around = |&other: &usize| {
                let (low, high) = boxes[other];
                other != shell && closed[other] && low.cmplt(p).all() && high.cmpgt(p).all()
            };
            (0..shells.len()).filter(around).filter(|&other| contains(mesh, &shells[other], p)).collect()
        })
        .collect();
    containers.iter().map(|list| list.iter().copied().find(|&c| containers[c].is_empty())).collect()
}

fn bounds(mesh: &Mesh, triangles: &[usize]) -> (DVec3, DVec3) {
    let infinite = (DVec3::INFINITY, DVec3::NEG_INFINITY);
    let corners = triangles.iter().flat_map(|&t| mesh.corners(t));
    corners.fold(infinite, |(low, high), p| (low.min(p), high.max(p)))
}

/// Returns a point of the largest triangle, at uneven weights so that it is not above another shell's corner or edge.
fn sample_point(mesh: &Mesh, triangles: &[usize]) -> DVec3 {
    let area = |&t: &usize| mesh.doubled_area_normal(t).length_squared();
    let largest = triangles.iter().copied().max_by(|a, b| area(a).total_cmp(&area(b)).then(b.cmp(a)));
    let [a, b, c] = mesh.corners(largest.unwrap_or(triangles[0]));
    a + (b - a) * 0.287_654_321 + (c - a) * 0.412_345_678
}

fn contains(mesh: &Mesh, triangles: &[usize], p: DVec3) -> bool {
    triangles.iter().filter(|&&t| crossing_above(&mesh.corners(t), p) != 0).count() % 2 == 1
}
