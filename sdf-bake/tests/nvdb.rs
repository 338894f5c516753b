//! NanoVDB files: round trips, the layout byte by byte, and statistics compared with a plain recount.

use glam::{DVec3, IVec3};
use sdf_bake::grid::{BRICK_VOXELS, INSIDE, voxel_at};
use sdf_bake::nvdb::{BricksError, Checksum, Codec, GridClass, GridRef, Values, WriteError, read, write, write_field};
use sdf_bake::{BrickGrid, Scalar};

const VOXEL: f64 = 0.0005;

/// A ball off the origin, mostly at negative coordinates, with labels and a dose on one side.
fn ball(radius_voxels: f64) -> (BrickGrid, Vec<f32>) {
    let centre = DVec3::new(-31.3, 17.1, -20.3) * VOXEL;
    let radius = radius_voxels * VOXEL;
    let mut grid =
        BrickGrid::from_distance(centre - radius, centre + radius, VOXEL, 3.0, |p| (p - centre).length() - radius);
    grid.label = vec![0; grid.phi.len()];
    let mut dose = vec![0.0; grid.phi.len()];
    for (at, (label, dose)) in grid.label.iter_mut().zip(&mut dose).enumerate() {
        let voxel = voxel_at(grid.bricks[at / BRICK_VOXELS], at % BRICK_VOXELS);
        if voxel.x > -30 && grid.phi[at] < 0.0005 {
            *label = if voxel.y > 15 { 65535 } else { 1 };
            *dose = 0.25 + 0.001 * voxel.z as f32;
        }
    }
    (grid, dose)
}

fn written(grid: &BrickGrid, dose: &[f32], codec: Codec) -> Vec<u8> {
    let grids = [
        GridRef::LevelSet { name: "phi", grid },
        GridRef::Labels { name: "weld", grid },
        GridRef::Density { name: "dose", grid, values: dose },
    ];
    write(&grids, codec).unwrap()
}

/// Checks that all voxels are equal, whatever box the index spans.
fn assert_same_field(a: &BrickGrid, b: &BrickGrid) {
    assert_eq!(a.voxel.to_bits(), b.voxel.to_bits());
    assert_eq!(a.band.to_bits(), b.band.to_bits());
    assert_eq!(a.bricks, b.bricks);
    assert_eq!(bytemuck::cast_slice::<f32, u32>(&a.phi), bytemuck::cast_slice::<f32, u32>(&b.phi));
    let low = a.origin.min(b.origin) - 1;
    let high = (a.origin + a.dims).max(b.origin + b.dims) + 1;
    for x in low.x..high.x {
        for y in low.y..high.y {
            for z in low.z..high.z {
                let brick = IVec3::new(x, y, z);
                assert_eq!(a.slot(brick), b.slot(brick), "brick {brick}");
            }
        }
    }
}

fn assert_comes_back(radius_voxels: f64, codec: Codec) {
    let (grid, dose) = ball(radius_voxels);
    let file = read(&written(&grid, &dose, codec)).unwrap();
    let mut back = file.grid("phi").unwrap().to_bricks().unwrap();
    assert_eq!(back.sanity_check(), Ok(()));
    assert_same_field(&grid, &back);
    file.grid("weld").unwrap().attach_labels(&mut back).unwrap();
    assert_eq!(grid.label, back.label);
    assert_eq!(dose, file.grid("dose").unwrap().channel(&back).unwrap());
    assert!(file.grids.iter().all(|grid| grid.checksum == Checksum::Matches));
}

#[test]
fn everything_comes_back_bit_for_bit() {
    assert_comes_back(5.0, Codec::None);
    assert_comes_back(40.0, Codec::None);
    assert_comes_back(260.0, Codec::None);
}

#[test]
fn everything_comes_back_bit_for_bit_from_zip() {
    assert_comes_back(5.0, Codec::Zip);
    assert_comes_back(40.0, Codec::Zip);
}

#[test]
fn a_field_comes_back_with_the_channels_it_has() {
    let (mut field, dose) = ball(40.0);
    field.dose = dose;
    let back = read(&write_field(&field, Codec::None).unwrap()).unwrap().to_field().unwrap();
    assert_same_field(&field, &back);
    assert_eq!((&back.label, &back.dose, back.removed.len()), (&field.label, &field.dose, 0));
    assert_eq!(back.sanity_check(), Ok(()));
    field.label.clear();
    field.scalar_or_zero(Scalar::Removed)[7] = -1.5;
    let file = read(&write_field(&field, Codec::Zip).unwrap()).unwrap();
    let names: Vec<&str> = file.grids.iter().map(|grid| grid.name.as_str()).collect();
    assert_eq!(names, ["phi", "dose", "removed"]);
    let back = file.to_field().unwrap();
    assert_eq!((back.label.len(), &back.dose, &back.removed), (0, &field.dose, &field.removed));
    field.dose[5] = f32::INFINITY;
    let error = read(&write_field(&field, Codec::None).unwrap()).unwrap().to_field().unwrap_err().to_string();
    assert!(error.contains("dose inf; a finite number is needed"), "{error}");
    let labels = write(&[GridRef::Labels { name: "weld", grid: &ball(5.0).0 }], Codec::None).unwrap();
    let error = read(&labels).unwrap().to_field().unwrap_err().to_string();
    assert!(error.contains("no grid \"phi\"; the file holds [\"weld\"]"), "{error}");
}

#[test]
fn a_large_ball_needs_tiles_of_whole_lower_nodes() {
    let (grid, dose) = ball(260.0);
    let file = read(&written(&grid, &dose, Codec::None)).unwrap();
    let Values::Float(tree) = &file.grids[0].values else { panic!("φ is Float") };
    assert!(tree.tiles.iter().any(|tile| tile.side_log2 == 7 && tile.value == -grid.band));
    assert!(tree.tiles.iter().all(|tile| tile.value == -grid.band && !tile.active));
    let inside: u64 = tree.tiles.iter().map(|tile| 1 << (3 * (tile.side_log2 - 3))).sum();
    assert_eq!(inside, grid.index.dense().iter().filter(|slot| **slot == INSIDE).count() as u64);
}

#[test]
fn an_index_with_room_to_spare_loses_only_the_room() {
    let mut grid = BrickGrid::empty(VOXEL, 0.0015, IVec3::new(-40, -3, 100), IVec3::new(50, 6, 20));
    let brick = IVec3::new(-33, 1, 111);
    grid.set_slot(brick, 0);
    grid.set_slot(brick + IVec3::Z, INSIDE);
    grid.bricks.push(brick);
    grid.phi = (0..BRICK_VOXELS).map(|i| 0.0015 - i as f32 * 3e-6).collect();
    let file = read(&write(&[GridRef::LevelSet { name: "φ", grid: &grid }], Codec::Zip).unwrap()).unwrap();
    let back = file.grid("φ").unwrap().to_bricks().unwrap();
    assert_eq!((back.origin, back.dims), (brick, IVec3::new(1, 1, 2)));
    assert_same_field(&grid, &back);
}

#[test]
fn boxes_and_counts_are_those_of_the_active_voxels() {
    let (grid, dose) = ball(40.0);
    let file = read(&written(&grid, &dose, Codec::None)).unwrap();
    let phi = &file.grids[0];
    let (mut low, mut high, mut count) = (IVec3::MAX, IVec3::MIN, 0);
    for (at, value) in grid.phi.iter().enumerate() {
        if value.abs() < grid.band {
            let voxel = voxel_at(grid.bricks[at / BRICK_VOXELS], at % BRICK_VOXELS);
            (low, high, count) = (low.min(voxel), high.max(voxel), count + 1);
        }
    }
    assert_eq!(phi.index_bbox, Some((low, high)));
    assert_eq!(phi.world_bbox, Some((low.as_dvec3() * VOXEL, (high.as_dvec3() + 1.0) * VOXEL)));
    assert_eq!(phi.active_voxels, count);
    assert_eq!((phi.class, phi.voxel, phi.translation), (GridClass::LevelSet, VOXEL, DVec3::ZERO));
    assert_eq!(file.grids[2].class, GridClass::FogVolume);
}

/// `N` bytes at an offset in the file.
fn field<const N: usize>(bytes: &[u8], at: usize) -> [u8; N] {
    bytes[at..at + N].try_into().unwrap()
}

fn f32_at(bytes: &[u8], at: usize) -> f32 {
    f32::from_le_bytes(field(bytes, at))
}

fn u64_at(bytes: &[u8], at: usize) -> usize {
    u64::from_le_bytes(field(bytes, at)) as usize
}

const VERSION: [u8; 4] = (32 << 21 | 4 << 10 | 2u32).to_le_bytes();
/// Offset of the payload: file header, one table entry, the name `phi` and its zero.
const PAYLOAD: usize = 16 + 176 + 4;

#[test]
fn the_file_header_and_table_are_those_of_version_32_4() {
    let (grid, _) = ball(5.0);
    let bytes = write(&[GridRef::LevelSet { name: "phi", grid: &grid }], Codec::None).unwrap();
    assert_eq!(&bytes[..8], b"NanoVDB0");
    assert_eq!(field(&bytes, 8), VERSION);
    assert_eq!(field(&bytes, 12), [1, 0, 0, 0], "one grid, codec none");
    let meta = &bytes[16..PAYLOAD];
    assert_eq!((u64_at(meta, 0), u64_at(meta, 8)), (bytes.len() - PAYLOAD, bytes.len() - PAYLOAD));
    let key = (usize::from(b'p') * 67 + usize::from(b'h')) * 67 + usize::from(b'i');
    assert_eq!(u64_at(meta, 16), key);
    assert_eq!(field(meta, 32), [1, 0, 0, 0], "Float");
    assert_eq!(field(meta, 36), [1, 0, 0, 0], "level set");
    assert_eq!(field(meta, 136), [4, 0, 0, 0], "length of the name");
    assert_eq!(field(meta, 172), VERSION);
    assert_eq!(&meta[176..], b"phi\0");
}

#[test]
fn a_grid_is_laid_out_as_in_version_32_4() {
    let (grid, _) = ball(5.0);
    let bytes = write(&[GridRef::LevelSet { name: "phi", grid: &grid }], Codec::None).unwrap();
    let head = &bytes[PAYLOAD..];
    assert_eq!(&head[..8], b"NanoVDB0");
    assert_eq!(field(head, 16), VERSION);
    assert_eq!(u64_at(head, 32), head.len());
    assert_eq!(&head[40..44], b"phi\0");
    assert_eq!(f64::from_le_bytes(field(head, 384)), VOXEL);
    assert_eq!((field(head, 632), field(head, 636)), ([1, 0, 0, 0], [1, 0, 0, 0]), "level set, Float");
    let (tree, root) = (&head[672..], &head[736..]);
    let first_leaf = u64_at(tree, 0);
    assert_eq!(u64_at(tree, 24), 64, "the root follows the tree");
    assert_eq!(tree.len() - first_leaf, 2144 * grid.brick_count());
    assert_eq!(f32_at(root, 28), grid.band);
    // A leaf's values start 96 bytes into it, in the brick's own order.
    let leaf = &tree[first_leaf..first_leaf + 2144];
    let voxel = IVec3::from_array([0, 4, 8].map(|at| i32::from_le_bytes(field(leaf, at))));
    let slot = grid.slot(voxel >> 3) as usize;
    let values: Vec<f32> = (96..2144).step_by(4).map(|at| f32_at(leaf, at)).collect();
    assert_eq!(values, grid.phi[slot * BRICK_VOXELS..(slot + 1) * BRICK_VOXELS]);
}

#[test]
fn the_roots_statistics_are_those_of_the_active_values() {
    let (grid, _) = ball(20.0);
    let bytes = write(&[GridRef::LevelSet { name: "phi", grid: &grid }], Codec::None).unwrap();
    let active: Vec<f64> = grid.phi.iter().filter(|v| v.abs() < grid.band).map(|&v| f64::from(v)).collect();
    let mean = active.iter().sum::<f64>() / active.len() as f64;
    let variance = active.iter().map(|v| (v - mean) * (v - mean)).sum::<f64>() / active.len() as f64;
    let root = &bytes[PAYLOAD + 736..];
    let extreme = |pick: fn(f64, f64) -> f64| active.iter().copied().reduce(pick).unwrap() as f32;
    assert_eq!((f32_at(root, 32), f32_at(root, 36)), (extreme(f64::min), extreme(f64::max)));
    // Tolerance: one unit in the last place of an f32 of the band's size.
    assert!((f64::from(f32_at(root, 40)) - mean).abs() < 1e-10);
    assert!((f64::from(f32_at(root, 44)) - variance.sqrt()).abs() < 1e-10);
}

/// The file with this hash was opened by the programs in `docs/nanovdb.md`. If it changes on purpose, open it with them
/// again.
#[test]
fn the_bytes_are_those_that_other_programs_accepted() {
    let (grid, dose) = ball(20.0);
    let bytes = written(&grid, &dose, Codec::None);
    assert_eq!((bytes.len(), crc32fast::hash(&bytes)), (3_397_614, 2_615_079_270));
}

#[test]
fn the_bytes_do_not_depend_on_the_number_of_threads() {
    let (grid, dose) = ball(40.0);
    let on = |threads: usize, codec| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        pool.install(|| written(&grid, &dose, codec))
    };
    for codec in [Codec::None, Codec::Zip] {
        assert!(on(1, codec) == on(3, codec));
    }
}

#[test]
fn a_grid_without_bricks_is_written_and_read() {
    let grid = BrickGrid::empty(VOXEL, 0.0015, IVec3::ZERO, IVec3::ZERO);
    let file = read(&written(&grid, &[], Codec::None)).unwrap();
    assert_eq!(file.grids[0].index_bbox, None);
    assert_eq!(file.grids[0].checksum, Checksum::Matches);
    let back = file.grids[0].to_bricks().unwrap();
    assert_eq!((back.brick_count(), back.band, back.dims), (0, 0.0015, IVec3::ZERO));
}

#[test]
fn what_cannot_be_written_is_refused_by_name() {
    let (grid, dose) = ball(5.0);
    let named = |name| write(&[GridRef::LevelSet { name, grid: &grid }], Codec::None).unwrap_err();
    assert_eq!(write(&[], Codec::None), Err(WriteError::GridCount(0)));
    let long = "n".repeat(256);
    assert_eq!(named(&long), WriteError::Name(long.clone()));
    assert_eq!(named("a\0b"), WriteError::Name("a\0b".to_owned()));
    let short = GridRef::Density { name: "dose", grid: &grid, values: &dose[1..] };
    assert!(matches!(write(&[short], Codec::None), Err(WriteError::Values { .. })));
    let mut broken = grid.clone();
    broken.set_slot(broken.origin + IVec3::Z, 1_000_000);
    let error = write(&[GridRef::LevelSet { name: "phi", grid: &broken }], Codec::None).unwrap_err();
    assert!(error.to_string().contains("slot 1000000"), "{error}");
    broken.dims = IVec3::splat(i32::MAX / 16);
    broken.origin = IVec3::ZERO;
    let error = write(&[GridRef::LevelSet { name: "phi", grid: &broken }], Codec::None).unwrap_err();
    assert!(error.to_string().contains("entries for"), "{error}");
}

#[test]
fn what_is_no_level_set_of_these_bricks_is_refused_by_name() {
    let (grid, dose) = ball(20.0);
    let file = read(&written(&grid, &dose, Codec::None)).unwrap();
    let message = |error: BricksError| error.to_string();
    assert!(message(file.grids[1].to_bricks().unwrap_err()).contains("Float level set is needed"));
    assert!(message(file.grids[2].to_bricks().unwrap_err()).contains("FogVolume"));
    assert!(message(file.grids[1].channel(&grid).unwrap_err()).contains("Float grid is needed"));
    let mut moved = file.grids[0].clone();
    moved.translation.x = 0.1;
    assert!(message(moved.to_bricks().unwrap_err()).contains("moved by [0.1, 0, 0] m"));
    let (mut other, _) = ball(5.0);
    assert!(message(file.grids[1].attach_labels(&mut other).unwrap_err()).contains("outside all bricks"));
}
