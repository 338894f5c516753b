//! Reads the bytes of a file to grids.

use std::io::Read as _;

use flate2::read::ZlibDecoder;
use glam::{DVec3, IVec3};
use rayon::prelude::*;

use super::bytes::Bytes;
use super::checksum;
use super::error::NvdbError;
use super::field::{CLASS_FOG, CLASS_LEVEL_SET, CLASS_UNKNOWN, Value};
use super::layout::{
    FileHeader, FileMeta, GridData, LEAF_BYTES, LOWER, MAGIC, MAGIC_NEWER_FILE, MAGIC_NEWER_GRID, Map, UPPER, Version,
    flags,
};
use super::nodes::{Found, Nodes, collect, walk};
use super::tree::{Checksum, GridClass, NvdbFile, NvdbGrid, Tree, Values};

/// Greatest compression ratio of zlib (RFC 1951: 258 bytes for two bits); a greater stated size is false.
const ZLIB_LIMIT: u64 = 1032;

/// NanoVDB's names of value types, by number.
const TYPE_NAMES: [&str; 20] = [
    "untyped", "Float", "Double", "Int16", "Int32", "Int64", "Vec3f", "Vec3d", "Mask", "Half", "UInt32", "Boolean",
    "RGBA8", "Fp4", "Fp8", "Fp16", "FpN", "Vec4f", "Vec4d", "Index",
];

/// Reads all grids of a `.nvdb` file of version 32.x, codec none or zip, value types Float and Int32.
///
/// The bytes are untrusted: the result is either grids or a named error, in memory of the order of the file's own
/// (decompressed) size. A checksum that differs is reported, and is not an error.
///
/// # Errors
/// The value found and the accepted values.
pub fn read(bytes: &[u8]) -> Result<NvdbFile, NvdbError> {
    let bytes = Bytes(bytes);
    let mut grids = Vec::new();
    let mut at = 0;
    while at == 0 || at < bytes.len() {
        at = segment(bytes, at, &mut grids)?;
    }
    Ok(NvdbFile { grids })
}

/// Number of bytes at the start of a file that [`grids_in`] needs for a few grids.
pub const HEAD_BYTES: usize = 4096;

/// Names of the grids in the first segment of a file written by this crate, from the file's first bytes.
pub fn grids_in(head: &[u8]) -> Option<Vec<String>> {
    let bytes = Bytes(head);
    let header: FileHeader = bytes.get("the file header", 0).ok()?;
    if header.magic != MAGIC || header.version != Version::WRITTEN {
        return None;
    }
    let mut at = size_of::<FileHeader>() as u64;
    let mut names = Vec::new();
    for _ in 0..header.grid_count {
        let meta: FileMeta = bytes.get("the table of grids", at).ok()?;
        at += size_of::<FileMeta>() as u64;
        names.push(until_zero(bytes.slice("a grid's name", at, u64::from(meta.name_size)).ok()?));
        at += u64::from(meta.name_size);
    }
    Some(names)
}

/// Reads one segment; returns its end.
fn segment(bytes: Bytes, start: u64, grids: &mut Vec<NvdbGrid>) -> Result<u64, NvdbError> {
    let magic: u64 = bytes.get("the file header", start)?;
    check_magic("the file", magic, MAGIC_NEWER_FILE)?;
    let header: FileHeader = bytes.get("the file header", start)?;
    check_version(header.version)?;
    let mut at = start + size_of::<FileHeader>() as u64;
    let mut entries = Vec::new();
    for _ in 0..header.grid_count {
        let meta: FileMeta = bytes.get("the table of grids", at)?;
        at += size_of::<FileMeta>() as u64;
        let name = bytes.slice("a grid's name", at, u64::from(meta.name_size))?;
        at += u64::from(meta.name_size);
        entries.push((meta, until_zero(name)));
    }
    for (meta, name) in entries {
        let payload = bytes.slice("a grid", at, meta.file_size)?;
        at += meta.file_size;
        grids.push(match header.codec {
            0 => grid(name, Bytes(payload).slice("a grid", 0, meta.grid_size)?)?,
            1 => grid(name.clone(), &unzip(&name, &meta, payload)?)?,
            2 => return Err(NvdbError::Codec("blosc")),
            _ => return Err(NvdbError::Codec("unknown")),
        });
    }
    Ok(at)
}

fn check_magic(what: &'static str, found: u64, newer: u64) -> Result<(), NvdbError> {
    if found == MAGIC || found == newer {
        return Ok(());
    }
    let found = found.to_le_bytes().escape_ascii().to_string();
    Err(NvdbError::Magic { what, found })
}

fn check_version(version: Version) -> Result<(), NvdbError> {
    if version.major() == Version::WRITTEN.major() {
        return Ok(());
    }
    Err(NvdbError::Version { major: version.major(), minor: version.minor() })
}

fn until_zero(name: &[u8]) -> String {
    let end = name.iter().position(|byte| *byte == 0).unwrap_or(name.len());
    String::from_utf8_lossy(&name[..end]).into_owned()
}

fn unzip(name: &str, meta: &FileMeta, payload: &[u8]) -> Result<Vec<u8>, NvdbError> {
    let bad = |reason: String| NvdbError::Unzip { grid: name.to_owned(), reason };
    let length: u64 = Bytes(payload).get("a zipped grid", 0)?;
    let packed = Bytes(payload).slice("a zipped grid", size_of::<u64>() as u64, length)?;
    if meta.grid_size > ZLIB_LIMIT.saturating_mul(length) {
        return Err(bad(format!("{length} bytes cannot hold {}", meta.grid_size)));
    }
    let mut raw = Vec::new();
    ZlibDecoder::new(packed).take(meta.grid_size + 1).read_to_end(&mut raw).map_err(|error| bad(error.to_string()))?;
    if raw.len() as u64 != meta.grid_size {
        return Err(bad(format!("{} bytes or more, where the table says {}", raw.len(), meta.grid_size)));
    }
    Ok(raw)
}

fn grid(name: String, bytes: &[u8]) -> Result<NvdbGrid, NvdbError> {
    let bytes = Bytes(bytes);
    check_magic("a grid", bytes.get("a grid's head", 0)?, MAGIC_NEWER_GRID)?;
    let head: GridData = bytes.get("a grid's head", 0)?;
    check_version(head.version)?;
    if head.grid_size != bytes.len() {
        let what = format!("its header states {} bytes, the file has {}", head.grid_size, bytes.len());
        return Err(NvdbError::Structure { grid: name, what });
    }
    let (voxel, translation) = placement(&name, &head.map)?;
    let (values, facts) = match head.grid_type {
        f32::GRID_TYPE => {
            let (tree, facts) = tree(&name, &head, bytes)?;
            (Values::Float(tree), facts)
        }
        i32::GRID_TYPE => {
            let (tree, facts) = tree(&name, &head, bytes)?;
            (Values::Int32(tree), facts)
        }
        other => {
            let found = TYPE_NAMES.get(other as usize).copied().unwrap_or("unknown");
            return Err(NvdbError::ValueType { grid: name, found });
        }
    };
    let corners = |b: [f64; 6]| (DVec3::from_slice(&b), DVec3::from_slice(&b[3..]));
    Ok(NvdbGrid {
        name,
        class: class(head.grid_class),
        voxel,
        translation,
        index_bbox: facts.index_bbox,
        world_bbox: facts.index_bbox.map(|_| corners(head.world_bbox)),
        active_voxels: facts.active_voxels,
        checksum: facts.checksum,
        values,
    })
}

/// Voxel size and position of voxel (0, 0, 0).
fn placement(name: &str, map: &Map) -> Result<(f64, DVec3), NvdbError> {
    let voxel = map.matrix[0];
    let uniform = [voxel, 0.0, 0.0, 0.0, voxel, 0.0, 0.0, 0.0, voxel];
    let close = map.matrix.iter().zip(uniform).all(|(a, b)| (a - b).abs() <= 1e-12 * voxel);
    let translation = DVec3::from_array(map.translation);
    if close && voxel.is_finite() && voxel > 0.0 && translation.is_finite() {
        return Ok((voxel, translation));
    }
    Err(NvdbError::Map { grid: name.to_owned() })
}

fn class(number: u32) -> GridClass {
    match number {
        CLASS_UNKNOWN => GridClass::Unknown,
        CLASS_LEVEL_SET => GridClass::LevelSet,
        CLASS_FOG => GridClass::FogVolume,
        other => GridClass::Other(other),
    }
}

/// Properties of a tree besides its values.
struct Facts {
    checksum: Checksum,
    index_bbox: Option<(IVec3, IVec3)>,
    active_voxels: u64,
}

fn tree<V: Value>(name: &str, head: &GridData, bytes: Bytes) -> Result<(Tree<V>, Facts), NvdbError> {
    let nodes = walk::<V>(name, bytes)?;
    let checksum = verify(head, &nodes, bytes)?;
    let (low, high) = (IVec3::from_slice(&nodes.root.bbox), IVec3::from_slice(&nodes.root.bbox[3..]));
    let index_bbox = low.cmple(high).all().then_some((low, high));
    let tree = collect(nodes, bytes)?;
    let active_voxels = tree.active_voxels();
    Ok((tree, Facts { checksum, index_bbox, active_voxels }))
}

/// Compares the stated checksum with that of the bytes.
fn verify<V: Value>(head: &GridData, nodes: &Nodes<V>, bytes: Bytes) -> Result<Checksum, NvdbError> {
    let (stated_head, stated_tail) = (head.checksum as u32, (head.checksum >> 32) as u32);
    if head.checksum == u64::MAX {
        return Ok(Checksum::Absent);
    }
    if head.version > Version::LAST_NODE_CHECKSUM {
        return Ok(Checksum::Unknown);
    }
    if checksum::head(bytes.slice("the root's table", 0, nodes.root_end)?) != stated_head {
        return Ok(Checksum::Differs);
    }
    if stated_tail == checksum::NONE {
        return Ok(Checksum::Matches);
    }
    let in_order = head.flags & flags::BREADTH_FIRST != 0;
    let mut crcs = Vec::new();
    for (list, size) in [(&nodes.uppers, UPPER.bytes()), (&nodes.lowers, LOWER.bytes()), (&nodes.leaves, LEAF_BYTES)] {
        crcs.extend(node_crcs(list, size, in_order, bytes)?);
    }
    let tails = [checksum::tail(crcs.iter().copied()), checksum::narrow_tail(crcs.iter().copied())];
    Ok(if tails.contains(&stated_tail) { Checksum::Matches } else { Checksum::Differs })
}

/// CRC of each node: in file order if the grid states that its nodes are ordered, otherwise in traversal order.
fn node_crcs(list: &[Found], size: usize, in_order: bool, bytes: Bytes) -> Result<Vec<u32>, NvdbError> {
    let mut places: Vec<u64> = list.iter().map(|node| node.at).collect();
    if in_order {
        places.sort_unstable();
    }
    places.par_iter().map(|&at| Ok(crc32fast::hash(bytes.slice("a node", at, size as u64)?))).collect()
}
