//! The virtual profilometer against surfaces that are known, and on the way heights -> bricks -> heights.

use std::time::Instant;

use glam::{DVec2, DVec3};
use sdf_bake::heights::SlabOptions;
use sdf_bake::{BrickGrid, HeightMap, PixelGrid};
use sim::Profilometer;

const PITCH: f64 = 0.25e-3;

fn pixels() -> PixelGrid {
    PixelGrid { origin: DVec2::new(0.0, -0.01), pitch: PITCH, nx: 280, ny: 80 }
}

/// A bead along x with rounded toes, 10 mm wide and 2 mm high.
fn bead(p: DVec2) -> f64 {
    let rise = 2e-3 * (1.0 - (p.y / 5e-3).powi(2));
    0.5 * (rise + rise.hypot(0.4e-3))
}

fn rms(a: &[f64], b: &[f64]) -> f64 {
    (a.iter().zip(b).map(|(a, b)| (a - b) * (a - b)).sum::<f64>() / a.len() as f64).sqrt()
}

#[test]
fn heights_return_from_bricks() {
    let map = HeightMap::from_function(pixels(), bead);
    for (voxel, bar) in [(0.5e-3, 3e-6), (0.25e-3, 0.3e-6), (0.2e-3, 0.3e-6), (0.125e-3, 0.1e-6)] {
        let (grid, _) = BrickGrid::from_heights(&map, &SlabOptions::with_voxel(voxel)).unwrap();
        let started = Instant::now();
        let seen = Profilometer::sharp(map.pixels).heights(&grid);
        let error = rms(&seen.heights, &map.heights);
        println!("voxel {:.3} mm: {error:.1e} m rms, read in {:.1?}", voxel * 1e3, started.elapsed());
        assert!(error < bar, "{error}");
    }
}
