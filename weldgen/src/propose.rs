//! One proposal: a random curve, and every reason why a bead might not fit on it.

use glam::DVec3;
use rand::{RngExt, SeedableRng};
use rand_pcg::Pcg64Mcg;
use sdf_bake::Mesh;

use crate::bead::{BeadProfile, sweep};
use crate::curvature::CurvatureProfile;
use crate::curve::{CurvePoint, Stretch, WeldCurve};
use crate::exposure::{ExposureRays, exposure};
use crate::footprint::Footprint;
use crate::rejection::Rejection;
use crate::surface::Surface;
use crate::trace::{TraceEnd, TraceLimits, TracePoint, TraceStart, trace};

/// Points of the curve per bead width.
const POINTS_PER_WIDTH: f64 = 16.0;
/// Clear run kept beyond each end, in bead widths: the round ends and a little more.
const CLEAR_WIDTHS: f64 = 0.75;
/// Largest turn [rad] of the surface's normal over half a bead width along the curve.
const MAX_BEND: f64 = 0.6;
/// Rays per point while proposals are judged; placed welds are measured with more.
const JUDGING_RAYS: u32 = 64;
/// Steps of one trace at most.
const MAX_STEPS: usize = 20_000;

/// Everything that the proposals of one stage share.
pub(crate) struct Proposals<'a> {
    pub(crate) surface: &'a Surface<'a>,
    pub(crate) length: f64,
    pub(crate) profile: BeadProfile,
    pub(crate) curvature_rms: f64,
    pub(crate) curvature_max: f64,
    pub(crate) sharp_angle: f64,
    pub(crate) min_exposure: f64,
    pub(crate) exposure_reach: f64,
}

/// A proposal that passed every check.
pub(crate) struct Candidate {
    pub(crate) curve: WeldCurve,
    pub(crate) bead: Mesh,
    pub(crate) root_depth: f64,
}

/// A proposal that did not.
pub(crate) struct Refused {
    pub(crate) why: Rejection,
    /// Clear run found [m], which may be all that was missing.
    pub(crate) run: f64,
}

impl Proposals<'_> {
    /// The proposal of a seed; checks go from cheap to dear.
    pub(crate) fn propose(&self, seed: u64) -> Result<Candidate, Refused> {
        let mut rng = Pcg64Mcg::seed_from_u64(seed);
        let start = self.start(&mut rng);
        let curve = self.run(start, &mut rng)?;
        let refuse = |why| Refused { why, run: self.length };
        self.bends_gently(&curve).map_err(refuse)?;
        self.keeps_apart(&curve).map_err(refuse)?;
        let footprint = Footprint { mesh: self.surface.part, query: self.surface.query, profile: self.profile };
        let root_depth = footprint.root_depth(&curve).map_err(refuse)?;
        self.lies_outside(&curve).map_err(refuse)?;
        self.sees_the_sky(&curve).map_err(refuse)?;
        let bead = sweep(&curve, &self.profile, root_depth).map_err(|_| refuse(Rejection::Fold))?;
        Ok(Candidate { curve, bead, root_depth })
    }

    /// A point evenly distributed over the surface, and a direction evenly distributed over its tangents.
    fn start(&self, rng: &mut Pcg64Mcg) -> TraceStart {
        let target = self.surface.area() * rng.random::<f64>();
        let face = self.surface.areas.partition_point(|sum| *sum <= target).min(self.surface.areas.len() - 1);
        // The square root makes the density even (Osada et al. 2002).
        let (root, share) = (rng.random::<f64>().sqrt(), rng.random::<f64>());
        let [a, b, _] = self.surface.part.corners(face);
        let along = (b - a).normalize_or_zero();
        let turn = std::f64::consts::TAU * rng.random::<f64>();
        let heading = along * turn.cos() + self.surface.part.normal(face).cross(along) * turn.sin();
        let barycentric = [1.0 - root, root * (1.0 - share), root * share];
        TraceStart { face: face as u32, barycentric, heading }
    }

    /// Traces both ways from the start until the wanted length and clear ends are there.
    fn run(&self, start: TraceStart, rng: &mut Pcg64Mcg) -> Result<WeldCurve, Refused> {
        let steps = (self.length / self.profile.width * POINTS_PER_WIDTH).ceil().max(2.0) as usize;
        let spacing = self.length / steps as f64;
        let clear = (CLEAR_WIDTHS * self.profile.width / spacing).ceil() as usize;
        let reach = (steps + 2 * clear) as f64 * spacing;
        let shape = CurvatureProfile::smooth(reach, 0.5 * self.length, self.curvature_rms, self.curvature_max, rng);
        let refuse = |(end, points): (TraceEnd, usize)| Refused {
            why: Rejection::cut_short(end),
            run: points.saturating_sub(2 * clear) as f64 * spacing,
        };
        let behind = self.room_behind(start, &shape, (steps + 2 * clear, spacing)).map_err(refuse)?;
        // Only now is it known which stretch of the profile the weld gets, and what its root mean square is.
        let first = (clear as f64 - behind as f64) * spacing;
        let curvature = shape.scaled_to(self.curvature_rms, self.curvature_max, [first, first + self.length]);
        let (back, back_end) = self.walk(start, false, &curvature, (behind, spacing));
        let (ahead, ahead_end) = self.walk(start, true, &curvature, (steps + 2 * clear - behind, spacing));
        let end = if back_end == TraceEnd::Length { ahead_end } else { back_end };
        let points: Vec<TracePoint> = back.into_iter().rev().chain(ahead.into_iter().skip(1)).collect();
        if points.len() <= steps + 2 * clear {
            return Err(refuse((end, points.len())));
        }
        // Normals and tangents are smoothed over half a width in all.
        let half_window = (0.25 * self.profile.width / spacing).round() as usize;
        let stretch = Stretch { first: clear, last: clear + steps, spacing, half_window, start: first };
        Ok(WeldCurve::frame(&points, stretch, &curvature))
    }

    /// How many of `steps` points to lay behind the start: half, or more where the way ahead is cut short.
    fn room_behind(
        &self,
        start: TraceStart,
        curvature: &CurvatureProfile,
        (steps, spacing): (usize, f64),
    ) -> Result<usize, (TraceEnd, usize)> {
        let (back, back_end) = self.walk(start, false, curvature, (steps / 2, spacing));
        let behind = back.len().saturating_sub(1);
        let (ahead, ahead_end) = self.walk(start, true, curvature, (steps - behind, spacing));
        let missing = steps - behind - ahead.len().saturating_sub(1);
        if missing == 0 {
            return Ok(behind);
        }
        if back_end != TraceEnd::Length {
            return Err((ahead_end, back.len() + ahead.len()));
        }
        let (back, back_end) = self.walk(start, false, curvature, (behind + missing, spacing));
        match back.len() > behind + missing {
            true => Ok(behind + missing),
            false => Err((back_end, back.len() + ahead.len())),
        }
    }

    fn walk(
        &self,
        start: TraceStart,
        ahead: bool,
        curvature: &CurvatureProfile,
        (steps, spacing): (usize, f64),
    ) -> (Vec<TracePoint>, TraceEnd) {
        let length = steps as f64 * spacing;
        let limits = TraceLimits { length, spacing, sharp_angle: self.sharp_angle, max_steps: MAX_STEPS };
        if ahead {
            let traced = trace(self.surface.part, &self.surface.topology, start, curvature, limits);
            return (traced.points, traced.end);
        }
        let backwards = TraceStart { heading: -start.heading, ..start };
        let mut traced = trace(self.surface.part, &self.surface.topology, backwards, &curvature.reversed(), limits);
        for point in &mut traced.points {
            point.tangent = -point.tangent;
        }
        (traced.points, traced.end)
    }

    fn bends_gently(&self, curve: &WeldCurve) -> Result<(), Rejection> {
        let half_width = (0.5 * POINTS_PER_WIDTH) as usize;
        let gentle = |ends: &[CurvePoint]| {
            ends.first().zip(ends.last()).is_some_and(|(a, b)| a.normal.dot(b.normal) > MAX_BEND.cos())
        };
        let bent = curve.points.windows(half_width + 1).any(|window| !gentle(window));
        if bent { Err(Rejection::Bend) } else { Ok(()) }
    }

    /// Points farther apart than 1.5 bases along the curve must be a base apart in space.
    fn keeps_apart(&self, curve: &WeldCurve) -> Result<(), Rejection> {
        let base = 2.0 * self.profile.half_width_at(0.25 * self.profile.height);
        let sparse: Vec<(f64, DVec3)> = curve.points.iter().step_by(4).map(|p| (p.arc_length, p.position)).collect();
        let close = |a: &(f64, DVec3), b: &(f64, DVec3)| b.0 - a.0 > 1.5 * base && a.1.distance(b.1) < base;
        let meets = sparse.iter().enumerate().any(|(i, a)| sparse[i + 1..].iter().any(|b| close(a, b)));
        if meets { Err(Rejection::OwnPass) } else { Ok(()) }
    }

    /// The winding number just above the curve must be that of open space.
    ///
    /// It is 1 on a face inside another body and -1 on a body turned inside out; above an open sheet it comes down to
    /// -1/2.
    fn lies_outside(&self, curve: &WeldCurve) -> Result<(), Rejection> {
        let outside = |point: &CurvePoint| {
            let above = point.position + 0.05 * self.profile.height * point.normal;
            (-0.75..0.5).contains(&self.surface.winding.winding_number(above))
        };
        let stride = (POINTS_PER_WIDTH / 2.0) as usize;
        if curve.points.iter().step_by(stride).all(outside) { Ok(()) } else { Err(Rejection::Inside) }
    }

    fn sees_the_sky(&self, curve: &WeldCurve) -> Result<(), Rejection> {
        let settings = self.rays(JUDGING_RAYS);
        let stride = (POINTS_PER_WIDTH / 2.0) as usize;
        let free = |point: &CurvePoint| {
            exposure(self.surface.query, point.position, point.normal, settings) >= self.min_exposure
        };
        if curve.points.iter().step_by(stride).all(free) { Ok(()) } else { Err(Rejection::Exposure) }
    }

    pub(crate) fn rays(&self, rays: u32) -> ExposureRays {
        ExposureRays { reach: self.exposure_reach, lift: 0.05 * self.profile.height, rays }
    }
}
