//! The area that a pad can reach: the largest rectangle of the top in which the pad lies flat at every centre position.
//!
//! At every pixel of a height map a plane is fitted to the surface under the pad. The pad can lie there if almost all
//! of its area lies near the plane and nothing protrudes through the plane, neither under the pad nor just beside it.

use glam::{DMat3, DVec2, DVec3, IVec2};
use sdf_bake::{BrickGrid, PixelGrid};
use sim::Profilometer;
use thiserror::Error;

/// Radius of the pad, as a share of the top's shorter side.
const PAD_SHARE: f64 = 0.13;
/// Pixels of the height map along the pad's radius.
const PIXELS_PER_RADIUS: f64 = 8.0;
/// Share of the pad that must have surface near its plane.
const LEAST_SUPPORT: f64 = 0.9;
/// Greatest distance from the plane that counts as near [pad radii]; a soft pad conforms to it.
const NEAR: f64 = 0.06;
/// Height above the plane from which a point is an obstacle [pad radii].
const IN_THE_WAY: f64 = 0.1;
/// Radius around the pad's centre that must be free of obstacles [pad radii].
const FREE: f64 = 1.15;
/// Least upward component of the plane's normal.
const LEAST_UPWARD: f64 = 0.8;

/// Reason why a pad has no patch on a surface.
#[derive(Clone, Copy, Debug, Error, PartialEq)]
pub enum PatchError {
    /// The field is entirely inside or entirely outside.
    #[error("the field holds no surface")]
    NoSurface,
    /// The pad lies flat nowhere.
    #[error("a pad of {:.1} mm lies flat nowhere on its top", 1e3 * radius)]
    NowhereFlat {
        /// Radius of the pad [m].
        radius: f64,
    },
}

/// A rectangle of positions for the pad's centre, with the plane on which the pad lies at each.
#[derive(Clone, Debug)]
pub struct PadPatch {
    /// Radius of the pad [m].
    pub radius: f64,
    /// Least x, y of the centre [m].
    pub low: DVec2,
    /// Greatest x, y of the centre [m].
    pub high: DVec2,
    pixels: PixelGrid,
    planes: Vec<Option<Plane>>,
}

/// The plane on which a pad lies: height at its centre [m] and slopes along x and y.
#[derive(Clone, Copy, Debug)]
struct Plane {
    height: f64,
    slope: DVec2,
}

/// Pose of the pad at a position.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PadRest {
    /// Centre of its face [m].
    pub contact: DVec3,
    /// Its axis, unit vector, out of the part.
    pub approach: DVec3,
}

impl PadPatch {
    /// Finds the patch on a part's top.
    ///
    /// # Errors
    /// If the field has no surface, or the pad lies flat nowhere on it.
    pub fn find(part: &BrickGrid) -> Result<Self, PatchError> {
        let (low, high) = part.surface_bounds().ok_or(PatchError::NoSurface)?;
        let radius = PAD_SHARE * (high - low).truncate().min_element();
        // Pixels on the field's own lattice lines are read without interpolation.
        let stride = (radius / PIXELS_PER_RADIUS / part.voxel).round().max(1.0);
        let first = (low.truncate() / part.voxel).floor();
        let count = ((high - low).truncate() / (stride * part.voxel)).ceil().as_uvec2() + 1;
        let pitch = stride * part.voxel;
        let pixels = PixelGrid { origin: first * part.voxel, pitch, nx: count.x as usize, ny: count.y as usize };
        let heights = Profilometer::sharp(pixels).heights(part).heights;
        let top = Top { pixels, heights, radius };
        let planes: Vec<Option<Plane>> = (0..pixels.len()).map(|at| top.plane(at)).collect();
        let free: Vec<bool> = planes.iter().map(Option::is_some).collect();
        let (from, to) = largest_rectangle(&free, pixels.nx).ok_or(PatchError::NowhereFlat { radius })?;
        let place = |at: IVec2| pixels.position(at.x as usize, at.y as usize);
        Ok(Self { radius, low: place(from), high: place(to), pixels, planes })
    }

    /// A flat patch at height 0.
    #[cfg(test)]
    pub(super) fn rectangle(low: DVec2, high: DVec2, radius: f64) -> Self {
        let pixels = PixelGrid { origin: low, pitch: (high - low).max_element(), nx: 2, ny: 2 };
        let planes = vec![Some(Plane { height: 0.0, slope: DVec2::ZERO }); 4];
        Self { radius, low, high, pixels, planes }
    }

    /// Returns the pad's pose with its centre at a position in the patch [m]; positions outside are clamped to its
    /// border.
    pub fn rest(&self, at: DVec2) -> PadRest {
        let cell = (at.clamp(self.low, self.high) - self.pixels.origin) / self.pixels.pitch;
        let corner = cell.floor().min(DVec2::new(self.pixels.nx as f64, self.pixels.ny as f64) - 2.0);
        let share = cell - corner;
        let (mut height, mut slope, mut weight) = (0.0, DVec2::ZERO, 0.0);
        for (i, j) in [(0, 0), (1, 0), (0, 1), (1, 1)] {
            let pixel = self.pixels.at(corner.x as usize + i, corner.y as usize + j);
            let along = |axis: f64, step: usize| if step == 1 { axis } else { 1.0 - axis };
            let part = along(share.x, i) * along(share.y, j);
            if let Some(plane) = self.planes[pixel] {
                height += part * plane.height;
                slope += part * plane.slope;
                weight += part;
            }
        }
        let (height, slope) = (height / weight, slope / weight);
        PadRest { contact: at.extend(height), approach: (-slope).extend(1.0).normalize() }
    }
}

/// A part's top as a height map.
struct Top {
    pixels: PixelGrid,
    heights: Vec<f64>,
    radius: f64,
}

impl Top {
    /// Fits the plane under a pad centred above a pixel; `None` if the pad cannot lie there.
    fn plane(&self, at: usize) -> Option<Plane> {
        let around: Vec<(DVec2, f64)> = self.around(at).collect();
        let under = || around.iter().filter(|(away, _)| away.length() <= self.radius);
        let plane = fit(under().filter(|(_, height)| height.is_finite()))?;
        let above = |&(away, height): &(DVec2, f64)| height - plane.height - plane.slope.dot(away);
        if around.iter().any(|pixel| above(pixel) > IN_THE_WAY * self.radius) {
            return None;
        }
        let supported = under().filter(|pixel| above(pixel).abs() <= NEAR * self.radius).count();
        let whole = std::f64::consts::PI * (self.radius / self.pixels.pitch).powi(2);
        let upward = 1.0 / plane.slope.length_squared().mul_add(1.0, 1.0).sqrt();
        (supported as f64 >= LEAST_SUPPORT * whole && upward >= LEAST_UPWARD).then_some(plane)
    }

    /// Returns the pixels within the radius that must be free: their offset from the centre [m] and height [m].
    fn around(&self, at: usize) -> impl Iterator<Item = (DVec2, f64)> {
        let reach = (FREE * self.radius / self.pixels.pitch).floor() as i32;
        let middle = IVec2::new((at % self.pixels.nx) as i32, (at / self.pixels.nx) as i32);
        let size = IVec2::new(self.pixels.nx as i32, self.pixels.ny as i32);
        let steps = (-reach..=reach).flat_map(move |j| (-reach..=reach).map(move |i| IVec2::new(i, j)));
        let within = steps.filter(move |step| {
            let pixel = middle + step;
            let is_there = pixel.cmpge(IVec2::ZERO).all() && pixel.cmplt(size).all();
            is_there && step.length_squared() <= reach * reach
        });
        within.map(move |step| {
            let pixel = middle + step;
            let height = self.heights[self.pixels.at(pixel.x as usize, pixel.y as usize)];
            (step.as_dvec2() * self.pixels.pitch, height)
        })
    }
}

/// Fits a plane to points (offset from the centre, height) by least squares.
fn fit<'a>(points: impl Iterator<Item = &'a (DVec2, f64)>) -> Option<Plane> {
    let (mut normal, mut right) = (DMat3::ZERO, DVec3::ZERO);
    for &(away, height) in points {
        let row = DVec3::new(1.0, away.x, away.y);
        normal += DMat3::from_cols(row * row.x, row * row.y, row * row.z);
        right += row * height;
    }
    let found = normal.inverse() * right;
    found.is_finite().then(|| Plane { height: found.x, slope: DVec2::new(found.y, found.z) })
}

/// Finds the largest rectangle of free cells in rows of `nx` and returns two opposite corners, both included; `None` if
/// no cell is free.
fn largest_rectangle(free: &[bool], nx: usize) -> Option<(IVec2, IVec2)> {
    let mut best: Option<(usize, (IVec2, IVec2))> = None;
    let mut depth = vec![0usize; nx];
    for (y, row) in free.chunks(nx).enumerate() {
        for (x, &is_free) in row.iter().enumerate() {
            depth[x] = if is_free { depth[x] + 1 } else { 0 };
        }
        for left in 0..nx {
            let mut least = usize::MAX;
            for (right, &depth) in depth.iter().enumerate().skip(left) {
                least = least.min(depth);
                if least == 0 {
                    break;
                }
                let area = least * (right - left + 1);
                if best.is_none_or(|(most, _)| area > most) {
                    let corner = |x: usize, y: usize| IVec2::new(x as i32, y as i32);
                    best = Some((area, (corner(left, y + 1 - least), corner(right, y))));
                }
            }
        }
    }
    best.map(|(_, corners)| corners)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_largest_rectangle_is_found() {
        let free: Vec<bool> =
            "#..#.\n.####\n#####\n.####\n#...#".bytes().filter(|&b| b != b'\n').map(|b| b == b'#').collect();
        assert_eq!(largest_rectangle(&free, 5), Some((IVec2::new(1, 1), IVec2::new(4, 3))));
        assert_eq!(largest_rectangle(&[false; 10], 5), None);
        assert_eq!(largest_rectangle(&[true; 10], 5), Some((IVec2::ZERO, IVec2::new(4, 1))));
    }

    #[test]
    fn a_pad_keeps_off_walls_and_edges_and_lies_on_slopes() {
        let slope = 0.2;
        // A tilted plate of 100 mm by 80 mm with a wall along its left side.
        let plate = |p: DVec3| {
            let beside = (p.truncate().abs() - DVec2::new(0.05, 0.04)).max_element();
            let top = (p.z - slope * p.y) / f64::hypot(1.0, slope);
            let body = top.max(-top - 0.01).max(beside);
            let wall = (p - DVec3::new(-0.045, 0.0, 0.01)).abs() - DVec3::new(0.005, 0.04, 0.02);
            body.min(wall.max_element())
        };
        let part =
            BrickGrid::from_distance(DVec3::new(-0.05, -0.04, -0.02), DVec3::new(0.05, 0.04, 0.031), 1e-3, 3.0, plate);
        let patch = PadPatch::find(&part).unwrap();
        let radius = patch.radius;
        assert!((radius - PAD_SHARE * 0.08).abs() < 5e-4, "{radius}");
        assert!(patch.low.x > -0.04 + radius && patch.low.x < -0.04 + 1.4 * radius, "{patch:?}", patch = patch.low);
        assert!(patch.high.y < 0.04 - 0.5 * radius && patch.high.y > 0.04 - 1.3 * radius, "{}", patch.high);
        let rest = patch.rest(DVec2::new(0.01, 0.012));
        assert!((rest.contact.z - slope * 0.012).abs() < 5e-5, "{}", rest.contact);
        assert!(rest.approach.distance(DVec3::new(0.0, -slope, 1.0).normalize()) < 5e-3, "{}", rest.approach);
    }

    #[test]
    fn a_part_without_a_flat_place_says_so() {
        // A roof whose sides slope down at 60°.
        let roof = |p: DVec3| (0.75f64.sqrt() * p.y.abs() + 0.5 * p.z - 0.01).max(-p.z).max(p.x.abs() - 0.02);
        let (low, high) = (DVec3::new(-0.02, -0.012, 0.0), DVec3::new(0.02, 0.012, 0.02));
        let roof = BrickGrid::from_distance(low, high, 2.5e-4, 3.0, roof);
        let found = PadPatch::find(&roof).map(|patch| (patch.low, patch.high));
        assert!(found.as_ref().is_err_and(|error| error.to_string().contains("lies flat nowhere")), "{found:?}");
    }
}
