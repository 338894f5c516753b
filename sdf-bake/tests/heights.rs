//! The solid below a height map: its surface, its distance, its border.

use glam::{DVec2, DVec3, IVec3};
use sdf_bake::heights::{HeightsError, SlabOptions};
use sdf_bake::{BrickGrid, HeightMap, PixelGrid};

const PITCH: f64 = 0.25e-3;

fn pixels() -> PixelGrid {
    PixelGrid { origin: DVec2::new(0.0, -0.01), pitch: PITCH, nx: 141, ny: 81 }
}

/// A parabolic bead along x, 10 mm wide, 2 mm high, with rounded toes.
fn bead(p: DVec2) -> f64 {
    let rise = 2e-3 * (1.0 - (p.y / 5e-3).powi(2));
    let round = 0.4e-3;
    // Smooth maximum of the bead and the plate.
    0.5 * (rise + rise.hypot(round)) - 0.1e-3
}

fn waves(p: DVec2) -> f64 {
    0.3e-3 * (p.x * 900.0).sin() * (p.y * 700.0).cos()
}

/// Height along z at which φ vanishes above a lattice point, by the cubic through the four voxels around it.
fn crossing(grid: &BrickGrid, i: i32, j: i32) -> Option<f64> {
    let top = (grid.origin.z + grid.dims.z) * 8 - 2;
    let phi = |k: i32| f64::from(grid.phi_at(IVec3::new(i, j, k)));
    let k = (grid.origin.z * 8..top).rev().find(|&k| phi(k) < 0.0 && phi(k + 1) >= 0.0)?;
    let values = [-1, 0, 1, 2].map(|step| phi(k + step));
    let cubic = |t: f64| {
        let [a, b, c, d] = values;
        -a * t * (t - 1.0) * (t - 2.0) / 6.0 + b * (t + 1.0) * (t - 1.0) * (t - 2.0) / 2.0
            - c * (t + 1.0) * t * (t - 2.0) / 2.0
            + d * (t + 1.0) * t * (t - 1.0) / 6.0
    };
    let (mut low, mut high) = (0.0, 1.0);
    for _ in 0..50 {
        let middle = 0.5 * (low + high);
        if cubic(middle) < 0.0 { low = middle } else { high = middle }
    }
    Some((f64::from(k) + low) * grid.voxel)
}

/// Greatest difference [m] between the crossing and the surface over the map's lattice points.
fn worst(voxel: f64, surface: fn(DVec2) -> f64) -> f64 {
    let map = HeightMap::from_function(pixels(), surface);
    let (grid, report) = BrickGrid::from_heights(&map, &SlabOptions::with_voxel(voxel)).unwrap();
    assert_eq!(report.spikes, Vec::<usize>::new());
    grid.sanity_check().unwrap();
    let places = (1..70).flat_map(|i| (-19..20).map(move |j| (i, j)));
    let scale = 0.5e-3 / voxel;
    let error = |(i, j): (i32, i32)| {
        let place = DVec2::new(f64::from(i), f64::from(j)) * 0.5e-3;
        let found = crossing(&grid, (f64::from(i) * scale) as i32, (f64::from(j) * scale) as i32);
        (found.expect("a surface") - surface(place)).abs()
    };
    places.map(error).fold(0.0, f64::max)
}

#[test]
fn the_surface_lies_at_the_heights_of_the_pixels() {
    for (name, surface) in [("bead", bead as fn(DVec2) -> f64), ("waves", waves)] {
        let errors = [0.5e-3, 0.25e-3, 0.125e-3].map(|voxel| worst(voxel, surface));
        println!(
            "{name}: surface within {:.1e}, {:.1e}, {:.1e} m at 0.5, 0.25, 0.125 mm",
            errors[0], errors[1], errors[2]
        );
        assert!(errors[1] < 0.2e-6 && errors[2] < 0.2e-6, "{errors:?}");
        assert!(errors[0] < 3e-6, "{errors:?}");
    }
}

/// Share of voxels in the band whose gradient length is wrong by more than 2 %, away from kinks.
#[test]
fn phi_is_a_distance_within_the_band() {
    let map = HeightMap::from_function(pixels(), bead);
    let (grid, _) = BrickGrid::from_heights(&map, &SlabOptions::with_voxel(PITCH)).unwrap();
    let (mut worst, mut counted) = (0f64, 0);
    for i in (4..136).step_by(7) {
        for j in -36..36 {
            for k in -8..20 {
                let voxel = IVec3::new(i, j, k);
                let around = IVec3::AXES.map(|axis| (grid.phi_at(voxel + axis), grid.phi_at(voxel - axis)));
                if around.iter().any(|&(a, b)| a.abs().max(b.abs()) >= grid.band) {
                    continue;
                }
                let slope = DVec3::from_array(around.map(|(a, b)| f64::from(a - b) / (2.0 * PITCH)));
                worst = worst.max((slope.length() - 1.0).abs());
                counted += 1;
            }
        }
    }
    println!("|∇φ| = 1 within {worst:.4} at {counted} voxels");
    assert!(counted > 5000 && worst < 0.02, "{worst}");
}

#[test]
fn between_the_flanks_of_a_groove_the_nearer_one_counts() {
    let groove = |p: DVec2| p.y.abs() * 1.5;
    let map = HeightMap::from_function(pixels(), groove);
    let (grid, _) = BrickGrid::from_heights(&map, &SlabOptions::with_voxel(PITCH)).unwrap();
    for (j, k) in [(1, 4), (-1, 4), (0, 3), (2, 6)] {
        let (y, z) = (f64::from(j) * PITCH, f64::from(k) * PITCH);
        let exact = (z - 1.5 * y.abs()) / 1.5f64.hypot(1.0);
        let found = f64::from(grid.phi_at(IVec3::new(40, j, k)));
        // The bicubic rounds the root by less than a tenth of a voxel.
        assert!((found - exact).abs() < 0.1 * PITCH, "at ({j}, {k}): {found}, {exact}");
    }
}

#[test]
fn the_border_is_continued_with_the_plates_tilt_and_no_wall() {
    let tilted = |p: DVec2| 0.004 * p.x - 0.003 * p.y;
    let mut map = HeightMap::from_function(pixels(), tilted);
    for i in 0..141 {
        map.heights[i] = f64::NAN;
        map.heights[80 * 141 + i] = f64::NAN;
    }
    map.heights[40 * 141 + 70] += 1e-3;
    let options = SlabOptions { margin: 0.012, ..SlabOptions::with_voxel(PITCH) };
    let (grid, report) = BrickGrid::from_heights(&map, &options).unwrap();
    assert_eq!((report.spikes, report.missing), (vec![40 * 141 + 70], 282));
    for (i, j) in [(-40, -80), (70, 85), (180, 0), (70, 0)] {
        let place = DVec2::new(f64::from(i), f64::from(j)) * PITCH;
        let found = crossing(&grid, i, j).unwrap();
        assert!((found - tilted(place)).abs() < 1e-7, "at {place}: {found}, {}", tilted(place));
    }
    assert!(grid.volume() > 0.0 && grid.phi_at(IVec3::new(0, 0, -4)) == -grid.band);
    assert_eq!(grid.phi_at(IVec3::new(0, 0, -100)), grid.band);
}

#[test]
fn voxels_of_a_hundred_pixels_cost_about_what_the_map_does() {
    let tilted = |p: DVec2| 1e-3 + 0.004 * p.x - 0.003 * p.y;
    let pixels = PixelGrid { origin: DVec2::new(0.0, -1e-3), pitch: 1e-5, nx: 500, ny: 400 };
    let map = HeightMap::from_function(pixels, tilted);
    let timed = |across: f64| {
        let started = std::time::Instant::now();
        let options = SlabOptions::with_voxel(across * pixels.pitch);
        let (grid, _) = BrickGrid::from_heights(&map, &options).unwrap();
        (grid, started.elapsed().as_secs_f64())
    };
    let ((_, ten), (grid, hundred)) = (timed(10.0), timed(100.0));
    let voxel = grid.voxel;
    println!("{ten:.2} s with voxels of 10 pixels, {hundred:.2} s with voxels of 100");
    // Smoothing every pixel of the margin would sum four hundred times as many products.
    assert!(hundred < 40.0 * ten, "{hundred} s, and {ten} s with voxels of 10 pixels");
    for (i, j) in [(1, 0), (3, 2), (-10, -8), (15, 12)] {
        let place = DVec2::new(f64::from(i), f64::from(j)) * voxel;
        let found = crossing(&grid, i, j).unwrap();
        assert!((found - tilted(place)).abs() < 1e-6, "at {place}: {found}, {}", tilted(place));
    }
    let finer = HeightMap { pixels: PixelGrid { pitch: 1e-6, ..pixels }, ..map };
    let error = BrickGrid::from_heights(&finer, &SlabOptions::with_voxel(2e-3)).unwrap_err();
    assert!(matches!(error, HeightsError::TooCoarse { .. }), "{error}");
    assert!(error.to_string().contains("a voxel of 2000 pixels"), "{error}");
}

#[test]
fn labels_follow_the_columns() {
    let map = HeightMap::from_function(pixels(), bead);
    let (mut grid, _) = BrickGrid::from_heights(&map, &SlabOptions::with_voxel(PITCH)).unwrap();
    let labels: Vec<u16> = (0..map.pixels.len()).map(|at| u16::from((at / 141).abs_diff(40) <= 20)).collect();
    grid.label_columns(&map.pixels, &labels);
    grid.sanity_check().unwrap();
    assert_eq!(grid.label_at(IVec3::new(40, 0, 7)), 1);
    assert_eq!(grid.label_at(IVec3::new(40, 21, 0)), 0);
}

#[test]
fn what_is_no_map_is_refused_with_the_reason() {
    let map = HeightMap::from_function(pixels(), bead);
    let made = |map: &HeightMap, options: SlabOptions| BrickGrid::from_heights(map, &options).map(|_| ());
    let fine = SlabOptions::with_voxel(PITCH);
    let short = HeightMap { heights: map.heights[1..].to_vec(), ..map.clone() };
    assert!(matches!(made(&short, fine), Err(HeightsError::WrongShape { nx: 141, ny: 81, .. })));
    let blind = HeightMap { heights: vec![f64::NAN; map.heights.len()], ..map.clone() };
    assert!(matches!(made(&blind, fine), Err(HeightsError::TooFewPixels { seen: 0, .. })));
    let flat = HeightMap { pixels: PixelGrid { pitch: 0.0, ..map.pixels }, ..map.clone() };
    assert!(matches!(made(&flat, fine), Err(HeightsError::BadGrid { .. })));
    for large in [SlabOptions::with_voxel(1e-7), SlabOptions { margin: 1.0, ..SlabOptions::with_voxel(1e-4) }] {
        assert!(matches!(made(&map, large), Err(HeightsError::TooLarge { .. })));
    }
    for bad in [SlabOptions { voxel: f64::NAN, ..fine }, SlabOptions { band_voxels: 1.0, ..fine }] {
        assert!(matches!(made(&map, bad), Err(HeightsError::BadOption { .. })));
    }
}

#[test]
fn heights_too_far_apart_for_the_voxel_are_refused_before_walls_are_made_of_them() {
    let pixels = PixelGrid { origin: DVec2::ZERO, pitch: 0.25e-3, nx: 60, ny: 40 };
    let block = |p: DVec2| if p.x > 6e-3 && p.y > 4e-3 { -9.999 } else { 1e-3 };
    let options = SlabOptions::with_voxel(0.05e-3);
    let error = BrickGrid::from_heights(&HeightMap::from_function(pixels, block), &options).unwrap_err();
    assert!(matches!(error, HeightsError::TooFarApart { .. }), "{error}");
    for word in ["-9999.0 mm", "1.0 mm", "voxel of 0.05 mm", "leave cells without a height empty"] {
        assert!(error.to_string().contains(word), "{error}");
    }
    // A step of one metre at every other pixel.
    let salt = HeightMap::from_function(pixels, |p| f64::from((p.x / 0.25e-3) as i32 % 2) - 0.5);
    assert!(BrickGrid::from_heights(&salt, &options).is_err());
    // A bead with steep flanks is accepted.
    let bead = |p: DVec2| (2e-3 - 3.0 * (p.y - 5e-3).abs()).max(0.0);
    let options = SlabOptions::with_voxel(0.25e-3);
    assert!(BrickGrid::from_heights(&HeightMap::from_function(pixels, bead), &options).is_ok());
}
