//! Cost of a field: bytes per byte of brick, and seconds of its operations.
//!
//! `cargo bench -p sdf-bake --bench grid`

#[path = "../tests/common/parts.rs"]
mod parts;

use std::time::Instant;

use glam::{DMat3, DVec3};
use sdf_bake::grid::BRICK_VOXELS;
use sdf_bake::nvdb::{Codec, write_field};
use sdf_bake::{BakeOptions, BrickGrid, Combine, bake};

fn main() {
    let gear = parts::gear(500, 25);
    let field = |across: f64| bake(&gear, &BakeOptions::with_voxel(0.08 / across)).expect("a closed gear").0;
    println!("{:28} {:>6} {:>8} {:>10} {:>10} {:>6}", "memory", "across", "bricks", "pool MB", "index MB", "ratio");
    for across in [256.0, 512.0] {
        memory("gear", across, &field(across));
    }
    for across in [256.0, 512.0, 1024.0] {
        memory("diagonal rod, 1 in 50", across, &diagonal_rod(across, 0.35e-3));
        memory("diagonal wire, 1 in 200", across, &diagonal_rod(across, 0.0875e-3));
    }
    let gear = field(512.0);
    fastest("write .nvdb, codec none", || write_field(&gear, Codec::None).expect("a sound field").len());
    fastest("volume", || gear.volume());
    let mut mesh = None;
    fastest("surface mesh", || mesh = Some(gear.surface_mesh()));
    println!("{:28} {} triangles", "", mesh.expect("made above").triangles.len());
    let ball = |p: DVec3| p.distance(DVec3::new(0.03, 0.01, 0.005)) - 0.02;
    let ball = BrickGrid::from_distance(DVec3::splat(-0.02), DVec3::splat(0.06), gear.voxel, 3.0, ball);
    fastest("union with a ball", || gear.combined_with(&ball, Combine::Union).expect("one lattice").brick_count());
    let slots: Vec<u32> = (0..gear.brick_count() as u32).collect();
    let mut changed = gear.clone();
    fastest("redistance all bricks", || changed.redistance(&slots));
    fastest("a million closest points", || closest_points(&gear));
    fastest("ten million slots", || slots_looked_up(&gear));
}

/// A round rod of given radius [m] along the diagonal of a cube of 20 mm.
fn diagonal_rod(across: f64, radius: f64) -> BrickGrid {
    let axis = DVec3::ONE.normalize();
    let turn = DMat3::from_cols(axis.any_orthonormal_pair().0, axis.any_orthonormal_pair().1, axis);
    let half = 0.017;
    BrickGrid::from_distance(DVec3::splat(-0.01), DVec3::splat(0.01), 0.02 / across, 3.0, |p| {
        let p = turn.transpose() * p;
        let (side, end) = (p.x.hypot(p.y) - radius, p.z.abs() - half);
        side.max(0.0).hypot(end.max(0.0)) + side.max(end).min(0.0)
    })
}

fn memory(name: &str, across: f64, grid: &BrickGrid) {
    let (pool, index) = (4 * BRICK_VOXELS * grid.brick_count(), grid.index.bytes());
    let ratio = grid.bytes() as f64 / pool as f64;
    let megabytes = |bytes: usize| bytes as f64 / 1e6;
    println!(
        "{name:28} {across:>6} {:>8} {:>10.2} {:>10.2} {ratio:>6.2}",
        grid.brick_count(),
        megabytes(pool),
        megabytes(index)
    );
}

/// Prints the least of five wall times and of five CPU times.
fn fastest<T>(what: &str, mut work: impl FnMut() -> T) {
    let (mut clock, mut processor) = (f64::INFINITY, f64::INFINITY);
    for _ in 0..5 {
        let (started, used) = (Instant::now(), cpu_seconds());
        std::hint::black_box(work());
        clock = clock.min(started.elapsed().as_secs_f64());
        processor = processor.min(cpu_seconds() - used);
    }
    println!("{what:28} {clock:.4} s by the clock, {processor:.3} CPU s");
}

/// CPU time of this process, all threads together [s]; NaN where the system does not report it.
fn cpu_seconds() -> f64 {
    // The first number of each thread's file is its CPU time in nanoseconds.
    let Ok(threads) = std::fs::read_dir("/proc/self/task") else { return f64::NAN };
    let of_thread = |folder: std::fs::DirEntry| {
        let text = std::fs::read_to_string(folder.path().join("schedstat")).ok()?;
        text.split_whitespace().next()?.parse::<f64>().ok()
    };
    threads.flatten().filter_map(of_thread).sum::<f64>() * 1e-9
}

fn closest_points(grid: &BrickGrid) -> f64 {
    let step = (grid.phi.len() / 1_000_000).max(1);
    let near = (0..grid.phi.len()).step_by(step).take(1_000_000);
    let foot = |place| grid.closest_surface_point(grid.position(grid.voxel_of(place)));
    near.filter_map(foot).map(|p: DVec3| p.x).sum()
}

fn slots_looked_up(grid: &BrickGrid) -> u64 {
    let bricks = grid.bricks.iter().cycle().take(10_000_000);
    bricks.map(|&brick| u64::from(grid.slot(brick + glam::IVec3::X))).sum()
}
