//! Share of a light that reaches a point of the surface, by sphere tracing (Hart 1996).
//!
//! Lengths are in voxels, from the lowest voxel of the index. [`ShadowRays::share`] is the twin of `light_share_along`
//! in `walk.wgsl`.

use glam::{Vec3, Vec3A};
pub(crate) use shaders::constants::LEAST_STEP;
pub(crate) use shaders::constants::PENUMBRA_BAND;

use super::field::Field;
use super::walk::{Line, indexed_size, nudge};

/// Greatest change of φ per length: 1 for an exact distance, slightly more where trilinear cells bend it.
pub(crate) const STEEPEST: f32 = 1.1;

/// Rays towards a light.
pub(crate) struct ShadowRays<'a> {
    pub(crate) field: &'a Field<'a>,
    pub(crate) line: Line,
    /// Size of the indexed box.
    pub(crate) size: Vec3A,
    /// Tangent of the light's half angle.
    pub(crate) spread: f32,
    pub(crate) nudge: f32,
    /// Greatest radius of the light's cone.
    pub(crate) cap: f32,
}

impl<'a> ShadowRays<'a> {
    /// `direction`: unit vector towards the light.
    pub(crate) fn new(field: &'a Field<'a>, direction: Vec3, spread: f32) -> Self {
        let band = field.grid.band * field.per_metre as f32;
        Self {
            field,
            line: Line::new(direction.into()),
            size: indexed_size(field).into(),
            spread,
            nudge: nudge(field),
            cap: PENUMBRA_BAND * band,
        }
    }

    /// Share of the light that reaches a point, 0 to 1: the least clearance along the ray relative to the radius of the
    /// light's cone there (after Quilez 2010), with the cone's radius limited to the band.
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

    /// Radius of the light's cone at a distance from the point.
    #[inline]
    pub(crate) fn cone(&self, distance: f32) -> f32 {
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
        let towards = ShadowRays::new(&field, Vec3::Z, 0.1);
        let share = |y: f64| towards.share(in_voxels(&field, [0.0, y, -0.1]));
        assert_eq!((share(0.0), share(0.013)), (0.0, 1.0));
        let penumbra = share(0.0106);
        assert!(penumbra > 0.2 && penumbra < 0.8, "{penumbra}");
    }
}
