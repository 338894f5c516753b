//! Share of a lamp's light that reaches the samples of a tile.
//!
//! ```text
//!   ↗ ↗ ↗ ↗ ↗     rays of neighbouring points towards one lamp run side by side. One central ray decides for all of
//!   · · ◉ · ·     them, since φ changes by no more than the distance: with enough clearance from the central cone all
//!  ───────────    cones are clear, and a point deep in the metal is in the metal for all. Otherwise each ray is traced
//!                 alone, in lanes.
//! ```
//!
//! Each share equals that of [`ShadowRays::share`]. Lengths are in voxels, from the lowest voxel of the index.

use glam::{IVec3, Vec3, Vec3A};

use super::field::Field;
use super::index::BEYOND;
use super::lanes::{Directions, LANES, Lanes, Points, any, larger, smaller};
use super::padded::Cells;
use super::shadow::{LEAST_STEP, STEEPEST, ShadowRays};
use super::skyline::Skyline;
use super::walk::{BRICK_SHIFT, integers};

/// Greatest distance of a ray from the central ray that decides for it [voxels]; rays farther away are seldom clear
/// together.
const MOST_APART: f32 = 0.45;

/// Greatest number of steps of the central ray towards the light, and of its search for metal; after them rays are
/// traced one by one.
const MOST_STEPS: usize = 24;
/// Height of a clearance ball's centre above the start of a ray, as a share of the band; φ is still exact there.
const BALL_HEIGHT: f32 = 0.75;

/// Rays towards a lamp from any tile.
pub(crate) struct LampRays<'a> {
    towards: ShadowRays<'a>,
    directions: Directions,
    skyline: Skyline,
    band: f32,
}

impl<'a> LampRays<'a> {
    /// `direction`: unit vector towards the lamp; `spread`: tangent of its half angle.
    pub(crate) fn new(field: &'a Field<'a>, direction: Vec3, spread: f32) -> Self {
        Self {
            towards: ShadowRays::new(field, direction, spread),
            directions: Directions::all(direction),
            skyline: Skyline::new(field.padded(), direction),
            band: field.grid.band * field.per_metre as f32,
        }
    }

    /// Unit vector towards the lamp.
    pub(crate) fn direction(&self) -> Vec3 {
        self.towards.line.direction.into()
    }

    /// Light shares of the `wanted` points of a tile; 0 for the others.
    ///
    /// `starts`: ray starts; `normals`: normals of the surface below them.
    pub(crate) fn shares(&self, starts: &Points, normals: &Points, wanted: &[bool; LANES]) -> Lanes {
        pulp::Arch::new().dispatch(LightVisibility { beam: self, starts, normals, wanted })
    }

    /// [`Field::clearance`] along this lamp's direction.
    #[inline(always)]
    fn clearance(&self, at: Vec3A) -> Result<f32, (IVec3, u8)> {
        let ShadowRays { field, line, .. } = &self.towards;
        let low = line.corner(at);
        let corner = integers(low);
        let brick = corner >> BRICK_SHIFT;
        let Some(place) = field.index.place(brick) else { return Err((brick, BEYOND.to_brick)) };
        match field.index.at(place).to_brick {
            0 => Ok(field.padded().phi(place, corner, (at - low).into()) * field.per_metre as f32),
            distance => Err((brick, distance)),
        }
    }

    /// Length of the central ray for which a ball without metal above its start proves that the cones of all rays are
    /// clear; 0 if it proves nothing.
    ///
    /// `above`: unit vector from the surface; `doubt`: greatest difference of φ between the central ray and the others
    /// [voxels].
    #[inline(always)]
    fn length_in_ball(&self, start: Vec3A, above: Vec3A, doubt: f32) -> f32 {
        let towards = &self.towards;
        let height = BALL_HEIGHT * self.band;
        let clearance = self.clearance(start + above * height).unwrap_or(self.band);
        // The ball, and the cone relative to the length of the ray, both in lengths over which φ may change as much.
        let (radius, slope) = ((clearance - doubt) / STEEPEST, towards.spread / STEEPEST);
        let (square, within) = (1.0 - slope * slope, radius * radius - height * height);
        let is_clear = (radius > height) & (square > 0.0);
        if !is_clear {
            return 0.0;
        }
        let half = height * above.dot(towards.line.direction) - radius * slope;
        (half + (half * half + square * within).sqrt()) / square
    }

    /// Share common to all rays, 1 or 0, if the central ray proves it.
    #[inline(always)]
    fn common_share(&self, starts: &Points, normals: &Points, wanted: &[bool; LANES]) -> Option<f32> {
        let towards = &self.towards;
        let (middle, apart) = starts.around(wanted);
        let is_close = apart <= MOST_APART;
        if !is_close {
            return None;
        }
        let doubt = STEEPEST * apart;
        let clear = self.skyline.length(middle, apart);
        let middle = Vec3A::from(middle);
        let (mut t, end) = towards.line.span(middle, (Vec3A::ZERO, towards.size), 0.0);
        let end = end.min(clear);
        if t < end {
            let above = normals.get(wanted.iter().position(|wanted| *wanted).unwrap_or(0));
            t = t.max(self.length_in_ball(middle, above.into(), doubt));
        }
        for _ in 0..MOST_STEPS {
            let is_under_way = t < end;
            if !is_under_way {
                return Some(1.0);
            }
            let at = middle + towards.line.direction * t;
            let clearance = match self.clearance(at) {
                Ok(clearance) => clearance,
                // All rays are within the cube that is smaller by one brick.
                Err((brick, distance @ 2..)) => {
                    t += towards.line.length_in_free(at, (brick, distance - 1)) + towards.nudge;
                    continue;
                }
                Err(free) => {
                    let length = towards.line.length_in_free(at, free) + towards.nudge;
                    let is_clear = towards.cone(t + length) <= self.band - doubt;
                    if !is_clear {
                        break;
                    }
                    t += length;
                    continue;
                }
            };
            let slack = clearance - doubt - towards.cone(t);
            let is_clear = slack > 0.0;
            if !is_clear {
                break;
            }
            // At least the step of a single ray.
            t += (slack / (STEEPEST + towards.spread)).max(LEAST_STEP);
        }
        self.meets_metal(middle, (t, end), doubt).then_some(0.0)
    }

    /// True if the central ray has a point so deep in the metal that all rays are inside it for longer than their least
    /// step.
    #[inline(always)]
    fn meets_metal(&self, middle: Vec3A, (mut t, end): (f32, f32), doubt: f32) -> bool {
        let line = &self.towards.line;
        for _ in 0..MOST_STEPS {
            let is_under_way = t < end;
            if !is_under_way {
                return false;
            }
            let at = middle + line.direction * t;
            match self.clearance(at) {
                Err(free) => t += line.length_in_free(at, free) + self.towards.nudge,
                Ok(clearance) if clearance < -(doubt + LEAST_STEP) => return true,
                Ok(clearance) => t += (clearance + doubt + LEAST_STEP).max(LEAST_STEP),
            }
        }
        false
    }
}

/// Light shares of a tile's points, each by its own ray; compiled by `pulp` for each instruction set.
struct LightVisibility<'a> {
    beam: &'a LampRays<'a>,
    starts: &'a Points,
    normals: &'a Points,
    wanted: &'a [bool; LANES],
}

impl pulp::NullaryFnOnce for LightVisibility<'_> {
    type Output = Lanes;

    #[inline(always)]
    fn call(self) -> Lanes {
        let Self { beam: LampRays { towards, directions, .. }, starts, normals, wanted } = self;
        if let Some(common) = self.beam.common_share(starts, normals, wanted) {
            return wanted.map(|wanted| if wanted { common } else { 0.0 });
        }
        let field = towards.field;
        let (padded, per_metre) = (field.padded(), field.per_metre as f32);
        let (mut t, end) = self.spans();
        let (mut share, mut under_way) = ([0.0; LANES], [false; LANES]);
        for i in 0..LANES {
            share[i] = if wanted[i] { 1.0 } else { 0.0 };
            under_way[i] = wanted[i] & (t[i] < end[i]);
        }
        let mut cells = Cells::new(field.grid.band);
        while any(&under_way) {
            let at = starts.moved(&directions.along, &t);
            cells.low = at.corners(&directions.along);
            padded.read(&under_way, &mut cells);
            for i in 0..LANES {
                let (point, low) = (at.get(i), cells.low.get(i));
                let is_free = cells.to_brick[i] > 0;
                let (cube, side) = cells.free_cube(i, cells.to_brick[i]);
                let stride = directions.length_in(i, point, cube, side) + towards.nudge;
                let clearance = cells.phi(i, point - low) * per_metre;
                let cone = smaller(towards.spread * t[i], towards.cap);
                let is_near = under_way[i] & !is_free;
                let is_outside = clearance > 0.0;
                let is_dark = is_near & !is_outside;
                let is_less = is_near & (clearance < share[i] * cone);
                let less = if is_less { clearance / cone } else { share[i] };
                share[i] = if is_dark { 0.0 } else { less };
                t[i] += if is_free { stride } else { larger(clearance, LEAST_STEP) };
                under_way[i] &= (t[i] < end[i]) & !is_dark;
            }
        }
        share
    }
}

impl LightVisibility<'_> {
    /// Interval of each ray within the indexed box, up to the length at which it is clear. Inlined into the call, like
    /// all functions that it calls.
    #[inline(always)]
    fn spans(&self) -> (Lanes, Lanes) {
        let LampRays { towards, directions, skyline, .. } = self.beam;
        let mut ends = skyline.lengths(self.starts);
        let mut begins = [0.0; LANES];
        for i in 0..LANES {
            let (point, along, inverse) = (self.starts.get(i), directions.along.get(i), directions.inverse.get(i));
            for axis in 0..3 {
                let (low, high) = (-point[axis] * inverse[axis], (towards.size[axis] - point[axis]) * inverse[axis]);
                let (near, far) = if along[axis] < 0.0 { (high, low) } else { (low, high) };
                begins[i] = larger(begins[i], near);
                ends[i] = smaller(ends[i], far);
            }
        }
        (begins, ends)
    }
}

#[cfg(test)]
mod tests {
    use glam::DVec3;
    use sdf_bake::BrickGrid;

    use super::*;

    const VOXEL: f64 = 0.0005;

    #[test]
    fn one_ray_tells_of_its_neighbours_what_their_own_rays_do() {
        // A rib on a plate: points in light, in shadow and in the penumbra.
        let cuboid = |p: DVec3, centre: DVec3, half: DVec3| {
            let q = (p - centre).abs() - half;
            q.max(DVec3::ZERO).length() + q.max_element().min(0.0)
        };
        let shape = move |p: DVec3| {
            let plate = cuboid(p, DVec3::ZERO, DVec3::new(0.02, 0.01, 0.001));
            plate.min(cuboid(p, DVec3::new(0.0, 0.0, 0.005), DVec3::new(0.0011, 0.01, 0.005)))
        };
        let half = DVec3::new(0.02, 0.01, 0.01);
        let grid = BrickGrid::from_distance(-half, half, VOXEL, 3.0, shape);
        let field = Field::new(&grid);
        let beam = LampRays::new(&field, Vec3::new(-0.7, 0.1, 0.9).normalize(), 0.15);
        let mut told = [0; 2];
        for i in 0..1500 {
            let x = -0.019 + 0.038 * f64::from(i) / 1500.0;
            let start = |j: usize| {
                let (dx, dy) = (6e-5 * (j % 4) as f64, 6e-5 * (j / 4) as f64);
                field.in_voxels(DVec3::new(x + dx, 0.003 + dy, 0.001)) + 0.6 * Vec3::Z
            };
            let mut starts = Points::ZERO;
            let normals = Points { z: [1.0; LANES], ..Points::ZERO };
            (0..LANES).for_each(|lane| starts.set(lane, start(lane)));
            let wanted: [bool; LANES] = std::array::from_fn(|lane| (i + lane as i32) % 7 != 0);
            let own: Lanes =
                std::array::from_fn(|lane| if wanted[lane] { beam.towards.share(start(lane)) } else { 0.0 });
            assert_eq!(beam.shares(&starts, &normals, &wanted), own, "at x = {x}");
            if let Some(share) = beam.common_share(&starts, &normals, &wanted) {
                told[usize::from(share > 0.5)] += 1;
            }
        }
        assert!(told[0] > 100 && told[1] > 600 && told[0] + told[1] < 1500, "{told:?}");
    }
}
