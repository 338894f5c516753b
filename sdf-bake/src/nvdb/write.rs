//! Writes several grids to the bytes of one file.

use std::io::Write as _;

use bytemuck::{Zeroable, bytes_of};
use flate2::{Compression, write::ZlibEncoder};

use super::encode::{Plan, Written};
use super::field::{Density, Labels, LevelSet};
use super::layout::{FileHeader, FileMeta, MAGIC, NAME_BYTES, Version};
use super::{Codec, GridRef, WriteError};
use crate::grid::{BRICK_VOXELS, BrickGrid};

/// Returns the bytes of a `.nvdb` file with the given grids, in order.
///
/// The bytes depend on the arguments only, not on the number of threads.
///
/// # Errors
/// No grid, a name that NanoVDB cannot store, or a grid whose arrays are inconsistent.
pub fn write(grids: &[GridRef], codec: Codec) -> Result<Vec<u8>, WriteError> {
    if grids.is_empty() || grids.len() > usize::from(u16::MAX) {
        return Err(WriteError::GridCount(grids.len()));
    }
    grids.iter().try_for_each(check)?;
    let plans: Vec<AnyPlan> = grids.iter().map(AnyPlan::new).collect();
    let tables =
        size_of::<FileHeader>() + grids.iter().map(|grid| size_of::<FileMeta>() + grid.name().len() + 1).sum::<usize>();
    let (mut file, metas) = match codec {
        Codec::None => raw_payloads(grids, &plans, tables),
        Codec::Zip => zipped_payloads(grids, &plans, tables),
    };
    let header =
        FileHeader { magic: MAGIC, version: Version::WRITTEN, grid_count: grids.len() as u16, codec: codec.number() };
    let mut head = bytes_of(&header).to_vec();
    for (grid, meta) in grids.iter().zip(metas) {
        head.extend_from_slice(bytes_of(&FileMeta { codec: codec.number(), ..meta }));
        head.extend_from_slice(grid.name().as_bytes());
        head.push(0);
    }
    file[..tables].copy_from_slice(&head);
    Ok(file)
}

/// Space for the tables, then the grids as stored in memory.
fn raw_payloads(grids: &[GridRef], plans: &[AnyPlan], tables: usize) -> (Vec<u8>, Vec<FileMeta>) {
    let mut file = vec![0; tables + plans.iter().map(AnyPlan::bytes).sum::<usize>()];
    let mut rest = &mut file[tables..];
    let mut metas = Vec::with_capacity(grids.len());
    for (i, (grid, plan)) in grids.iter().zip(plans).enumerate() {
        let (payload, later) = rest.split_at_mut(plan.bytes());
        rest = later;
        let written = plan.write(grid.name(), (grids.len() - i) as u32, payload);
        metas.push(meta(grid.name(), &written, payload.len()));
    }
    (file, metas)
}

/// Space for the tables, then each grid as a length and a zlib stream.
fn zipped_payloads(grids: &[GridRef], plans: &[AnyPlan], tables: usize) -> (Vec<u8>, Vec<FileMeta>) {
    let mut file = vec![0; tables];
    let mut metas = Vec::with_capacity(grids.len());
    for (i, (grid, plan)) in grids.iter().zip(plans).enumerate() {
        let mut raw = vec![0; plan.bytes()];
        let written = plan.write(grid.name(), (grids.len() - i) as u32, &mut raw);
        let packed = zlib(&raw);
        file.extend_from_slice(bytes_of(&(packed.len() as u64)));
        file.extend_from_slice(&packed);
        metas.push(meta(grid.name(), &written, size_of::<u64>() + packed.len()));
    }
    (file, metas)
}

/// Compresses at the fast level: distances hardly repeat, and the usual level takes seven times as long for another
/// tenth.
fn zlib(raw: &[u8]) -> Vec<u8> {
    let mut encoder = ZlibEncoder::new(Vec::new(), Compression::fast());
    encoder.write_all(raw).and_then(|()| encoder.finish()).expect("writing to memory does not fail")
}

fn meta(name: &str, written: &Written, file_size: usize) -> FileMeta {
    let (head, tree) = (&written.head, &written.tree);
    let [leaves, lowers, uppers] = tree.node_count;
    FileMeta {
        grid_size: head.grid_size,
        file_size: file_size as u64,
        name_key: name_key(name),
        voxel_count: tree.voxel_count,
        grid_type: head.grid_type,
        grid_class: head.grid_class,
        world_bbox: head.world_bbox,
        index_bbox: written.index_bbox,
        voxel_size: head.voxel_size,
        name_size: name.len() as u32 + 1,
        node_count: [leaves, lowers, uppers, 1],
        tile_count: tree.tile_count,
        version: Version::WRITTEN,
        ..FileMeta::zeroed()
    }
}

/// NanoVDB's hash of a name, which readers use to find grids.
fn name_key(name: &str) -> u64 {
    name.bytes().fold(0u64, |hash, byte| hash.wrapping_mul(67).wrapping_add(u64::from(byte)).wrapping_add(hash >> 56))
}

enum AnyPlan<'a> {
    LevelSet(Plan<LevelSet<'a>>),
    Labels(Plan<Labels<'a>>),
    Density(Plan<Density<'a>>),
}

impl<'a> AnyPlan<'a> {
    fn new(grid: &GridRef<'a>) -> Self {
        match *grid {
            GridRef::LevelSet { grid, .. } => Self::LevelSet(Plan::new(LevelSet(grid))),
            GridRef::Labels { grid, .. } => Self::Labels(Plan::new(Labels(grid))),
            GridRef::Density { grid, values, .. } => Self::Density(Plan::new(Density { grid, values })),
        }
    }

    fn bytes(&self) -> usize {
        match self {
            Self::LevelSet(plan) => plan.bytes(),
            Self::Labels(plan) => plan.bytes(),
            Self::Density(plan) => plan.bytes(),
        }
    }

    fn write(&self, name: &str, grids_left: u32, out: &mut [u8]) -> Written {
        match self {
            Self::LevelSet(plan) => plan.write(name, grids_left, out),
            Self::Labels(plan) => plan.write(name, grids_left, out),
            Self::Density(plan) => plan.write(name, grids_left, out),
        }
    }
}

/// Checks the writer's assumptions, so that no input makes it panic.
fn check(what: &GridRef) -> Result<(), WriteError> {
    let name = what.name();
    if name.is_empty() || name.len() >= NAME_BYTES || name.contains('\0') {
        return Err(WriteError::Name(name.to_owned()));
    }
    let (grid, values) = match *what {
        GridRef::LevelSet { grid, .. } => (grid, grid.phi.len()),
        GridRef::Labels { grid, .. } => (grid, grid.label.len()),
        GridRef::Density { grid, values, .. } => (grid, values.len()),
    };
    check_shape(name, grid)?;
    let expected = grid.bricks.len() * BRICK_VOXELS;
    if values != expected {
        return Err(WriteError::Values { name: name.to_owned(), values, expected });
    }
    Ok(())
}

fn check_shape(name: &str, grid: &BrickGrid) -> Result<(), WriteError> {
    let wrong = |what: String| Err(WriteError::Grid { name: name.to_owned(), what });
    if !(grid.voxel.is_finite() && grid.voxel > 0.0 && grid.band.is_finite() && grid.band > 0.0) {
        return wrong(format!("the voxel is {} m and the band {} m", grid.voxel, grid.band));
    }
    // NanoVDB counts voxels in 32 bits.
    let reach = i64::from(i32::MAX / 8);
    let (first, end) = (grid.origin.as_i64vec3(), grid.origin.as_i64vec3() + grid.dims.as_i64vec3());
    if grid.dims.min_element() < 0 || first.min_element() < -reach || end.max_element() > reach {
        return wrong(format!("bricks {} and {} more on each axis do not fit 32-bit voxels", grid.origin, grid.dims));
    }
    if grid.dims != grid.index.dims() {
        return wrong(format!("the index has {} entries for {} bricks", grid.index.dims(), grid.dims));
    }
    match grid.index.slots().find(|&slot| slot as usize >= grid.bricks.len()) {
        Some(slot) => wrong(format!("the index names slot {slot} of {}", grid.bricks.len())),
        None => Ok(()),
    }
}
