//! Walls inside bodies: parts of the surface with material on both sides.
//!
//! Where bodies overlap, are nested or touch, the surface of the union is the part that separates inside from outside.
//! The rest must not pull φ to zero inside the metal. Triangles are cut where other bodies intersect them (`cuts.rs`);
//! pieces with a winding number above one half on both sides serve the sign only. Outside nothing changes: the nearest
//! point of all triangles is on the union's surface.

use glam::DVec3;
use rayon::prelude::*;

use super::closed::BoxTree;
use super::cuts;
use super::holes::ClosedSurface;
use super::skin::Corners;
use crate::Mesh;
use crate::clean::EdgeMap;

/// Distance from a piece at which its sides are evaluated [voxels]; smaller gaps between touching bodies count as
/// closed.
const ASIDE: f64 = 1e-3;

/// Points closer than this to a plane lie in it [voxels].
const TOLERANCE: f64 = 1e-5;

/// Greatest number of triangles per task; the result does not depend on it.
const TRIANGLES: usize = 64;

/// Bodies of a mesh: components connected across edges of two triangles.
pub(super) struct Bodies {
    /// Body of each triangle.
    labels: Vec<u32>,
    /// Bounding box of each body.
    boxes: Vec<Bounds>,
    /// For each body, the bodies whose boxes overlap its box.
    neighbours: Vec<Vec<usize>>,
}

/// Triangles that others may intersect.
pub(super) struct CandidateTriangles<'a> {
    bodies: &'a Bodies,
    /// True if bodies may also intersect themselves.
    may_meet_itself: bool,
    triangles: Vec<u32>,
}

/// The triangles of a mesh, separated by purpose.
pub(super) struct Walls {
    /// For sign and distance.
    pub(super) kept: Mesh,
    /// Walls, and triangles that are partly walls, for the sign only.
    pub(super) sign_only: Vec<Corners>,
    /// Remaining pieces of triangles that are partly walls, for the distance only.
    pub(super) distance_only: Vec<Corners>,
}

impl Bodies {
    pub(super) fn of(mesh: &Mesh, edges: &EdgeMap) -> Self {
        let (labels, count) = edges.components(|uses| uses.len() == 2);
        let mut boxes = vec![(DVec3::INFINITY, DVec3::NEG_INFINITY); count];
        for (t, &label) in labels.iter().enumerate() {
            for corner in mesh.corners(t) {
                let (low, high) = &mut boxes[label as usize];
                (*low, *high) = (low.min(corner), high.max(corner));
            }
        }
        let neighbours = overlapping(&boxes, margin(mesh));
        Self { labels, boxes, neighbours }
    }

    /// True if boxes of bodies overlap.
    pub(super) fn are_close(&self) -> bool {
        self.neighbours.iter().any(|neighbours| !neighbours.is_empty())
    }

    /// Triangles within the box of another body, or all if bodies are known to overlap; `None` if there are none.
    pub(super) fn suspects(&self, mesh: &Mesh, overlaps: bool) -> Option<CandidateTriangles<'_>> {
        if !overlaps && !self.are_close() {
            return None;
        }
        let margin = margin(mesh);
        let is_suspect = |t: &u32| {
            let [a, b, c] = mesh.corners(*t as usize);
            let bounds = (a.min(b).min(c), a.max(b).max(c));
            let neighbours = &self.neighbours[self.labels[*t as usize] as usize];
            overlaps || neighbours.iter().any(|&other| overlap(&bounds, &self.boxes[other], margin))
        };
        let triangles: Vec<u32> = (0..self.labels.len() as u32).filter(is_suspect).collect();
        (!triangles.is_empty()).then_some(CandidateTriangles { bodies: self, may_meet_itself: overlaps, triangles })
    }
}

/// Distance by which overlapping boxes may be apart [m], to allow for rounding.
fn margin(mesh: &Mesh) -> f64 {
    1e-6 * mesh.diagonal()
}

/// Lowest and highest coordinates [m].
type Bounds = (DVec3, DVec3);

fn overlap(a: &Bounds, b: &Bounds, margin: f64) -> bool {
    (a.0 - margin).cmple(b.1).all() && (b.0 - margin).cmple(a.1).all()
}

/// Boxes that overlap each box, by a sweep along x.
fn overlapping(boxes: &[Bounds], margin: f64) -> Vec<Vec<usize>> {
    let mut order: Vec<usize> = (0..boxes.len()).collect();
    order.sort_by(|&a, &b| boxes[a].0.x.total_cmp(&boxes[b].0.x));
    let mut neighbours = vec![Vec::new(); boxes.len()];
    for (at, &a) in order.iter().enumerate() {
        let reached = order[at + 1..].iter().take_while(|&&b| boxes[b].0.x - margin <= boxes[a].1.x);
        for &b in reached.filter(|&&b| overlap(&boxes[a], &boxes[b], margin)) {
            neighbours[a].push(b);
            neighbours[b].push(a);
        }
    }
    neighbours
}

/// Separates the triangles of a closed surface by purpose; `None` without a wall.
///
/// - `edges`: those of the closed surface's triangles, in any orientation
/// - `sides`: those of the closed surface
/// - `voxel`: distance between voxels [m]
pub(super) fn within(
    mesh: &Mesh,
    edges: &EdgeMap,
    suspects: &CandidateTriangles,
    sides: &Sides,
    voxel: f64,
) -> Option<Walls> {
    let segments = segments(mesh, suspects, &sides.boxes, TOLERANCE * voxel);
    let mut is_wall = whole_triangles(mesh, edges, suspects, &segments, sides);
    let cut: Vec<(usize, Vec<Corners>)> = (0..mesh.triangles.len())
        .into_par_iter()
        .with_max_len(TRIANGLES)
        .filter(|&t| !segments[t].is_empty())
        .filter_map(|t| {
            let pieces = cuts::pieces(&mesh.corners(t), &segments[t], TOLERANCE * voxel)?;
            let before = pieces.len();
            let surface: Vec<Corners> = pieces.into_iter().filter(|piece| !sides.is_wall(piece)).collect();
            (surface.len() < before).then_some((t, surface))
        })
        .collect();
    cut.iter().for_each(|(t, _)| is_wall[*t] = true);
    if !is_wall.contains(&true) {
        return None;
    }
    let is_wall = &is_wall;
    let parted = |wall: bool| (0..is_wall.len()).filter(move |&t| is_wall[t] == wall);
    let kept =
        Mesh { positions: mesh.positions.clone(), triangles: parted(false).map(|t| mesh.triangles[t]).collect() };
    let sign_only = parted(true).map(|t| mesh.corners(t)).collect();
    Some(Walls { kept, sign_only, distance_only: cut.into_iter().flat_map(|(_, surface)| surface).collect() })
}

/// Winding numbers on the two sides of a piece of surface.
pub(super) struct Sides {
    /// The closed surface.
    boxes: BoxTree,
    /// Distance from the piece at which its sides are evaluated [m].
    aside: f64,
}

impl Sides {
    /// - `voxel`: distance between voxels [m]
    pub(super) fn of(closed: &ClosedSurface, voxel: f64) -> Self {
        let mut corners: Vec<Corners> = (0..closed.mesh.triangles.len()).map(|t| closed.mesh.corners(t)).collect();
        corners.extend_from_slice(&closed.patches);
        Self { boxes: BoxTree::new(corners, TOLERANCE * voxel), aside: ASIDE * voxel }
    }

    fn is_wall(&self, [a, b, c]: &Corners) -> bool {
        let step = self.aside * (b - a).cross(c - a).normalize_or_zero();
        let middle = (a + b + c) / 3.0;
        // The inner side is nearly always inside, so the outer one is evaluated first.
        self.boxes.winding_number(middle + step) > 0 && self.boxes.winding_number(middle - step) > 0
    }
}

/// Intersection segments of each triangle with others.
///
/// - `boxes`: tree whose first triangles are the mesh's
fn segments(mesh: &Mesh, suspects: &CandidateTriangles, boxes: &BoxTree, tolerance: f64) -> Vec<Vec<[DVec3; 2]>> {
    let mut is_suspect = vec![false; boxes.triangles.len()];
    suspects.triangles.iter().for_each(|&t| is_suspect[t as usize] = true);
    let of_suspect = |&t: &u32| {
        let t = t as usize;
        let mut others = Vec::new();
        boxes.near(t, |u| {
            if u != t && is_suspect[u] && suspects.may_meet(mesh, t, u) {
                others.push(u);
            }
        });
        others.sort_unstable();
        let met = others.iter().flat_map(|&u| cuts::meeting(&boxes.triangles[t], &boxes.triangles[u], tolerance));
        (t, met.collect::<Vec<_>>())
    };
    let mut segments = vec![Vec::new(); mesh.triangles.len()];
    let met = suspects.triangles.par_iter().with_max_len(TRIANGLES).map(of_suspect);
    for (t, met) in met.collect::<Vec<_>>() {
        segments[t] = met;
    }
    segments
}

impl CandidateTriangles<'_> {
    /// True if two triangles may intersect; neighbours in one body that share a corner are excluded.
    fn may_meet(&self, mesh: &Mesh, t: usize, u: usize) -> bool {
        let shares_corner = || mesh.triangles[t].iter().any(|corner| mesh.triangles[u].contains(corner));
        self.bodies.labels[t] != self.bodies.labels[u] || (self.may_meet_itself && !shares_corner())
    }
}

/// Marks the uncut triangles that are walls; one triangle of each patch is evaluated.
fn whole_triangles(
    mesh: &Mesh,
    edges: &EdgeMap,
    suspects: &CandidateTriangles,
    segments: &[Vec<[DVec3; 2]>],
    sides: &Sides,
) -> Vec<bool> {
    let is_whole = |t: u32| segments[t as usize].is_empty();
    let (patches, count) = edges.components(|uses| uses.len() == 2 && uses.iter().all(|u| is_whole(u.triangle)));
    let area = |t: usize| mesh.doubled_area_normal(t).length_squared();
    let mut largest = vec![None; count];
    for t in (0..mesh.triangles.len()).filter(|&t| segments[t].is_empty()) {
        let best: &mut Option<usize> = &mut largest[patches[t] as usize];
        if best.is_none_or(|best| area(t) > area(best)) {
            *best = Some(t);
        }
    }
    let mut suspected = vec![false; count];
    suspects.triangles.iter().for_each(|&t| suspected[patches[t as usize] as usize] = true);
    let asked: Vec<bool> = largest
        .par_iter()
        .with_max_len(TRIANGLES)
        .zip(&suspected)
        .map(|(largest, suspected)| *suspected && largest.is_some_and(|t| sides.is_wall(&mesh.corners(t))))
        .collect();
    (0..mesh.triangles.len()).map(|t| segments[t].is_empty() && asked[patches[t] as usize]).collect()
}
