//! Two ways in: the input is a file, or it is a list of changes to a sound one, which otherwise is too large to find.

#![no_main]

use std::sync::LazyLock;

use glam::DVec3;
use libfuzzer_sys::fuzz_target;
use robofin_fuzz::{on_one_thread, within_memory};
use sdf_bake::BrickGrid;
use sdf_bake::nvdb::{Codec, GridRef, read, write};

/// Bytes of one change: two of place, one of value.
const CHANGE: usize = 3;

/// A small ball with labels, uncompressed.
static SOUND: LazyLock<Vec<u8>> = LazyLock::new(|| {
    let (low, high) = (DVec3::splat(0.004), DVec3::splat(0.014));
    let mut ball = BrickGrid::from_distance(low, high, 0.001, 3.0, |p| p.distance((low + high) / 2.0) - 0.005);
    ball.label = ball.phi.iter().map(|phi| u16::from(*phi > 0.0)).collect();
    let grids = [GridRef::LevelSet { name: "phi", grid: &ball }, GridRef::Labels { name: "weld", grid: &ball }];
    write(&grids, Codec::None).expect("a sound file")
});

fuzz_target!(init: on_one_thread(), |input: &[u8]| {
    let Some((way, rest)) = input.split_first() else { return };
    if way % 2 == 0 {
        within_memory(rest, 1200, || survive(rest));
        return;
    }
    let mut bytes = SOUND.clone();
    // Heads are few among many bytes, so half of the ways aim at them.
    let reach = if way % 4 == 1 { 1500 } else { bytes.len() };
    for change in rest.chunks_exact(CHANGE) {
        let place = usize::from(change[0]) << 8 | usize::from(change[1]);
        bytes[place * reach >> 16] = change[2];
    }
    within_memory(&bytes, 60, || survive(&bytes));
});

/// Reads, and follows what was read to the bricks.
fn survive(bytes: &[u8]) {
    let Ok(file) = read(bytes) else { return };
    for grid in &file.grids {
        if let Ok(mut bricks) = grid.to_bricks() {
            assert_eq!(bricks.sanity_check(), Ok(()));
            let _ = file.grids.iter().map(|other| other.attach_labels(&mut bricks)).count();
        }
    }
}
