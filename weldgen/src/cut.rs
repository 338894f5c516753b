//! Imperfections that remove metal: closed bodies to be subtracted from the welded part.
//!
//! ```text
//!            .--'''--.                    |    |
//!         .-'         '-.               .-|    |-.       burn-through: bead and sheet
//!   -----o---------------o.  .----   ---o-|    |-o---
//!                          ''            -|    |----
//!       an undercut beside the toe
//! ```

use std::f64::consts::TAU;

use glam::DVec3;
use rand::RngExt;
use sdf_bake::Mesh;

use crate::bead::loft::loft;
use crate::bead::{BeadForm, BeadProfile, Defect, DefectKind, FormRequest, WIDEST_GROOVE};
use crate::curve::{CurvePoint, WeldCurve};
use crate::rejection::Rejection;
use crate::surface::Surface;

/// Positions tried for one imperfection.
const TRIES: usize = 8;
/// Number of points around a groove or a hole.
const AROUND: u32 = 16;
/// Greatest angle [rad] between the surface beside a toe and at it.
const MAX_TILT: f64 = 0.35;
/// Greatest thickness that burns through [bead widths].
const THICKEST: f64 = 1.0;
/// Distance by which a hole extends beyond the far side [bead widths]; this space must be free.
const BEYOND: f64 = 0.15;

/// Bodies that are removed, and their imperfections.
#[derive(Default)]
pub(crate) struct Cuts {
    /// Closed bodies [m], normals outwards.
    pub(crate) bodies: Mesh,
    pub(crate) defects: Vec<Defect>,
}

/// A bead on its surface.
#[derive(Clone, Copy)]
pub(crate) struct PlacedBead<'a> {
    pub(crate) surface: &'a Surface<'a>,
    pub(crate) curve: &'a WeldCurve,
    pub(crate) profile: &'a BeadProfile,
    pub(crate) form: &'a BeadForm,
}

impl PlacedBead<'_> {
    /// Makes the requested undercut and holes, or returns the reason why the surface allows none.
    pub(crate) fn cuts(&self, request: &FormRequest, rng: &mut impl RngExt) -> Result<Cuts, Rejection> {
        let mut cuts = Cuts::default();
        let mut add = |(body, defect): (Mesh, Defect)| {
            cuts.bodies.append(&body);
            cuts.defects.push(defect);
        };
        if request.undercut > 0.0 {
            let depth = request.undercut * self.profile.height;
            add((0..TRIES).find_map(|_| self.undercut(depth, rng)).ok_or(Rejection::Tilt)?);
        }
        for _ in 0..request.burn_through {
            add((0..TRIES).find_map(|_| self.burn_through(rng)).ok_or(Rejection::Thick)?);
        }
        Ok(cuts)
    }

    /// True if no surface rises into the lobe of an overlap.
    pub(crate) fn overlaps_hang_free(&self) -> bool {
        let free = |defect: &Defect| {
            let at = |point: &&CurvePoint| (point.arc_length - defect.arc_length).abs() < 0.25 * defect.size;
            let clear = |point: &CurvePoint| {
                let aside =
                    self.form.made_offset(point.arc_length, defect.offset) + defect.depth.copysign(defect.offset);
                let over = point.position + aside * point.side + self.profile.height * point.normal;
                !self.surface.query.occluded(over, -point.normal, 0.95 * self.profile.height)
            };
            self.curve.points.iter().filter(at).all(clear)
        };
        self.form.defects().iter().filter(|defect| defect.kind == DefectKind::Overlap).all(free)
    }

    /// Makes a groove one to three widths long and 0.2 to 0.3 widths wide, a half ellipse across and along.
    fn undercut(&self, depth: f64, rng: &mut impl RngExt) -> Option<(Mesh, Defect)> {
        let (length, width) = (self.curve.length(), self.profile.width);
        let size = (width * (1.0 + 2.0 * rng.random::<f64>())).min(0.8 * length);
        let middle = 0.5 * size + (length - size) * rng.random::<f64>();
        let half = 0.5 * WIDEST_GROOVE * width * (0.7 + 0.3 * rng.random::<f64>());
        let left = if rng.random::<bool>() { 1.0 } else { -1.0 };
        let along = |point: &CurvePoint| 2.0 * (point.arc_length - middle) / size;
        let points = self.curve.points.iter().filter(|point| along(point).abs() <= 1.0);
        let places: Vec<(f64, [DVec3; 3])> = points
            .map(|point| Some((along(point), self.beside_toe(point, left * half, depth)?)))
            .collect::<Option<_>>()?;
        let [(_, [first, ..]), inner @ .., (_, [last, ..])] = &places[..] else { return None };
        let ring = |(along, [centre, out, up]): &(f64, [DVec3; 3])| {
            let swell = (1.0 - along * along).sqrt();
            let point = |i: u32| {
                let (sin, cos) = (TAU * f64::from(i) / f64::from(AROUND)).sin_cos();
                // Seen from ahead, left and right are exchanged: counter-clockwise runs from the left over the top.
                *centre + swell * (left * half * cos * *out + depth * sin * *up)
            };
            (0..AROUND).map(point).collect::<Vec<DVec3>>()
        };
        let rings: Vec<Vec<DVec3>> = inner.iter().map(ring).collect();
        let offset = self.form.made_offset(middle, left * 0.5 * width) + left * half;
        let defect = Defect { kind: DefectKind::Undercut, arc_length: middle, offset, size, depth };
        (!rings.is_empty()).then(|| (loft(&rings, [*first, *last]), defect))
    }

    /// Returns the surface point at a distance outwards from a toe, the outward direction along the surface, and the
    /// surface normal, both perpendicular to the curve. `None` if the surface bends away, or the part is thinner than
    /// twice the depth.
    ///
    /// - `off`: distance [m], negative on the right
    fn beside_toe(&self, point: &CurvePoint, off: f64, depth: f64) -> Option<[DVec3; 3]> {
        let Surface { query, part, .. } = self.surface;
        let (profile, s) = (self.profile, point.arc_length);
        let toe = self.form.made_offset(s, (0.5 * profile.width).copysign(off));
        let at = point.position + toe * point.side + profile.toe_height * point.normal;
        let foot = query.closest_within(at, 0.5 * profile.height)?;
        let upright = part.normal(foot.triangle as usize);
        let up = upright.reject_from_normalized(point.tangent).try_normalize()?;
        let out = up.cross(point.tangent) * off.signum();
        let ground = query.closest_within(foot.point + off.abs() * out, 0.5 * off.abs())?;
        let even = part.normal(ground.triangle as usize).dot(upright) > MAX_TILT.cos();
        let skin = 1e-4 * profile.height;
        let thick = !query.occluded(ground.point - skin * up, -up, 2.0 * depth);
        (even && thick).then_some([ground.point, out, up])
    }

    /// Makes a hole 0.3 to 0.4 widths in diameter through bead and part.
    fn burn_through(&self, rng: &mut impl RngExt) -> Option<(Mesh, Defect)> {
        let BeadProfile { width, height, .. } = *self.profile;
        let radius = width * (0.15 + 0.05 * rng.random::<f64>());
        let count = self.curve.points.len();
        let point = &self.curve.points[(count as f64 * (0.2 + 0.6 * rng.random::<f64>())) as usize];
        let shift = self.form.shift(point.arc_length);
        let centre = point.position + shift * point.side;
        let around = |radius: f64, z: f64| -> Vec<DVec3> {
            let at = |i: u32| {
                let (sin, cos) = (TAU * f64::from(i) / f64::from(AROUND)).sin_cos();
                centre + radius * (cos * point.tangent + sin * point.side) + z * point.normal
            };
            (0..AROUND).map(at).collect()
        };
        let rim = around(radius, 0.0).into_iter().step_by(4).chain([centre]);
        let depths: Vec<f64> = rim.map(|at| self.far_side(at, point.normal)).collect::<Option<_>>()?;
        let depth = depths.into_iter().fold(0.0, f64::max);
        let (top, bottom) = (2.0 * height, -(depth + BEYOND * width));
        let rings = [around(radius, bottom), around(radius, top)];
        let ends = [bottom, top].map(|z| centre + z * point.normal);
        let (arc_length, size) = (point.arc_length, 2.0 * radius);
        let defect = Defect { kind: DefectKind::BurnThrough, arc_length, offset: shift, size, depth: depth + height };
        Some((loft(&rings, ends), defect))
    }

    /// Depth [m] of the part's far side below a point near its surface, if the part is thin there and free space
    /// follows.
    fn far_side(&self, place: DVec3, normal: DVec3) -> Option<f64> {
        let BeadProfile { width, height, .. } = *self.profile;
        let (query, skin) = (self.surface.query, 1e-4 * height);
        let lift = 1.5 * height;
        let ground = query.ray(place + lift * normal, -normal, 2.0 * lift)?.distance - lift;
        let inside = place - (ground + skin) * normal;
        let depth = ground + skin + query.ray(inside, -normal, THICKEST * width)?.distance;
        let beyond = place - (depth + skin) * normal;
        (!query.occluded(beyond, -normal, 2.0 * BEYOND * width)).then_some(depth)
    }
}
