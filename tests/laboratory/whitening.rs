//! Whitened noise has unit covariance, and fitted nuisance parameters do not count as evidence.

use lab::{Freedom, Kernel, TileGrid, TileNoise, Tiles, Whitener};
use nalgebra::{Cholesky, DMatrix, DVector};
use rand::{RngExt, SeedableRng};
use rand_pcg::Pcg64Mcg;
use sdf_bake::PixelGrid;

const TILES: usize = 120;

/// Makes tiles of 4 by 4 pixels, 1 mm apart.
fn tiles() -> Tiles {
    let origin = glam::DVec2::splat(-0.375e-3);
    TileGrid { pixels: PixelGrid { origin, pitch: 0.25e-3, nx: 80, ny: 24 }, side: 4 }.tiles(|_| true)
}

fn centres() -> Vec<glam::DVec2> {
    tiles().centres
}

fn noise() -> TileNoise {
    TileNoise { alone: 0.6e-6, shared: 1.5e-6, length: 2.5e-3, kernel: Kernel::Exponential }
}

/// Returns a height offset and a tilt of the scan, up to 50 µm.
fn pose() -> Freedom {
    let place = centres();
    let columns = DMatrix::from_fn(TILES, 2, |row, k| if k == 0 { 1.0 } else { place[row].x / 0.02 });
    Freedom::around_zero(columns, &[50e-6, 50e-6])
}

fn normals(random: &mut Pcg64Mcg, count: usize) -> DVector<f64> {
    DVector::from_fn(count, |_, _| (0..12).map(|_| random.random::<f64>()).sum::<f64>() - 6.0)
}

#[test]
fn shared_noise_and_pose_become_white() {
    let covariance = noise().covariance(&tiles(), &[0.0; TILES]);
    let factor = Cholesky::new(covariance.clone()).unwrap();
    let whitener = Whitener::new(covariance, pose()).unwrap();
    let mut random = Pcg64Mcg::seed_from_u64(11);
    let (mut squares, mut products, mut count) = (0.0, 0.0, 0.0);
    for _ in 0..400 {
        let scan = factor.l() * normals(&mut random, TILES) + pose().columns * (50e-6 * normals(&mut random, 2));
        let white = whitener.whiten(scan.as_slice());
        squares += white.iter().map(|r| r * r).sum::<f64>();
        products += white.windows(2).map(|pair| pair[0] * pair[1]).sum::<f64>();
        count += TILES as f64;
    }
    println!("variance {:.4}, neighbours {:+.4}", squares / count, products / count);
    assert!((squares / count - 1.0).abs() < 0.02, "{}", squares / count);
    assert!((products / count).abs() < 0.02, "{}", products / count);
}

#[test]
fn a_tilt_is_found_and_is_no_evidence() {
    let covariance = noise().covariance(&tiles(), &[0.0; TILES]);
    let whitener = Whitener::new(covariance, pose()).unwrap();
    let tilted: Vec<f64> = centres().iter().map(|place| 30e-6 + 40e-6 * place.x / 0.02).collect();
    let left: f64 = whitener.whiten(&tilted).iter().map(|r| r * r).sum();
    let found = whitener.degrees_of_freedom(&tilted).mean;
    println!("χ² {left:.2}, height {:.2} µm, tilt {:.2} µm", found[0] * 1e6, found[1] * 1e6);
    assert!(left < 2.0, "{left}");
    assert!((found[0] / 30e-6 - 1.0).abs() < 0.02 && (found[1] / 40e-6 - 1.0).abs() < 0.02);
    let bump: Vec<f64> = (0..TILES).map(|k| if k % 20 > 8 && k % 20 < 12 { 10e-6 } else { 0.0 }).collect();
    let seen: f64 = whitener.whiten(&bump).iter().map(|r| r * r).sum();
    assert!(seen > 100.0, "a bump of 10 µm is evidence: {seen}");
}

#[test]
fn noise_of_the_scan_before_counts_where_nothing_was_removed() {
    let all = noise().covariance(&tiles(), &[1.0; TILES]);
    let none = noise().covariance(&tiles(), &[0.0; TILES]);
    assert!((all[(7, 7)] / none[(7, 7)] - 2.0).abs() < 1e-12);
    let sigma = Whitener::new(none, pose()).unwrap().sigma_of_sum(&[1e-6; TILES]);
    let height_alone = TILES as f64 * 1e-6 * 50e-6;
    assert!(sigma > height_alone && sigma < 2.0 * height_alone, "a height of 50 µm under all tiles: {sigma}");
}

#[test]
fn a_tile_of_fewer_pixels_is_less_sure() {
    let whole = tiles();
    let half = whole.grid.tiles(|at| at % 2 == 0);
    let [whole, half] = [whole, half].map(|tiles| noise().covariance(&tiles, &[0.0; TILES]));
    let alone = noise().alone.powi(2);
    assert!(((half[(7, 7)] - whole[(7, 7)]) / alone - 1.0).abs() < 1e-9, "twice the variance of a tile's own part");
    assert!((half[(7, 8)] / whole[(7, 8)] - 1.0).abs() < 1e-9, "neighbours share as much");
}
