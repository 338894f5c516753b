//! All cells that the surface crosses, brick by brick.

use std::collections::HashMap;

use glam::{DVec3, IVec3};
use rayon::prelude::*;

use super::cell::{NO_PIECE, Signs, edge_ends};
use super::place::{Shape, Site, Vertex};
use crate::grid::{BRICK_SIDE, BRICK_VOXELS, BrickGrid, cell_corner, voxel_at, voxel_offset};
use crate::halo::Halo;
use crate::tangent::Tangent;

/// No cell in [`Brick::place`].
const NO_CELL: u16 = u16::MAX;
/// Voxels around a brick that its cells, the voxels around those and their slopes read.
const REACH: usize = 4;
/// How far φ differs from the distance to one face where there is another [voxels].
const OTHER_FACE: f64 = 0.25;

/// A cell that the surface crosses.
#[derive(Clone, Copy, Debug)]
pub(super) struct Cell {
    /// Place of its lowest corner in the brick.
    pub(super) offset: u16,
    pub(super) signs: Signs,
    /// Number of the first of its vertices; its pieces follow each other.
    first_vertex: u32,
}

/// The crossed cells whose lowest corners are in one brick.
pub(super) struct Brick {
    at: IVec3,
    pub(super) cells: Vec<Cell>,
    /// Position in `cells` of the cell at each offset.
    place: Box<[u16; BRICK_VOXELS]>,
}

/// A vertex of the mesh.
#[derive(Clone, Copy, Debug)]
pub(super) struct Corner {
    /// Position [m].
    pub(super) at: DVec3,
    pub(super) shape: Shape,
}

/// The crossed cells of a grid.
pub(super) struct CellMap {
    bricks: Vec<Brick>,
    position: HashMap<IVec3, usize>,
}

impl Brick {
    /// Lowest corner of a cell [voxels].
    pub(super) fn voxel(&self, cell: &Cell) -> IVec3 {
        voxel_at(self.at, usize::from(cell.offset))
    }

    fn of(grid: &BrickGrid, at: IVec3) -> Option<Self> {
        let halo = grid.halo(at, 1);
        let mut brick = Self { at, cells: Vec::new(), place: Box::new([NO_CELL; BRICK_VOXELS]) };
        for offset in 0..BRICK_VOXELS {
            let signs = Signs::of(&corner_values(&halo, voxel_at(IVec3::ZERO, offset)));
            if signs.inside != 0 && signs.inside != 255 {
                brick.place[offset] = brick.cells.len() as u16;
                brick.cells.push(Cell { offset: offset as u16, signs, first_vertex: 0 });
            }
        }
        (!brick.cells.is_empty()).then_some(brick)
    }
}

fn corner_values(halo: &Halo, low: IVec3) -> [f32; 8] {
    std::array::from_fn(|i| halo.phi[halo.at(low + cell_corner(i))])
}

impl CellMap {
    pub(super) fn of(grid: &BrickGrid) -> Self {
        // A cell whose lowest corner has no brick may still reach into one.
        let mut at: Vec<IVec3> =
            grid.bricks.iter().flat_map(|&brick| (0..8).map(move |i| brick - cell_corner(i))).collect();
        at.par_sort_unstable_by_key(|brick| brick.to_array());
        at.dedup();
        let bricks: Vec<Brick> = at.into_par_iter().filter_map(|at| Brick::of(grid, at)).collect();
        let position = bricks.iter().enumerate().map(|(i, brick)| (brick.at, i)).collect();
        let mut map = Self { bricks, position };
        map.split_doubles();
        map.number();
        map
    }

    /// The bricks with crossed cells, by their coordinates.
    pub(super) fn bricks(&self) -> &[Brick] {
        &self.bricks
    }

    /// The vertex of the piece that an edge of a cell belongs to.
    pub(super) fn vertex(&self, voxel: IVec3, edge: usize) -> u32 {
        let (brick, cell) = self.find(voxel).expect("the four cells around a crossed edge are crossed");
        let cell = &self.bricks[brick].cells[cell];
        let (pieces, _) = cell.signs.pieces();
        debug_assert_ne!(pieces[edge], NO_PIECE);
        cell.first_vertex + u32::from(pieces[edge])
    }

    fn find(&self, voxel: IVec3) -> Option<(usize, usize)> {
        let brick = *self.position.get(&(voxel >> 3))?;
        let cell = self.bricks[brick].place[voxel_offset(voxel)];
        (cell != NO_CELL).then_some((brick, usize::from(cell)))
    }

    /// Turns the pairs of each face through which one piece passes twice on both sides. That splits both pieces and
    /// joins none, so one round is enough.
    fn split_doubles(&mut self) {
        for brick in 0..self.bricks.len() {
            for cell in 0..self.bricks[brick].cells.len() {
                for axis in 0..3 {
                    let here = self.bricks[brick].cells[cell];
                    let (upper, lower) = (2 * axis + 1, 2 * axis);
                    if !(here.signs.alternates(upper) && here.signs.doubles_at(upper)) {
                        continue;
                    }
                    let beyond = self.bricks[brick].voxel(&here) + IVec3::AXES[axis];
                    let Some((next_brick, next)) = self.find(beyond) else { continue };
                    if self.bricks[next_brick].cells[next].signs.doubles_at(lower) {
                        self.bricks[brick].cells[cell].signs.joined ^= 1 << upper;
                        self.bricks[next_brick].cells[next].signs.joined ^= 1 << lower;
                    }
                }
            }
        }
    }

    fn number(&mut self) {
        let mut vertices = 0;
        for cell in self.bricks.iter_mut().flat_map(|brick| &mut brick.cells) {
            cell.first_vertex = vertices;
            vertices += u32::from(cell.signs.pieces().1);
        }
    }

    /// All vertices in their order.
    pub(super) fn vertices(&self, grid: &BrickGrid) -> Vec<Corner> {
        let of_brick = |brick: &Brick| {
            let halo = grid.halo(brick.at, REACH);
            let corner = BRICK_SIDE as i32 * brick.at;
            let mut vertices = Vec::new();
            for cell in &brick.cells {
                let low = voxel_at(IVec3::ZERO, usize::from(cell.offset));
                let (pieces, count) = cell.signs.pieces();
                for piece in 0..count {
                    let edges: Vec<usize> = (0..12).filter(|&edge| pieces[edge] == piece).collect();
                    let vertex = Around { grid, halo: &halo, low }.vertex(&edges);
                    let at = ((corner + low).as_dvec3() + vertex.at) * grid.voxel;
                    vertices.push(Corner { at, shape: vertex.shape });
                }
            }
            vertices
        };
        self.bricks.par_iter().map(of_brick).collect::<Vec<_>>().concat()
    }
}

/// A cell with the voxels around it.
struct Around<'a> {
    grid: &'a BrickGrid,
    halo: &'a Halo,
    /// Its lowest corner [voxels from the brick's first].
    low: IVec3,
}

impl Around<'_> {
    /// The vertex of the piece with these crossed edges.
    fn vertex(&self, edges: &[usize]) -> Vertex {
        let ends = edges.iter().fold(0u8, |bits, &edge| bits | 1 << edge_ends(edge).0 | 1 << edge_ends(edge).1);
        let corners = (0..8).filter(|corner| ends >> corner & 1 != 0).map(cell_corner);
        let is_crossed = |step: IVec3| {
            let values = corner_values(self.halo, self.low + step.clamp(-IVec3::ONE, IVec3::ONE));
            values.iter().any(|&phi| phi < 0.0) && values.iter().any(|&phi| phi >= 0.0)
        };
        let tangents = corners.filter_map(|corner| self.tangent(corner)).collect();
        let wider = |face: &Tangent| self.wider(face);
        let phi = corner_values(self.halo, self.low).map(|phi| f64::from(phi) / self.grid.voxel);
        Site { tangents, centre: self.middle(edges), phi, is_crossed: &is_crossed, wider: &wider }.vertex()
    }

    /// Mean of the points where φ vanishes along the edges [voxels from the cell's lowest corner].
    fn middle(&self, edges: &[usize]) -> DVec3 {
        let values = corner_values(self.halo, self.low);
        let crossing = |&edge: &usize| {
            let (a, b) = edge_ends(edge);
            let along = f64::from(values[a]) / (f64::from(values[a]) - f64::from(values[b]));
            cell_corner(a).as_dvec3().lerp(cell_corner(b).as_dvec3(), along)
        };
        edges.iter().map(crossing).sum::<DVec3>() / edges.len() as f64
    }

    /// What the voxel at an offset from the cell's lowest corner knows of the surface.
    fn tangent(&self, corner: IVec3) -> Option<Tangent> {
        let at = self.low + corner;
        let tangent = self.grid.tangent_of(|step| self.halo.phi[self.halo.at(at + step)])?;
        Some(Tangent { foot: tangent.foot + corner.as_dvec3(), ..tangent })
    }

    /// What the 4³ voxels around the cell know, if they know more than one face.
    fn wider(&self, face: &Tangent) -> Vec<Tangent> {
        let corners = || (0..64).map(|i| IVec3::new(i >> 4, i >> 2 & 3, i & 3) - 1);
        let off_plane = |corner: IVec3| {
            let phi = self.halo.phi[self.halo.at(self.low + corner)];
            let height = face.normal.dot(corner.as_dvec3() - face.foot) * self.grid.voxel;
            phi.abs() < self.grid.band && (f64::from(phi) - height).abs() > OTHER_FACE * self.grid.voxel
        };
        if corners().any(off_plane) {
            corners().filter_map(|corner| self.tangent(corner)).collect()
        } else {
            Vec::new()
        }
    }
}
