//! Downsampling of fine scans for the checks, which concern features much larger than a pixel.

use std::borrow::Cow;

use glam::DVec2;
use sdf_bake::{HeightMap, PixelGrid};

use super::super::{ExposureMask, LabelMap, Pass, PassScan, Scans, Trial};

/// Maximum number of pixels of a scan for the checks; with a side of 400, a track of a tenth of it has 40 pixels.
const MOST_PIXELS: usize = 160_000;

/// The trial with means over square blocks in place of pixels, if its scans have more than [`MOST_PIXELS`].
pub(super) fn coarse(trial: &Trial) -> Cow<'_, Trial> {
    let pixels = trial.scans.before.pixels;
    let side = (pixels.len() as f64 / MOST_PIXELS as f64).sqrt().ceil() as usize;
    if side < 2 {
        return Cow::Borrowed(trial);
    }
    let blocks = Blocks { pixels, side };
    let map = |map: &HeightMap| HeightMap { pixels: blocks.grid(), heights: blocks.means(|at| map.heights[at]) };
    let scan = |scan: &PassScan| scan.converted(map, |mask| blocks.exposed(mask));
    let scans = &trial.scans;
    Cow::Owned(Trial {
        scans: Scans {
            before: map(&scans.before),
            is_nominal: scans.is_nominal,
            repeats: scans.repeats.iter().map(map).collect(),
            material: scans.material.as_ref().map(|labels| blocks.labels(labels)),
        },
        passes: trial.passes.iter().map(|pass| Pass { scan: scan(&pass.scan), ..pass.clone() }).collect(),
        ..trial.clone()
    })
}

/// Square blocks of pixels; incomplete blocks at the end are left out.
struct Blocks {
    pixels: PixelGrid,
    side: usize,
}

impl Blocks {
    fn grid(&self) -> PixelGrid {
        let PixelGrid { origin, pitch, nx, ny } = self.pixels;
        let middle = 0.5 * (self.side - 1) as f64 * pitch;
        PixelGrid {
            origin: origin + DVec2::splat(middle),
            pitch: pitch * self.side as f64,
            nx: nx / self.side,
            ny: ny / self.side,
        }
    }

    /// Mean of the known values in each block; NaN if more than half are missing.
    fn means(&self, value: impl Fn(usize) -> f64) -> Vec<f64> {
        let (grid, side) = (self.grid(), self.side);
        let block = |k: usize| {
            let (i, j) = (k % grid.nx * side, k / grid.nx * side);
            let values = (0..side * side).map(|k| value(self.pixels.at(i + k % side, j + k / side)));
            let known = values.filter(|value| value.is_finite());
            let (sum, count) = known.fold((0.0, 0), |(sum, count), value| (sum + value, count + 1));
            if 2 * count >= side * side { sum / count as f64 } else { f64::NAN }
        };
        (0..grid.len()).map(block).collect()
    }

    fn exposed(&self, mask: &ExposureMask) -> ExposureMask {
        let shares = self.means(|at| mask.exposed[at].map_or(f64::NAN, f64::from));
        let seen = |share: f64| (!share.is_nan()).then_some(share >= 0.5);
        ExposureMask { pixels: self.grid(), exposed: shares.into_iter().map(seen).collect() }
    }

    /// The label in the middle of each block.
    fn labels(&self, labels: &LabelMap) -> LabelMap {
        let (grid, side) = (self.grid(), self.side);
        let label = |k: usize| {
            let (i, j) = (k % grid.nx * side, k / grid.nx * side);
            labels.labels[self.pixels.at(i + side / 2, j + side / 2)]
        };
        LabelMap { pixels: grid, labels: (0..grid.len()).map(label).collect() }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn blocks_are_the_means_of_their_pixels_at_their_middle() {
        let pixels = PixelGrid { origin: DVec2::new(1.0, 2.0), pitch: 0.5, nx: 7, ny: 5 };
        let blocks = Blocks { pixels, side: 2 };
        let plane = HeightMap::from_function(pixels, |place| place.dot(DVec2::new(3.0, -1.0)));
        let grid = blocks.grid();
        assert_eq!((grid.nx, grid.ny), (3, 2));
        for (k, mean) in blocks.means(|at| plane.heights[at]).iter().enumerate() {
            let place = grid.position(k % 3, k / 3);
            assert!((mean - place.dot(DVec2::new(3.0, -1.0))).abs() < 1e-12, "{place}");
        }
        let known = |at: usize| if at.is_multiple_of(7) || at % 7 == 1 && at < 7 { f64::NAN } else { 1.0 };
        assert!(blocks.means(known)[0].is_nan());
        assert_eq!(blocks.means(known)[3], 1.0, "half is known");
    }
}
