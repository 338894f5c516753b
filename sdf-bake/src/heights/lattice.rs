//! A cleaned height map laid on the voxel lattice, with a continued border.

use glam::{DVec2, IVec2};

use super::{HeightMap, PixelGrid};

/// Slope up to which a border is continued as the tilt of a plate; a steeper one is a flank that ends [1].
const MOST_TILT: f64 = 0.02;
/// Pixels whose mean is continued outwards.
const BORDER: usize = 5;
/// Longest base over which a border's slope is measured [pixels].
const SLOPE_BASE: usize = 20;

/// Heights at the lattice points `first + (i, j)` [voxels].
pub(super) struct LatticeHeights {
    pub(super) first: IVec2,
    pub(super) nx: usize,
    /// Heights [voxels], shape `[ny, nx]`.
    pub(super) heights: Vec<f64>,
}

impl LatticeHeights {
    /// Heights at the lattice points from `first` to `last`, which may lie beyond the map.
    ///
    /// Between pixels the surface is the bicubic of Keys 1981. Where a voxel spans two pixels or more, the pixels are
    /// first smoothed by local parabolas over a voxel to each side (Savitzky and Golay 1964), which keeps smooth
    /// beads and halves the noise.
    pub(super) fn of(map: &HeightMap, voxel: f64, first: IVec2, last: IVec2) -> Self {
        let low = map.pixels.coordinates(first.as_dvec2() * voxel);
        let high = map.pixels.coordinates(last.as_dvec2() * voxel);
        let beyond = [-low.x, -low.y, high.x - map.pixels.nx as f64, high.y - map.pixels.ny as f64];
        let pad = beyond.into_iter().fold(0.0, f64::max).ceil() as usize + 3;
        let mut padded = padded(map, pad);
        let half_width = (voxel / map.pixels.pitch + 1e-9).floor() as usize;
        if half_width >= 2 {
            smooth(&mut padded, half_width);
        }
        let (nx, ny) = ((last.x - first.x + 1) as usize, (last.y - first.y + 1) as usize);
        let place = |k: usize| (first + IVec2::new((k % nx) as i32, (k / nx) as i32)).as_dvec2() * voxel;
        let heights = (0..nx * ny).map(|k| bicubic(&padded, padded.pixels.coordinates(place(k))) / voxel).collect();
        Self { first, nx, heights }
    }

    /// Position of a lattice point in `heights`.
    fn index(&self, point: IVec2) -> usize {
        let local = point - self.first;
        local.y as usize * self.nx + local.x as usize
    }

    /// Height at a lattice point [voxels].
    pub(super) fn at(&self, point: IVec2) -> f64 {
        self.heights[self.index(point)]
    }

    /// Heights [voxels] at `count` lattice points along x from `start`.
    pub(super) fn row(&self, start: IVec2, count: usize) -> &[f64] {
        let at = self.index(start);
        &self.heights[at..at + count]
    }
}

/// Smallest box of pixels whose rows and columns are at least half seen: drops the empty rim of an instrument.
pub(super) fn without_empty_rim(map: &HeightMap) -> HeightMap {
    let PixelGrid { origin, pitch, nx, ny } = map.pixels;
    let seen = |i: usize, j: usize| map.height(i, j).is_finite();
    let column = |i: usize| 2 * (0..ny).filter(|&j| seen(i, j)).count() >= ny;
    let row = |j: usize| 2 * (0..nx).filter(|&i| seen(i, j)).count() >= nx;
    let ends = |count: usize, whole: &dyn Fn(usize) -> bool| {
        let first = (0..count).find(|&k| whole(k))?;
        let last = (0..count).rfind(|&k| whole(k))?;
        (last >= first + super::LEAST_PIXELS - 1).then_some((first, last))
    };
    let (Some((i0, i1)), Some((j0, j1))) = (ends(nx, &column), ends(ny, &row)) else {
        return map.clone();
    };
    let pixels = PixelGrid {
        origin: origin + pitch * DVec2::new(i0 as f64, j0 as f64),
        pitch,
        nx: i1 - i0 + 1,
        ny: j1 - j0 + 1,
    };
    let heights = (j0..=j1).flat_map(|j| (i0..=i1).map(move |i| map.height(i, j))).collect();
    HeightMap { pixels, heights }
}

/// The map with `pad` more pixels on each side: the mean of the border's pixels, continued with the side's tilt.
fn padded(map: &HeightMap, pad: usize) -> HeightMap {
    let PixelGrid { origin, pitch, nx, ny } = map.pixels;
    let most = MOST_TILT * pitch;
    let along_x = extended(&map.heights, nx, pad, most);
    let along_y = extended(&transposed(&along_x, nx + 2 * pad), ny, pad, most);
    let pixels = PixelGrid { origin: origin - pitch * pad as f64, pitch, nx: nx + 2 * pad, ny: ny + 2 * pad };
    HeightMap { pixels, heights: transposed(&along_y, pixels.ny) }
}

/// Rows of `width` values, each continued by `pad` values at both ends; `most` is the steepest tilt per pixel.
fn extended(values: &[f64], width: usize, pad: usize, most: f64) -> Vec<f64> {
    let (before, after) = (side_slope(values, width, false, most), side_slope(values, width, true, most));
    let border = BORDER.min(width);
    // The mean stands for the middle of its pixels.
    let centre = 0.5 * (border as f64 - 1.0);
    let mut out = Vec::with_capacity(values.len() / width * (width + 2 * pad));
    for row in values.chunks_exact(width) {
        let (start, end) = (mean(&row[..border]), mean(&row[width - border..]));
        out.extend((1..=pad).rev().map(|k| start - before * (k as f64 + centre)));
        out.extend_from_slice(row);
        out.extend((1..=pad).map(|k| end + after * (k as f64 + centre)));
    }
    out
}

/// Median slope per pixel of the rows at their start or end; zero where it is steeper than `most`.
fn side_slope(values: &[f64], width: usize, at_end: bool, most: f64) -> f64 {
    let base = SLOPE_BASE.min(width);
    let border = BORDER.min(base / 2);
    let rise = |row: &[f64]| {
        let stretch = if at_end { &row[width - base..] } else { &row[..base] };
        mean(&stretch[base - border..]) - mean(&stretch[..border])
    };
    let mut rises: Vec<f64> = values.chunks_exact(width).map(rise).collect();
    let middle = rises.len() / 2;
    let slope = *rises.select_nth_unstable_by(middle, f64::total_cmp).1 / (base - border) as f64;
    if slope.abs() <= most { slope } else { 0.0 }
}

fn mean(values: &[f64]) -> f64 {
    values.iter().sum::<f64>() / values.len() as f64
}

/// Turns rows of `width` values into columns.
fn transposed(values: &[f64], width: usize) -> Vec<f64> {
    let height = values.len() / width;
    (0..values.len()).map(|k| values[(k % height) * width + k / height]).collect()
}

/// Fits a parabola over `half_width` pixels to each side of every pixel, along x and then along y.
fn smooth(map: &mut HeightMap, half_width: usize) {
    let PixelGrid { nx, ny, .. } = map.pixels;
    let along_x = transposed(&smoothed_rows(&map.heights, nx, half_width), nx);
    map.heights = transposed(&smoothed_rows(&along_x, ny, half_width), ny);
}

fn smoothed_rows(values: &[f64], width: usize, half_width: usize) -> Vec<f64> {
    let m = half_width as f64;
    let norm = (2.0 * m - 1.0) * (2.0 * m + 1.0) * (2.0 * m + 3.0);
    let weight = |k: f64| (3.0 * (3.0 * m * m + 3.0 * m - 1.0) - 15.0 * k * k) / norm;
    let weights: Vec<f64> = (0..=2 * half_width).map(|k| weight(k as f64 - m)).collect();
    let fitted = |row: &[f64], i: usize| {
        let sum = |(k, weight): (usize, &f64)| weight * row[(i + k).saturating_sub(half_width).min(width - 1)];
        weights.iter().enumerate().map(sum).sum::<f64>()
    };
    values.chunks_exact(width).flat_map(|row| (0..width).map(move |i| fitted(row, i)).collect::<Vec<_>>()).collect()
}

/// Height [m] at pixel coordinates inside the map.
fn bicubic(map: &HeightMap, at: DVec2) -> f64 {
    let floor = at.floor();
    let (wx, wy) = (cubic_weights(at.x - floor.x), cubic_weights(at.y - floor.y));
    let clamp =
        |k: f64, step: usize, count: usize| (k as isize + step as isize - 1).clamp(0, count as isize - 1) as usize;
    let row = |b: usize| {
        let j = clamp(floor.y, b, map.pixels.ny);
        (0..4).map(|a| wx[a] * map.height(clamp(floor.x, a, map.pixels.nx), j)).sum::<f64>()
    };
    (0..4).map(|b| wy[b] * row(b)).sum()
}

/// Weights of the four points around a cell at `t` (0 to 1): Keys's cubic with a = -1/2.
pub(super) fn cubic_weights(t: f64) -> [f64; 4] {
    let (t2, t3) = (t * t, t * t * t);
    [0.5 * (2.0 * t2 - t3 - t), 0.5 * (3.0 * t3 - 5.0 * t2 + 2.0), 0.5 * (4.0 * t2 - 3.0 * t3 + t), 0.5 * (t3 - t2)]
}
