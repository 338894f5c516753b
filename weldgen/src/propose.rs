//! One proposal: a random curve, and every reason why a bead might not fit on it.

use glam::DVec3;
use rand::{RngExt, SeedableRng};
use rand_pcg::Pcg64Mcg;
use sdf_bake::Mesh;
use sdf_bake::query::MeshQuery;

use crate::bead::{BeadProfile, sweep};
use crate::curvature::CurvatureProfile;
use crate::curve::{Stretch, WeldCurve};
use crate::exposure::{ExposureRays, exposure};
use crate::footprint::Footprint;
use crate::rejection::Rejection;
use crate::topology::Topology;
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
const MAX_STEPS: usize = 200_000;

/// Everything that proposals on one part share.
pub(crate) struct Proposals<'a> {
    pub(crate) part: &'a Mesh,
    pub(crate) query: &'a MeshQuery,
    pub(crate) topology: &'a Topology,
    /// Running sum of the triangles' areas [m²].
    pub(crate) areas: &'a [f64],
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
        let footprint = Footprint { mesh: self.part, query: self.query, profile: self.profile };
        let root_depth = footprint.root_depth(&curve).map_err(refuse)?;
        self.sees_the_sky(&curve).map_err(refuse)?;
        let bead = sweep(&curve, &self.profile, root_depth).map_err(|_| refuse(Rejection::Fold))?;
        Ok(Candidate { curve, bead, root_depth })
    }

    /// A point evenly distributed over the surface, and a direction evenly distributed over its tangents.
    fn start(&self, rng: &mut Pcg64Mcg) -> TraceStart {
        let total = self.areas.last().copied().unwrap_or(0.0);
        let target = total * rng.random::<f64>();
        let face = self.areas.partition_point(|sum| *sum <= target).min(self.areas.len() - 1);
        // The square root makes the density even (Osada et al. 2002).
        let (root, share) = (rng.random::<f64>().sqrt(), rng.random::<f64>());
        let [a, b, _] = self.part.corners(face);
        let along = (b - a).normalize_or_zero();
        let turn = std::f64::consts::TAU * rng.random::<f64>();
        let heading = along * turn.cos() + self.part.normal(face).cross(along) * turn.sin();
        let barycentric = [1.0 - root, root * (1.0 - share), root * share];
        TraceStart { face: face as u32, barycentric, heading }
    }

    /// Traces both ways from the start and cuts the wanted length out of the middle.
    ///
    /// Where one side is cut short, the other is traced further to make up for it.
    fn run(&self, start: TraceStart, rng: &mut Pcg64Mcg) -> Result<WeldCurve, Refused> {
        let steps = (self.length / self.profile.width * POINTS_PER_WIDTH).ceil().max(2.0) as usize;
        let spacing = self.length / steps as f64;
        let clear = (CLEAR_WIDTHS * self.profile.width / spacing).ceil() as usize;
        let whole = steps + 2 * clear;
        let reach = whole as f64 * spacing;
        let curvature = CurvatureProfile::smooth(reach, 0.5 * self.length, self.curvature_rms, self.curvature_max, rng);
        let (mut back, mut back_end) = self.walk(start, false, &curvature, (whole / 2, spacing));
        let missing = whole - (back.len() - 1).min(whole);
        let (ahead, ahead_end) = self.walk(start, true, &curvature, (missing, spacing));
        if back.len() + ahead.len() < whole + 2 && back_end == TraceEnd::Length {
            (back, back_end) = self.walk(start, false, &curvature, (whole + 1 - ahead.len(), spacing));
        }
        let origin = back.len() - 1;
        let points: Vec<TracePoint> = back.into_iter().rev().chain(ahead.into_iter().skip(1)).collect();
        if points.len() <= whole {
            let end = if ahead_end == TraceEnd::Length { back_end } else { ahead_end };
            let run = points.len().saturating_sub(2 * clear) as f64 * spacing;
            return Err(Refused { why: Rejection::cut_short(end), run });
        }
        // Normals and tangents are smoothed over half a width in all.
        let half_window = (0.25 * self.profile.width / spacing).round() as usize;
        let start = (clear as f64 - origin as f64) * spacing;
        let stretch = Stretch { first: clear, last: clear + steps, spacing, half_window, start };
        Ok(WeldCurve::frame(&points, stretch, &curvature))
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
            let traced = trace(self.part, self.topology, start, curvature, limits);
            return (traced.points, traced.end);
        }
        let backwards = TraceStart { heading: -start.heading, ..start };
        let mut traced = trace(self.part, self.topology, backwards, &curvature.reversed(), limits);
        for point in &mut traced.points {
            point.tangent = -point.tangent;
        }
        (traced.points, traced.end)
    }

    fn bends_gently(&self, curve: &WeldCurve) -> Result<(), Rejection> {
        let half_width = (0.5 * POINTS_PER_WIDTH) as usize;
        let gentle = |ends: &[crate::curve::CurvePoint]| {
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

    fn sees_the_sky(&self, curve: &WeldCurve) -> Result<(), Rejection> {
        let settings = self.rays(JUDGING_RAYS);
        let stride = (POINTS_PER_WIDTH / 2.0) as usize;
        let free = |point: &crate::curve::CurvePoint| {
            exposure(self.query, point.position, point.normal, settings) >= self.min_exposure
        };
        if curve.points.iter().step_by(stride).all(free) { Ok(()) } else { Err(Rejection::Exposure) }
    }

    pub(crate) fn rays(&self, rays: u32) -> ExposureRays {
        ExposureRays { reach: self.exposure_reach, lift: 0.05 * self.profile.height, rays }
    }
}
