//! Lateral blur of the instrument on a surface with a cut, holes and borders.

use glam::DVec2;
use sdf_bake::{HeightMap, PixelGrid};
use trial_simulation::blurred;

/// Least change that counts as the tool's [m].
const CHANGED: f64 = 2e-6;

/// Makes a rough surface; the cut part is 50 µm lower.
fn surface(cut: bool) -> HeightMap {
    let pixels = PixelGrid { origin: DVec2::ZERO, pitch: 0.25e-3, nx: 31, ny: 17 };
    let mut map = HeightMap::from_function(pixels, |at| {
        let is_cut = cut && (at.x - 3e-3).abs() < 1.1e-3 && at.y < 2e-3;
        1e-5 * (9e3 * at.x).sin() * (7e3 * at.y).cos() - if is_cut { 50e-6 } else { 0.0 }
    });
    for hole in [3 * 31 + 12, 4 * 31 + 12, 9 * 31] {
        map.heights[hole] = f64::NAN;
    }
    map
}

/// Returns the Gaussian-weighted mean of the pixels around one, for `sigma` [pixels]; beyond 3 sigma the weights fade
/// out within a pixel.
fn mean_around(map: &HeightMap, at: usize, sigma: f64) -> f64 {
    let place = |k: usize| [(k % map.pixels.nx) as f64, (k / map.pixels.nx) as f64];
    let weight = |d: f64| (3.0 * sigma + 1.0 - d.abs()).clamp(0.0, 1.0) * (-0.5 * (d / sigma).powi(2)).exp();
    let around = (0..map.heights.len()).filter(|&k| map.heights[k].is_finite()).map(|k| {
        let ([x, y], [i, j]) = (place(k), place(at));
        (weight(x - i) * weight(y - j), map.heights[k])
    });
    let (weights, sum) = around.fold((0.0, 0.0), |(all, sum), (weight, height)| (all + weight, sum + weight * height));
    sum / weights
}

#[test]
fn pixels_near_a_change_become_means_of_those_around_them_and_the_others_stay() {
    let (before, after) = (surface(false), surface(true));
    for sigma in [0.4, 0.9, 1.7] {
        let seen = blurred(&after, (&before, CHANGED), sigma * after.pixels.pitch);
        let (mut blurry, mut kept) = (0, 0);
        for (at, &height) in seen.heights.iter().enumerate() {
            if !after.heights[at].is_finite() {
                assert!(height.is_nan(), "a hole stays a hole");
            } else if height == after.heights[at] {
                kept += 1;
            } else {
                let mean = mean_around(&after, at, sigma);
                assert!((height - mean).abs() < 1e-15, "sigma {sigma}, pixel {at}: {height} instead of {mean}");
                blurry += 1;
            }
        }
        assert!(blurry >= 81 && kept > 100, "sigma {sigma}: {blurry} pixels blurred, {kept} kept");
    }
    assert_eq!(
        blurred(&after, (&before, CHANGED), 0.0).heights[5 * 31 + 12].to_bits(),
        after.heights[5 * 31 + 12].to_bits()
    );
}
