//! Which nodes a tree needs for a brick grid, and in which order they lie in the file.
//!
//! Bricks are the leaves. 16³ of them make a lower node, 32³ of those an upper node. A cell that is wholly
//! inside or wholly outside needs no node: it is one tile value in its parent.

use glam::IVec3;

use super::layout::{LOWER, UPPER};
use crate::grid::{BrickGrid, INSIDE, OUTSIDE};

/// What a cell of the tree is.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Cell {
    /// A tile of the background.
    Outside,
    /// A tile of the inside value.
    Inside,
    /// A node, with its place among the nodes of its level.
    Node(u32),
}

/// All cells of one level of the tree within a box; beyond it is the background.
#[derive(Clone, Debug)]
pub(super) struct Cells {
    origin: IVec3,
    dims: IVec3,
    cells: Vec<Cell>,
}

impl Cells {
    fn entry(&self, at: IVec3) -> Option<usize> {
        let at = at - self.origin;
        let within = at.cmpge(IVec3::ZERO).all() && at.cmplt(self.dims).all();
        within.then(|| ((at.x * self.dims.y + at.y) as usize) * self.dims.z as usize + at.z as usize)
    }

    pub(super) fn get(&self, at: IVec3) -> Cell {
        self.entry(at).map_or(Cell::Outside, |entry| self.cells[entry])
    }

    /// All cells of the box, x slowest.
    fn all(&self) -> impl Iterator<Item = IVec3> + use<> {
        cells_between(self.origin, self.origin + self.dims)
    }

    /// The part of the box within the node `parent` of 2^`log2` cells along an axis, x slowest.
    pub(super) fn within(&self, parent: IVec3, log2: u32) -> impl Iterator<Item = IVec3> + use<> {
        cells_between((parent << log2).max(self.origin), ((parent + 1) << log2).min(self.origin + self.dims))
    }

    /// The next level up, each of its cells 2^`log2` of these along an axis.
    fn coarsen(&self, log2: u32) -> Self {
        let origin = self.origin >> log2;
        let dims =
            if self.cells.is_empty() { IVec3::ZERO } else { ((self.origin + self.dims - 1) >> log2) - origin + 1 };
        let mut coarse = Self { origin, dims, cells: Vec::new() };
        let whole = 1usize << (3 * log2);
        for parent in coarse.all() {
            let (mut nodes, mut inside) = (0, 0);
            for cell in self.within(parent, log2) {
                match self.get(cell) {
                    Cell::Outside => {}
                    Cell::Inside => inside += 1,
                    Cell::Node(_) => nodes += 1,
                }
            }
            coarse.cells.push(match (nodes, inside) {
                (0, 0) => Cell::Outside,
                (0, inside) if inside == whole => Cell::Inside,
                _ => Cell::Node(0),
            });
        }
        coarse
    }

    /// Numbers those of the given cells that are nodes, on from the nodes already listed.
    fn number(&mut self, cells: impl Iterator<Item = IVec3>, nodes: &mut Vec<IVec3>) {
        for cell in cells {
            if let Some(entry) = self.entry(cell)
                && let Cell::Node(number) = &mut self.cells[entry]
            {
                *number = nodes.len() as u32;
                nodes.push(cell);
            }
        }
    }

    /// Numbers this level's nodes parent by parent.
    fn number_below(&mut self, parents: &[IVec3], log2: u32) -> Nodes {
        let mut nodes = Nodes { at: Vec::new(), first: vec![0] };
        for &parent in parents {
            self.number(self.within(parent, log2), &mut nodes.at);
            nodes.first.push(nodes.at.len());
        }
        nodes
    }
}

fn cells_between(low: IVec3, high: IVec3) -> impl Iterator<Item = IVec3> + use<> {
    (low.x..high.x)
        .flat_map(move |x| (low.y..high.y).flat_map(move |y| (low.z..high.z).map(move |z| IVec3::new(x, y, z))))
}

/// The nodes of a level in file order.
#[derive(Clone, Debug)]
pub(super) struct Nodes {
    /// Coordinates, in units of the level's node.
    pub(super) at: Vec<IVec3>,
    /// Where each parent's nodes begin in `at`; one entry more than there are parents.
    first: Vec<usize>,
}

impl Nodes {
    /// The places of a parent's nodes.
    pub(super) fn of_parent(&self, parent: usize) -> std::ops::Range<usize> {
        self.first[parent]..self.first[parent + 1]
    }
}

/// The tree over a brick grid.
#[derive(Clone, Debug)]
pub(super) struct Topology {
    pub(super) brick_cells: Cells,
    pub(super) lower_cells: Cells,
    /// Entries of the root: coordinates [upper nodes] and what is there.
    pub(super) root: Vec<(IVec3, Cell)>,
    /// Upper nodes in file order [upper nodes].
    pub(super) uppers: Vec<IVec3>,
    pub(super) lowers: Nodes,
    pub(super) leaves: Nodes,
}

impl Topology {
    /// The tree of the bricks whose slot is `kept`, with inside tiles if the field has an `inside`.
    pub(super) fn new(grid: &BrickGrid, kept: impl Fn(usize) -> bool, inside: bool) -> Self {
        let cell = |&slot: &u32| match slot {
            OUTSIDE => Cell::Outside,
            INSIDE if inside => Cell::Inside,
            INSIDE => Cell::Outside,
            slot if kept(slot as usize) => Cell::Node(0),
            _ => Cell::Outside,
        };
        let cells = grid.index.iter().map(cell).collect();
        let brick_cells = Cells { origin: grid.origin, dims: grid.dims, cells };
        let lower_cells = brick_cells.coarsen(LOWER.log2);
        Self::over(brick_cells, lower_cells)
    }

    fn over(mut brick_cells: Cells, mut lower_cells: Cells) -> Self {
        let mut upper_cells = lower_cells.coarsen(UPPER.log2);
        let mut uppers = Vec::new();
        upper_cells.number(upper_cells.all(), &mut uppers);
        let root = upper_cells.all().map(|at| (at, upper_cells.get(at))).filter(|(_, c)| *c != Cell::Outside).collect();
        let lowers = lower_cells.number_below(&uppers, UPPER.log2);
        let leaves = brick_cells.number_below(&lowers.at, LOWER.log2);
        Self { brick_cells, lower_cells, root, uppers, lowers, leaves }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_node_that_is_inside_throughout_becomes_a_tile() {
        let mut grid = BrickGrid::empty(1.0, 3.0, IVec3::splat(-17), IVec3::splat(34));
        grid.index.fill(INSIDE);
        let tree = Topology::new(&grid, |_| true, true);
        assert_eq!(tree.lower_cells.get(IVec3::splat(-1)), Cell::Inside);
        assert_eq!(tree.lower_cells.get(IVec3::ZERO), Cell::Inside);
        assert!(matches!(tree.lower_cells.get(IVec3::splat(-2)), Cell::Node(_)));
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
        (0..24).for_each(|slot| grid.index[slot as usize] = slot);
        let tree = Topology::new(&grid, |slot| slot != 5, true);
        assert_eq!(tree.leaves.at.len(), 23);
        assert_eq!(tree.lowers.at, [(-1, 0, 0), (-1, 0, 1), (0, 0, 0), (0, 0, 1)].map(|(x, y, z)| IVec3::new(x, y, z)));
        for lower in 0..4 {
            for leaf in tree.leaves.of_parent(lower) {
                assert_eq!(tree.leaves.at[leaf] >> 4, tree.lowers.at[lower]);
                assert_eq!(tree.brick_cells.get(tree.leaves.at[leaf]), Cell::Node(leaf as u32));
            }
        }
    }
}
