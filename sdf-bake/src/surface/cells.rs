//! Finds all cells that the surface crosses, brick by brick.

use glam::{DVec3, IVec3, Vec3};
use rayon::prelude::*;

use super::around::{BrickSurroundings, CellSurroundings};
use super::cell::{NO_PIECE, Pieces, PiecesOf, Signs, middle_of_edges};
use super::place::{Shape, outside_by};
use super::settle::keep_apart;
use crate::grid::{BRICK_SIDE, BRICK_VOXELS, BrickGrid, cell_corner, voxel_at, voxel_offset};
use crate::halo::Halo;
use crate::index::BrickIndex;

/// Entry of [`Brick::place`] without a cell.
const NO_CELL: u16 = u16::MAX;
/// Nodes along the side of a brick's cells.
const NODES: usize = BRICK_SIDE + 1;

/// A cell that the surface crosses.
#[derive(Clone, Copy, Debug)]
pub(super) struct Cell {
    /// Offset of its lowest corner in the brick.
    pub(super) offset: u16,
    pub(super) signs: Signs,
    /// Index of its first vertex; its pieces have consecutive indices.
    first_vertex: u32,
    /// Piece of each of its edges.
    pieces: Pieces,
    piece_count: u8,
}

/// The crossed cells whose lowest corners are in one brick.
pub(super) struct Brick {
    at: IVec3,
    pub(super) cells: Vec<Cell>,
    /// Index in `cells` of the cell at each offset.
    place: Box<[u16; BRICK_VOXELS]>,
}

/// A vertex of the mesh.
#[derive(Clone, Copy, Debug)]
pub(super) struct Corner {
    /// Position [voxels].
    pub(super) at: DVec3,
    pub(super) shape: Shape,
    /// Lowest corner of its cell [voxels].
    pub(super) cell: IVec3,
    /// Position well within the cell, used if `at` is taken [voxels from the cell's lowest corner].
    pub(super) home: Vec3,
}

impl Corner {
    /// Distance outside the cell on the axis where it is greatest [voxels]; negative within.
    pub(super) fn away(&self) -> f64 {
        outside_by(self.at - self.cell.as_dvec3())
    }

    pub(super) fn at_home(&self) -> DVec3 {
        self.cell.as_dvec3() + self.home.as_dvec3()
    }
}

/// The crossed cells of a grid.
pub(super) struct CellMap {
    bricks: Vec<Brick>,
    /// Brick coordinates of the first entry of `position`.
    origin: IVec3,
    /// Index in `bricks` of each brick with a crossed cell.
    position: BrickIndex,
}

impl Brick {
    /// Lowest corner of a cell [voxels].
    pub(super) fn voxel(&self, cell: &Cell) -> IVec3 {
        voxel_at(self.at, usize::from(cell.offset))
    }

    fn of(grid: &BrickGrid, at: IVec3, inset: f64) -> Option<Self> {
        let mut halo = grid.halo(at, 1);
        let level = level(grid, inset);
        halo.phi.iter_mut().for_each(|phi| *phi -= level);
        let inside = inside_rows(&halo);
        let mut brick = Self { at, cells: Vec::new(), place: Box::new([NO_CELL; BRICK_VOXELS]) };
        for row in 0..BRICK_SIDE * BRICK_SIDE {
            let mut crossed = crossed_in_row(&inside, row / BRICK_SIDE, row % BRICK_SIDE);
            while crossed != 0 {
                let offset = row * BRICK_SIDE + crossed.trailing_zeros() as usize;
                crossed &= crossed - 1;
                brick.place[offset] = brick.cells.len() as u16;
                brick.cells.push(Cell {
                    offset: offset as u16,
                    signs: Signs::of(&corner_values(&halo, voxel_at(IVec3::ZERO, offset))),
                    first_vertex: 0,
                    pieces: [NO_PIECE; 12],
                    piece_count: 0,
                });
            }
        }
        (!brick.cells.is_empty()).then_some(brick)
    }
}

/// φ [m] below which a lattice point counts as inside.
pub(super) fn level(grid: &BrickGrid, inset: f64) -> f32 {
    -(inset * grid.voxel) as f32
}

/// For each row of a brick's nodes along z, one bit per node, set if it is inside.
fn inside_rows(halo: &Halo) -> [[u16; NODES]; NODES] {
    let row = |x: usize, y: usize| {
        let first = halo.at(IVec3::new(x as i32, y as i32, 0));
        let nodes = halo.phi[first..first + NODES].iter();
        nodes.rev().fold(0, |bits, &phi| bits << 1 | u16::from(phi < 0.0))
    };
    std::array::from_fn(|x| std::array::from_fn(|y| row(x, y)))
}

/// One bit per cell of a row along z, set if it has corners inside and outside.
fn crossed_in_row(inside: &[[u16; NODES]; NODES], x: usize, y: usize) -> u16 {
    let rows = [inside[x][y], inside[x][y + 1], inside[x + 1][y], inside[x + 1][y + 1]];
    let (any, all) = rows.iter().fold((0, u16::MAX), |(any, all), row| (any | row, all & row));
    (any | any >> 1) & !(all & all >> 1) & 0xff
}

/// Bricks that contain the lowest corners of cells that reach into a brick.
fn lowest_bricks(brick: IVec3) -> impl Iterator<Item = IVec3> {
    (0..8).map(move |i| brick - cell_corner(i))
}

/// [`lowest_bricks`] where the surface passes between bricks that are entirely inside and entirely outside.
fn between_sides(grid: &BrickGrid) -> impl ParallelIterator<Item = IVec3> {
    let inside = (0..grid.index.tile_count()).into_par_iter().flat_map_iter(|tile| grid.index.inside_of(tile));
    let lowest = inside.flat_map_iter(|brick| lowest_bricks(grid.origin + brick));
    lowest.filter(|&brick| grid.jumps_at(brick))
}

pub(super) fn corner_values(halo: &Halo, low: IVec3) -> [f32; 8] {
    let ([x, y, z], base) = (halo.strides(), halo.at(low));
    [0, z, y, y + z, x, x + z, x + y, x + y + z].map(|step| halo.phi[base + step])
}

impl CellMap {
    pub(super) fn of(grid: &BrickGrid, inset: f64) -> Self {
        // A cell whose lowest corner has no brick may still reach into one.
        let mut at: Vec<IVec3> = grid.bricks.iter().flat_map(|&brick| lowest_bricks(brick)).collect();
        at.par_extend(between_sides(grid));
        at.par_sort_unstable_by_key(|brick| brick.to_array());
        at.dedup();
        let bricks: Vec<Brick> = at.into_par_iter().filter_map(|at| Brick::of(grid, at, inset)).collect();
        // A crossed cell has a corner in an indexed brick.
        let mut map = Self { bricks, origin: grid.origin - 1, position: BrickIndex::new(grid.dims + 1) };
        for (place, brick) in map.bricks.iter().enumerate() {
            map.position.set(brick.at - map.origin, place as u32);
        }
        map.split_doubles();
        map.number();
        map
    }

    /// Bricks with crossed cells, ordered by their coordinates.
    pub(super) fn bricks(&self) -> &[Brick] {
        &self.bricks
    }

    /// Vertex of the piece to which an edge of a cell belongs.
    pub(super) fn vertex(&self, voxel: IVec3, edge: usize) -> u32 {
        let (brick, cell) = self.find(voxel).expect("the four cells around a crossed edge are crossed");
        let cell = &self.bricks[brick].cells[cell];
        debug_assert_ne!(cell.pieces[edge], NO_PIECE);
        cell.first_vertex + u32::from(cell.pieces[edge])
    }

    /// Vertices of a cell; empty if the surface does not cross it.
    pub(super) fn vertices_of(&self, voxel: IVec3) -> std::ops::Range<u32> {
        let Some((brick, cell)) = self.find(voxel) else { return 0..0 };
        let cell = &self.bricks[brick].cells[cell];
        cell.first_vertex..cell.first_vertex + u32::from(cell.piece_count)
    }

    fn find(&self, voxel: IVec3) -> Option<(usize, usize)> {
        let brick = self.position.get((voxel >> 3) - self.origin) as usize;
        let cell = self.bricks.get(brick)?.place[voxel_offset(voxel)];
        (cell != NO_CELL).then_some((brick, usize::from(cell)))
    }

    /// Exchanges the pairs of each face through which one piece passes twice on both sides. That splits both pieces and
    /// joins none, so one pass suffices.
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
        let mut known = PiecesOf::default();
        for cell in self.bricks.iter_mut().flat_map(|brick| &mut brick.cells) {
            (cell.pieces, cell.piece_count) = known.of(cell.signs);
            cell.first_vertex = vertices;
            vertices += u32::from(cell.piece_count);
        }
    }

    /// Computes all vertices in order, at their positions on the surface; their homes are `inset` [voxels] within their
    /// cells.
    pub(super) fn vertices(&self, grid: &BrickGrid, inset: f64) -> Vec<Corner> {
        let of_brick = |brick: &Brick| {
            let known = BrickSurroundings::of(grid, brick.at, inset);
            let mut vertices = Vec::new();
            brick.cells.iter().for_each(|cell| cell_vertices(brick, cell, &known, &mut vertices));
            vertices
        };
        self.bricks.par_iter().map(of_brick).collect::<Vec<_>>().concat()
    }
}

fn cell_vertices(brick: &Brick, cell: &Cell, known: &BrickSurroundings, vertices: &mut Vec<Corner>) {
    let low = voxel_at(IVec3::ZERO, usize::from(cell.offset));
    let voxel = brick.voxel(cell);
    let edges_of = |piece: u8| (0..12).filter(move |&edge| cell.pieces[edge] == piece);
    let around = CellSurroundings { known, low };
    let first = vertices.len();
    for piece in 0..cell.piece_count {
        let vertex = around.vertex(edges_of(piece));
        let at = voxel.as_dvec3() + vertex.at;
        vertices.push(Corner { at, shape: vertex.shape, cell: voxel, home: vertex.home.as_vec3() });
    }
    if cell.piece_count > 1 {
        let middles: Vec<DVec3> = (0..cell.piece_count).map(|piece| middle_of_edges(edges_of(piece))).collect();
        keep_apart(&mut vertices[first..], &middles, &around);
    }
}
