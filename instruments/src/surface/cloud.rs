//! Conversion of a point cloud to a map: on the points' own grid if they form one, otherwise by pixels.

use glam::{DVec2, DVec3};
use sdf_bake::{HeightMap, PixelGrid};

use super::axis::Axis;
use super::window::Extent;
use super::{MOST_PIXELS, Source, Surface};
use crate::misread::{Misread, Place};

/// Maximum number of grid cells per point: a grid with more holes is treated as a cloud.
const MOST_CELLS_PER_POINT: usize = 10;
/// Maximum number of pixels per point of a cloud, if the pitch is given and the shape is not.
const MOST_PIXELS_PER_POINT: usize = 1000;
/// Points per pixel of a cloud whose pitch is not given.
const POINTS_PER_PIXEL: usize = 2;

/// Converts points [m] to a map. A point without a height is a hole in a grid and is ignored in a cloud.
///
/// # Errors
/// [`Misread`] if there are too few points, or none near the pixels of the source's window.
pub(super) fn mapped(
    format: &'static str,
    points: &[DVec3],
    source: &Source,
    mut notes: Vec<String>,
) -> Result<Surface, Misread> {
    if let Some(mut surface) = on_own_grid(format, points) {
        let pitch = surface.pitch.unwrap_or_default() * 1e6;
        let Surface { nx, ny, .. } = surface;
        notes.push(format!(
            "{} points lie on a grid of {nx} x {ny} places, pitch {:.6} x {:.6} µm",
            points.len(),
            pitch.x,
            pitch.y
        ));
        surface.notes = notes;
        return Ok(surface);
    }
    by_pixel(format, points, source, notes)
}

/// The map of points that lie on a regular grid along x and y, at most one at each grid position.
fn on_own_grid(format: &'static str, points: &[DVec3]) -> Option<Surface> {
    let most = points.len().saturating_mul(MOST_CELLS_PER_POINT).min(MOST_PIXELS);
    let x = Axis::through(points.iter().map(|point| point.x).collect())?;
    let y = Axis::through(points.iter().map(|point| point.y).collect())?;
    let (nx, ny) = (x.count, y.count);
    if nx.checked_mul(ny).is_none_or(|cells| cells > most) {
        return None;
    }
    let mut heights = vec![f64::NAN; nx * ny];
    let mut taken = vec![false; nx * ny];
    for point in points {
        let at = y.index(point.y)? * nx + x.index(point.x)?;
        if std::mem::replace(&mut taken[at], true) {
            return None;
        }
        heights[at] = point.z;
    }
    let (pitch, origin) = (DVec2::new(x.pitch, y.pitch), DVec2::new(x.start, y.start));
    Some(Surface { format, nx, ny, pitch: Some(pitch), origin: Some(origin), heights, notes: Vec::new() })
}

/// The map of a cloud: at each pixel the median height of the points that are nearest to it, otherwise the nearest
/// point within a pitch.
fn by_pixel(
    format: &'static str,
    points: &[DVec3],
    source: &Source,
    mut notes: Vec<String>,
) -> Result<Surface, Misread> {
    let seen: Vec<DVec3> = points.iter().copied().filter(|point| point.is_finite()).collect();
    let place = || Place::file(source.file);
    if seen.len() < 3 {
        return Err(place().bad(format!("{} points with a height", seen.len()), "at least three points are expected"));
    }
    let extent = Extent::of(seen.iter().map(|point| point.truncate()), seen.len() / POINTS_PER_PIXEL);
    let pixels = extent.pixels(source)?;
    if source.window.shape.is_none() && pixels.len() / MOST_PIXELS_PER_POINT > seen.len() {
        let found = format!("{} points for {} x {} pixels", seen.len(), pixels.nx, pixels.ny);
        return Err(place().bad(found, "points denser than that, or a larger pitch, are expected"));
    }
    let buckets = Buckets::new(pixels, &seen);
    let mut map = HeightMap { pixels, heights: vec![f64::NAN; pixels.len()] };
    let mut near = 0_usize;
    for (at, height) in map.heights.iter_mut().enumerate() {
        *height = buckets.median(at).unwrap_or_else(|| {
            let nearest = buckets.nearest(at);
            near += usize::from(nearest.is_some());
            nearest.unwrap_or(f64::NAN)
        });
    }
    if map.missing() == map.heights.len() {
        return Err(extent.beside(source));
    }
    notes.push(format!(
        "{} points on no grid: each pixel, {} µm apart, has the median of its points; {near} without a point have the \
         nearest one within a pitch",
        seen.len(),
        pixels.pitch * 1e6
    ));
    Ok(Surface::on(format, map, notes))
}

/// Points sorted by their nearest pixel.
struct Buckets<'a> {
    pixels: PixelGrid,
    points: &'a [DVec3],
    /// Start of each pixel's points; one entry more than there are pixels.
    starts: Vec<u32>,
    /// Indices of the points, pixel by pixel.
    order: Vec<u32>,
}

impl<'a> Buckets<'a> {
    fn new(pixels: PixelGrid, points: &'a [DVec3]) -> Self {
        let pixel_of = |point: &DVec3| pixels.nearest(point.truncate());
        let mut starts = vec![0_u32; pixels.len() + 1];
        points.iter().filter_map(pixel_of).for_each(|at| starts[at + 1] += 1);
        for at in 1..starts.len() {
            starts[at] += starts[at - 1];
        }
        let mut next = starts.clone();
        let mut order = vec![0_u32; starts[pixels.len()] as usize];
        for (number, point) in points.iter().enumerate() {
            if let Some(at) = pixel_of(point) {
                order[next[at] as usize] = number as u32;
                next[at] += 1;
            }
        }
        Self { pixels, points, starts, order }
    }

    fn of(&self, at: usize) -> impl Iterator<Item = DVec3> {
        self.order[self.starts[at] as usize..self.starts[at + 1] as usize].iter().map(|&k| self.points[k as usize])
    }

    /// Median height of a pixel's points; the mean of the two middle ones for an even number.
    fn median(&self, at: usize) -> Option<f64> {
        let mut heights: Vec<f64> = self.of(at).map(|point| point.z).collect();
        heights.sort_unstable_by(f64::total_cmp);
        let upper = *heights.get(heights.len() / 2)?;
        if heights.len() % 2 == 1 { Some(upper) } else { Some(0.5 * (heights[heights.len() / 2 - 1] + upper)) }
    }

    /// Height of the point nearest to a pixel, at most one pitch away.
    fn nearest(&self, at: usize) -> Option<f64> {
        let (i, j) = (at % self.pixels.nx, at / self.pixels.nx);
        let place = self.pixels.origin + DVec2::new(i as f64, j as f64) * self.pixels.pitch;
        let mut best = (self.pixels.pitch, None);
        for row in j.saturating_sub(1)..(j + 2).min(self.pixels.ny) {
            for column in i.saturating_sub(1)..(i + 2).min(self.pixels.nx) {
                for point in self.of(self.pixels.at(column, row)) {
                    let distance = point.truncate().distance(place);
                    if distance < best.0 {
                        best = (distance, Some(point.z));
                    }
                }
            }
        }
        best.1
    }
}
