//! Traverses the tree of a grid in untrusted bytes.
//!
//! Upper nodes refer only to lower nodes and those only to leaves, so a cycle cannot be followed for more than three
//! steps. The traversal visits no more nodes than fit in the bytes, so shared nodes cannot multiply.

use std::collections::HashSet;

use glam::IVec3;
use rayon::prelude::*;

use super::bytes::Bytes;
use super::error::NvdbError;
use super::field::Value;
use super::layout::{GridData, LEAF_BYTES, LOWER, Leaf, Level, RootData, RootTile, TreeData, UPPER, root_coordinates};
use super::tree::{Tile, Tree};
use crate::grid::BRICK_VOXELS;

/// A node: offset of its bytes, and its coordinates in units of its own size.
#[derive(Clone, Copy, Debug)]
pub(super) struct Found {
    pub(super) at: u64,
    pub(super) coordinates: IVec3,
}

/// A root and everything below it.
pub(super) struct Nodes<V> {
    pub(super) root: RootData,
    pub(super) uppers: Vec<Found>,
    pub(super) lowers: Vec<Found>,
    pub(super) leaves: Vec<Found>,
    pub(super) tiles: Vec<Tile<V>>,
    pub(super) background: V,
    /// End of the root's table [bytes].
    pub(super) root_end: u64,
}

/// A traversal of one grid that collects its tiles.
struct Walk<'a, V> {
    grid: &'a str,
    bytes: Bytes<'a>,
    background: V,
    tiles: Vec<Tile<V>>,
}

/// Finds all nodes and tiles of a grid of values `V`.
pub(super) fn walk<V: Value>(grid: &str, bytes: Bytes) -> Result<Nodes<V>, NvdbError> {
    let tree: TreeData = bytes.get("the tree", size_of::<GridData>() as u64)?;
    let root_at = (size_of::<GridData>() as u64).saturating_add(tree.node_offset[3]);
    let root: RootData = bytes.get("the root", root_at)?;
    let mut walk = Walk { grid, bytes, background: bytemuck::cast(root.background), tiles: Vec::new() };
    walk.aligned("the root", root_at)?;
    let [leaf_count, lower_count, upper_count] = tree.node_count;
    walk.fits("leaves", leaf_count, LEAF_BYTES)?;
    walk.fits("lower nodes", lower_count, LOWER.bytes())?;
    walk.fits("upper nodes", upper_count, UPPER.bytes())?;
    walk.fits("root entries", root.table_size, size_of::<RootTile>())?;

    let uppers = walk.root(root_at, root.table_size)?;
    walk.at_most("upper nodes", uppers.len(), upper_count)?;
    let (mut lowers, mut leaves) = (Vec::new(), Vec::new());
    for upper in &uppers {
        lowers.extend(walk.inner(UPPER, upper)?);
        walk.at_most("lower nodes", lowers.len(), lower_count)?;
    }
    for lower in &lowers {
        leaves.extend(walk.inner(LOWER, lower)?);
        walk.at_most("leaves", leaves.len(), leaf_count)?;
    }
    let root_end = root_at + (size_of::<RootData>() + root.table_size as usize * size_of::<RootTile>()) as u64;
    Ok(Nodes { root, root_end, uppers, lowers, leaves, background: walk.background, tiles: walk.tiles })
}

impl<V: Value> Walk<'_, V> {
    fn damaged<T>(&self, what: String) -> Result<T, NvdbError> {
        Err(NvdbError::Structure { grid: self.grid.to_owned(), what })
    }

    fn fits(&self, what: &str, count: u32, each: usize) -> Result<(), NvdbError> {
        if u64::from(count) * each as u64 > self.bytes.len() {
            return self.damaged(format!("{count} {what} of {each} bytes in {} bytes", self.bytes.len()));
        }
        Ok(())
    }

    fn at_most(&self, what: &str, found: usize, declared: u32) -> Result<(), NvdbError> {
        if found > declared as usize {
            return self.damaged(format!("more {what} than the {declared} it declares"));
        }
        Ok(())
    }

    fn aligned(&self, what: &str, at: u64) -> Result<(), NvdbError> {
        if !at.is_multiple_of(32) {
            return self.damaged(format!("{what} lies at byte {at}, not at a multiple of 32"));
        }
        Ok(())
    }

    /// Offset of a node of `size` bytes that its parent at `parent` refers to.
    fn child(&self, what: &'static str, parent: u64, ahead: i64, size: usize) -> Result<u64, NvdbError> {
        let at = parent.checked_add_signed(ahead).unwrap_or(u64::MAX);
        self.bytes.slice(what, at, size as u64)?;
        self.aligned(what, at)?;
        Ok(at)
    }

    /// Finds the upper nodes.
    fn root(&mut self, root_at: u64, table_size: u32) -> Result<Vec<Found>, NvdbError> {
        let mut seen = HashSet::new();
        let mut uppers = Vec::new();
        for i in 0..u64::from(table_size) {
            let at = root_at + size_of::<RootData>() as u64 + i * size_of::<RootTile>() as u64;
            let tile: RootTile = self.bytes.get("the root's table", at)?;
            let Some(coordinates) = root_coordinates(tile.key) else {
                return self.damaged(format!("root key {:#x}", tile.key));
            };
            if !seen.insert(tile.key) {
                return self.damaged(format!("two root entries for upper node {coordinates}"));
            }
            if tile.child == 0 {
                let side_log2 = UPPER.voxels_log2;
                let (value, active) = (bytemuck::cast(tile.value), tile.state != 0);
                self.keep(Tile { voxel: coordinates << side_log2, side_log2, value, active });
            } else {
                let at = self.child("an upper node", root_at, tile.child, UPPER.bytes())?;
                uppers.push(Found { at, coordinates });
            }
        }
        Ok(uppers)
    }

    /// Finds the children of an inner node.
    fn inner(&mut self, level: Level, node: &Found) -> Result<Vec<Found>, NvdbError> {
        let bytes = self.bytes.slice("an inner node", node.at, level.bytes() as u64)?;
        let bit = |from: usize, i: usize| bytes[from + i / 8] >> (i % 8) & 1 != 0;
        let (what, size) =
            if level.log2 == LOWER.log2 { ("a leaf", LEAF_BYTES) } else { ("a lower node", LOWER.bytes()) };
        let (log2, mask) = (level.log2, (1i32 << level.log2) - 1);
        let side_log2 = level.voxels_log2 - log2;
        let mut children = Vec::new();
        for (i, cell) in bytes[level.table_at()..].chunks_exact(8).enumerate() {
            let local = IVec3::new(i as i32 >> (2 * log2), i as i32 >> log2 & mask, i as i32 & mask);
            let coordinates = (node.coordinates << log2) + local;
            if bit(level.children_at(), i) {
                let at = self.child(what, node.at, bytemuck::pod_read_unaligned(cell), size)?;
                children.push(Found { at, coordinates });
            } else {
                let (value, active) = (bytemuck::pod_read_unaligned(&cell[..4]), bit(level.active_at(), i));
                self.keep(Tile { voxel: coordinates << side_log2, side_log2, value, active });
            }
        }
        Ok(children)
    }

    fn keep(&mut self, tile: Tile<V>) {
        if tile.active || tile.value.bits() != self.background.bits() {
            self.tiles.push(tile);
        }
    }
}

/// Copies the leaves from the bytes.
pub(super) fn collect<V: Value>(nodes: Nodes<V>, bytes: Bytes) -> Result<Tree<V>, NvdbError> {
    let mut tree = Tree {
        background: nodes.background,
        leaves: nodes.leaves.iter().map(|leaf| leaf.coordinates).collect(),
        active: vec![[0; 8]; nodes.leaves.len()],
        values: vec![V::zeroed(); nodes.leaves.len() * BRICK_VOXELS],
        tiles: nodes.tiles,
    };
    let rooms = tree.values.par_chunks_exact_mut(BRICK_VOXELS).zip(&mut tree.active);
    rooms.zip(&nodes.leaves).try_for_each(|((values, active), leaf)| {
        let data: Leaf = bytes.get("a leaf", leaf.at)?;
        *active = data.active;
        values.copy_from_slice(bytemuck::cast_slice(&data.values));
        Ok(())
    })?;
    Ok(tree)
}
