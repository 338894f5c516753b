//! The contact patch: where the wheel overlaps the workpiece, and the force it meets there.
//!
//! Pressure is stiffness times depth, `p = K · depth`, sampled on the workpiece's surface. The patch is cut
//! into columns along the approach axis, [`COLUMNS_PER_VOXEL`] to a voxel in either direction. Where each
//! column meets the surface does not depend on how far the wheel is lifted, so it is found once; the
//! force as a function of the travel is then a sum over columns.
//!
//! Within a column's square the depth is taken as linear where the rim crosses it, and integrated exactly;
//! inside the patch it is taken as quadratic. So the integral is second order in the voxel size.

use glam::DVec3;
use rayon::prelude::*;
use sdf_bake::BrickGrid;

use crate::ramp::{ramp_mean, wet_share};
use crate::surface::way_to_surface;
use crate::tool::{Pose, Wheel};

/// Quadrature columns along one voxel.
pub const COLUMNS_PER_VOXEL: f64 = 1.5;

/// Longest patch to either side [wheel radii].
pub const LONGEST: f64 = 0.9;

/// Which part of the surface a patch covers.
#[derive(Clone, Copy, Debug)]
pub struct PatchExtent {
    /// Length ahead of the wheel's lowest point [m].
    pub front: f64,
    /// Length behind it [m].
    pub back: f64,
    /// How far the wheel may sink below the given pose [m].
    pub sink: f64,
}

impl PatchExtent {
    /// Half as long again to either side.
    pub fn grown(&self) -> Self {
        Self { front: 1.5 * self.front, back: 1.5 * self.back, ..*self }
    }
}

/// The surface under a wheel, as columns along the approach axis.
///
/// Columns are stored feed by feed: shape `[along, across]`, the across index runs fastest.
pub struct Patch {
    along: usize,
    across: usize,
    /// Columns behind the wheel's lowest point.
    behind: usize,
    pitch_along: f64,
    pitch_across: f64,
    wheel: Wheel,
    pose: Pose,
    columns: Vec<Column>,
}

/// Where one column meets the surface, relative to the wheel at its unlifted pose.
#[derive(Clone, Copy)]
struct Column {
    /// Offset from the wheel's centre [m].
    offset: DVec3,
    /// Squared distance from the wheel's axis [m²]; infinite where the column meets no surface.
    radial_squared: f64,
    /// Component across the wheel's axis, times the approach axis' [m].
    radial_approach: f64,
    /// Surface area per projected area, 1/cos of the slope.
    area_ratio: f64,
}

/// What the wheel meets at one travel.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Contact {
    /// Normal force `F = ∫ p n·a dA` along the approach axis a [N].
    pub force: f64,
    /// Moment of that force about the wheel's centre [N m].
    pub moment: DVec3,
    /// Area under pressure, projected along the approach axis [m²].
    pub area: f64,
    /// Highest pressure [Pa].
    pub pressure_max: f64,
    /// Length of the patch ahead of the wheel's centre [m].
    pub front: f64,
    /// Length of the patch behind it [m].
    pub back: f64,
}

impl Contact {
    /// Force over area [Pa]; 0 without contact.
    pub fn pressure_mean(&self) -> f64 {
        if self.area > 0.0 { self.force / self.area } else { 0.0 }
    }
}

impl Patch {
    /// Finds the surface under a wheel at `pose`.
    pub fn find(grid: &BrickGrid, wheel: &Wheel, pose: &Pose, extent: PatchExtent) -> Self {
        let pitch = grid.voxel / COLUMNS_PER_VOXEL;
        let columns = |length: f64| (length.min(LONGEST * wheel.radius) / pitch).ceil() as usize;
        let face = (wheel.width / pitch).ceil();
        let mut patch = Self {
            along: columns(extent.back) + 1 + columns(extent.front),
            behind: columns(extent.back),
            across: face as usize + 2,
            pitch_along: pitch,
            pitch_across: wheel.width / face,
            wheel: *wheel,
            pose: *pose,
            columns: Vec::new(),
        };
        let columns = patch.along * patch.across;
        patch.columns =
            (0..columns).into_par_iter().with_min_len(64).map(|i| patch.meet(grid, i, extent.sink)).collect();
        patch.set_area_ratios();
        patch
    }

    /// Place of a column on the working face of the unlifted wheel [m].
    fn place(&self, column: usize) -> DVec3 {
        let u = ((column / self.across) as f64 - self.behind as f64) * self.pitch_along;
        let v = ((column % self.across) as f64 - 0.5 * (self.across - 1) as f64) * self.pitch_across;
        let drop = (self.wheel.radius.powi(2) - u * u).sqrt();
        self.pose.centre + self.pose.feed() * u + self.pose.axis * v - self.pose.radial_approach() * drop
    }

    fn meet(&self, grid: &BrickGrid, column: usize, sink: f64) -> Column {
        let start = self.place(column);
        // A column is left out if the wheel, sunk as far as it may, cannot reach the surface; the margin is
        // for what the trilinear φ lacks.
        let reach = sink + 0.15 * grid.voxel;
        let clear = reach < 0.9 * f64::from(grid.band) && f64::from(grid.sample(start)) > reach;
        let way = if clear { None } else { way_to_surface(grid, start, self.pose.approach, 2.0 * sink + grid.voxel) };
        let offset = start + self.pose.approach * way.unwrap_or(0.0) - self.pose.centre;
        let radial = offset.reject_from_normalized(self.pose.axis);
        Column {
            offset,
            radial_squared: if way.is_some() { radial.length_squared() } else { f64::INFINITY },
            radial_approach: radial.dot(self.pose.approach),
            area_ratio: 1.0,
        }
    }

    /// From the slopes of the surface between neighbouring columns.
    fn set_area_ratios(&mut self) {
        let height: Vec<f64> = self
            .columns
            .iter()
            .map(|c| if c.radial_squared.is_finite() { c.offset.dot(self.pose.approach) } else { f64::NEG_INFINITY })
            .collect();
        for i in 0..self.columns.len() {
            let (along, across) = self.differences(&height, i);
            let slopes = (along.slope(self.pitch_along), across.slope(self.pitch_across));
            let slope_squared = slopes.0 * slopes.0 + slopes.1 * slopes.1;
            self.columns[i].area_ratio = (1.0 + slope_squared).sqrt();
        }
    }

    /// Depth [m] of each column's surface point under the wheel lifted by `travel`; -∞ where there is none.
    fn depths(&self, travel: f64) -> Vec<f64> {
        let lift = travel * travel * self.pose.approach.reject_from_normalized(self.pose.axis).length_squared();
        let depth =
            |c: &Column| self.wheel.radius - (c.radial_squared - 2.0 * travel * c.radial_approach + lift).sqrt();
        self.columns.iter().map(depth).collect()
    }

    /// Force, moment, area and peak pressure [SI] of the wheel lifted by `travel` [m], for the stiffness K [Pa/m].
    pub fn contact(&self, travel: f64, stiffness: f64) -> Contact {
        let depths = self.depths(travel);
        let cell = self.pitch_along * self.pitch_across;
        let feed = self.pose.feed();
        let mut contact = Contact::default();
        for (i, column) in self.columns.iter().enumerate() {
            let Some(square) = self.square(&depths, i, travel, 0.0) else { continue };
            let offset = column.offset - self.pose.approach * travel;
            let force = stiffness * square.depth * cell;
            contact.force += force;
            contact.moment += offset.cross(self.pose.approach) * force;
            contact.area += square.wet * cell;
            contact.pressure_max = contact.pressure_max.max(stiffness * depths[i]);
            contact.front = contact.front.max(offset.dot(feed));
            contact.back = contact.back.max(-offset.dot(feed));
        }
        contact
    }

    /// `∫ max(p - p_c, 0) dA` over the surface itself [N]: k times this is the removal rate [m³/s].
    pub fn load_above(&self, travel: f64, stiffness: f64, threshold_pressure: f64) -> f64 {
        let depths = self.depths(travel);
        let threshold = threshold_pressure / stiffness;
        let squares = (0..depths.len()).filter_map(|i| {
            let square = self.square(&depths, i, travel, threshold)?;
            Some(square.depth * self.columns[i].area_ratio)
        });
        stiffness * self.pitch_along * self.pitch_across * squares.sum::<f64>()
    }

    /// Largest depth [m] under the face, negative: the gap; -∞ where no column meets the surface.
    pub fn depth_max(&self, travel: f64) -> f64 {
        let depths = self.depths(travel);
        let under = (0..depths.len()).filter(|&i| self.cover(i, travel) > 0.0);
        under.map(|i| depths[i]).fold(f64::NEG_INFINITY, f64::max)
    }

    /// Whether the patch ends inside the sampled length.
    pub fn is_whole(&self, travel: f64) -> bool {
        let depths = self.depths(travel);
        let ends = depths.iter().take(self.across).chain(depths.iter().rev().take(self.across));
        ends.fold(f64::NEG_INFINITY, |most, &depth| most.max(depth)) <= 0.0
    }

    /// Surface points under pressure [m].
    pub fn wet_points(&self, travel: f64) -> Vec<DVec3> {
        let depths = self.depths(travel);
        let wet = |&i: &usize| depths[i] > 0.0 && self.cover(i, travel) > 0.0;
        (0..depths.len()).filter(wet).map(|i| self.pose.centre + self.columns[i].offset).collect()
    }

    fn cover(&self, column: usize, travel: f64) -> f64 {
        let axial = (self.columns[column].offset - self.pose.approach * travel).dot(self.pose.axis);
        self.wheel.cover(axial, self.pitch_across)
    }

    /// Mean depth beyond `threshold` and wet share of a column's square; `None` where it is dry.
    fn square(&self, depths: &[f64], column: usize, travel: f64, threshold: f64) -> Option<Square> {
        let depth = depths[column] - threshold;
        // The depth changes by less than a pitch across a square: most are dry without a closer look.
        if depth < -self.pitch_along.max(self.pitch_across) {
            return None;
        }
        let cover = self.cover(column, travel);
        let (along, across) = self.differences(depths, column);
        let spans = (0.5 * along.mean.abs(), 0.5 * across.mean.abs());
        let wet = cover * wet_share(depth, spans);
        let bend = if depth >= spans.0 + spans.1 { (along.bend + across.bend) / 24.0 } else { 0.0 };
        (wet > 0.0).then(|| Square { depth: cover * (ramp_mean(depth, spans) + bend), wet })
    }

    /// Differences of `values` along the feed and across it.
    fn differences(&self, values: &[f64], column: usize) -> (Difference, Difference) {
        let (row, place) = (column / self.across, column % self.across);
        let at = |there: bool, i: usize| if there { values[i] } else { f64::NEG_INFINITY };
        let here = values[column];
        let before = at(row > 0, column.wrapping_sub(self.across));
        let after = at(row + 1 < self.along, column + self.across);
        let left = at(place > 0, column.wrapping_sub(1));
        let right = at(place + 1 < self.across, column + 1);
        (Difference::new(before, here, after), Difference::new(left, here, right))
    }
}

struct Square {
    depth: f64,
    wet: f64,
}

/// First and second difference across a column; a side without a surface does not count.
struct Difference {
    mean: f64,
    bend: f64,
}

impl Difference {
    /// Slope over a `pitch`; where the slopes to either side differ by more than 1, next to a wall, the
    /// gentler one.
    fn slope(&self, pitch: f64) -> f64 {
        let steep = if self.bend.abs() > pitch { 0.5 * self.bend.abs() } else { 0.0 };
        (self.mean.abs() - steep).max(0.0) / pitch
    }

    fn new(before: f64, here: f64, after: f64) -> Self {
        match (before.is_finite(), after.is_finite() && here.is_finite()) {
            (true, true) => Self { mean: 0.5 * (after - before), bend: after - 2.0 * here + before },
            (true, false) if here.is_finite() => Self { mean: here - before, bend: 0.0 },
            (false, true) => Self { mean: after - here, bend: 0.0 },
            _ => Self { mean: 0.0, bend: 0.0 },
        }
    }
}
