//! Closes a surface for the sign only: reversed triangles are flipped, and holes are patched.
//!
//! The edges that are not used equally often in both directions form closed walks on any surface: as many of them end
//! at a vertex as start there, since this holds for each triangle's outline (the boundary of a boundary is empty). So
//! any surface closes with a patch over each of its rims. Every edge is then balanced, which is all that counting
//! crossings requires (`columns.rs`). The distance never uses a patch.

use std::borrow::Cow;

use glam::DVec3;
use rayon::prelude::*;

use super::patch::{Patch, RimCorner};
use super::skin::Corners;
use crate::Mesh;
use crate::clean::{EdgeMap, disagreeing};

/// Greatest share of patches in the surface's area; above it the surface is hardly connected, or a sheet.
const MOST_PATCHED: f64 = 0.9;

/// A surface whose triangles and patches together are closed.
pub(super) struct ClosedSurface<'a> {
    pub(super) mesh: Cow<'a, Mesh>,
    /// Triangles over holes.
    pub(super) patches: Vec<Corners>,
    /// Patches over holes that do not continue the surface around them: the sign there is ambiguous.
    pub(super) guesses: Vec<Corners>,
    /// Number of patched holes.
    pub(super) holes: usize,
    /// Number of triangles flipped to agree with their neighbours.
    pub(super) turned: usize,
}

/// Closes a surface; `None` if the patches would outweigh it.
pub(super) fn close<'a>(mesh: &'a Mesh, edges: &EdgeMap) -> Option<ClosedSurface<'a>> {
    let differs = |edge: usize| edges.uses(edge).len() == 2 && !edges.is_balanced(edge);
    let mut closed = ClosedSurface::as_it_is(mesh);
    if edges.indices().any(differs) {
        let turn = disagreeing(mesh, edges);
        closed.turned = turn.iter().filter(|&&turn| turn).count();
        let triangles = closed.mesh.to_mut().triangles.iter_mut().zip(turn);
        triangles.filter(|(_, turn)| *turn).for_each(|(corners, _)| corners.swap(1, 2));
        let edges = EdgeMap::new(&closed.mesh);
        closed.patch(&edges);
    } else {
        closed.patch(edges);
    }
    if closed.patches.is_empty() {
        return Some(closed);
    }
    let area: f64 = closed.patches.iter().map(|[a, b, c]| 0.5 * (b - a).cross(c - a).length()).sum();
    (area <= MOST_PATCHED * mesh.area()).then_some(closed)
}

impl<'a> ClosedSurface<'a> {
    /// A surface that is already closed.
    pub(super) fn as_it_is(mesh: &'a Mesh) -> Self {
        Self { mesh: Cow::Borrowed(mesh), patches: Vec::new(), guesses: Vec::new(), holes: 0, turned: 0 }
    }

    fn patch(&mut self, edges: &EdgeMap) {
        let corner = |arc: &Arc| RimCorner { position: self.mesh.positions[arc.from as usize], normal: arc.normal };
        let over = |rim: Vec<Arc>| Patch::over(rim.iter().map(corner).collect());
        let patches: Vec<Patch> = rims(arcs(&self.mesh, edges)).into_par_iter().with_max_len(1).map(over).collect();
        self.holes += patches.len();
        for patch in patches {
            if !patch.continues {
                self.guesses.extend_from_slice(&patch.triangles);
            }
            self.patches.extend(patch.triangles);
        }
    }
}

/// An edge in the direction in which a patch must use it to close the surface.
#[derive(Clone, Copy)]
struct Arc {
    from: u32,
    to: u32,
    /// Unit normal of a face at this edge.
    normal: DVec3,
}

/// Directed edges that are missing for every edge to be used equally often in both directions, sorted by start vertex.
fn arcs(mesh: &Mesh, edges: &EdgeMap) -> Vec<Arc> {
    let mut arcs = Vec::new();
    for edge in edges.indices().filter(|&edge| !edges.is_balanced(edge)) {
        let (uses, [low, high]) = (edges.uses(edge), edges.vertices(edge));
        let forward = uses.iter().filter(|u| u.forward).count();
        let is_forward = 2 * forward > uses.len();
        let missing = forward.abs_diff(uses.len() - forward);
        let (from, to) = if is_forward { (high, low) } else { (low, high) };
        let in_excess = uses.iter().filter(|u| u.forward == is_forward).take(missing);
        arcs.extend(in_excess.map(|u| Arc { from, to, normal: mesh.normal(u.triangle as usize) }));
    }
    arcs.sort_by_key(|arc| arc.from);
    arcs
}

/// Splits arcs into closed walks that visit no vertex twice.
fn rims(arcs: Vec<Arc>) -> Vec<Vec<Arc>> {
    let vertices = arcs.iter().map(|arc| arc.from as usize + 1).max().unwrap_or(0);
    // Next unused arc of each vertex, and its position on the walk plus one.
    let mut next = vec![0; vertices + 1];
    let mut place = vec![0; vertices];
    for (at, arc) in arcs.iter().enumerate().rev() {
        next[arc.from as usize] = at;
    }
    let mut rims = Vec::new();
    let mut walk: Vec<Arc> = Vec::new();
    let mut used = vec![false; arcs.len()];
    for start in 0..arcs.len() {
        let mut at = start;
        while !used[at] {
            let arc = arcs[at];
            used[at] = true;
            next[arc.from as usize] = at + 1;
            walk.push(arc);
            place[arc.from as usize] = walk.len();
            if place[arc.to as usize] > 0 {
                let rim = walk.split_off(place[arc.to as usize] - 1);
                rim.iter().for_each(|arc| place[arc.from as usize] = 0);
                rims.push(rim);
            }
            at = match next[arc.to as usize] {
                unused if arcs.get(unused).is_some_and(|other| other.from == arc.to) => unused,
                _ => break,
            };
        }
    }
    rims
}
