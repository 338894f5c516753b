//! Share of exposed pixels around each pixel of a mask, measured or simulated: the field whose contour at one half is the
//! border.

use glam::DVec2;
use sdf_bake::PixelGrid;

use crate::trial::ExposureMask;

/// Share of exposed pixels around each pixel.
///
/// - `radius`: columns and rows on each side that count as around [pixels]
pub fn majority(mask: &ExposureMask, radius: usize) -> Vec<f64> {
    let seen: Vec<Option<f64>> = mask.exposed.iter().map(|seen| seen.map(|seen| f64::from(u8::from(seen)))).collect();
    shares_around(&seen, mask.pixels, radius)
}

/// Mean of the known values around each pixel; 0 where there are none.
///
/// - `radius`: columns and rows on each side that count as around [pixels]
pub fn shares_around(values: &[Option<f64>], pixels: PixelGrid, radius: usize) -> Vec<f64> {
    let around = |at: usize| {
        let beside = |place: usize, count: usize| place.saturating_sub(radius)..(place + radius + 1).min(count);
        let (columns, rows) = (beside(at % pixels.nx, pixels.nx), beside(at / pixels.nx, pixels.ny));
        let known = rows.flat_map(|j| columns.clone().map(move |i| pixels.at(i, j)));
        let (sum, count) =
            known.filter_map(|at| values[at]).fold((0.0, 0.0), |(sum, count), value| (sum + value, count + 1.0));
        if count > 0.0 { sum / count } else { 0.0 }
    };
    (0..pixels.len()).map(around).collect()
}

/// Exposed share of each pixel, from the simulated dose minus the exposure threshold: linear between the places where
/// a straight border touches the pixel's first and last corner. NaN where the dose is unknown.
pub fn covered(margin: &[f64], pixels: PixelGrid) -> Vec<f64> {
    let slope = |at: usize, step: usize, is_inside: [bool; 2]| {
        let (low, high) = (at - step * usize::from(is_inside[0]), at + step * usize::from(is_inside[1]));
        step as f64 * (margin[high] - margin[low]) / (high - low).max(1) as f64
    };
    let share = |at: usize| {
        let (i, j) = (at % pixels.nx, at / pixels.nx);
        let along = slope(at, 1, [i > 0, i + 1 < pixels.nx]);
        let across = slope(at, pixels.nx, [j > 0, j + 1 < pixels.ny]);
        let reach = along.abs() + across.abs();
        let resolved = 0.5 + margin[at] / reach;
        if reach > 0.0 || margin[at].is_nan() {
            resolved.clamp(0.0, 1.0)
        } else {
            f64::from(u8::from(margin[at] >= 0.0))
        }
    };
    (0..pixels.len()).map(share).collect()
}

/// Bilinear interpolation of a field between the pixels around a place.
pub fn between(field: &[f64], pixels: PixelGrid, place: DVec2) -> f64 {
    let last = DVec2::new((pixels.nx - 1) as f64, (pixels.ny - 1) as f64);
    let local = pixels.coordinates(place).clamp(DVec2::ZERO, last);
    let low = local.floor().min(last - 1.0).max(DVec2::ZERO);
    let (share, i, j) = (local - low, low.x as usize, low.y as usize);
    let row = |j: usize| {
        let value = |i: usize| field[pixels.at(i.min(pixels.nx - 1), j.min(pixels.ny - 1))];
        value(i) + share.x * (value(i + 1) - value(i))
    };
    row(j) + share.y * (row(j + 1) - row(j))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_disc_covers_its_area() {
        let pixels = PixelGrid { origin: DVec2::ZERO, pitch: 0.5e-3, nx: 60, ny: 50 };
        let places = (0..pixels.len()).map(|at| pixels.position(at % pixels.nx, at / pixels.nx));
        let margin: Vec<f64> = places.map(|place| 6.2e-3 - place.distance(DVec2::new(14.3e-3, 12.1e-3))).collect();
        let area = covered(&margin, pixels).iter().sum::<f64>() * pixels.pitch.powi(2);
        assert!((area / (std::f64::consts::PI * 6.2e-3f64.powi(2)) - 1.0).abs() < 2e-3, "{area}");
        assert!(covered(&[f64::NAN; 3000], pixels).iter().all(|share| share.is_nan()));
    }

    #[test]
    fn a_plane_is_interpolated_exactly() {
        let pixels = PixelGrid { origin: DVec2::new(-1e-3, 2e-3), pitch: 0.5e-3, nx: 7, ny: 5 };
        let plane = |place: DVec2| 3.0 + 200.0 * place.x - 700.0 * place.y;
        let field: Vec<f64> = (0..35).map(|at| plane(pixels.position(at % 7, at / 7))).collect();
        for place in [DVec2::new(0.13e-3, 2.91e-3), pixels.position(6, 4), pixels.position(0, 0)] {
            assert!((between(&field, pixels, place) - plane(place)).abs() < 1e-12, "{place}");
        }
    }
}
