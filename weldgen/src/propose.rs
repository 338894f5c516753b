//! A proposal: a random curve, and all checks that a bead fits on it.

use std::f64::consts::TAU;

use glam::DVec3;
use rand::{RngExt, SeedableRng};
use rand_pcg::Pcg64Mcg;
use sdf_bake::Mesh;

use crate::bead::{BeadForm, BeadProfile, sweep_formed};
use crate::curvature::CurvatureProfile;
use crate::curve::{CurvePoint, Stretch, WeldCurve};
use crate::cut::{Cuts, PlacedBead};
use crate::exposure::{ExposureRays, exposure};
use crate::footprint::Footprint;
use crate::place::{DrawnDials, Search, Weld};
use crate::rejection::Rejection;
use crate::request::Placement;
use crate::trace::{TraceEnd, TraceLimits, TracePoint, TraceStart, trace};

/// Points of the curve per bead width.
pub(crate) const POINTS_PER_WIDTH: f64 = 16.0;
/// Clear run required beyond each end [bead widths]: the round end and a margin.
pub(crate) const CLEAR_WIDTHS: f64 = 0.75;
/// Greatest rotation [rad] of the surface's normal over half a bead width along the curve.
const MAX_BEND: f64 = 0.6;
/// Rays per point while proposals are examined; placed welds are measured with more.
const JUDGING_RAYS: u32 = 64;
/// Greatest error of the exposure with this number of rays.
const JUDGING_ERROR: f64 = 0.03;
/// Its multiples modulo 1 fill the unit interval evenly.
const GOLDEN_RATIO: f64 = 0.618_033_988_749_894_9;
/// Greatest number of steps of one trace.
pub(crate) const MAX_STEPS: usize = 20_000;

/// Data shared by the proposals of one stage.
pub(crate) struct Proposals<'a> {
    /// Part, request, and possible starts of welds.
    pub(crate) search: &'a Search<'a>,
    /// The dials of this stage.
    pub(crate) wanted: DrawnDials,
    /// Cross-section of a bead on a face.
    pub(crate) profile: BeadProfile,
}

/// Area occupied by a weld that is already placed.
pub(crate) struct OccupiedArea {
    points: Vec<DVec3>,
    half_base: f64,
}

impl OccupiedArea {
    pub(crate) fn by(weld: &Weld) -> Self {
        let points = weld.curve.points.iter().step_by(4).map(|point| point.position).collect();
        Self { points, half_base: weld.profile.half_width_at(weld.root_depth) }
    }

    fn is_near(&self, point: DVec3, distance: f64) -> bool {
        self.points.iter().any(|there| there.distance(point) < distance + self.half_base)
    }
}

/// Derives a seed from a seed and a number (splitmix64's finaliser).
pub(crate) fn mix(seed: u64, number: usize) -> u64 {
    let z = seed.wrapping_add((number as u64).wrapping_add(1).wrapping_mul(0x9e37_79b9_7f4a_7c15));
    let z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
    let z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
    z ^ (z >> 31)
}

/// Point spacing of a weld's curve.
#[derive(Clone, Copy)]
pub(crate) struct Layout {
    /// Steps from the first point to the last.
    pub(crate) steps: usize,
    /// Arc length of a step [m].
    pub(crate) spacing: f64,
    /// Clear steps beyond each end.
    pub(crate) clear: usize,
}

impl Layout {
    /// Stretch of the weld between its clear ends, smoothed over a window of half a bead width [m]. Its first point is
    /// at `start` [m] of the curvature profile.
    pub(crate) fn stretch(self, width: f64, start: f64) -> Stretch {
        let Self { steps, spacing, clear } = self;
        let half_window = (0.25 * width / spacing).round() as usize;
        Stretch { first: clear, last: clear + steps, spacing, half_window, start }
    }
}

/// A proposal that passed every check.
pub(crate) struct Candidate {
    pub(crate) curve: WeldCurve,
    pub(crate) bead: Mesh,
    pub(crate) root_depth: f64,
    pub(crate) profile: BeadProfile,
    pub(crate) form: BeadForm,
    pub(crate) cuts: Cuts,
}

/// A rejected proposal.
pub(crate) struct RejectedProposal {
    pub(crate) why: Rejection,
    /// Clear run found [m], possibly the only requirement that was missed.
    pub(crate) run: f64,
}

impl Proposals<'_> {
    /// Makes the proposal of a number in the sequence of a seed; checks run from cheap to expensive.
    pub(crate) fn propose(&self, seed: u64, number: usize) -> Result<Candidate, RejectedProposal> {
        if self.search.along_seams {
            return self.propose_fillet(seed, number);
        }
        let mut rng = Pcg64Mcg::seed_from_u64(mix(seed, number));
        let start = self.start(seed, number, &mut rng);
        let butt = self.search.request.placement == Placement::Butt;
        let curve = if butt { self.section(start)? } else { self.run(start, &mut rng)? };
        let refuse = |why| RejectedProposal { why, run: self.wanted.length };
        self.bends_gently(&curve).map_err(refuse)?;
        self.keeps_apart(&curve).map_err(refuse)?;
        let footprint =
            Footprint { mesh: self.search.surface.part, query: self.search.surface.query, profile: self.envelope() };
        let root_depth = footprint.root_depth(&curve).map_err(refuse)?;
        self.lies_outside(&curve).map_err(refuse)?;
        self.sees_the_sky(&curve).map_err(refuse)?;
        let form = BeadForm::new(
            self.search.request.form,
            [self.wanted.length, self.profile.width, self.profile.height],
            &mut rng,
        );
        let bead = sweep_formed(&curve, &self.profile, &form, root_depth).map_err(|_| refuse(Rejection::Fold))?;
        let profile = self.profile;
        let cuts = self.cuts(&curve, &profile, &form, &mut rng).map_err(refuse)?;
        Ok(Candidate { curve, bead, root_depth, profile, form, cuts })
    }

    /// Makes the bodies that imperfections remove from a placed bead.
    pub(crate) fn cuts(
        &self,
        curve: &WeldCurve,
        profile: &BeadProfile,
        form: &BeadForm,
        rng: &mut Pcg64Mcg,
    ) -> Result<Cuts, Rejection> {
        let laid = PlacedBead { surface: self.search.surface, curve, profile, form };
        if laid.overlaps_hang_free() { laid.cuts(&self.search.request.form, rng) } else { Err(Rejection::Wall) }
    }

    /// Section that encloses the bead with all its form deviations.
    fn envelope(&self) -> BeadProfile {
        BeadProfile { width: 2.0 * self.search.request.form.half_reach(0.5 * self.profile.width), ..self.profile }
    }

    /// Draws a start point and a tangent direction; successive proposals cover the strata evenly.
    fn start(&self, seed: u64, number: usize, rng: &mut Pcg64Mcg) -> TraceStart {
        let offset = Pcg64Mcg::seed_from_u64(seed).random::<f64>();
        let turn = (offset + number as f64 * GOLDEN_RATIO).fract();
        let stratum = self.search.starts[(turn * self.search.starts.len() as f64) as usize];
        let share = self.search.field.share(stratum, rng.random());
        let (face, barycentric) = self.search.surface.place_at(share, [rng.random(), rng.random()]);
        let [a, b, _] = self.search.surface.part.corners(face as usize);
        let along = (b - a).normalize_or_zero();
        let turn = TAU * rng.random::<f64>();
        let heading = along * turn.cos() + self.search.surface.part.normal(face as usize).cross(along) * turn.sin();
        TraceStart { face, barycentric, heading }
    }

    /// Traces in both directions from the start until the requested length and clear ends are reached.
    fn run(&self, start: TraceStart, rng: &mut Pcg64Mcg) -> Result<WeldCurve, RejectedProposal> {
        let Layout { steps, spacing, clear } = self.layout();
        let reach = (steps + 2 * clear) as f64 * spacing;
        let correlation = self.search.request.correlation.unwrap_or(0.5 * self.wanted.length);
        let (rms, max) = (self.wanted.curvature_rms, self.search.request.curvature_max);
        let shape = CurvatureProfile::random(reach, correlation, rng);
        let refuse = |(end, points): (TraceEnd, usize)| RejectedProposal {
            why: Rejection::cut_short(end),
            run: points.saturating_sub(2 * clear) as f64 * spacing,
        };
        let all = shape.limited_to(rms, max, [-0.5 * reach, 0.5 * reach]);
        let behind = self.room_behind(start, &all, (steps + 2 * clear, spacing)).map_err(refuse)?;
        // Only now the stretch of the profile that the weld covers is known, and therefore its root mean square.
        let first = (clear as f64 - behind as f64) * spacing;
        let curvature = shape.limited_to(rms, max, [first, first + self.wanted.length]);
        let (back, back_end) = self.walk(start, false, &curvature, (behind, spacing));
        let (ahead, ahead_end) = self.walk(start, true, &curvature, (steps + 2 * clear - behind, spacing));
        let end = if back_end == TraceEnd::Length { ahead_end } else { back_end };
        let points: Vec<TracePoint> = back.into_iter().rev().chain(ahead.into_iter().skip(1)).collect();
        if points.len() <= steps + 2 * clear {
            return Err(refuse((end, points.len())));
        }
        Ok(WeldCurve::frame(&points, self.layout().stretch(self.profile.width, first), &curvature))
    }

    /// Number and spacing of the points.
    pub(crate) fn layout(&self) -> Layout {
        let steps = (self.wanted.length / self.profile.width * POINTS_PER_WIDTH).ceil().max(2.0) as usize;
        let spacing = self.wanted.length / steps as f64;
        Layout { steps, spacing, clear: (CLEAR_WIDTHS * self.profile.width / spacing).ceil() as usize }
    }

    /// Number of `steps` points to place behind the start: half, or more if the trace ahead is cut short.
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
        let limits =
            TraceLimits { length, spacing, sharp_angle: self.search.request.sharp_angle, max_steps: MAX_STEPS };
        if ahead {
            let traced = trace(self.search.surface.part, &self.search.surface.topology, start, curvature, limits);
            return (traced.points, traced.end);
        }
        let backwards = TraceStart { heading: -start.heading, ..start };
        let mut traced =
            trace(self.search.surface.part, &self.search.surface.topology, backwards, &curvature.reversed(), limits);
        for point in &mut traced.points {
            point.tangent = -point.tangent;
        }
        (traced.points, traced.end)
    }

    pub(crate) fn bends_gently(&self, curve: &WeldCurve) -> Result<(), Rejection> {
        let half_width = (0.5 * POINTS_PER_WIDTH) as usize;
        let gentle = |ends: &[CurvePoint]| {
            ends.first().zip(ends.last()).is_some_and(|(a, b)| a.normal.dot(b.normal) > MAX_BEND.cos())
        };
        let bent = curve.points.windows(half_width + 1).any(|window| !gentle(window));
        if bent { Err(Rejection::Bend) } else { Ok(()) }
    }

    /// Checks that points farther apart than 1.5 bases along the curve are at least one base apart in space, and that
    /// other welds are farther away.
    pub(crate) fn keeps_apart(&self, curve: &WeldCurve) -> Result<(), Rejection> {
        let base = 2.0 * self.envelope().half_width_at(0.25 * self.profile.height);
        let sparse: Vec<(f64, DVec3)> = curve.points.iter().step_by(4).map(|p| (p.arc_length, p.position)).collect();
        let close = |a: &(f64, DVec3), b: &(f64, DVec3)| b.0 - a.0 > 1.5 * base && a.1.distance(b.1) < base;
        let meets = sparse.iter().enumerate().any(|(i, a)| sparse[i + 1..].iter().any(|b| close(a, b)));
        if meets {
            return Err(Rejection::OwnPass);
        }
        let near = |taken: &OccupiedArea| {
            sparse.iter().any(|(_, point)| taken.is_near(*point, 0.5 * base + self.search.request.gap))
        };
        if self.search.taken.iter().any(near) { Err(Rejection::OtherWeld) } else { Ok(()) }
    }

    /// Checks that the space just above the curve is open.
    fn lies_outside(&self, curve: &WeldCurve) -> Result<(), Rejection> {
        let above = |point: &CurvePoint| point.position + 0.05 * self.profile.height * point.normal;
        let outside = |point: &CurvePoint| self.search.surface.is_open_space(above(point));
        let stride = (POINTS_PER_WIDTH / 2.0) as usize;
        if curve.points.iter().step_by(stride).all(outside) { Ok(()) } else { Err(Rejection::Inside) }
    }

    /// Checks that the least exposure, measured with few rays, is not clearly out of range.
    pub(crate) fn sees_the_sky(&self, curve: &WeldCurve) -> Result<(), Rejection> {
        let settings = self.rays(JUDGING_RAYS);
        let stride = (POINTS_PER_WIDTH / 2.0) as usize;
        let [low, high] = self.wanted.exposure;
        let mut least = 1f64;
        for point in curve.points.iter().step_by(stride) {
            least = least.min(exposure(self.search.surface.query, point.position, point.normal, settings));
            if least < low - JUDGING_ERROR {
                return Err(Rejection::Exposure);
            }
        }
        if least <= high + JUDGING_ERROR { Ok(()) } else { Err(Rejection::TooOpen) }
    }

    pub(crate) fn rays(&self, rays: u32) -> ExposureRays {
        ExposureRays { reach: self.search.request.exposure_reach, lift: 0.05 * self.profile.height, rays }
    }
}
