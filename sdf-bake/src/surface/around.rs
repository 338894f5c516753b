//! Surface information from the voxels around a cell.

use std::cell::RefCell;

use glam::{DVec3, IVec3};

use super::cell::edge_ends;
use super::cells::{corner_values, level};
use super::place::{Site, Vertex, onto_zero};
use crate::grid::{BrickGrid, cell_corner, trilinear};
use crate::halo::Halo;
use crate::tangent::Tangent;

/// Width of the border around a brick that is read: by its cells, by the voxels around them and by their slopes
/// [voxels].
const REACH: usize = 4;

/// Typical number of voxels whose tangents are computed, for a brick crossed by a smooth face: two layers, including
/// those around the brick.
const TYPICAL: usize = 256;

/// The voxels of a brick and around it; their tangents are computed on first use.
pub(super) struct BrickSurroundings<'a> {
    grid: &'a BrickGrid,
    /// Inset from [`super::settle::inset`].
    pub(super) inset: f64,
    /// φ [m] below which a lattice point counts as inside.
    level: f32,
    halo: Halo,
    /// For each voxel of the halo, its index in `tangents` plus one, or 0.
    place: RefCell<Vec<u16>>,
    tangents: RefCell<Vec<Option<Tangent>>>,
}

impl<'a> BrickSurroundings<'a> {
    pub(super) fn of(grid: &'a BrickGrid, brick: IVec3, inset: f64) -> Self {
        let halo = grid.halo(brick, REACH);
        let place = RefCell::new(vec![0; halo.phi.len()]);
        Self {
            grid,
            inset,
            level: level(grid, inset),
            halo,
            place,
            tangents: RefCell::new(Vec::with_capacity(TYPICAL)),
        }
    }

    /// Tangent at a voxel, with its foot relative to the voxel.
    fn tangent(&self, local: IVec3) -> Option<Tangent> {
        let at = self.halo.at(local);
        let (mut place, mut tangents) = (self.place.borrow_mut(), self.tangents.borrow_mut());
        if place[at] == 0 {
            let strides = self.halo.strides().map(|stride| stride as i32);
            let phi = |step: IVec3| {
                let [x, y, z] = step.to_array();
                self.halo.phi[(at as i32 + x * strides[0] + y * strides[1] + z * strides[2]) as usize]
            };
            tangents.push(self.grid.tangent_of(phi));
            place[at] = tangents.len() as u16;
        }
        tangents[usize::from(place[at]) - 1]
    }
}

/// A cell with the voxels around it.
pub(super) struct CellSurroundings<'a> {
    pub(super) known: &'a BrickSurroundings<'a>,
    /// Lowest corner of the cell [voxels from the brick's first].
    pub(super) low: IVec3,
}

impl CellSurroundings<'_> {
    /// Returns the vertex of the piece with these crossed edges.
    pub(super) fn vertex(&self, edges: impl Iterator<Item = usize> + Clone) -> Vertex {
        let ends = edges.clone().map(edge_ends).fold(0u8, |bits, (low, high)| bits | 1 << low | 1 << high);
        let is_crossed = |step: IVec3| {
            let values = corner_values(&self.known.halo, self.low + step.clamp(-IVec3::ONE, IVec3::ONE));
            values.iter().any(|&phi| phi < self.known.level) && values.iter().any(|&phi| phi >= self.known.level)
        };
        let mut tangents = Vec::with_capacity(8);
        tangents.extend((0..8).filter(|i| ends >> i & 1 != 0).filter_map(|i| self.tangent(cell_corner(i))));
        let all_clear = tangents.len() == ends.count_ones() as usize;
        let wider = || self.wider();
        let phi = self.heights_at_corners();
        let height = |at: DVec3| self.height(at);
        let centre = middle(&phi, edges);
        let inset = self.known.inset;
        let wider: Option<&dyn Fn() -> Vec<Tangent>> = if all_clear { None } else { Some(&wider) };
        Site { tangents, centre, phi, inset, height: &height, is_crossed: &is_crossed, wider }.vertex()
    }

    /// Returns the point on φ = 0 near a position in the cell [voxels from its lowest corner].
    pub(super) fn onto_zero(&self, at: DVec3) -> DVec3 {
        onto_zero(at, &self.heights_at_corners(), self.known.inset, |at| self.height(at))
    }

    /// φ at the cell's corners, relative to the level below which they are inside [voxels].
    fn heights_at_corners(&self) -> [f64; 8] {
        let above = |phi: f32| f64::from(phi - self.known.level) / self.known.grid.voxel;
        corner_values(&self.known.halo, self.low).map(above)
    }

    /// φ [voxels] at a position near the cell [voxels from its lowest corner], trilinear.
    fn height(&self, at: DVec3) -> f64 {
        let corner = at.floor();
        let values = corner_values(&self.known.halo, self.low + corner.as_ivec3());
        f64::from(trilinear(&values, (at - corner).as_vec3())) / self.known.grid.voxel
    }

    /// Tangent at the voxel at an offset from the cell's lowest corner.
    fn tangent(&self, corner: IVec3) -> Option<Tangent> {
        let tangent = self.known.tangent(self.low + corner)?;
        Some(Tangent { foot: tangent.foot + corner.as_dvec3(), ..tangent })
    }

    /// Tangents at the 4³ voxels around the cell.
    fn wider(&self) -> Vec<Tangent> {
        (0..64).filter_map(|i| self.tangent(IVec3::new(i >> 4, i >> 2 & 3, i & 3) - 1)).collect()
    }
}

/// Mean of the zero crossings along the edges [voxels from the cell's lowest corner].
fn middle(values: &[f64; 8], edges: impl Iterator<Item = usize>) -> DVec3 {
    let crossing = |edge: usize| {
        let (a, b) = edge_ends(edge);
        let along = values[a] / (values[a] - values[b]);
        cell_corner(a).as_dvec3().lerp(cell_corner(b).as_dvec3(), along)
    };
    let (sum, count) = edges.map(crossing).fold((DVec3::ZERO, 0.0), |(sum, count), at| (sum + at, count + 1.0));
    sum / count
}
