//! Time to convert a height map to bricks on one thread: milliseconds, and pixels per second.
//!
//! `cargo bench -p sdf-bake --bench heights`

use std::time::Instant;

use glam::DVec2;
use sdf_bake::heights::SlabOptions;
use sdf_bake::{BrickGrid, HeightMap, PixelGrid};

fn main() {
    let pool = rayon::ThreadPoolBuilder::new().num_threads(1).build().expect("one thread");
    let pixels = PixelGrid { origin: DVec2::new(0.0, -0.01), pitch: 0.25e-3, nx: 281, ny: 81 };
    let mut map = HeightMap::from_function(pixels, |p| (2e-3 * (1.0 - (p.y / 4.7e-3).powi(2))).max(0.0));
    for (at, height) in map.heights.iter_mut().enumerate() {
        *height += 2e-6 * (((at * 7919) % 1000) as f64 / 500.0 - 1.0);
        if at % 97 == 0 {
            *height = f64::NAN;
        }
    }
    println!("{:>9} {:>9} {:>8} {:>9} {:>12}", "voxel mm", "margin mm", "bricks", "ms", "1e6 pixels/s");
    for (voxel, margin) in [(0.5e-3, 0.0), (0.25e-3, 0.0), (0.25e-3, 0.01), (0.125e-3, 0.0)] {
        let options = SlabOptions { margin, ..SlabOptions::with_voxel(voxel) };
        let started = Instant::now();
        let grid = pool.install(|| BrickGrid::from_heights(&map, &options)).expect("a surface").0;
        let seconds = started.elapsed().as_secs_f64();
        println!(
            "{:>9} {:>9} {:>8} {:>9.0} {:>12.2}",
            voxel * 1e3,
            margin * 1e3,
            grid.brick_count(),
            seconds * 1e3,
            1e-6 * pixels.len() as f64 / seconds
        );
    }
}
