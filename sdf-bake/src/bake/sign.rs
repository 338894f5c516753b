//! Inside and outside with few evaluations of the winding number.
//!
//! Two neighbouring voxels whose distances add up to more than the step between them lie on the same side: the balls
//! around them contain no surface and cover the step. Such voxels form components, and the winding number of the voxel
//! farthest from the surface gives the sign of all. If the surface has holes, it must agree with those of the
//! component's outermost voxels; otherwise a hole joins inside and outside, and each voxel is evaluated separately.

use std::collections::VecDeque;

use glam::IVec3;
use rayon::prelude::*;

use super::normals::Normals;
use super::scatter::BrickTriangles;
use super::skin::Corners;
use super::winding::WindingTree;
use crate::Mesh;
use crate::clean::EdgeMap;
use crate::grid::{BRICK_SIDE, BRICK_VOXELS, BrickGrid, INSIDE, OUTSIDE, cell_corner, voxel_at, voxel_offset};
use crate::index::entry_brick;

/// Distance of a winding number from a whole number above which it is ambiguous.
const AMBIGUOUS: f64 = 0.25;

/// Distance below which a voxel lies on the surface [voxels]; there the winding number jumps and is meaningless.
const ON_SURFACE: f32 = 1e-4;

/// Greatest difference between the samples of a component that still gives one sign to all of it: through a hole the
/// winding number changes smoothly from inside to outside.
const AGREEMENT: f64 = 0.1;

/// Greatest number of voxels evaluated for the ambiguous share; it determines a share of 0.5 % to 0.06 %.
const MOST_ASKED: usize = 1 << 14;

/// Greatest number of bricks per task; the result does not depend on it.
const BRICKS: usize = 32;

/// Points evaluated together.
const LANES: usize = 8;

/// A surface that is not closed, or not consistently oriented.
pub(super) struct Surface {
    tree: WindingTree,
    /// True if it has boundary edges, so that inside and outside may be connected.
    has_holes: bool,
}

impl Surface {
    pub(super) fn new(mesh: &Mesh, edges: &EdgeMap) -> Self {
        let has_holes = edges.indices().any(|edge| edges.uses(edge).len() % 2 == 1);
        Self { tree: WindingTree::new(mesh), has_holes }
    }
}

/// Converts a brick's distances to signed distances; returns the numbers of its ambiguous and of its inside voxels.
pub(super) fn judge(brick: IVec3, phi: &mut [f32], surface: &Surface, grid: &BrickGrid) -> (usize, usize) {
    let windings_at = |voxels: &[usize]| windings(voxels, brick, &surface.tree, grid);
    let members = members(&components(phi, grid.voxel as f32));
    let samples: Vec<Vec<usize>> = members.iter().map(|voxels| sampled(voxels, phi, surface.has_holes)).collect();
    let sample_windings = windings_at(&samples.concat());
    let (mut ambiguous, mut inside, mut first) = (0, 0, 0);
    for (voxels, samples) in members.iter().zip(&samples) {
        let of_samples = &sample_windings[first..first + samples.len()];
        first += samples.len();
        let alike = of_samples.iter().all(|winding| (winding - of_samples[0]).abs() < AGREEMENT);
        let windings = if alike { vec![of_samples[0]; voxels.len()] } else { windings_at(voxels) };
        for (&voxel, winding) in voxels.iter().zip(windings) {
            let clear_of_surface = phi[voxel] > ON_SURFACE * grid.voxel as f32;
            ambiguous += usize::from(clear_of_surface && is_ambiguous(winding));
            if winding > 0.5 {
                inside += 1;
                phi[voxel] = -phi[voxel];
            }
        }
    }
    (ambiguous, inside)
}

fn is_ambiguous(winding: f64) -> bool {
    (winding - winding.round()).abs() > AMBIGUOUS
}

/// Winding numbers at voxels of a brick.
fn windings(voxels: &[usize], brick: IVec3, tree: &WindingTree, grid: &BrickGrid) -> Vec<f64> {
    let mut windings = Vec::with_capacity(voxels.len());
    for voxels in voxels.chunks(LANES) {
        let last = voxels.len() - 1;
        let point = |i: usize| grid.position(voxel_at(brick, voxels[i.min(last)]));
        windings.extend_from_slice(&tree.winding_numbers::<LANES>(&std::array::from_fn(point))[..voxels.len()]);
    }
    windings
}

/// [`judge`] by normals, for a surface without holes; returns the number of inside voxels.
pub(super) fn judge_by_normals(brick: IVec3, phi: &mut [f32], normals: &Normals, grid: &BrickGrid) -> usize {
    let mut inside = 0;
    for voxels in members(&components(phi, grid.voxel as f32)) {
        let farthest = sampled(&voxels, phi, false)[0];
        if normals.is_inside(grid.position(voxel_at(brick, farthest))) {
            inside += voxels.len();
            voxels.iter().for_each(|&voxel| phi[voxel] = -phi[voxel]);
        }
    }
    inside
}

/// Share of the voxels of the touched bricks at which patches leave the sign ambiguous: without the patches, the
/// winding number would differ from a whole number by more than [`AMBIGUOUS`]. One voxel of 64 is evaluated; in large
/// fields the bricks are sampled to give [`MOST_ASKED`].
pub(super) fn ambiguous_share(patches: &[Corners], near: &BrickTriangles, grid: &BrickGrid) -> f64 {
    if patches.is_empty() {
        return 0.0;
    }
    let tree = WindingTree::of(patches.to_vec());
    let step = (LANES * near.brick_count()).div_ceil(MOST_ASKED);
    let asked: Vec<usize> = (0..near.brick_count()).step_by(step).collect();
    let of_brick = |&b: &usize| {
        let brick = grid.origin + entry_brick(near.entry(b), grid.dims);
        let point = |i: usize| grid.position(brick * BRICK_SIDE as i32 + 2 + 4 * cell_corner(i));
        let windings = tree.winding_numbers::<LANES>(&std::array::from_fn(point));
        windings.into_iter().filter(|&winding| is_ambiguous(winding)).count()
    };
    let ambiguous: usize = asked.par_iter().with_max_len(BRICKS).map(of_brick).sum();
    ambiguous as f64 / (LANES * asked.len()) as f64
}

/// Voxels of each component, in order.
fn members(component: &[usize; BRICK_VOXELS]) -> Vec<Vec<usize>> {
    let mut members = vec![Vec::new(); BRICK_VOXELS];
    for (voxel, &root) in component.iter().enumerate() {
        members[root].push(voxel);
    }
    members.retain(|voxels| !voxels.is_empty());
    members
}

/// The voxel of a component that is farthest from the surface; if holes may join two sides, also those outermost along
/// the axes and diagonals.
fn sampled(voxels: &[usize], distance: &[f32], has_holes: bool) -> Vec<usize> {
    let most = |measure: &dyn Fn(usize) -> f32| {
        let keep = |best: usize, &voxel: &usize| if measure(voxel) > measure(best) { voxel } else { best };
        voxels.iter().fold(voxels[0], keep)
    };
    let mut samples = vec![most(&|voxel| distance[voxel])];
    if has_holes && voxels.len() > 1 {
        for direction in DIRECTIONS {
            let outermost = |sign: i32| most(&|voxel| (sign * direction.dot(voxel_at(IVec3::ZERO, voxel))) as f32);
            samples.extend([outermost(1), outermost(-1)]);
        }
        samples[1..].sort_unstable();
        samples.dedup();
    }
    samples
}

const DIRECTIONS: [IVec3; 7] =
    [IVec3::X, IVec3::Y, IVec3::Z, IVec3::ONE, IVec3::new(1, 1, -1), IVec3::new(1, -1, 1), IVec3::new(-1, 1, 1)];

/// Component of each voxel, identified by one of its voxels.
fn components(phi: &[f32], step: f32) -> [usize; BRICK_VOXELS] {
    let mut parent: [usize; BRICK_VOXELS] = std::array::from_fn(|i| i);
    fn root(parent: &mut [usize; BRICK_VOXELS], mut i: usize) -> usize {
        while parent[i] != i {
            parent[i] = parent[parent[i]];
            i = parent[i];
        }
        i
    }
    // The margin keeps rounding to f32 from joining two sides.
    let free = step * (1.0 + 1e-5);
    for offset in 0..BRICK_VOXELS {
        for (stride, local) in [(64, offset >> 6), (8, offset >> 3 & 7), (1, offset & 7)] {
            if local < BRICK_SIDE - 1 && phi[offset] + phi[offset + stride] > free {
                let (a, b) = (root(&mut parent, offset), root(&mut parent, offset + stride));
                parent[a.max(b)] = a.min(b);
            }
        }
    }
    std::array::from_fn(|i| root(&mut parent, i))
}

const FACES: [IVec3; 6] = [IVec3::X, IVec3::NEG_X, IVec3::Y, IVec3::NEG_Y, IVec3::Z, IVec3::NEG_Z];

/// Marks the entries without a brick: each connected region takes the side of most of the bordering voxels; a region
/// that reaches the edge of the index is outside.
pub(super) fn flood_empty(grid: &mut BrickGrid) {
    let mut seen = vec![false; grid.dims.as_usizevec3().element_product()];
    for start in 0..seen.len() {
        if seen[start] || grid.index.get(entry_brick(start, grid.dims)) != OUTSIDE {
            continue;
        }
        let region = region(start, grid, &mut seen);
        if region.votes < 0 && !region.at_edge {
            for entry in region.entries {
                grid.index.set(entry_brick(entry, grid.dims), INSIDE);
            }
        }
    }
}

struct Region {
    entries: Vec<usize>,
    /// Outside minus inside voxels on the bordering brick faces.
    votes: i64,
    at_edge: bool,
}

fn region(start: usize, grid: &BrickGrid, seen: &mut [bool]) -> Region {
    let mut region = Region { entries: Vec::new(), votes: 0, at_edge: false };
    let mut queue = VecDeque::from([start]);
    seen[start] = true;
    while let Some(entry) = queue.pop_front() {
        region.entries.push(entry);
        let brick = grid.origin + entry_brick(entry, grid.dims);
        for face in FACES {
            let Some(next) = grid.entry(brick + face) else {
                region.at_edge = true;
                continue;
            };
            match grid.slot(brick + face) {
                OUTSIDE if seen[next] => {}
                OUTSIDE => {
                    seen[next] = true;
                    queue.push_back(next);
                }
                INSIDE => region.votes -= (BRICK_SIDE * BRICK_SIDE) as i64,
                slot => region.votes += face_votes(grid, slot, face),
            }
        }
    }
    region
}

/// Number of outside minus inside voxels on the side of a brick opposite to `face`.
fn face_votes(grid: &BrickGrid, slot: u32, face: IVec3) -> i64 {
    let base = slot as usize * BRICK_VOXELS;
    let axis = (0..3).find(|&a| face[a] != 0).unwrap_or(0);
    let mut local = IVec3::ZERO;
    local[axis] = if face[axis] > 0 { 0 } else { BRICK_SIDE as i32 - 1 };
    let mut votes = 0;
    for u in 0..BRICK_SIDE as i32 {
        for v in 0..BRICK_SIDE as i32 {
            local[(axis + 1) % 3] = u;
            local[(axis + 2) % 3] = v;
            votes += if grid.phi[base + voxel_offset(local)] > 0.0 { 1 } else { -1 };
        }
    }
    votes
}
