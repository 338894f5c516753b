//! The virtual profilometer against known surfaces, and on the round trip heights -> bricks -> heights.

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

#[test]
fn a_ball_is_seen_between_the_lattice_lines_and_not_beside_it() {
    let radius = 0.01;
    let half = DVec3::splat(radius);
    let error = |voxel: f64| {
        let ball = BrickGrid::from_distance(-half, half, voxel, 3.0, |p| p.length() - radius);
        let pixels = PixelGrid { origin: DVec2::new(-0.00613, -0.00591), pitch: 0.31e-3, nx: 40, ny: 39 };
        let seen = Profilometer::sharp(pixels).heights(&ball);
        let exact = HeightMap::from_function(pixels, |p| (radius * radius - p.length_squared()).sqrt());
        rms(&seen.heights, &exact.heights)
    };
    let (coarse, fine) = (error(0.5e-3), error(0.25e-3));
    println!("ball of 10 mm: {coarse:.1e} m rms at 0.5 mm, {fine:.1e} m at 0.25 mm");
    assert!(coarse < 3e-7 && fine < coarse / 6.0, "{coarse}, {fine}");

    let ball = BrickGrid::from_distance(-half, half, 0.5e-3, 3.0, |p| p.length() - radius);
    let aside = PixelGrid { origin: DVec2::splat(0.02), pitch: 1e-3, nx: 3, ny: 3 };
    assert_eq!(Profilometer::sharp(aside).heights(&ball).missing(), 9);
}

#[test]
fn blur_widens_a_wave_as_a_gaussian_does() {
    let wavelength = 4e-3;
    let turn = std::f64::consts::TAU / wavelength;
    let wave = |p: DVec2| 0.1e-3 * (turn * p.x).sin();
    let map = HeightMap::from_function(pixels(), wave);
    let (grid, _) = BrickGrid::from_heights(&map, &SlabOptions::with_voxel(PITCH)).unwrap();
    for blur in [0.1e-3, 0.3e-3, 0.6e-3] {
        let seen = Profilometer { blur, ..Profilometer::sharp(pixels()) }.heights(&grid);
        // A Gaussian attenuates a wave by exp(-(turn σ)²/2).
        let passed = (-0.5 * (turn * blur).powi(2)).exp();
        let middle = |k: &usize| (20..260).contains(&(k % 280));
        let error = (0..map.heights.len())
            .filter(middle)
            .map(|k| (seen.heights[k] - passed * map.heights[k]).abs())
            .fold(0.0, f64::max);
        println!("blur of {:.1} mm: {error:.1e} m off the wave that passes", blur * 1e3);
        assert!(error < 1e-6, "{error}");
    }
}

#[test]
fn blur_leaves_missing_pixels_missing_and_their_neighbours_alone() {
    let half = DVec3::new(0.01, 0.01, 0.002);
    let plate = BrickGrid::from_distance(-half, half, 0.5e-3, 3.0, |p| {
        let q = p.abs() - DVec3::new(0.01, 0.01, 0.002);
        q.max(DVec3::ZERO).length() + q.max_element().min(0.0)
    });
    let pixels = PixelGrid { origin: DVec2::splat(-0.012), pitch: 0.5e-3, nx: 49, ny: 49 };
    let seen = Profilometer { blur: 0.7e-3, ..Profilometer::sharp(pixels) }.heights(&plate);
    assert!(seen.height(0, 24).is_nan() && seen.height(48, 48).is_nan());
    // The edge of the plate is blurred over half a voxel; inside it is flat up to the last row.
    for i in 6..43 {
        assert!((seen.height(i, 6) - 0.002).abs() < 2e-5, "{}", seen.height(i, 6));
        assert!((seen.height(i, 24) - 0.002).abs() < 1e-7, "{}", seen.height(i, 24));
    }
}

#[test]
fn exposure_is_where_the_dose_on_the_surface_reaches_one() {
    let map = HeightMap::from_function(pixels(), bead);
    let (grid, _) = BrickGrid::from_heights(&map, &SlabOptions::with_voxel(PITCH)).unwrap();
    // A dose that grows along x, is 1 at 35 mm, and differs from voxel to voxel below the surface.
    let dose = |k: usize| {
        let place = grid.position(sdf_bake::grid::voxel_at(grid.bricks[k / 512], k % 512));
        (place.x / 0.035 + (place.z - bead(place.truncate())) / 0.01) as f32
    };
    let doses: Vec<f32> = (0..grid.phi.len()).map(dose).collect();
    let instrument = Profilometer::sharp(pixels());
    let seen = instrument.channel(&grid, &doses);
    for (k, dose) in seen.iter().enumerate() {
        let place = pixels().position(k % 280, k / 280);
        assert!((dose - place.x / 0.035).abs() < 1e-4, "{dose} at {place}");
    }
    assert!(instrument.channel(&grid, &[]).iter().all(|dose| *dose == 0.0), "a part that nobody sanded has no channel");
    let exposed = instrument.exposed(&grid, &doses);
    for (k, exposed) in exposed.iter().enumerate().filter(|(k, _)| k % 280 != 140) {
        assert_eq!(*exposed, Some(k % 280 > 140), "pixel {k}");
    }
}
