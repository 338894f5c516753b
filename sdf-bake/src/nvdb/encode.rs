//! Encodes one grid: the tree, its statistics and its checksum.

use bytemuck::{Zeroable, bytes_of};
use glam::{DVec3, IVec3};
use rayon::prelude::*;

use super::checksum;
use super::field::{Field, Value};
use super::layout::{
    GridData, LEAF_BYTES, LOWER, Leaf, Level, MAGIC, Map, NAME_BYTES, NodeHead, RootData, RootTile, TreeData, UPPER,
    Version, flags, root_key,
};
use super::summary::Summary;
use super::topology::{Cell, Cells, Nodes, Topology};
use crate::grid::{BRICK_SIDE, BRICK_VOXELS};

/// Offsets of the parts of a grid [bytes from its head].
#[derive(Clone, Copy, Debug)]
struct Places {
    root: usize,
    uppers: usize,
    lowers: usize,
    leaves: usize,
    end: usize,
}

impl Places {
    fn new(tree: &Topology) -> Self {
        let root = size_of::<GridData>() + size_of::<TreeData>();
        let uppers = root + size_of::<RootData>() + size_of::<RootTile>() * tree.root.len();
        let lowers = uppers + UPPER.bytes() * tree.uppers.len();
        let leaves = lowers + LOWER.bytes() * tree.lowers.at.len();
        Self { root, uppers, lowers, leaves, end: leaves + LEAF_BYTES * tree.leaves.at.len() }
    }
}

/// A grid prepared for writing: its tree is laid out, so its size is known.
pub(super) struct Plan<F: Field> {
    field: F,
    tree: Topology,
    places: Places,
}

/// Entries for a grid in the file's own table.
pub(super) struct Written {
    pub(super) head: GridData,
    pub(super) tree: TreeData,
    pub(super) index_bbox: [i32; 6],
}

/// A node's summary and the CRC of its bytes.
type Done<V> = (Summary<V>, u32);

impl<F: Field> Plan<F> {
    pub(super) fn new(field: F) -> Self {
        let tree = Topology::new(field.grid(), |slot| field.keeps(slot), field.inside().is_some());
        let places = Places::new(&tree);
        Self { field, tree, places }
    }

    /// Size of the grid in memory [bytes].
    pub(super) fn bytes(&self) -> usize {
        self.places.end
    }

    /// Writes the grid into `out`, which is zero and [`Plan::bytes`] long. `grids_left` is the number of grids of the
    /// file from this one on.
    pub(super) fn write(&self, name: &str, grids_left: u32, out: &mut [u8]) -> Written {
        let (head_bytes, rest) = out.split_at_mut(self.places.uppers);
        let (upper_bytes, rest) = rest.split_at_mut(self.places.lowers - self.places.uppers);
        let (lower_bytes, leaf_bytes) = rest.split_at_mut(self.places.leaves - self.places.lowers);

        let leaf_rooms = leaf_bytes.par_chunks_exact_mut(LEAF_BYTES).zip(&self.tree.leaves.at);
        let leaves: Vec<Done<F::Value>> = leaf_rooms.map(|(room, at)| self.leaf(*at, room)).collect();
        let lowers = self.nodes(lower_bytes, &self.lower_plan(), &leaves);
        let uppers = self.nodes(upper_bytes, &self.upper_plan(), &lowers);

        let summary = merged(&uppers);
        let mut written = self.head(name, grids_left, &summary);
        self.write_root(&summary, &written, head_bytes);
        let crcs = uppers.iter().chain(&lowers).chain(&leaves).map(|(_, crc)| *crc);
        written.head.checksum = checksum::join(checksum::head(head_bytes), checksum::tail(crcs));
        put(head_bytes, 0, &written.head);
        written
    }

    fn lower_plan(&self) -> LevelPlan<'_> {
        LevelPlan {
            level: LOWER,
            at: &self.tree.lowers.at,
            cells: &self.tree.brick_cells,
            children: &self.tree.leaves,
            child_bytes: LEAF_BYTES,
            gap: self.places.leaves - self.places.lowers,
        }
    }

    fn upper_plan(&self) -> LevelPlan<'_> {
        LevelPlan {
            level: UPPER,
            at: &self.tree.uppers,
            cells: &self.tree.lower_cells,
            children: &self.tree.lowers,
            child_bytes: LOWER.bytes(),
            gap: self.places.lowers - self.places.uppers,
        }
    }

    fn leaf(&self, brick: IVec3, out: &mut [u8]) -> Done<F::Value> {
        let first = brick * BRICK_SIDE as i32;
        let base = self.field.grid().slot(brick) as usize * BRICK_VOXELS;
        let mut leaf = Leaf::zeroed();
        let mut summary = Summary::empty();
        for (x, mask) in leaf.active.iter_mut().enumerate() {
            for yz in 0..64 {
                let offset = x << 6 | yz;
                let value = self.field.value(base + offset);
                leaf.values[offset] = value.bits();
                if self.field.is_active(value) {
                    *mask |= 1 << yz;
                    summary.add(value);
                }
            }
        }
        leaf.bbox_min = first.to_array();
        if summary.count > 0 {
            let (low, high) = active_box(&leaf.active);
            summary.set_box(first + low, first + high);
            leaf.bbox_min = summary.low.to_array();
            leaf.bbox_extent = (high - low).to_array().map(|extent| extent as u8);
            leaf.flags |= flags::NODE_ACTIVE;
        }
        if summary.beyond(self.field.skip_beyond()) {
            leaf.flags |= flags::NODE_SKIP;
        }
        leaf.stats = summary.stats(self.field.background());
        out.copy_from_slice(bytes_of(&leaf));
        (summary, crc32fast::hash(out))
    }

    /// Writes all nodes of an inner level.
    fn nodes(&self, out: &mut [u8], plan: &LevelPlan, children: &[Done<F::Value>]) -> Vec<Done<F::Value>> {
        out.par_chunks_exact_mut(plan.level.bytes())
            .enumerate()
            .map(|(number, room)| {
                let summary = merged(&children[plan.children.of_parent(number)]);
                self.node(number, plan, &summary, room);
                (summary, crc32fast::hash(room))
            })
            .collect()
    }

    fn node(&self, number: usize, plan: &LevelPlan, summary: &Summary<F::Value>, out: &mut [u8]) {
        let (level, at) = (plan.level, plan.at[number]);
        let background = self.field.background();
        let inside = self.field.inside().unwrap_or(background);
        out[level.table_at()..].chunks_exact_mut(8).for_each(|c| c[..4].copy_from_slice(bytes_of(&background.bits())));
        for (cell, kind) in plan.cells.rows_within(at, level.log2).flat_map(|row| plan.cells.row(row)) {
            let local = cell - (at << level.log2);
            let offset = ((local.x << (2 * level.log2)) | (local.y << level.log2) | local.z) as usize;
            let place = level.table_at() + 8 * offset;
            match kind {
                Cell::Outside => {}
                Cell::Inside => put(out, place, &inside.bits()),
                Cell::Node(child) => {
                    out[level.children_at() + offset / 8] |= 1 << (offset % 8);
                    let ahead = plan.gap + child as usize * plan.child_bytes - number * level.bytes();
                    put(out, place, &(ahead as i64));
                }
            }
        }
        let skip = summary.count == 0 || summary.beyond(self.field.skip_beyond());
        let skip = if skip { flags::NODE_SKIP } else { 0 };
        let active = if summary.count > 0 { flags::NODE_ACTIVE } else { 0 };
        put(out, 0, &NodeHead { bbox: summary.node_box(at << level.voxels_log2), flags: u64::from(skip | active) });
        put(out, level.stats_at(), &summary.stats(background));
    }

    fn head(&self, name: &str, grids_left: u32, summary: &Summary<F::Value>) -> Written {
        let voxel = self.field.grid().voxel;
        let has_box = if summary.count > 0 { flags::BBOX } else { 0 };
        let head = GridData {
            magic: MAGIC,
            version: Version::WRITTEN,
            flags: flags::MIN_MAX | flags::AVERAGE | flags::STD_DEVIATION | flags::BREADTH_FIRST | has_box,
            // Readers of 32.4 treat a payload as a separate buffer and look for grid 0 in it; others concatenate the
            // payloads and continue while the count allows. Counting down works for both.
            grid_index: 0,
            grid_count: grids_left,
            grid_size: self.places.end as u64,
            name: padded(name),
            map: uniform_map(voxel),
            world_bbox: world_box(summary, voxel),
            voxel_size: [voxel; 3],
            grid_class: F::CLASS,
            grid_type: F::Value::GRID_TYPE,
            ..GridData::zeroed()
        };
        let tree = &self.tree;
        let counts = [tree.leaves.at.len(), tree.lowers.at.len(), tree.uppers.len()];
        let places = [self.places.leaves, self.places.lowers, self.places.uppers];
        let from_tree = |i: usize| if counts[i] == 0 { 0 } else { (places[i] - size_of::<GridData>()) as u64 };
        let tree = TreeData {
            node_offset: [from_tree(0), from_tree(1), from_tree(2), size_of::<TreeData>() as u64],
            node_count: counts.map(|count| count as u32),
            tile_count: [0; 3],
            voxel_count: summary.count,
        };
        Written { head, tree, index_bbox: index_box(summary) }
    }

    fn write_root(&self, summary: &Summary<F::Value>, written: &Written, out: &mut [u8]) {
        let background = self.field.background();
        put(out, 0, &written.head);
        put(out, size_of::<GridData>(), &written.tree);
        put(
            out,
            self.places.root,
            &RootData {
                bbox: written.index_bbox,
                table_size: self.tree.root.len() as u32,
                background: background.bits(),
                stats: summary.stats(background),
                padding: [0; 2],
            },
        );
        for (i, &(at, cell)) in self.tree.root.iter().enumerate() {
            let child = match cell {
                Cell::Node(upper) => self.places.uppers + upper as usize * UPPER.bytes() - self.places.root,
                _ => 0,
            };
            let value = if cell == Cell::Inside { self.field.inside() } else { None };
            put(
                out,
                self.places.root + size_of::<RootData>() + i * size_of::<RootTile>(),
                &RootTile {
                    key: root_key(at),
                    child: child as i64,
                    state: 0,
                    value: value.map_or(0, Value::bits),
                    padding: 0,
                },
            );
        }
    }
}

/// Layout of an inner level and its references to the level below.
struct LevelPlan<'a> {
    level: Level,
    /// Coordinates of this level's nodes, in units of their size.
    at: &'a [IVec3],
    cells: &'a Cells,
    children: &'a Nodes,
    child_bytes: usize,
    /// Offset from this level's first node to the first child [bytes].
    gap: usize,
}

fn merged<V: Value>(parts: &[Done<V>]) -> Summary<V> {
    parts.iter().fold(Summary::empty(), |whole, (part, _)| whole.merge(part))
}

fn put<T: bytemuck::Pod>(out: &mut [u8], at: usize, value: &T) {
    out[at..at + size_of::<T>()].copy_from_slice(bytes_of(value));
}

/// Lowest and highest active voxel of a leaf, relative to it; at least one is active.
fn active_box(active: &[u64; 8]) -> (IVec3, IVec3) {
    let first_x = active.iter().position(|word| *word != 0).unwrap_or(0) as i32;
    let last_x = active.iter().rposition(|word| *word != 0).unwrap_or(0) as i32;
    let plane = active.iter().fold(0, |all, word| all | word);
    let row = plane.to_le_bytes().iter().fold(0u8, |all, byte| all | byte);
    let low = IVec3::new(first_x, plane.trailing_zeros() as i32 / 8, row.trailing_zeros() as i32);
    let high = IVec3::new(last_x, (63 - plane.leading_zeros() as i32) / 8, 7 - row.leading_zeros() as i32);
    (low, high)
}

/// Box of the active voxels; NanoVDB's empty box if there are none.
fn index_box<V>(summary: &Summary<V>) -> [i32; 6] {
    let (low, high) = (summary.low, summary.high);
    [low.x, low.y, low.z, high.x, high.y, high.z]
}

/// Box from the lowest active voxel to one beyond the highest [m].
fn world_box<V>(summary: &Summary<V>, voxel: f64) -> [f64; 6] {
    if summary.count == 0 {
        return [f64::MAX, f64::MAX, f64::MAX, f64::MIN, f64::MIN, f64::MIN];
    }
    let low = summary.low.as_dvec3() * voxel;
    let high = (summary.high.as_dvec3() + DVec3::ONE) * voxel;
    [low.x, low.y, low.z, high.x, high.y, high.z]
}

fn uniform_map(voxel: f64) -> Map {
    let diagonal = |s: f64| [s, 0.0, 0.0, 0.0, s, 0.0, 0.0, 0.0, s];
    Map {
        matrix_f: diagonal(voxel).map(|v| v as f32),
        inverse_f: diagonal(1.0 / voxel).map(|v| v as f32),
        matrix: diagonal(voxel),
        inverse: diagonal(1.0 / voxel),
        taper_f: 1.0,
        taper: 1.0,
        ..Map::zeroed()
    }
}

fn padded(name: &str) -> [u8; NAME_BYTES] {
    let mut bytes = [0; NAME_BYTES];
    bytes[..name.len()].copy_from_slice(name.as_bytes());
    bytes
}
