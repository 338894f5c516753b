//! How much of a light reaches points of the surface, by sphere tracing (Hart 1996).
//!
//! ```text
//!   ↗ ↗ ↗ ↗ ↗     rays of neighbouring points towards one lamp run side by side. One ray in their middle tells for all
//!   · · ◉ · ·     of them, as φ changes by no more than the distance: what is far enough from the middle's cone is
//!  ───────────    clear of all cones, and what is deep in the metal there is in the metal for all.
//! ```
//!
//! Lengths are in voxels, from the lowest voxel of the index. [`Towards::share`] is the twin of `light_share_along` in
//! `walk.wgsl`.

use glam::{Vec3, Vec3A, Vec4};

use super::field::Field;
use super::four::Four;
use super::walk::{BRICK_SHIFT, Line, indexed_size, nudge};

/// Part of the band over which a penumbra is drawn; beyond it φ is truncated and says nothing.
const PENUMBRA_BAND: f32 = 0.9;
/// Least step towards a light [voxels]: what throws no shadow is thinner than this.
const LEAST_STEP: f32 = 0.5;
/// What φ changes along a length: 1 for a distance, a little more where trilinear cells bend.
pub(crate) const STEEPEST: f32 = 1.1;
/// Largest distance of a ray from the one that tells for it [voxels]: farther ones are seldom as clear as that.
const MOST_APART: f32 = 0.45;
/// Points whose rays go in lanes.
const FOUR: usize = 4;

/// Rays towards a light.
pub(crate) struct Towards<'a> {
    field: &'a Field<'a>,
    line: Line,
    /// Size of the indexed box.
    size: Vec3A,
    /// Tangent of the light's half angle.
    spread: f32,
    nudge: f32,
    /// Cap of the light's cone.
    cap: f32,
    band: f32,
}

impl<'a> Towards<'a> {
    /// `direction`: unit vector to the light.
    pub(crate) fn new(field: &'a Field<'a>, direction: Vec3, spread: f32) -> Self {
        let band = field.grid.band * field.per_metre as f32;
        Self {
            field,
            line: Line::new(direction.into()),
            size: indexed_size(field).into(),
            spread,
            nudge: nudge(field),
            cap: PENUMBRA_BAND * band,
            band,
        }
    }

    /// Unit vector to the light.
    pub(crate) fn direction(&self) -> Vec3 {
        self.line.direction.into()
    }

    /// Share of the light that reaches a point, 0 to 1: the least clearance along the ray against the radius of the
    /// light's cone there (after Quilez 2010), the cone capped at the band.
    pub(crate) fn share(&self, start: Vec3) -> f32 {
        let start = Vec3A::from(start);
        let (mut t, end) = self.line.span(start, (Vec3A::ZERO, self.size), 0.0);
        let mut share = 1f32;
        while t < end {
            let at = start + self.line.direction * t;
            match self.field.clearance(&self.line, at) {
                Err(free) => t += self.line.length_in_free(at, free) + self.nudge,
                Ok(clearance) => {
                    let is_outside = clearance > 0.0;
                    if !is_outside {
                        return 0.0;
                    }
                    let cone = self.cone(t);
                    if clearance < share * cone {
                        share = clearance / cone;
                    }
                    t += clearance.max(LEAST_STEP);
                }
            }
        }
        share
    }

    /// The shares of several points; neighbours in the list had better be neighbours in space.
    pub(crate) fn shares(&self, starts: &[Vec3], shares: &mut [f32]) {
        if starts.len() > 1
            && let Some(share) = self.common_share(starts)
        {
            shares.fill(share);
        } else if starts.len() > FOUR {
            starts.chunks(FOUR).zip(shares.chunks_mut(FOUR)).for_each(|(starts, shares)| self.shares(starts, shares));
        } else if !starts.is_empty() {
            let last = starts.len() - 1;
            let own = |starts: &[Vec3]| self.shares_of_four(std::array::from_fn(|i| starts[i.min(last)]));
            shares.iter_mut().zip(own(starts)).for_each(|(share, own)| *share = own);
        }
    }

    /// [`Towards::share`] of four points.
    fn shares_of_four(&self, starts: [Vec3; FOUR]) -> [f32; FOUR] {
        let ends = starts.map(|start| self.line.span(start.into(), (Vec3A::ZERO, self.size), 0.0));
        let (starts, direction) = (Four::of(&starts), self.line.direction);
        let (mut t, end) = (Vec4::from(ends.map(|span| span.0)), Vec4::from(ends.map(|span| span.1)));
        let backward = [0, 1, 2].map(|axis| self.line.backward.test(axis));
        let mut share = Vec4::ONE;
        let mut under_way = t.cmplt(end);
        while under_way.any() {
            let at = starts.moved(direction, t);
            let low = at.corners(backward);
            let (mut values, mut stride) = ([[self.field.grid.band; 8]; FOUR], [0.0; FOUR]);
            for (lane, corner) in low.integers().into_iter().enumerate() {
                let brick = corner >> BRICK_SHIFT;
                match self.field.index.entry(brick).to_brick {
                    0 => values[lane] = self.field.cell_phi(corner),
                    free => stride[lane] = self.line.length_in_free(at.point(lane), (brick, free)) + self.nudge,
                }
            }
            let (stride, clearance) = (Vec4::from(stride), at.trilinear(&low, &values) * self.field.per_metre as f32);
            let is_near = under_way & stride.cmpeq(Vec4::ZERO);
            let is_dark = is_near & !clearance.cmpgt(Vec4::ZERO);
            let cone = (self.spread * t).min(Vec4::splat(self.cap));
            let is_less = is_near & clearance.cmplt(share * cone);
            share = Vec4::select(is_dark, Vec4::ZERO, Vec4::select(is_less, clearance / cone, share));
            t += Vec4::select(stride.cmpgt(Vec4::ZERO), stride, clearance.max(Vec4::splat(LEAST_STEP)));
            under_way &= t.cmplt(end) & !is_dark;
        }
        share.to_array()
    }

    /// 1 or 0 where the ray in the middle of several shows that it is the share of them all.
    fn common_share(&self, starts: &[Vec3]) -> Option<f32> {
        let (low, high) =
            starts.iter().fold((Vec3::INFINITY, Vec3::NEG_INFINITY), |(low, high), p| (low.min(*p), high.max(*p)));
        let middle = 0.5 * (low + high);
        let apart = starts.iter().map(|start| start.distance_squared(middle)).fold(0.0, f32::max).sqrt();
        let is_close = apart <= MOST_APART;
        if !is_close {
            return None;
        }
        let doubt = STEEPEST * apart;
        let middle = Vec3A::from(middle);
        let (mut t, end) = self.line.span(middle, (Vec3A::ZERO, self.size), 0.0);
        let mut is_lit = true;
        while t < end {
            let at = middle + self.line.direction * t;
            let clearance = match self.field.clearance(&self.line, at) {
                Ok(clearance) => clearance,
                // All rays are within the cube that is smaller by a brick.
                Err((brick, distance @ 2..)) => {
                    t += self.line.length_in_free(at, (brick, distance - 1)) + self.nudge;
                    continue;
                }
                Err(free) => {
                    t += self.line.length_in_free(at, free) + self.nudge;
                    is_lit &= self.cone(t) <= self.band - doubt;
                    continue;
                }
            };
            if clearance < -(doubt + LEAST_STEP) {
                return Some(0.0);
            }
            // No finer than the steps of a single ray.
            let slack = clearance - doubt - self.cone(t);
            is_lit &= slack > 0.0;
            t += (if is_lit { slack / (STEEPEST + self.spread) } else { clearance }).max(LEAST_STEP);
        }
        is_lit.then_some(1.0)
    }

    /// Radius of the light's cone at a distance from the point.
    #[inline]
    fn cone(&self, distance: f32) -> f32 {
        (self.spread * distance).min(self.cap)
    }
}

#[cfg(test)]
mod tests {
    use glam::DVec3;
    use sdf_bake::BrickGrid;

    use super::*;

    const VOXEL: f64 = 0.0005;

    fn in_voxels(field: &Field, point: [f64; 3]) -> Vec3 {
        field.in_voxels(DVec3::from(point))
    }

    #[test]
    fn shadow_is_full_behind_the_ball_and_none_beside_it() {
        let distance = |p: DVec3| p.length() - 0.01;
        let grid = BrickGrid::from_distance(DVec3::splat(-0.01), DVec3::splat(0.01), VOXEL, 3.0, distance);
        let field = Field::new(&grid);
        let towards = Towards::new(&field, Vec3::Z, 0.1);
        let share = |y: f64| towards.share(in_voxels(&field, [0.0, y, -0.1]));
        assert_eq!((share(0.0), share(0.013)), (0.0, 1.0));
        let penumbra = share(0.0106);
        assert!(penumbra > 0.2 && penumbra < 0.8, "{penumbra}");
    }

    #[test]
    fn one_ray_tells_of_its_neighbours_what_their_own_rays_do() {
        // A rib on a plate: lit, in its shadow and between.
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
        let towards = Towards::new(&field, Vec3::new(-0.7, 0.1, 0.9).normalize(), 0.15);
        let mut told = [0; 2];
        for i in 0..1500 {
            let x = -0.019 + 0.038 * f64::from(i) / 1500.0;
            let start = |j: usize| {
                let (dx, dy) = (6e-5 * (j % 4) as f64, 6e-5 * (j / 4) as f64);
                in_voxels(&field, [x + dx, 0.003 + dy, 0.001]) + 0.6 * Vec3::Z
            };
            let starts: [Vec3; 16] = std::array::from_fn(start);
            let own = starts.map(|start| towards.share(start));
            let mut shares = [f32::NAN; 16];
            towards.shares(&starts, &mut shares);
            assert_eq!(shares, own, "at x = {x}");
            if let Some(share) = towards.common_share(&starts) {
                told[usize::from(share > 0.5)] += 1;
            }
        }
        assert!(told[0] > 100 && told[1] > 600 && told[0] + told[1] < 1500, "{told:?}");
    }
}
