//! Walks the tree of a grid in untrusted bytes.
//!
//! Upper nodes point only to lower nodes and those only to leaves, so no cycle can be followed for more than three
//! steps; and since the walk visits no more nodes than fit in the bytes, shared nodes cannot multiply.

use glam::IVec3;

use super::bytes::Bytes;
use super::error::NvdbError;
use super::field::Value;
use super::layout::{GridData, LEAF_BYTES, LOWER, Leaf, Level, RootData, RootTile, TreeData, UPPER, root_coordinates};
use super::tree::{Tile, Tree};

/// A node found: where its bytes begin, and its place in the tree in units of its own size.
#[derive(Clone, Copy, Debug)]
pub(super) struct Found {
    pub(super) at: u64,
    pub(super) coordinates: IVec3,
}

/// Everything below a root.
pub(super) struct Nodes<V> {
    pub(super) uppers: Vec<Found>,
    pub(super) lowers: Vec<Found>,
    pub(super) leaves: Vec<Found>,
    pub(super) tiles: Vec<Tile<V>>,
    pub(super) background: V,
    /// Where the root and its table lie [bytes].
    pub(super) root_at: u64,
    pub(super) root_end: u64,
}

/// A walk through one grid.
struct Walk<'a> {
    grid: &'a str,
    bytes: Bytes<'a>,
}

/// Finds all nodes and tiles of a grid of values `V`.
pub(super) fn walk<V: Value>(grid: &str, bytes: Bytes) -> Result<Nodes<V>, NvdbError> {
    let walk = Walk { grid, bytes };
    let tree: TreeData = bytes.get("the tree", size_of::<GridData>() as u64)?;
    let [leaf_count, lower_count, upper_count] = tree.node_count.map(u64::from);
    walk.fits("leaves", leaf_count, LEAF_BYTES)?;
    walk.fits("lower nodes", lower_count, LOWER.bytes())?;
    walk.fits("upper nodes", upper_count, UPPER.bytes())?;

    let root_at = walk.aligned("the root", (size_of::<GridData>() as u64).saturating_add(tree.node_offset[3]))?;
    let root: RootData = bytes.get("the root", root_at)?;
    walk.fits("root entries", u64::from(root.table_size), size_of::<RootTile>())?;
    let background: V = bytemuck::cast(root.background);
    let mut nodes = Nodes {
        uppers: Vec::new(),
        lowers: Vec::new(),
        leaves: Vec::new(),
        tiles: Vec::new(),
        background,
        root_at,
        root_end: root_at + (size_of::<RootData>() + root.table_size as usize * size_of::<RootTile>()) as u64,
    };
    walk.root(root_at, root.table_size, &mut nodes)?;
    for upper in nodes.uppers.clone() {
        walk.inner(UPPER, upper, &mut nodes.lowers, &mut nodes.tiles, background)?;
        walk.at_most("lower nodes", nodes.lowers.len(), lower_count)?;
    }
    for lower in nodes.lowers.clone() {
        walk.inner(LOWER, lower, &mut nodes.leaves, &mut nodes.tiles, background)?;
        walk.at_most("leaves", nodes.leaves.len(), leaf_count)?;
    }
    walk.at_most("upper nodes", nodes.uppers.len(), upper_count)?;
    Ok(nodes)
}

impl Walk<'_> {
    fn damaged<T>(&self, what: String) -> Result<T, NvdbError> {
        Err(NvdbError::Structure { grid: self.grid.to_owned(), what })
    }

    fn fits(&self, what: &str, count: u64, each: usize) -> Result<(), NvdbError> {
        if count.saturating_mul(each as u64) > self.bytes.len() {
            return self.damaged(format!("{count} {what} of {each} bytes in {} bytes", self.bytes.len()));
        }
        Ok(())
    }

    fn at_most(&self, what: &str, found: usize, declared: u64) -> Result<(), NvdbError> {
        if found as u64 > declared {
            return self.damaged(format!("more {what} than the {declared} it declares"));
        }
        Ok(())
    }

    fn aligned(&self, what: &str, at: u64) -> Result<u64, NvdbError> {
        if at % 32 != 0 {
            return self.damaged(format!("{what} lies at byte {at}, not at a multiple of 32"));
        }
        Ok(at)
    }

    /// Where a node lies that its parent at `parent` points to.
    fn child(&self, what: &'static str, parent: u64, ahead: i64, size: usize) -> Result<u64, NvdbError> {
        let at = parent.checked_add_signed(ahead).unwrap_or(u64::MAX);
        let at = self.aligned(what, at)?;
        self.bytes.slice(what, at, size as u64)?;
        Ok(at)
    }

    fn root<V: Value>(&self, root_at: u64, table_size: u32, nodes: &mut Nodes<V>) -> Result<(), NvdbError> {
        let mut seen = std::collections::HashSet::new();
        for i in 0..u64::from(table_size) {
            let at = root_at + size_of::<RootData>() as u64 + i * size_of::<RootTile>() as u64;
            let tile: RootTile = self.bytes.get("the root's table", at)?;
            let Some(coordinates) = root_coordinates(tile.key) else {
                return self.damaged(format!("root key {:#x}", tile.key));
            };
            if !seen.insert(tile.key) {
                return self.damaged(format!("two root entries for upper node {coordinates}"));
            }
            if tile.child != 0 {
                let at = self.child("an upper node", root_at, tile.child, UPPER.bytes())?;
                nodes.uppers.push(Found { at, coordinates });
            } else {
                let value: V = bytemuck::cast(tile.value);
                let log2 = UPPER.voxels_log2;
                self.tile(coordinates, log2, value, tile.state != 0, nodes.background, &mut nodes.tiles);
            }
        }
        Ok(())
    }

    fn tile<V: Value>(&self, at: IVec3, log2: u32, value: V, active: bool, background: V, tiles: &mut Vec<Tile<V>>) {
        if active || value.bits() != background.bits() {
            tiles.push(Tile { voxel: at << log2, side_log2: log2, value, active });
        }
    }

    fn inner<V: Value>(
        &self,
        level: Level,
        node: Found,
        children: &mut Vec<Found>,
        tiles: &mut Vec<Tile<V>>,
        background: V,
    ) -> Result<(), NvdbError> {
        let bytes = self.bytes.slice("an inner node", node.at, level.bytes() as u64)?;
        let bit = |from: usize, i: usize| bytes[from + i / 8] >> (i % 8) & 1 != 0;
        let (what, size) =
            if level.log2 == LOWER.log2 { ("a leaf", LEAF_BYTES) } else { ("a lower node", LOWER.bytes()) };
        let (log2, mask) = (level.log2, (1i32 << level.log2) - 1);
        for (i, cell) in bytes[level.table_at()..].chunks_exact(8).enumerate() {
            let local = IVec3::new(i as i32 >> (2 * log2), i as i32 >> log2 & mask, i as i32 & mask);
            let coordinates = (node.coordinates << log2) + local;
            if bit(level.children_at(), i) {
                let at = self.child(what, node.at, bytemuck::pod_read_unaligned(cell), size)?;
                children.push(Found { at, coordinates });
            } else {
                let value: V = bytemuck::pod_read_unaligned(&cell[..4]);
                let active = bit(level.active_at(), i);
                self.tile(coordinates, level.voxels_log2 - log2, value, active, background, tiles);
            }
        }
        Ok(())
    }
}

/// Copies the leaves out of the bytes.
pub(super) fn collect<V: Value>(nodes: Nodes<V>, bytes: Bytes) -> Result<Tree<V>, NvdbError> {
    let mut tree = Tree {
        background: nodes.background,
        leaves: Vec::with_capacity(nodes.leaves.len()),
        active: Vec::with_capacity(nodes.leaves.len()),
        values: Vec::with_capacity(nodes.leaves.len() * 512),
        tiles: nodes.tiles,
    };
    for leaf in &nodes.leaves {
        let data: Leaf = bytes.get("a leaf", leaf.at)?;
        tree.leaves.push(leaf.coordinates);
        tree.active.push(data.active);
        tree.values.extend_from_slice(bytemuck::cast_slice(&data.values));
    }
    Ok(tree)
}
