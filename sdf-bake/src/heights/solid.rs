//! The solid below a height map, as bricks.

use glam::{DVec2, DVec3, IVec2, IVec3};

use super::foot::distance;
use super::lattice::{LatticeHeights, smoothing_sums, without_empty_rim};
use super::{HeightMap, HeightsError, PixelGrid};
use crate::grid::{BRICK_SIDE, BRICK_VOXELS, BrickGrid, voxel_at};
use crate::implicit::BrickContents;
use crate::simd::in_wide_lanes;

/// Position of the sides and the bottom in a brick [voxels from its first voxel]: a band of three voxels fits around
/// them.
const SIDE_PLACE: f64 = 3.5;

/// Greatest number of points of a map with its margin: 800 MB of heights.
const MOST_POINTS: f64 = 1e8;

/// Greatest number of products summed in smoothing: about a minute of computing.
const MOST_SUMS: f64 = 3e10;

/// Greatest number of voxels on the vertical walls of steps between pixels, and of bricks in the box around a solid:
/// about a minute of computing each.
const MOST_WALL: f64 = 3e7;
const MOST_BOX: f64 = 3e7;

/// Options for the conversion of a height map to a solid.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SlabOptions {
    /// Distance between voxels [m].
    pub voxel: f64,
    /// Truncation distance [voxels], 2 to 16. Default 3.
    pub band_voxels: f64,
    /// Least distance to which the surface is extrapolated beyond the map's border [m]. Use half the tool's width, so
    /// that the tool meets no edge. Default 16 voxels.
    pub margin: f64,
    /// Least thickness of material below the lowest pixel [m]. Default 2 mm or 16 voxels.
    pub thickness: f64,
}

impl SlabOptions {
    /// Default options for a voxel size [m].
    pub fn with_voxel(voxel: f64) -> Self {
        Self { voxel, band_voxels: 3.0, margin: 16.0 * voxel, thickness: (16.0 * voxel).max(2e-3) }
    }

    fn check(&self) -> Result<(), HeightsError> {
        let Self { voxel, band_voxels, margin, thickness } = *self;
        for (name, found, good, accepted) in [
            ("voxel", voxel, voxel > 0.0 && voxel.is_finite(), "above zero [m]"),
            ("band_voxels", band_voxels, (2.0..=16.0).contains(&band_voxels), "2 to 16"),
            ("margin", margin, (0.0..=1.0).contains(&margin), "0 to 1 [m]"),
            ("thickness", thickness, (0.0..=1.0).contains(&thickness), "0 to 1 [m]"),
        ] {
            if !good {
                return Err(HeightsError::BadOption { name, found, accepted });
            }
        }
        Ok(())
    }
}

impl SlabOptions {
    /// Rejects more points than fit in memory: of the lattice over map and margin, or of the map's rows extended by the
    /// margin. Also rejects smoothing that would take more than about a minute, if a voxel spans many pixels.
    fn check_size(&self, pixels: &PixelGrid) -> Result<(), HeightsError> {
        let ratio = self.voxel / pixels.pitch;
        let shape = DVec2::new(pixels.nx as f64, pixels.ny as f64);
        // Whole bricks around the margin, and those that may lie beyond the sides.
        let beyond = self.margin / self.voxel + 3.0 * BRICK_SIDE as f64 + self.band_voxels;
        let lattice = shape / ratio + 2.0 * beyond;
        let padded = shape + 2.0 * beyond * ratio;
        let points = lattice.element_product().max(padded.x * shape.y);
        if points > MOST_POINTS {
            return Err(HeightsError::TooLarge { points, accepted: MOST_POINTS });
        }
        let sums = smoothing_sums(ratio, lattice, padded);
        if sums > MOST_SUMS {
            return Err(HeightsError::TooCoarse { pixels: ratio, sums, accepted: MOST_SUMS });
        }
        Ok(())
    }
}

impl SlabOptions {
    /// Rejects heights that differ so much that walls and empty bricks between them would be most of the work.
    fn check_steps(&self, map: &HeightMap) -> Result<(), HeightsError> {
        let PixelGrid { pitch, nx, ny, .. } = map.pixels;
        let heights = &map.heights;
        let along = heights.chunks_exact(nx).flat_map(|row| row.windows(2).map(|pair| (pair[1] - pair[0]).abs()));
        let across = heights.iter().zip(&heights[nx..]).map(|(one, next)| (next - one).abs());
        let wall = along.chain(across).sum::<f64>() * pitch / (self.voxel * self.voxel);
        let (low, high) = heights.iter().fold((f64::INFINITY, f64::NEG_INFINITY), |(l, h), z| (l.min(*z), h.max(*z)));
        let side = BRICK_SIDE as f64 * self.voxel;
        let extent = DVec2::new(nx as f64, ny as f64) * pitch + 2.0 * self.margin;
        let bricks = (extent / side).element_product() * (high - low + self.thickness) / side;
        if wall <= MOST_WALL && bricks <= MOST_BOX {
            return Ok(());
        }
        Err(HeightsError::TooFarApart { low, high, voxel: self.voxel })
    }
}

/// Changes to a map before its conversion.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct HeightsReport {
    /// Indices of pixels that were treated as spikes and replaced.
    pub spikes: Vec<usize>,
    /// Number of missing pixels that were filled, including an empty rim.
    pub missing: usize,
}

/// The surface, and the box of which it is the top, in voxels.
struct Slab {
    surface: LatticeHeights,
    band: f64,
    low: DVec3,
    high: DVec2,
}

impl BrickGrid {
    /// Converts a height map to a solid: a slab with the map's surface as its top, extrapolated beyond the border by
    /// [`SlabOptions::margin`], with vertical sides and a flat bottom.
    ///
    /// Spikes are removed and missing pixels filled first. φ is the distance to the bicubic surface through the heights
    /// at the lattice points. Where pixels and lattice coincide, the surface on the lattice lines is exactly at the
    /// map's heights.
    ///
    /// # Errors
    /// [`HeightsError`] if the map gives no surface or an option is out of range.
    pub fn from_heights(map: &HeightMap, options: &SlabOptions) -> Result<(Self, HeightsReport), HeightsError> {
        options.check()?;
        map.check()?;
        let mut clean = map.clone();
        let report = HeightsReport { spikes: map.spikes(), missing: map.missing() };
        for &at in &report.spikes {
            clean.heights[at] = f64::NAN;
        }
        options.check_size(&clean.pixels)?;
        let clean = without_empty_rim(&clean).filled()?;
        options.check_steps(&clean)?;
        let slab = Slab::of(&clean, options);
        Ok((slab.bricks(options.voxel), report))
    }

    /// Labels every voxel with the label of the pixel above or below it; 0 beyond the pixels.
    ///
    /// - `labels`: one per pixel, shape `[ny, nx]`
    pub fn label_columns(&mut self, pixels: &PixelGrid, labels: &[u16]) {
        let of = |voxel: IVec3| {
            let place = self.position(voxel).truncate();
            pixels.nearest(place).and_then(|at| labels.get(at)).copied().unwrap_or(0)
        };
        let column = |&brick: &IVec3| (0..BRICK_VOXELS).map(move |offset| voxel_at(brick, offset)).map(of);
        self.label = self.bricks.iter().flat_map(column).collect();
    }
}

impl Slab {
    fn of(map: &HeightMap, options: &SlabOptions) -> Self {
        let side = BRICK_SIDE as f64;
        let before = |x: f64| ((x - SIDE_PLACE) / side).floor() * side + SIDE_PLACE;
        let after = |x: f64| ((x - SIDE_PLACE) / side).ceil() * side + SIDE_PLACE;
        let PixelGrid { origin, pitch, nx, ny } = map.pixels;
        let extent = pitch * DVec2::new((nx - 1) as f64, (ny - 1) as f64);
        let low = ((origin - options.margin) / options.voxel).map(before);
        let high = ((origin + extent + options.margin) / options.voxel).map(after);
        // Bricks end less than two sides beyond the slab's sides, and feet are searched within a band of them.
        let reach = options.band_voxels + 2.0 * side;
        let (first, last) = ((low - reach).floor().as_ivec2(), (high + reach).ceil().as_ivec2());
        let surface = LatticeHeights::of(map, options.voxel, first, last);
        let lowest = surface.heights.iter().copied().fold(f64::INFINITY, f64::min);
        let bottom = before(lowest - options.thickness / options.voxel);
        Self { surface, band: options.band_voxels, low: low.extend(bottom), high }
    }

    fn bricks(&self, voxel: f64) -> BrickGrid {
        let side = BRICK_SIDE as f64;
        let highest = self.surface.heights.iter().copied().fold(f64::NEG_INFINITY, f64::max);
        let first = ((self.low - self.band) / side).floor().as_ivec3();
        let last = ((self.high.extend(highest) + self.band) / side).floor().as_ivec3();
        BrickGrid::from_bricks((voxel, self.band * voxel), first, last - first + 1, |brick| self.fill(brick, voxel))
    }

    /// φ [m] of a brick.
    fn fill(&self, brick: IVec3, voxel: f64) -> BrickContents {
        let low = brick.as_dvec3() * BRICK_SIDE as f64;
        let high = low + (BRICK_SIDE - 1) as f64;
        let (least, most) = self.range(low.truncate() - self.band, high.truncate() + self.band);
        if low.z - most >= self.band {
            return BrickContents::Outside;
        }
        // The distance to a box is convex, so its maximum over the brick is at a corner.
        let corners = [low, low.with_x(high.x), low.with_y(high.y), high.with_z(low.z)];
        if high.z - least <= -self.band && corners.iter().all(|&corner| self.box_distance(corner) <= -self.band) {
            return BrickContents::Inside;
        }
        let band = (self.band * voxel) as f32;
        in_wide_lanes(
            #[inline(always)]
            || {
                BrickContents::of(
                    #[inline(always)]
                    |offset| (self.distance(voxel_at(brick, offset), (least, most)) * voxel) as f32,
                    band,
                )
            },
        )
    }

    /// Signed distance [voxels] of a lattice point to the slab; the heights around it are from `least` to `most`.
    #[inline(always)]
    fn distance(&self, point: IVec3, (least, most): (f64, f64)) -> f64 {
        let z = f64::from(point.z);
        let surface = if z - most >= self.band {
            self.band
        } else if z - least <= -self.band {
            -self.band
        } else {
            self.surface_distance(point)
        };
        self.cut_by_box(surface, point)
    }

    /// Least and greatest height [voxels] over a rectangle [voxels].
    fn range(&self, low: DVec2, high: DVec2) -> (f64, f64) {
        let (low, high) = (low.floor().as_ivec2(), high.ceil().as_ivec2());
        let points = (low.x..=high.x).flat_map(|i| (low.y..=high.y).map(move |j| IVec2::new(i, j)));
        points
            .map(|point| self.surface.at(point))
            .fold((f64::INFINITY, f64::NEG_INFINITY), |(least, most), height| (least.min(height), most.max(height)))
    }

    /// Signed distance [voxels] of a lattice point to the surface.
    #[inline(always)]
    fn surface_distance(&self, point: IVec3) -> f64 {
        let above = f64::from(point.z) - self.surface.at(point.truncate());
        distance(&self.surface, point.as_dvec3(), self.band).copysign(above)
    }

    /// Signed distance [voxels] of a lattice point to the slab, given its signed distance `surface` to the top.
    #[inline(always)]
    fn cut_by_box(&self, surface: f64, point: IVec3) -> f64 {
        let sides = self.box_distance(point.as_dvec3());
        if surface > 0.0 && sides > 0.0 { surface.hypot(sides) } else { surface.max(sides) }
    }

    /// Signed distance [voxels] to the sides and the bottom; the top is open.
    #[inline(always)]
    fn box_distance(&self, at: DVec3) -> f64 {
        let middle = 0.5 * (self.low.truncate() + self.high);
        let across = (at.truncate() - middle).abs() - 0.5 * (self.high - self.low.truncate());
        let q = across.extend(self.low.z - at.z);
        q.max(DVec3::ZERO).length() + q.max_element().min(0.0)
    }
}
