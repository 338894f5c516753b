//! Nodes of the tree for a brick grid, and their order in the file.
//!
//! Bricks are the leaves. 16³ of them form a lower node, 32³ of those an upper node. A cell that is entirely inside or
//! entirely outside needs no node: it is one tile value in its parent.

use std::ops::Range;

use glam::IVec3;
use rayon::prelude::*;

use super::layout::{LOWER, UPPER};
use crate::grid::{BrickGrid, INSIDE, OUTSIDE};
use crate::index::{columns, entry_brick};

/// Kind of a cell of the tree.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Cell {
    /// A tile of the background.
    Outside,
    /// A tile of the inside value.
    Inside,
    /// A node, with its index among the nodes of its level.
    Node(u32),
}

/// All cells of one level of the tree within a box; outside it is the background.
#[derive(Clone, Debug)]
pub(super) struct Cells {
    origin: IVec3,
    dims: IVec3,
    cells: Vec<Cell>,
}

impl Cells {
    /// The rows along z of the whole box: first cell and entries of each, x slowest.
    fn rows(&self) -> impl Iterator<Item = Row> + use<> {
        self.rows_between(self.origin, self.origin + self.dims)
    }

    /// The rows along z within the node `parent` of 2^`log2` cells along an axis.
    pub(super) fn rows_within(&self, parent: IVec3, log2: u32) -> impl Iterator<Item = Row> + use<> {
        self.rows_between((parent << log2).max(self.origin), ((parent + 1) << log2).min(self.origin + self.dims))
    }

    /// Rows along z from `low` to below `high`, which must lie within the box.
    fn rows_between(&self, low: IVec3, high: IVec3) -> impl Iterator<Item = Row> + use<> {
        let (origin, dims) = (self.origin, self.dims);
        let length = (high.z - low.z).max(0) as usize;
        (low.x..high.x).flat_map(move |x| {
            (low.y..high.y).map(move |y| {
                let at = IVec3::new(x, y, low.z) - origin;
                let first = (at.x as usize * dims.y as usize + at.y as usize) * dims.z as usize + at.z as usize;
                Row { first: at + origin, entries: first..first + length }
            })
        })
    }

    /// Cells of a row, each with its coordinates.
    pub(super) fn row(&self, row: Row) -> impl Iterator<Item = (IVec3, Cell)> {
        self.cells[row.entries].iter().enumerate().map(move |(z, cell)| (row.first + IVec3::new(0, 0, z as i32), *cell))
    }

    /// The next level up; each of its cells is 2^`log2` of these along an axis.
    fn coarsen(&self, log2: u32) -> Self {
        let origin = self.origin >> log2;
        let end = (self.origin + self.dims + ((1 << log2) - 1)) >> log2;
        let dims = if self.cells.is_empty() { IVec3::ZERO } else { end - origin };
        let count = dims.as_i64vec3().element_product() as usize;
        let cells =
            (0..count).into_par_iter().map(|entry| self.summed_up(origin + entry_brick(entry, dims), log2)).collect();
        Self { origin, dims, cells }
    }

    /// Kind of a cell of the next level up.
    fn summed_up(&self, parent: IVec3, log2: u32) -> Cell {
        let (mut nodes, mut inside) = (0usize, 0usize);
        for row in self.rows_within(parent, log2) {
            for cell in &self.cells[row.entries] {
                nodes += usize::from(matches!(cell, Cell::Node(_)));
                inside += usize::from(*cell == Cell::Inside);
            }
        }
        match (nodes, inside) {
            (0, 0) => Cell::Outside,
            (0, inside) if inside == 1 << (3 * log2) => Cell::Inside,
            _ => Cell::Node(0),
        }
    }

    /// Numbers the nodes in the given rows, continuing from the nodes already listed.
    fn number(&mut self, rows: impl Iterator<Item = Row>, nodes: &mut Vec<IVec3>) {
        for row in rows {
            for (z, cell) in self.cells[row.entries].iter_mut().enumerate() {
                if let Cell::Node(number) = cell {
                    *number = nodes.len() as u32;
                    nodes.push(row.first + IVec3::new(0, 0, z as i32));
                }
            }
        }
    }

    /// Numbers this level's nodes, parent by parent.
    fn number_below(&mut self, parents: &[IVec3], log2: u32) -> Nodes {
        let mut nodes = Nodes { at: Vec::new(), first: vec![0] };
        for &parent in parents {
            self.number(self.rows_within(parent, log2), &mut nodes.at);
            nodes.first.push(nodes.at.len());
        }
        nodes
    }
}

/// Consecutive cells along z.
#[derive(Clone, Debug)]
pub(super) struct Row {
    first: IVec3,
    entries: Range<usize>,
}

/// The nodes of a level in file order.
#[derive(Clone, Debug)]
pub(super) struct Nodes {
    /// Coordinates, in units of the level's node.
    pub(super) at: Vec<IVec3>,
    /// Index in `at` of each parent's first node, and one past the last.
    first: Vec<usize>,
}

impl Nodes {
    /// Index range of a parent's nodes.
    pub(super) fn of_parent(&self, parent: usize) -> Range<usize> {
        self.first[parent]..self.first[parent + 1]
    }
}

/// The tree over a brick grid.
#[derive(Clone, Debug)]
pub(super) struct Topology {
    pub(super) brick_cells: Cells,
    pub(super) lower_cells: Cells,
    /// Entries of the root: coordinates [upper nodes] and kind.
    pub(super) root: Vec<(IVec3, Cell)>,
    /// Upper nodes in file order [upper nodes].
    pub(super) uppers: Vec<IVec3>,
    pub(super) lowers: Nodes,
    pub(super) leaves: Nodes,
}

impl Topology {
    /// Tree of the bricks whose slot is `kept`, with inside tiles if the field has an `inside`.
    pub(super) fn new(grid: &BrickGrid, kept: impl Fn(usize) -> bool + Sync, inside: bool) -> Self {
        let cell = |slot: u32| match slot {
            OUTSIDE => Cell::Outside,
            INSIDE if inside => Cell::Inside,
            INSIDE => Cell::Outside,
            slot if kept(slot as usize) => Cell::Node(0),
            _ => Cell::Outside,
        };
        let cells = columns(grid.dims).flat_map_iter(|at| grid.index.row(at.x, at.y).map(cell)).collect();
        let brick_cells = Cells { origin: grid.origin, dims: grid.dims, cells };
        let lower_cells = brick_cells.coarsen(LOWER.log2);
        Self::over(brick_cells, lower_cells)
    }

    fn over(mut brick_cells: Cells, mut lower_cells: Cells) -> Self {
        let mut upper_cells = lower_cells.coarsen(UPPER.log2);
        let mut uppers = Vec::new();
        upper_cells.number(upper_cells.rows(), &mut uppers);
        let all = upper_cells.rows().flat_map(|row| upper_cells.row(row));
        let root = all.filter(|(_, cell)| *cell != Cell::Outside).collect();
        let lowers = lower_cells.number_below(&uppers, UPPER.log2);
        let leaves = brick_cells.number_below(&lowers.at, LOWER.log2);
        Self { brick_cells, lower_cells, root, uppers, lowers, leaves }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::index::BrickIndex;

    fn at(cells: &Cells, wanted: IVec3) -> Option<Cell> {
        cells.rows().flat_map(|row| cells.row(row)).find(|(at, _)| *at == wanted).map(|(_, cell)| cell)
    }

    #[test]
    fn a_node_that_is_inside_throughout_becomes_a_tile() {
        let mut grid = BrickGrid::empty(1.0, 3.0, IVec3::splat(-17), IVec3::splat(34));
        grid.index.fill(IVec3::ZERO, grid.dims, INSIDE);
        let tree = Topology::new(&grid, |_| true, true);
        assert_eq!(at(&tree.lower_cells, IVec3::splat(-1)), Some(Cell::Inside));
        assert_eq!(at(&tree.lower_cells, IVec3::ZERO), Some(Cell::Inside));
        assert!(matches!(at(&tree.lower_cells, IVec3::splat(-2)), Some(Cell::Node(_))));
        assert_eq!(tree.lowers.at.len(), 4 * 4 * 4 - 2 * 2 * 2);
        assert_eq!(tree.leaves.at.len(), 0);
    }

    #[test]
    fn an_upper_node_that_is_inside_throughout_becomes_a_root_tile() {
        let brick_cells = Cells { origin: IVec3::ZERO, dims: IVec3::ZERO, cells: Vec::new() };
        let lower_cells = Cells { origin: IVec3::splat(-32), dims: IVec3::splat(32), cells: vec![Cell::Inside; 32768] };
        let tree = Topology::over(brick_cells, lower_cells);
        assert_eq!(tree.root, [(IVec3::splat(-1), Cell::Inside)]);
        assert!(tree.uppers.is_empty());
    }

    #[test]
    fn nodes_follow_their_parents_in_order() {
        let mut grid = BrickGrid::empty(1.0, 3.0, IVec3::new(-3, 0, 14), IVec3::new(6, 1, 4));
        grid.index = BrickIndex::from_dense(grid.dims, &(0..24).collect::<Vec<u32>>());
        let tree = Topology::new(&grid, |slot| slot != 5, true);
        assert_eq!(tree.leaves.at.len(), 23);
        assert_eq!(tree.lowers.at, [(-1, 0, 0), (-1, 0, 1), (0, 0, 0), (0, 0, 1)].map(|(x, y, z)| IVec3::new(x, y, z)));
        for lower in 0..4 {
            for leaf in tree.leaves.of_parent(lower) {
                assert_eq!(tree.leaves.at[leaf] >> 4, tree.lowers.at[lower]);
                assert_eq!(at(&tree.brick_cells, tree.leaves.at[leaf]), Some(Cell::Node(leaf as u32)));
            }
        }
    }
}
