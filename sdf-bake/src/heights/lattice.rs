//! A cleaned height map resampled on the voxel lattice, with an extrapolated border.

use std::collections::BTreeSet;
use std::ops::RangeInclusive;

use glam::{DVec2, IVec2};
use rayon::prelude::*;

use super::{HeightMap, PixelGrid};

/// Greatest slope of a border that is extrapolated as the tilt of a plate [1]; a steeper border is a flank that ends
/// there.
const MOST_TILT: f64 = 0.02;
/// Number of border pixels whose mean is extrapolated.
const BORDER: usize = 5;
/// Greatest base length over which a border's slope is measured [pixels].
const SLOPE_BASE: usize = 20;

/// Lattice rows that are interpolated together.
const STACK: usize = 16;

/// Heights at the lattice points `first + (i, j)` [voxels].
pub(super) struct LatticeHeights {
    pub(super) first: IVec2,
    pub(super) nx: usize,
    /// Heights [voxels], shape `[ny, nx]`.
    pub(super) heights: Vec<f64>,
}

impl LatticeHeights {
    /// Resamples heights at the lattice points from `first` to `last`, which may lie beyond the map.
    ///
    /// Between pixels the surface is the bicubic of Keys 1981. If a voxel spans two pixels or more, the pixels are
    /// first smoothed by local parabolas over one voxel to each side (Savitzky and Golay 1964), which preserves smooth
    /// beads and halves the noise. Only pixels that the lattice points use are smoothed.
    pub(super) fn of(map: &HeightMap, voxel: f64, first: IVec2, last: IVec2) -> Self {
        let low = map.pixels.coordinates(first.as_dvec2() * voxel);
        let high = map.pixels.coordinates(last.as_dvec2() * voxel);
        let beyond = [-low.x, -low.y, high.x - map.pixels.nx as f64, high.y - map.pixels.ny as f64];
        let pad = beyond.into_iter().fold(0.0, f64::max).ceil() as usize + 3;
        let padded = Padded::of(map, pad);
        let along = |points: RangeInclusive<i32>, origin: f64, count: usize| -> Vec<Stencil> {
            points.map(|k| Stencil::at((f64::from(k) * voxel - origin) / map.pixels.pitch, count)).collect()
        };
        let (origin, [nx, ny]) = (padded.origin, padded.shape());
        let (x, y) = (along(first.x..=last.x, origin.x, nx), along(first.y..=last.y, origin.y, ny));
        let half_width = half_width(voxel / map.pixels.pitch);
        let heights: Vec<f64> = if half_width >= 2 {
            let smooth = Smooth::of(&padded, (&x, &y), half_width);
            laid((&x, &y), |i, j| smooth.height(i, j))
        } else {
            laid((&x, &y), |i, j| padded.height(i, j))
        };
        Self { first, nx: x.len(), heights: heights.into_iter().map(|height| height / voxel).collect() }
    }

    /// Index of a lattice point in `heights`.
    #[inline(always)]
    fn index(&self, point: IVec2) -> usize {
        let local = point - self.first;
        local.y as usize * self.nx + local.x as usize
    }

    /// Height at a lattice point [voxels].
    #[inline(always)]
    pub(super) fn at(&self, point: IVec2) -> f64 {
        self.heights[self.index(point)]
    }

    /// Heights [voxels] at `count` lattice points along x from `start`.
    #[inline(always)]
    pub(super) fn row(&self, start: IVec2, count: usize) -> &[f64] {
        let at = self.index(start);
        &self.heights[at..at + count]
    }
}

/// Crops a map to the smallest box of rows and columns with at least half of their pixels measured, without an empty
/// rim.
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

/// The map with `pad` more pixels on each side: the mean of the border's pixels, extrapolated with the side's tilt.
/// Rows beyond the map are straight lines along y and are not stored.
struct Padded {
    /// Position of the first pixel [m].
    origin: DVec2,
    pad: usize,
    nx: usize,
    /// Heights [m] of the map's rows, extrapolated along x, shape `[ny of the map, nx]`.
    rows: Vec<f64>,
    /// Below and above the map: for each column the mean of its border [m], and the outward slope [m per pixel].
    low: (Vec<f64>, f64),
    high: (Vec<f64>, f64),
}

impl Padded {
    fn of(map: &HeightMap, pad: usize) -> Self {
        let PixelGrid { origin, pitch, nx, ny } = map.pixels;
        let most = MOST_TILT * pitch;
        let rows = extended(&map.heights, nx, pad, most);
        let nx = nx + 2 * pad;
        let columns = transposed(&rows, nx);
        let border = BORDER.min(ny);
        let means = |of: fn(&[f64], usize) -> &[f64]| {
            columns.chunks_exact(ny).map(|column| mean(of(column, border))).collect::<Vec<f64>>()
        };
        let low = (means(|column, border| &column[..border]), -side_slope(&columns, ny, false, most));
        let high = (means(|column, border| &column[column.len() - border..]), side_slope(&columns, ny, true, most));
        Self { origin: origin - pitch * pad as f64, pad, nx, rows, low, high }
    }

    /// Pixels along x and y.
    fn shape(&self) -> [usize; 2] {
        [self.nx, self.rows.len() / self.nx + 2 * self.pad]
    }

    /// Height of a pixel [m].
    fn height(&self, i: usize, j: usize) -> f64 {
        let ny = self.rows.len() / self.nx;
        let outwards = |(means, slope): &(Vec<f64>, f64), beyond: usize| {
            // The mean is the height at the centre of its pixels.
            let centre = 0.5 * (BORDER.min(ny) as f64 - 1.0);
            means[i] + slope * (beyond as f64 + centre)
        };
        match j.checked_sub(self.pad) {
            None => outwards(&self.low, self.pad - j),
            Some(row) if row < ny => self.rows[row * self.nx + i],
            Some(row) => outwards(&self.high, row + 1 - ny),
        }
    }
}

/// The four pixels around a position along an axis, with their weights.
struct Stencil {
    pixels: [usize; 4],
    weights: [f64; 4],
}

impl Stencil {
    /// Stencil at a pixel coordinate of an axis with `count` pixels.
    fn at(coordinate: f64, count: usize) -> Self {
        let floor = coordinate.floor();
        let clamp = |step: usize| (floor as isize + step as isize - 1).clamp(0, count as isize - 1) as usize;
        Self { pixels: [0, 1, 2, 3].map(clamp), weights: cubic_weights(coordinate - floor) }
    }
}

/// Heights at the intersections of stencils along x and y, from pixel heights; x runs fastest.
///
/// Neighbouring lattice rows use the same rows of pixels: each is weighted along x once for a stack of lattice rows.
fn laid((x, y): (&[Stencil], &[Stencil]), height: impl Fn(usize, usize) -> f64 + Sync) -> Vec<f64> {
    let of_stack = |stack: &[Stencil]| -> Vec<f64> {
        let pixels = read(stack);
        let across = |stencil: &Stencil, j: usize| {
            (0..4).map(|a| stencil.weights[a] * height(stencil.pixels[a], j)).sum::<f64>()
        };
        let rows: Vec<Vec<f64>> =
            pixels.iter().map(|&j| x.iter().map(|stencil| across(stencil, j)).collect()).collect();
        let along = |stencil: &Stencil| -> Vec<f64> {
            let row = |pixel: usize| rows[pixels.partition_point(|&known| known < pixel)].as_slice();
            let rows = stencil.pixels.map(row);
            (0..x.len()).map(|i| (0..4).map(|b| stencil.weights[b] * rows[b][i]).sum()).collect()
        };
        stack.iter().flat_map(along).collect()
    };
    y.par_chunks(STACK).flat_map_iter(of_stack).collect()
}

/// Half width in pixels of the fitted parabolas, for a voxel that spans this number of pixels.
fn half_width(pixels: f64) -> usize {
    (pixels + 1e-9).floor() as usize
}

/// Upper bound on the products summed by [`LatticeHeights::of`], for voxels that span this number of pixels: over each
/// row of the padded map for each used column, then over those. Shapes are those of the lattice and of the padded map.
pub(super) fn smoothing_sums(pixels: f64, lattice: DVec2, padded: DVec2) -> f64 {
    let half_width = half_width(pixels);
    if half_width < 2 {
        return 0.0;
    }
    let read = (4.0 * lattice).min(padded);
    (2 * half_width + 1) as f64 * read.x * (padded.y + read.y)
}

/// The pixels that stencils use, smoothed by the parabola over `half_width` pixels to each side, along x and then y.
struct Smooth {
    /// Columns and rows, ascending.
    columns: Vec<usize>,
    rows: Vec<usize>,
    /// Heights [m], shape `[rows, columns]`.
    heights: Vec<f64>,
}

impl Smooth {
    fn of(padded: &Padded, (x, y): (&[Stencil], &[Stencil]), half_width: usize) -> Self {
        let (columns, rows) = (read(x), read(y));
        let weights = parabola(half_width);
        let [nx, ny] = padded.shape();
        let along_x = (0..ny).into_par_iter().flat_map_iter(|j| {
            let row: Vec<f64> = (0..nx).map(|i| padded.height(i, j)).collect();
            columns.iter().map(|&i| fitted(&weights, &row, i)).collect::<Vec<_>>()
        });
        let along_x = transposed(&along_x.collect::<Vec<f64>>(), columns.len());
        let heights = rows
            .par_iter()
            .flat_map_iter(|&j| along_x.chunks_exact(ny).map(|column| fitted(&weights, column, j)).collect::<Vec<_>>());
        let heights = heights.collect();
        Self { columns, rows, heights }
    }

    /// Smoothed height of a pixel that a stencil uses [m].
    fn height(&self, i: usize, j: usize) -> f64 {
        let place = |of: &[usize], pixel: usize| of.binary_search(&pixel).expect("a pixel that a stencil reads");
        self.heights[place(&self.rows, j) * self.columns.len() + place(&self.columns, i)]
    }
}

/// Pixels used by some stencils, ascending.
fn read(stencils: &[Stencil]) -> Vec<usize> {
    let pixels: BTreeSet<usize> = stencils.iter().flat_map(|stencil| stencil.pixels).collect();
    pixels.into_iter().collect()
}

/// Weights of the values around a pixel for the parabola's value at that pixel.
fn parabola(half_width: usize) -> Vec<f64> {
    let m = half_width as f64;
    let norm = (2.0 * m - 1.0) * (2.0 * m + 1.0) * (2.0 * m + 3.0);
    let weight = |k: f64| (3.0 * (3.0 * m * m + 3.0 * m - 1.0) - 15.0 * k * k) / norm;
    (0..=2 * half_width).map(|k| weight(k as f64 - m)).collect()
}

/// Value at pixel `i` of the parabola fitted to the values around it; beyond the ends the last values are repeated.
fn fitted(weights: &[f64], values: &[f64], i: usize) -> f64 {
    let half_width = weights.len() / 2;
    let first = i.checked_sub(half_width);
    if let Some(around) = first.and_then(|first| values.get(first..first + weights.len())) {
        return weights.iter().zip(around).map(|(weight, value)| weight * value).sum();
    }
    let clamped = |k: usize| values[(i + k).saturating_sub(half_width).min(values.len() - 1)];
    weights.iter().enumerate().map(|(k, weight)| weight * clamped(k)).sum()
}

/// Rows of `width` values, each extended by `pad` values at both ends; `most` is the greatest tilt per pixel.
fn extended(values: &[f64], width: usize, pad: usize, most: f64) -> Vec<f64> {
    let (before, after) = (side_slope(values, width, false, most), side_slope(values, width, true, most));
    let border = BORDER.min(width);
    // The mean is the height at the centre of its pixels.
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

/// Median slope per pixel of the rows at their start or end; zero if it is steeper than `most`.
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

/// Transposes rows of `width` values.
fn transposed(values: &[f64], width: usize) -> Vec<f64> {
    let height = values.len() / width;
    (0..values.len()).map(|k| values[(k % height) * width + k / height]).collect()
}

/// Weights of the four points around a cell at `t` (0 to 1): Keys's cubic with a = -1/2.
#[inline(always)]
pub(super) fn cubic_weights(t: f64) -> [f64; 4] {
    let (t2, t3) = (t * t, t * t * t);
    [0.5 * (2.0 * t2 - t3 - t), 0.5 * (3.0 * t3 - 5.0 * t2 + 2.0), 0.5 * (4.0 * t2 - 3.0 * t3 + t), 0.5 * (t3 - t2)]
}
