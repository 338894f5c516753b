//! The surface below a bead: whether it exists, and the root depth that it needs.
//!
//! Rays are cast down on the footprint from above the crown, parallel to the normal of their station:
//!
//! ```text
//!      |   |   |   |   |        from `lift` above the tangent plane
//!      |   v---v---v   |
//!      v--'         '--v        the surface: its sag determines the root depth
//! ```

use std::f64::consts::PI;

use glam::DVec3;
use sdf_bake::Mesh;
use sdf_bake::query::MeshQuery;

use crate::bead::BeadProfile;
use crate::curve::{CurvePoint, WeldCurve};
use crate::rejection::Rejection;

/// Offsets across the bead, as shares of half the base.
const ACROSS: [f64; 8] = [-1.0, -0.75, -0.5, -0.25, 0.25, 0.5, 0.75, 1.0];
/// Directions of the round ends, in steps of π/6.
const AROUND: [f64; 5] = [1.0, 2.0, 3.0, 4.0, 5.0];
/// Largest angle [rad] between the curve's normal and the surface under the bead.
const MAX_TILT: f64 = 0.8;
/// Margin between the surface and the root, as a share of the bead's height.
const ROOT_MARGIN: f64 = 0.1;
/// Greatest rise of the surface under a toe that does not count as a wall, as a share of the bead's height.
const MAX_RISE: f64 = 0.3;

/// Measurement of the surface below a bead.
pub(crate) struct Footprint<'a> {
    pub(crate) mesh: &'a Mesh,
    pub(crate) query: &'a MeshQuery,
    pub(crate) profile: BeadProfile,
}

impl Footprint<'_> {
    /// Returns the root depth [m] that puts the whole base below the surface, or the reason why the bead does not fit.
    ///
    /// A deeper root widens the base, which may require a still deeper root; the height of the bead is the limit.
    pub(crate) fn root_depth(&self, curve: &WeldCurve) -> Result<f64, Rejection> {
        let margin = ROOT_MARGIN * self.profile.height;
        let mut depth = margin;
        for _ in 0..12 {
            let needed = self.survey(curve, depth)? + margin;
            if needed <= depth {
                return Ok(depth);
            }
            if needed > self.profile.height {
                return Err(Rejection::DeepRoot);
            }
            depth = 1.02 * needed;
        }
        Err(Rejection::DeepRoot)
    }

    /// Greatest sag [m] of the surface below the tangent plane under the base of a bead with this root depth.
    fn survey(&self, curve: &WeldCurve, depth: f64) -> Result<f64, Rejection> {
        let base = self.profile.half_width_at(depth);
        let stride = (curve.points.len() / 8).clamp(1, 2);
        let mut sag = 0f64;
        for point in curve.points.iter().step_by(stride) {
            self.beside(point, base)?;
            for across in ACROSS {
                sag = sag.max(-self.ground(point, across * base * point.side, depth)?);
            }
        }
        let ends = [(curve.points.first(), -1.0), (curve.points.last(), 1.0)];
        for (point, ahead) in ends.into_iter().filter_map(|(point, ahead)| Some((point?, ahead))) {
            for (turn, share) in AROUND.into_iter().flat_map(|turn| [(turn, 0.5), (turn, 1.0)]) {
                let (sin, cos) = (turn * PI / 6.0).sin_cos();
                let out = ahead * sin * point.tangent + cos * point.side;
                sag = sag.max(-self.ground(point, share * base * out, depth)?);
            }
        }
        Ok(sag)
    }

    /// Checks that no wall stands within the base, seen from half the bead's height.
    fn beside(&self, point: &CurvePoint, base: f64) -> Result<(), Rejection> {
        let eye = point.position + 0.5 * self.profile.height * point.normal;
        let walled = [point.side, -point.side].iter().any(|side| self.query.occluded(eye, *side, base));
        if walled { Err(Rejection::Wall) } else { Ok(()) }
    }

    /// Height [m] of the surface above the tangent plane at an offset; the sheet must be thicker than the root there.
    fn ground(&self, point: &CurvePoint, offset: DVec3, depth: f64) -> Result<f64, Rejection> {
        let height = self.profile.height;
        let lift = 1.2 * height;
        let origin = point.position + offset + lift * point.normal;
        let down = -point.normal;
        let hit = self.query.ray(origin, down, lift + 1.1 * height).ok_or(Rejection::Hole)?;
        let ground = lift - hit.distance;
        if ground > MAX_RISE * height {
            return Err(Rejection::Wall);
        }
        let upright = self.mesh.normal(hit.triangle as usize).dot(point.normal) > MAX_TILT.cos();
        if !upright {
            return Err(Rejection::Tilt);
        }
        let skin = 1e-4 * height;
        let below = origin + (hit.distance + skin) * down;
        let thick = !self.query.occluded(below, down, 1.1 * (depth + ground.max(0.0)));
        if thick { Ok(ground) } else { Err(Rejection::Thin) }
    }
}
