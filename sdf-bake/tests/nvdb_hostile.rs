//! Hostile `.nvdb` bytes: grids or a named error, never a panic, never more memory than the file can require.

use glam::{DVec3, IVec3};
use proptest::prelude::*;
use sdf_bake::BrickGrid;
use sdf_bake::grid::{BRICK_VOXELS, INSIDE};
use sdf_bake::nvdb::{Checksum, Codec, GridRef, NvdbError, read, write};

/// A few bricks in two upper nodes, with an inside tile.
fn small() -> BrickGrid {
    let mut grid = BrickGrid::empty(0.001, 0.003, IVec3::new(-2, 0, 0), IVec3::new(4, 1, 2));
    for (slot, x) in (-2..2).enumerate() {
        let brick = IVec3::new(x, 0, 0);
        grid.set_slot(brick, slot as u32);
        grid.bricks.push(brick);
    }
    grid.set_slot(IVec3::new(1, 0, 1), INSIDE);
    grid.phi = (0..4 * BRICK_VOXELS).map(|i| ((i * 37) % 601) as f32 * 1e-5 - 0.003).collect();
    grid.label = (0..4 * BRICK_VOXELS).map(|i| u16::from(i % 5 == 0)).collect();
    grid
}

fn file(codec: Codec) -> Vec<u8> {
    let grid = small();
    write(&[GridRef::LevelSet { name: "phi", grid: &grid }, GridRef::Labels { name: "weld", grid: &grid }], codec)
        .unwrap()
}

/// Offset of the first payload: header, two entries of 176 bytes, two names with their zeros.
const PHI: usize = 16 + 2 * 176 + 4 + 5;
const TREE: usize = PHI + 672;
const ROOT: usize = PHI + 736;

fn patched(at: usize, value: &[u8]) -> Result<sdf_bake::nvdb::NvdbFile, NvdbError> {
    let mut bytes = file(Codec::None);
    bytes[at..at + value.len()].copy_from_slice(value);
    read(&bytes)
}

/// Reads the bytes, and converts what was read to bricks.
fn survive(bytes: &[u8]) {
    if let Ok(file) = read(bytes) {
        for grid in &file.grids {
            if let Ok(mut bricks) = grid.to_bricks() {
                assert_eq!(bricks.sanity_check(), Ok(()));
                let _ = file.grids.iter().map(|other| other.attach_labels(&mut bricks)).count();
            }
        }
    }
}

#[test]
fn a_file_cut_anywhere_is_an_error() {
    for codec in [Codec::None, Codec::Zip] {
        let bytes = file(codec);
        let places = (0..900).chain((900..bytes.len()).step_by(997)).chain([bytes.len() - 1]);
        for end in places.filter(|end| *end < bytes.len()) {
            assert!(read(&bytes[..end]).is_err(), "cut at {end} of {}", bytes.len());
        }
    }
}

#[test]
fn what_is_not_understood_is_refused_by_name() {
    let says = |at, value: &[u8], text: &str| {
        let Err(error) = patched(at, value) else { panic!("no complaint of {text}") };
        let error = error.to_string();
        assert!(error.contains(text), "{error}");
    };
    says(0, b"NanoVDBX", "NanoVDBX");
    says(0, b"0BDVonaN", "\"NanoVDB0\"");
    says(8, &(33u32 << 21 | 1 << 10).to_le_bytes(), "version 33.1");
    says(14, &[2], "blosc");
    says(14, &[9], "codec unknown");
    says(PHI, b"NanoVDB9", "NanoVDB9");
    says(PHI + 636, &[14], "Fp8");
    says(PHI + 636, &[200], "unknown values");
    says(PHI + 296 + 88, &0.5f64.to_le_bytes(), "turns, shears or stretches");
    says(PHI + 296 + 88, &f64::NAN.to_le_bytes(), "turns, shears or stretches");
}

#[test]
fn offsets_and_counts_out_of_range_are_named() {
    let says = |at, value: &[u8], text: &str| {
        let Err(error) = patched(at, value) else { panic!("no complaint of {text}") };
        let error = error.to_string();
        assert!(error.contains(text), "{error}");
    };
    says(16, &u64::MAX.to_le_bytes(), "inside a grid");
    says(24, &u64::MAX.to_le_bytes(), "truncated");
    says(PHI + 32, &1u64.to_le_bytes(), "its header states 1 bytes");
    says(TREE + 24, &(1u64 << 40).to_le_bytes(), "the root");
    says(TREE + 24, &65u64.to_le_bytes(), "not at a multiple of 32");
    says(TREE + 32, &u32::MAX.to_le_bytes(), "4294967295 leaves");
    says(TREE + 32, &1u32.to_le_bytes(), "more leaves than the 1");
    says(TREE + 40, &0u32.to_le_bytes(), "more upper nodes than the 0");
    says(ROOT + 24, &u32::MAX.to_le_bytes(), "root entries");
    says(ROOT + 64 + 8, &i64::MIN.to_le_bytes(), "an upper node");
    says(ROOT + 64 + 8, &(1i64 << 40).to_le_bytes(), "an upper node");
    says(ROOT + 64, &(1u64 << 20).to_le_bytes(), "root key 0x100000");
    says(ROOT + 96, &file(Codec::None)[ROOT + 64..ROOT + 72], "two root entries");
}

/// If every entry of an inner node referred to one child, a leaf would be visited 32768 × 4096 times.
#[test]
fn shared_children_do_not_multiply() {
    let mut bytes = file(Codec::None);
    let upper = ROOT + 64 + 2 * 32;
    let (children, table) = (upper + 32 + 4096, upper + 8256);
    let child = bytes[children..children + 4096].iter().position(|byte| *byte != 0).unwrap();
    let child = 8 * child + bytes[children + child].trailing_zeros() as usize;
    let ahead: [u8; 8] = bytes[table + 8 * child..table + 8 * child + 8].try_into().unwrap();
    bytes[children..children + 4096].fill(255);
    bytes[table..table + 8 * 32768].chunks_exact_mut(8).for_each(|cell| cell.copy_from_slice(&ahead));
    assert!(read(&bytes).unwrap_err().to_string().contains("more lower nodes than the 2"));
}

#[test]
fn a_zip_that_promises_too_much_is_refused_before_it_is_unpacked() {
    let mut bytes = file(Codec::Zip);
    bytes[16..24].copy_from_slice(&(1u64 << 50).to_le_bytes());
    assert!(matches!(read(&bytes), Err(NvdbError::Unzip { .. })));
    let mut bytes = file(Codec::Zip);
    bytes[16..24].copy_from_slice(&1000u64.to_le_bytes());
    assert!(matches!(read(&bytes), Err(NvdbError::Unzip { .. })));
}

#[test]
fn bricks_far_apart_do_not_become_a_huge_index() {
    let mut bytes = file(Codec::None);
    bytes[ROOT + 64..ROOT + 72].copy_from_slice(&(0x7_ffffu64 << 42).to_le_bytes());
    let error = read(&bytes).unwrap().grids[0].to_bricks().unwrap_err().to_string();
    assert!(error.contains("index entries; the limit is"), "{error}");
}

#[test]
fn a_changed_value_shows_in_the_checksum() {
    let mut bytes = file(Codec::None);
    let leaf = TREE + u64::from_le_bytes(bytes[TREE..TREE + 8].try_into().unwrap()) as usize;
    bytes[leaf + 96] ^= 1;
    let read_back = read(&bytes).unwrap();
    assert_eq!(read_back.grids[0].checksum, Checksum::Differs);
    assert_eq!(read_back.grids[1].checksum, Checksum::Matches);
    assert_eq!(patched(PHI + 8, &[255; 8]).unwrap().grids[0].checksum, Checksum::Absent);
}

#[test]
fn a_value_that_is_no_distance_is_refused() {
    let mut bytes = file(Codec::None);
    let leaf = TREE + u64::from_le_bytes(bytes[TREE..TREE + 8].try_into().unwrap()) as usize;
    bytes[leaf + 96..leaf + 100].copy_from_slice(&f32::NAN.to_le_bytes());
    let error = read(&bytes).unwrap().grids[0].to_bricks().unwrap_err().to_string();
    assert!(error.contains("voxel [-16, 0, 0]: NaN"), "{error}");
    assert!(patched(ROOT + 28, &(-1f32).to_le_bytes()).unwrap().grids[0].to_bricks().is_err());
}

#[test]
fn a_world_that_is_moved_is_kept() {
    let grid = &patched(PHI + 296 + 88 + 144, &2.5f64.to_le_bytes()).unwrap().grids[0];
    assert_eq!(grid.translation, DVec3::new(2.5, 0.0, 0.0));
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(64))]

    #[test]
    fn random_bytes_are_survived(bytes in prop::collection::vec(any::<u8>(), 0..2000)) {
        survive(&bytes);
    }

    #[test]
    fn random_changes_are_survived(changes in prop::collection::vec((0.0..1.0f64, any::<u8>()), 1..20)) {
        // The heads are a thousandth of the file, so half of the changes are made in them.
        let mut bytes = file(Codec::None);
        for (i, (place, value)) in changes.into_iter().enumerate() {
            let reach = if i % 2 == 0 { ROOT + 128 } else { bytes.len() };
            bytes[(place * reach as f64) as usize] = value;
        }
        survive(&bytes);
    }

    #[test]
    fn random_changes_to_a_zip_are_survived(changes in prop::collection::vec((0.0..1.0f64, any::<u8>()), 1..8)) {
        let mut bytes = file(Codec::Zip);
        for (place, value) in changes {
            let at = (place * bytes.len() as f64) as usize;
            bytes[at] = value;
        }
        survive(&bytes);
    }
}
