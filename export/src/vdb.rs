//! OpenVDB files (`.vdb`) of grids read from NanoVDB, for Blender, Houdini and other programs with OpenVDB.
//!
//! Both formats have the same tree: leaves of 8³ voxels, 16³ of them in a lower node, 32³ of those in an upper one. A
//! file has format version 224 (OpenVDB 6.2 and later); buffers are zlib streams, half precision and value masks are
//! not used. The layout follows `openvdb/io/Archive.cc`, `openvdb/tree/*.h` and `openvdb/math/Maps.h`.

use std::collections::BTreeMap;
use std::io::Write as _;

use flate2::{Compression, write::ZlibEncoder};
use glam::{DVec3, IVec3};
use sdf_bake::nvdb::{GridClass, NvdbGrid, Tree, Values};

/// First eight bytes of a file.
const MAGIC: u64 = 0x5644_4220;
/// Format version, and the library version that readers of it accept.
const VERSIONS: [u32; 3] = [224, 8, 0];
/// Identity of a file. Equal content must have equal bytes, so it is no random number.
const UUID: &[u8] = b"00000000-0000-0000-0000-000000000000";
/// Compression of buffers: zlib.
const ZIP: u32 = 1;
/// Code before a buffer that holds the values of all voxels, active or not.
const ALL_VALUES: u8 = 6;
/// Binary logarithms of the cells of a lower and of an upper node along an axis.
const LOWER: u32 = 4;
const UPPER: u32 = 5;
/// Binary logarithms of the sides of a leaf, of a lower and of an upper node [voxels].
const SIDES: [u32; 3] = [3, 7, 12];

/// Value of a voxel.
trait Value: Copy {
    const TREE: &'static str;
    const ZERO: Self;
    fn bytes(self) -> [u8; 4];
}

impl Value for f32 {
    const TREE: &'static str = "Tree_float_5_4_3";
    const ZERO: Self = 0.0;

    fn bytes(self) -> [u8; 4] {
        self.to_le_bytes()
    }
}

impl Value for i32 {
    const TREE: &'static str = "Tree_int32_5_4_3";
    const ZERO: Self = 0;

    fn bytes(self) -> [u8; 4] {
        self.to_le_bytes()
    }
}

/// A node with its children by cell.
struct Node<V, Child> {
    children: BTreeMap<u32, Child>,
    /// Values and active states of cells without a child, other than inactive background.
    tiles: BTreeMap<u32, (V, bool)>,
}

/// Children of a lower node are indices of leaves.
type Lower<V> = Node<V, usize>;
type Upper<V> = Node<V, Lower<V>>;

impl<V, Child> Default for Node<V, Child> {
    fn default() -> Self {
        Self { children: BTreeMap::new(), tiles: BTreeMap::new() }
    }
}

/// Returns the bytes of a `.vdb` file with the given grids, in order.
pub fn write_vdb(grids: &[&NvdbGrid]) -> Vec<u8> {
    let mut file = MAGIC.to_le_bytes().to_vec();
    file.extend(VERSIONS.iter().flat_map(|version| version.to_le_bytes()));
    // Grids state their places in the file.
    file.push(1);
    file.extend(UUID);
    file.extend(0_u32.to_le_bytes());
    file.extend((grids.len() as u32).to_le_bytes());
    for grid in grids {
        match &grid.values {
            Values::Float(tree) => push_grid(&mut file, grid, tree),
            Values::Int32(tree) => push_grid(&mut file, grid, tree),
        }
    }
    file
}

fn push_grid<V: Value>(file: &mut Vec<u8>, grid: &NvdbGrid, tree: &Tree<V>) {
    for text in [&grid.name, V::TREE, ""] {
        push_text(file, text);
    }
    let places = file.len();
    file.extend([0; 24]);
    let start = file.len();
    file.extend(ZIP.to_le_bytes());
    push_metadata(file, grid);
    push_transform(file, grid.voxel, grid.translation);
    file.extend(1_u32.to_le_bytes());
    let uppers = uppers(tree);
    push_topology(file, tree, &uppers);
    let blocks = file.len();
    for lower in uppers.values().flat_map(|upper| upper.children.values()) {
        for &leaf in lower.children.values() {
            push_mask(file, &tree.active[leaf]);
            push_values(file, &tree.values[512 * leaf..512 * (leaf + 1)]);
        }
    }
    for (place, position) in [start, blocks, file.len()].into_iter().enumerate() {
        file[places + 8 * place..places + 8 * (place + 1)].copy_from_slice(&(position as u64).to_le_bytes());
    }
}

fn push_metadata(file: &mut Vec<u8>, grid: &NvdbGrid) {
    let class = match grid.class {
        GridClass::LevelSet => "level set",
        GridClass::FogVolume => "fog volume",
        GridClass::Unknown | GridClass::Other(_) => "unknown",
    };
    let entries = [("class", class), ("name", grid.name.as_str())];
    file.extend((entries.len() as u32).to_le_bytes());
    for (key, value) in entries {
        [key, "string", value].into_iter().for_each(|text| push_text(file, text));
    }
}

/// Adds the map from voxels to metres: a uniform scale and a translation, with the derived numbers that the format
/// stores.
fn push_transform(file: &mut Vec<u8>, voxel: f64, translation: DVec3) {
    push_text(file, "UniformScaleTranslateMap");
    let scales = [voxel, voxel, 1.0 / voxel, 1.0 / (voxel * voxel), 0.5 / voxel].map(DVec3::splat);
    let numbers = [translation].into_iter().chain(scales).flat_map(|vector| vector.to_array());
    file.extend(numbers.flat_map(f64::to_le_bytes));
}

fn push_topology<V: Value>(file: &mut Vec<u8>, tree: &Tree<V>, uppers: &BTreeMap<[i32; 3], Upper<V>>) {
    file.extend(tree.background.bytes());
    let tiles: Vec<_> = tree.tiles.iter().filter(|tile| tile.side_log2 == SIDES[2]).collect();
    file.extend([tiles.len() as u32, uppers.len() as u32].into_iter().flat_map(u32::to_le_bytes));
    for tile in tiles {
        file.extend(tile.voxel.to_array().into_iter().flat_map(i32::to_le_bytes));
        file.extend(tile.value.bytes());
        file.push(u8::from(tile.active));
    }
    for (place, upper) in uppers {
        file.extend(place.iter().flat_map(|cell| (cell << SIDES[2]).to_le_bytes()));
        push_node(file, upper, UPPER, tree.background);
        for lower in upper.children.values() {
            push_node(file, lower, LOWER, tree.background);
            lower.children.values().for_each(|&leaf| push_mask(file, &tree.active[leaf]));
        }
    }
}

/// Adds the masks and values of an inner node with 2^`log2` cells along an axis.
fn push_node<V: Value, Child>(file: &mut Vec<u8>, node: &Node<V, Child>, log2: u32, background: V) {
    let cells = 1 << (3 * log2);
    let (mut children, mut active) = (vec![0_u64; cells / 64], vec![0_u64; cells / 64]);
    let mut values = vec![background; cells];
    let set = |mask: &mut [u64], cell: u32| mask[cell as usize / 64] |= 1 << (cell % 64);
    for &cell in node.children.keys() {
        set(&mut children, cell);
        values[cell as usize] = V::ZERO;
    }
    for (&cell, &(value, is_active)) in &node.tiles {
        values[cell as usize] = value;
        if is_active {
            set(&mut active, cell);
        }
    }
    push_mask(file, &children);
    push_mask(file, &active);
    push_values(file, &values);
}

fn push_mask(file: &mut Vec<u8>, mask: &[u64]) {
    file.extend(mask.iter().flat_map(|word| word.to_le_bytes()));
}

/// Adds a buffer: its code, the length of the stream and the zlib stream; or the negative length and the plain bytes,
/// where these are shorter.
fn push_values<V: Value>(file: &mut Vec<u8>, values: &[V]) {
    let raw: Vec<u8> = values.iter().flat_map(|value| value.bytes()).collect();
    let mut encoder = ZlibEncoder::new(Vec::new(), Compression::fast());
    let packed = encoder.write_all(&raw).and_then(|()| encoder.finish()).expect("writing to memory does not fail");
    file.push(ALL_VALUES);
    let is_shorter = packed.len() < raw.len();
    let length = if is_shorter { packed.len() as i64 } else { -(raw.len() as i64) };
    file.extend(length.to_le_bytes());
    file.extend(if is_shorter { packed } else { raw });
}

fn push_text(file: &mut Vec<u8>, text: &str) {
    file.extend((text.len() as u32).to_le_bytes());
    file.extend(text.as_bytes());
}

/// Sorts leaves and tiles below the root into nodes, by the coordinates of the upper ones [upper nodes].
fn uppers<V: Value>(tree: &Tree<V>) -> BTreeMap<[i32; 3], Upper<V>> {
    let mut uppers: BTreeMap<[i32; 3], Upper<V>> = BTreeMap::new();
    let place = |voxel: IVec3| (voxel >> SIDES[2]).to_array();
    for (leaf, brick) in tree.leaves.iter().enumerate() {
        let voxel = *brick << SIDES[0];
        let lower = uppers.entry(place(voxel)).or_default().children.entry(cell(voxel >> SIDES[1], UPPER)).or_default();
        lower.children.insert(cell(*brick, LOWER), leaf);
    }
    for tile in &tree.tiles {
        let content = (tile.value, tile.active);
        let in_upper = cell(tile.voxel >> SIDES[1], UPPER);
        if tile.side_log2 == SIDES[2] {
            continue;
        }
        let upper = uppers.entry(place(tile.voxel)).or_default();
        if tile.side_log2 == SIDES[1] {
            upper.tiles.insert(in_upper, content);
        } else {
            let lower = upper.children.entry(in_upper).or_default();
            lower.tiles.insert(cell(tile.voxel >> SIDES[0], LOWER), content);
        }
    }
    uppers
}

/// Returns the number of a cell within its node, which has 2^`log2` cells along an axis; z counts fastest.
fn cell(at: IVec3, log2: u32) -> u32 {
    let local = (at & ((1 << log2) - 1)).as_uvec3();
    (local.x << (2 * log2)) | (local.y << log2) | local.z
}

/// Returns the names of the grids of a `.vdb` file made by [`write_vdb`], if it is complete.
pub fn read_vdb_names(bytes: &[u8]) -> Option<Vec<String>> {
    let rest = bytes.strip_prefix(&MAGIC.to_le_bytes())?;
    let mut at = bytes.len() - rest.len() + size_of_val(&VERSIONS) + 1 + UUID.len() + 4;
    let number = |at: usize| Some(u32::from_le_bytes(bytes.get(at..at.checked_add(4)?)?.try_into().ok()?) as usize);
    let text = |at: usize| {
        let end = (at + 4).checked_add(number(at)?)?;
        Some((String::from_utf8(bytes.get(at + 4..end)?.to_vec()).ok()?, end))
    };
    let count = number(at)?;
    at += 4;
    let mut names = Vec::new();
    for _ in 0..count {
        let (name, after_name) = text(at)?;
        let (_, after_type) = text(after_name)?;
        let (_, places) = text(after_type)?;
        at = u64::from_le_bytes(bytes.get(places + 16..places + 24)?.try_into().ok()?) as usize;
        names.push(name);
        if at < places || at > bytes.len() {
            return None;
        }
    }
    (at == bytes.len()).then_some(names)
}

#[cfg(test)]
mod tests {
    use super::*;
    use sdf_bake::nvdb::{Checksum, Tile};

    fn grid(name: &str) -> NvdbGrid {
        let tile =
            |voxel: i32, side_log2: u32| Tile { voxel: IVec3::splat(voxel), side_log2, value: -3.0, active: false };
        let values = Values::Float(Tree {
            background: 3.0,
            leaves: vec![IVec3::new(-1, 0, 2)],
            active: vec![[1; 8]],
            values: (0..512_u16).map(f32::from).collect(),
            tiles: vec![tile(8, 3), tile(-128, 7), tile(4096, 12)],
        });
        NvdbGrid {
            name: name.to_owned(),
            class: GridClass::LevelSet,
            voxel: 0.5,
            translation: DVec3::ZERO,
            index_bbox: None,
            world_bbox: None,
            active_voxels: 8,
            checksum: Checksum::Matches,
            values,
        }
    }

    #[test]
    fn a_file_has_the_names_of_its_grids_and_a_cut_one_has_none() {
        let bytes = write_vdb(&[&grid("phi"), &grid("target")]);
        assert_eq!(read_vdb_names(&bytes), Some(vec!["phi".to_owned(), "target".to_owned()]));
        for length in (0..bytes.len()).step_by(101) {
            assert_eq!(read_vdb_names(&bytes[..length]), None, "cut at {length}");
        }
    }

    #[test]
    fn leaves_and_tiles_lie_below_their_nodes() {
        let Values::Float(tree) = grid("phi").values else { panic!("a float grid") };
        let uppers = uppers(&tree);
        // Upper nodes at x below zero for the leaf, and at zero and below zero for the tiles; the root tile has none.
        assert_eq!(uppers.keys().copied().collect::<Vec<_>>(), [[-1, -1, -1], [-1, 0, 0], [0, 0, 0]]);
        assert_eq!(uppers[&[-1, -1, -1]].tiles[&(31 << 10 | 31 << 5 | 31)], (-3.0, false));
        let lower = &uppers[&[-1, 0, 0]].children[&(31 << 10)];
        assert_eq!(lower.children[&(15 << 8 | 2)], 0);
        assert_eq!(uppers[&[0, 0, 0]].children[&0].tiles[&(1 << 8 | 1 << 4 | 1)], (-3.0, false));
    }
}
