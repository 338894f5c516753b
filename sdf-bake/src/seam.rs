//! Distances in a union of two bodies where the nearer surface is not that of the union.

use glam::{DVec3, Vec3};

use crate::grid::BrickGrid;

/// Depth of a nearest surface point inside the other body from which it counts as buried [voxels].
const BURIED: f32 = 0.01;
/// Greatest distance of a seam point from both surfaces [voxels].
const ON_SEAM: f32 = 0.05;
/// Number of Newton steps towards the seam; convergence is quadratic.
const STEPS: usize = 6;
/// Cosine of the angle between two surfaces above which they count as touching instead of crossing.
const PARALLEL: f32 = 0.99;
/// Least slope of a blended field that is used.
const LEAST_SLOPE: f32 = 0.3;

/// Two bodies, each with the sign that makes it part of a union.
pub(crate) struct Bodies<'a> {
    pub(crate) grids: [&'a BrickGrid; 2],
    pub(crate) signs: [f32; 2],
}

impl Bodies<'_> {
    fn sample(&self, body: usize, point: DVec3) -> f32 {
        self.signs[body] * self.grids[body].sample(point)
    }

    fn normal(&self, body: usize, point: DVec3) -> Vec3 {
        self.signs[body] * self.grids[body].normal(point)
    }

    /// Nearest point of a body's surface to a point at signed distance `value` [m].
    fn foot(&self, body: usize, value: f32, point: DVec3) -> DVec3 {
        point - (self.normal(body, point) * value).as_dvec3()
    }

    /// True if a body's surface point nearest to `point` lies inside the other body.
    fn foot_is_buried(&self, body: usize, value: f32, point: DVec3) -> bool {
        self.sample(1 - body, self.foot(body, value, point)) < -BURIED * self.grids[0].voxel as f32
    }

    /// True if the nearer surface is not part of the union's surface; `values` are both distances [m] at `point`.
    pub(crate) fn is_buried(&self, values: [f32; 2], point: DVec3) -> bool {
        let near = usize::from(values[1] < values[0]);
        let depth = -values[near];
        // Beyond that depth, the other body does not reach the nearest point.
        depth > 0.0
            && depth < self.grids[0].band
            && values[1 - near] < depth
            && self.foot_is_buried(near, values[near], point)
    }

    /// Negative distance [m] of a point in the union whose nearer surface is buried; `None` if the seam is not found.
    pub(crate) fn depth(&self, values: [f32; 2], point: DVec3) -> Option<f32> {
        let far = usize::from(values[0] < values[1]);
        let seam = -(self.seam(point)?.distance(point) as f32);
        let clear = values[far] < 0.0 && !self.foot_is_buried(far, values[far], point);
        Some(if clear { seam.max(values[far]) } else { seam })
    }

    /// Point near `point` at which both distances vanish: Newton steps, each to the nearest point of the intersection
    /// line of the two tangent planes.
    fn seam(&self, point: DVec3) -> Option<DVec3> {
        let mut at = point;
        for _ in 0..STEPS {
            let normals = [0, 1].map(|body| self.normal(body, at).as_dvec3());
            let cosine = normals[0].dot(normals[1]);
            let crossing = cosine.abs() < f64::from(PARALLEL);
            if !crossing {
                return None;
            }
            // Distances from `point` along each normal to its plane; then both combined.
            let way = [0, 1].map(|body| -f64::from(self.sample(body, at)) + normals[body].dot(at - point));
            let both = 1.0 - cosine * cosine;
            let share = [(way[0] - cosine * way[1]) / both, (way[1] - cosine * way[0]) / both];
            at = point + normals[0] * share[0] + normals[1] * share[1];
        }
        let near = ON_SEAM * self.grids[0].voxel as f32;
        (self.sample(0, at).abs().max(self.sample(1, at).abs()) < near).then_some(at)
    }

    /// True if a blend of `radius` [m] changes the surface near a point with these distances [m].
    pub(crate) fn feet_are_within(&self, values: [f32; 2], radius: f32, point: DVec3) -> bool {
        let band = self.grids[0].band;
        let near = usize::from(values[1] < values[0]);
        let known = values[0].abs() < band && values[1].abs() < band;
        known
            && (values[0] - values[1]).abs() < radius
            && self.sample(1 - near, self.foot(near, values[near], point)) < radius
    }

    /// Smooth minimum at a point [m], divided by its slope: the distance to its zero set to second order.
    pub(crate) fn blended(&self, [a, b]: [f32; 2], radius: f32, point: DVec3) -> f32 {
        let h = 1.0 - (a - b).abs() / radius;
        let value = a.min(b) - 0.25 * radius * h * h;
        let share = if a < b { 0.5 * h } else { 1.0 - 0.5 * h };
        value / self.normal(0, point).lerp(self.normal(1, point), share).length().max(LEAST_SLOPE)
    }
}
