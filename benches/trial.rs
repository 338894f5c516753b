//! Speed of reading measured data and of the virtual profilometer: milliseconds and rates, on one thread.
//!
//! `cargo bench -p robofin --bench trial`

use std::fmt::Write as _;
use std::fs;
use std::time::Instant;

use glam::DVec2;
use sdf_bake::heights::SlabOptions;
use sdf_bake::{BrickGrid, HeightMap, PixelGrid};
use sim::Profilometer;
use trials::trial::{ScanFrame, heights_csv, read_heights, read_log};

fn main() {
    let pool = rayon::ThreadPoolBuilder::new().num_threads(1).build().expect("one thread");
    pool.install(|| {
        read_maps();
        read_logs();
        see_surfaces();
    });
}

fn bead(p: DVec2) -> f64 {
    (2e-3 * (1.0 - (p.y / 5e-3).powi(2))).max(0.0) + 2e-6 * (p.x * 4e4).sin()
}

fn report(what: &str, count: f64, unit: &str, work: impl FnOnce()) {
    let started = Instant::now();
    work();
    let seconds = started.elapsed().as_secs_f64();
    println!("{what:44} {:>8.1} ms {:>8.2} million {unit}/s", seconds * 1e3, 1e-6 * count / seconds);
}

fn read_maps() {
    let folder = tempfile::tempdir().expect("a folder");
    for (nx, ny) in [(280, 80), (2000, 2000)] {
        let pixels = PixelGrid { origin: DVec2::new(0.0, -0.01), pitch: 0.25e-3, nx, ny };
        let file = folder.path().join("map.csv");
        fs::write(&file, heights_csv(&HeightMap::from_function(pixels, bead))).expect("a map");
        let frame = ScanFrame { origin: Some(pixels.origin), pitch: Some(pixels.pitch), ..ScanFrame::default() };
        report(&format!("read a map of {nx} x {ny}"), pixels.len() as f64, "pixels", || {
            read_heights(&file, frame).expect("a map");
        });
    }
}

fn read_logs() {
    let folder = tempfile::tempdir().expect("a folder");
    let file = folder.path().join("log.csv");
    let mut text = String::from("t_s,x_mm,y_mm,z_mm,force_n,spindle_rpm\n");
    for k in 0..100_000 {
        let time = 1e-3 * f64::from(k);
        let _ = writeln!(text, "{time:.3},{:.3},0.000,51.0454,14.48,5995", 5.0 * time);
    }
    fs::write(&file, text).expect("a log");
    report("read a log of 100000 rows", 1e5, "rows", || {
        read_log(&file).expect("a log");
    });
}

fn see_surfaces() {
    let pixels = PixelGrid { origin: DVec2::new(0.0, -0.01), pitch: 0.25e-3, nx: 280, ny: 80 };
    let map = HeightMap::from_function(pixels, bead);
    for voxel in [0.5e-3, 0.25e-3, 0.125e-3] {
        let grid = BrickGrid::from_heights(&map, &SlabOptions::with_voxel(voxel)).expect("a surface").0;
        let shown = format!("see 280 x 80 pixels, voxel {} mm", voxel * 1e3);
        report(&shown, pixels.len() as f64, "pixels", || {
            Profilometer::sharp(pixels).heights(&grid);
        });
    }
}
