//! Resampling of maps at the pixels of another scan.

use glam::DVec2;
use sdf_bake::{HeightMap, PixelGrid};

/// Difference up to which two pixels are the same [pixels].
const SAME: f64 = 1e-6;

/// A map whose pixels may have different pitches along x and y.
pub(super) struct Placed {
    /// x, y of the first pixel [m].
    pub(super) origin: DVec2,
    /// Distance between pixels along x and y [m].
    pub(super) pitch: DVec2,
    pub(super) nx: usize,
    pub(super) ny: usize,
    /// Heights [m], NaN where missing, shape `[ny, nx]`.
    pub(super) heights: Vec<f64>,
}

impl Placed {
    /// Square pixels over the same area, with the larger of the two pitches, so that the resolution is not exaggerated.
    pub(super) fn square(&self) -> PixelGrid {
        let pitch = self.pitch.max_element();
        let count = |pixels: usize, own: f64| ((pixels - 1) as f64 * own / pitch + SAME) as usize + 1;
        PixelGrid { origin: self.origin, pitch, nx: count(self.nx, self.pitch.x), ny: count(self.ny, self.pitch.y) }
    }

    /// True if the pixels are those of a grid.
    pub(super) fn is_on(&self, pixels: &PixelGrid) -> bool {
        let most = SAME * pixels.pitch;
        let far = DVec2::new(self.nx as f64, self.ny as f64) * (self.pitch - pixels.pitch);
        (self.nx, self.ny) == (pixels.nx, pixels.ny)
            && (self.origin - pixels.origin).abs().max_element() < most
            && far.abs().max_element() < most
    }

    /// Heights at the pixels of a grid: bilinear between four known ones, missing elsewhere; a pixel of both keeps its
    /// value.
    pub(super) fn on(self, pixels: PixelGrid) -> HeightMap {
        if self.is_on(&pixels) {
            return HeightMap { pixels, heights: self.heights };
        }
        let height = |k: usize| self.at(pixels.position(k % pixels.nx, k / pixels.nx));
        HeightMap { pixels, heights: (0..pixels.len()).map(height).collect() }
    }

    fn at(&self, place: DVec2) -> f64 {
        let at = (place - self.origin) / self.pitch;
        let low = (at + SAME).floor();
        let share = (at - low).max(DVec2::ZERO);
        let share = DVec2::select(share.cmplt(DVec2::splat(SAME)), DVec2::ZERO, share);
        let pixel = |i: f64, j: f64| {
            let is_inside = i >= 0.0 && j >= 0.0 && i < self.nx as f64 && j < self.ny as f64;
            if is_inside { self.heights[j as usize * self.nx + i as usize] } else { f64::NAN }
        };
        let along = |j: f64| match share.x {
            0.0 => pixel(low.x, j),
            x => (1.0 - x) * pixel(low.x, j) + x * pixel(low.x + 1.0, j),
        };
        match share.y {
            0.0 => along(low.y),
            y => (1.0 - y) * along(low.y) + y * along(low.y + 1.0),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn placed(origin: DVec2, pitch: DVec2, (nx, ny): (usize, usize)) -> Placed {
        let place = |k: usize| origin + pitch * DVec2::new((k % nx) as f64, (k / nx) as f64);
        Placed { origin, pitch, nx, ny, heights: (0..nx * ny).map(|k| place(k).dot(DVec2::new(2.0, -3.0))).collect() }
    }

    #[test]
    fn a_plane_stays_a_plane_on_other_pixels() {
        let pixels = PixelGrid { origin: DVec2::new(0.5, 0.25), pitch: 0.75, nx: 9, ny: 8 };
        let map = placed(DVec2::ZERO, DVec2::new(1.0, 0.5), (8, 10)).on(pixels);
        for (k, height) in map.heights.iter().enumerate() {
            let place = pixels.position(k % 9, k / 9);
            let is_inside = place.x <= 7.0 && place.y <= 4.5;
            let off = (height - place.dot(DVec2::new(2.0, -3.0))).abs();
            assert!(if is_inside { off < 1e-12 } else { height.is_nan() }, "{place}: {height}");
        }
    }

    #[test]
    fn the_same_pixels_keep_every_bit_and_long_ones_become_square() {
        let map = placed(DVec2::splat(0.1), DVec2::splat(0.3), (5, 4));
        let (pixels, heights) = (map.square(), map.heights.clone());
        assert_eq!((pixels.nx, pixels.ny, pixels.pitch), (5, 4, 0.3));
        assert_eq!(map.on(pixels).heights, heights);
        let long = placed(DVec2::ZERO, DVec2::new(0.2, 0.1), (5, 9));
        let pixels = long.square();
        assert_eq!((pixels.nx, pixels.ny, pixels.pitch), (5, 5, 0.2));
        assert!(long.on(pixels).heights.iter().all(|height| height.is_finite()));
    }
}
