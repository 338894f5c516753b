//! Height changes of a scan's pixels and tiles per unit of its pose, and of the lateral place of the cut: columns of the
//! nuisance degrees of freedom.

use glam::DVec2;
use nalgebra::DMatrix;
use sdf_bake::{HeightMap, PixelGrid};

use super::tiles::Tiles;

/// Number of degrees of freedom of the scan's pose and of the part's lateral place.
pub(super) const PLACE_FREEDOMS: usize = POSE_FREEDOMS + 2;
/// Number of degrees of freedom of a scan's pose: height, tilt and shift along x and y, turn about z.
pub(super) const POSE_FREEDOMS: usize = 6;

/// Centre of a map and half of its diagonal [m].
#[derive(Clone, Copy)]
pub(super) struct Frame {
    middle: DVec2,
    reach: f64,
}

impl Frame {
    pub(super) fn of(pixels: PixelGrid) -> Self {
        let end = pixels.position(pixels.nx - 1, pixels.ny - 1);
        Self { middle: 0.5 * (pixels.origin + end), reach: 0.5 * pixels.origin.distance(end) }
    }
}

/// Height change of a pixel per unit of each degree of freedom of a scan's pose [m]; tilts and turn by the way that they
/// move the corners of the map.
pub(super) fn pose_column(frame: Frame, pixels: PixelGrid, at: usize, slope: DVec2) -> [f64; POSE_FREEDOMS] {
    let place = (pixels.position(at % pixels.nx, at / pixels.nx) - frame.middle) / frame.reach;
    [1.0, place.x, place.y, -slope.x, -slope.y, -slope.dot(place.perp())]
}

pub(super) fn pose_columns(tiles: &Tiles, slopes: &[DVec2]) -> DMatrix<f64> {
    let pixels = tiles.grid.pixels;
    let frame = Frame::of(pixels);
    let column = |k: usize| tiles.means(|at| pose_column(frame, pixels, at, slopes[at])[k]);
    DMatrix::from_vec(tiles.len(), POSE_FREEDOMS, (0..POSE_FREEDOMS).flat_map(column).collect())
}

/// Height change of each tile per shift of the cut along x and y.
pub(super) fn cut_columns(tiles: &Tiles, cut: &[DVec2]) -> DMatrix<f64> {
    let known = |slope: f64| if slope.is_finite() { -slope } else { 0.0 };
    let (x, y) = (tiles.means(|at| known(cut[at].x)), tiles.means(|at| known(cut[at].y)));
    DMatrix::from_fn(tiles.len(), 2, move |row, k| if k == 0 { x[row] } else { y[row] })
}

/// Height change of each tile per unit of the scan's pose and of the cut's place.
///
/// - `maps`: slopes of the scan and of the cut
pub(super) fn place_columns(tiles: &Tiles, [slopes, cut]: [&[DVec2]; 2]) -> DMatrix<f64> {
    let (pose, cut) = (pose_columns(tiles, slopes), cut_columns(tiles, cut));
    DMatrix::from_vec(tiles.len(), PLACE_FREEDOMS, [pose.as_slice(), cut.as_slice()].concat())
}

/// Slope at each pixel of a plane fitted to neighbours up to two pixels away, NaN where too few are known.
pub(super) fn slopes(map: &HeightMap) -> Vec<DVec2> {
    let (nx, ny) = (map.pixels.nx as i64, map.pixels.ny as i64);
    let slope = |at: usize| {
        let (i, j) = (at as i64 % nx, at as i64 / nx);
        let height = |di: i64, dj: i64| {
            let inside = (0..nx).contains(&(i + di)) && (0..ny).contains(&(j + dj));
            if inside { map.heights[((j + dj) * nx + i + di) as usize] } else { f64::NAN }
        };
        DVec2::new(along(|d| height(d, 0)), along(|d| height(0, d))) / map.pixels.pitch
    };
    (0..map.heights.len()).map(slope).collect()
}

/// Slope of the straight line fitted to the known ones of five values [per pixel]; NaN where fewer than two are known.
fn along(height: impl Fn(i64) -> f64) -> f64 {
    let known: Vec<(f64, f64)> =
        (-2..=2).map(|d| (d as f64, height(d))).filter(|(_, height)| height.is_finite()).collect();
    if known.len() < 2 {
        return f64::NAN;
    }
    let middle = known.iter().map(|(d, _)| d).sum::<f64>() / known.len() as f64;
    let (rise, weight) = known
        .iter()
        .fold((0.0, 0.0), |(rise, weight), (d, height)| (rise + (d - middle) * height, weight + (d - middle).powi(2)));
    rise / weight
}
