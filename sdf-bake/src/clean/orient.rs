//! Makes the orientation of each patch consistent, and the normals of each solid outward.
//!
//! Within a patch (triangles joined across edges of exactly two triangles) the part of smaller area is flipped. A
//! closed shell is then flipped as a whole if it is outermost and its volume negative. Shells nested in it are flipped
//! with it, so that a cavity stays a cavity.

use super::EdgeMap;
use super::nesting::outermost_containers;
use crate::Mesh;

/// Counts of flipped triangles and shells.
pub(super) struct Turned {
    /// Triangles flipped to agree with their patch.
    pub(super) triangles: usize,
    /// Shells flipped as a whole.
    pub(super) shells: usize,
}

/// Makes patches consistent, and the volume of outermost shells positive.
///
/// `edges` must belong to the mesh; if anything is flipped, its directions are no longer valid.
pub(super) fn orient(mesh: &mut Mesh, edges: &EdgeMap) -> Turned {
    let flip = disagreeing(mesh, edges);
    let triangles = flip.iter().filter(|&&f| f).count();
    turn(mesh, |t| flip[t]);
    let turned_edges;
    let edges = if triangles > 0 {
        turned_edges = EdgeMap::new(mesh);
        &turned_edges
    } else {
        edges
    };
    let (labels, count) = edges.components(|_| true);
    let inside_out = inside_out_shells(mesh, edges, &labels, count);
    turn(mesh, |t| inside_out[labels[t] as usize]);
    Turned { triangles, shells: inside_out.iter().filter(|&&f| f).count() }
}

fn turn(mesh: &mut Mesh, flip: impl Fn(usize) -> bool) {
    for (t, corners) in mesh.triangles.iter_mut().enumerate() {
        if flip(t) {
            corners.swap(1, 2);
        }
    }
}

/// Triangles to flip so that each patch is consistent: the part of smaller area.
pub(crate) fn disagreeing(mesh: &Mesh, edges: &EdgeMap) -> Vec<bool> {
    let mut state = vec![None; mesh.triangles.len()];
    let mut flip = vec![false; mesh.triangles.len()];
    for seed in 0..state.len() {
        if state[seed].is_some() {
            continue;
        }
        let patch = flood(edges, seed, &mut state);
        let area = |side: bool| -> f64 {
            let on_side = patch.iter().filter(|&&t| state[t] == Some(side));
            on_side.map(|&t| mesh.doubled_area_normal(t).length()).sum()
        };
        let turned = area(true) <= area(false);
        patch.iter().for_each(|&t| flip[t] = state[t] == Some(turned));
    }
    flip
}

/// Labels the seed's patch: `false` for triangles that agree with the seed, `true` for the others.
fn flood(edges: &EdgeMap, seed: usize, state: &mut [Option<bool>]) -> Vec<usize> {
    state[seed] = Some(false);
    let mut patch = vec![seed];
    let mut next = 0;
    while let Some(&triangle) = patch.get(next) {
        next += 1;
        let differs = state[triangle] == Some(true);
        for edge in edges.of_triangle(triangle) {
            let [a, b] = *edges.uses(edge as usize) else { continue };
            let neighbour = if a.triangle as usize == triangle { b.triangle } else { a.triangle } as usize;
            if state[neighbour].is_none() {
                state[neighbour] = Some(differs != (a.forward == b.forward));
                patch.push(neighbour);
            }
        }
    }
    patch
}

fn inside_out_shells(mesh: &Mesh, edges: &EdgeMap, labels: &[u32], count: usize) -> Vec<bool> {
    let mut shells = vec![Vec::new(); count];
    labels.iter().enumerate().for_each(|(t, &label)| shells[label as usize].push(t));
    let mut closed = vec![true; count];
    for edge in edges.indices().filter(|&edge| !edges.is_balanced(edge)) {
        closed[labels[edges.uses(edge)[0].triangle as usize] as usize] = false;
    }
    let negative: Vec<bool> = (0..count).map(|shell| closed[shell] && volume(mesh, &shells[shell]) < 0.0).collect();
    if !negative.contains(&true) {
        return negative;
    }
    let containers = outermost_containers(mesh, &shells, &closed);
    (0..count).map(|shell| negative[containers[shell].unwrap_or(shell)]).collect()
}

/// Volume [m³] enclosed by some triangles, relative to a point of their own to avoid cancellation.
fn volume(mesh: &Mesh, triangles: &[usize]) -> f64 {
    let origin = mesh.corners(triangles[0])[0];
    let cone = |&t: &usize| {
        let [a, b, c] = mesh.corners(t).map(|p| p - origin);
        a.dot(b.cross(c)) / 6.0
    };
    triangles.iter().map(cone).sum()
}
