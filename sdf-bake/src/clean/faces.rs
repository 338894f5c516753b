//! Removes faces and vertices that are not part of a surface: degenerate and duplicate faces, unused vertices.

use std::collections::HashSet;

use super::EdgeMap;
use crate::Mesh;

/// Height of a triangle relative to its longest side below which it has no usable normal in double precision.
const FLAT: f64 = 1e-12;

/// Removes triangles with a repeated corner; returns their number.
pub(super) fn drop_collapsed(mesh: &mut Mesh) -> usize {
    let before = mesh.triangles.len();
    mesh.triangles.retain(|[a, b, c]| a != b && b != c && c != a);
    before - mesh.triangles.len()
}

/// Removes triangles without height; returns their number.
pub(super) fn drop_flat(mesh: &mut Mesh) -> usize {
    let before = mesh.triangles.len();
    let keep: Vec<bool> = (0..before).map(|t| !is_degenerate(mesh, t)).collect();
    let mut keep = keep.into_iter();
    mesh.triangles.retain(|_| keep.next() == Some(true));
    before - mesh.triangles.len()
}

/// True if a triangle has no usable normal.
pub(super) fn is_degenerate(mesh: &Mesh, triangle: usize) -> bool {
    let [a, b, c] = mesh.corners(triangle);
    let longest_squared = a.distance_squared(b).max(b.distance_squared(c)).max(c.distance_squared(a));
    // Twice the area is height times longest side; NaN counts as degenerate.
    let has_height = mesh.doubled_area_normal(triangle).length() > FLAT * longest_squared;
    !has_height
}

/// Removes faces with the corners and the orientation of an earlier one; returns their number.
///
/// A face and its reverse both stay: two solids touch there.
pub(super) fn drop_duplicates(mesh: &mut Mesh) -> usize {
    let before = mesh.triangles.len();
    let mut seen = HashSet::with_capacity(before);
    mesh.triangles.retain(|&corners| seen.insert(smallest_first(corners)));
    before - mesh.triangles.len()
}

/// Number of pairs of faces that are each other's reverse; the mesh must have no duplicates.
pub(super) fn coincident_pairs(mesh: &Mesh, edges: &EdgeMap) -> usize {
    let reverses = |t: usize| {
        let [a, b, c] = smallest_first(mesh.triangles[t]);
        let sides = edges.of_triangle(t).map(|edge| edges.uses(edge as usize));
        // An edge can have very many triangles, but seldom all three edges do.
        let fewest = sides.into_iter().min_by_key(|uses| uses.len()).unwrap_or_default();
        let others = fewest.iter().map(|u| u.triangle as usize);
        others.filter(|&other| other > t && smallest_first(mesh.triangles[other]) == [a, c, b]).count()
    };
    (0..mesh.triangles.len()).map(reverses).sum()
}

fn smallest_first([a, b, c]: [u32; 3]) -> [u32; 3] {
    if a <= b && a <= c {
        [a, b, c]
    } else if b <= c {
        [b, c, a]
    } else {
        [c, a, b]
    }
}

/// Removes vertices that no face uses, and keeps the order of the others; returns their number.
pub(super) fn drop_unused_vertices(mesh: &mut Mesh) -> usize {
    let mut used = vec![false; mesh.positions.len()];
    mesh.triangles.iter().flatten().for_each(|&vertex| used[vertex as usize] = true);
    let mut target = vec![0; used.len()];
    let mut kept = 0;
    for (vertex, _) in used.iter().enumerate().filter(|(_, used)| **used) {
        target[vertex] = kept;
        mesh.positions[kept as usize] = mesh.positions[vertex];
        kept += 1;
    }
    let dropped = mesh.positions.len() - kept as usize;
    mesh.positions.truncate(kept as usize);
    mesh.triangles.iter_mut().for_each(|corners| *corners = corners.map(|vertex| target[vertex as usize]));
    dropped
}
