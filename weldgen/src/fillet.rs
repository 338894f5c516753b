//! Proposals of fillet welds: stretches of seams on which both toes of a fillet lie on the walls.

use glam::DVec3;
use rand::{RngExt, SeedableRng};
use rand_pcg::Pcg64Mcg;

use crate::bead::{BeadForm, BeadProfile, sweep_formed};
use crate::curvature::CurvatureProfile;
use crate::curve::{CurvePoint, WeldCurve};
use crate::propose::{Candidate, Layout, POINTS_PER_WIDTH, Proposals, RejectedProposal, mix};
use crate::rejection::Rejection;
use crate::seam::Seam;

/// Depth of the fillet in the walls [widths].
const ROOT_SHARE: f64 = 0.1;
/// Greatest change [rad] of the angle between the walls along one weld; it keeps the toes within the walls.
const OPENING_CHANGE: f64 = 0.07;
/// Least and greatest angle between the walls [rad] for a fillet.
const OPENINGS: [f64; 2] = [0.8, 2.6];

impl Proposals<'_> {
    /// Proposes a stretch of one of the seams, chosen with probability proportional to length.
    pub(crate) fn propose_fillet(&self, seed: u64, number: usize) -> Result<Candidate, RejectedProposal> {
        let mut rng = Pcg64Mcg::seed_from_u64(mix(seed, number));
        let seams = self.search.surface.seams();
        let Layout { steps, spacing, clear } = self.layout();
        let reach = (steps + 2 * clear) as f64 * spacing;
        let cut_short = |run: f64| RejectedProposal { why: Rejection::SharpEdge, run };
        let whole: f64 = seams.iter().map(Seam::length).sum();
        let mut place = whole * rng.random::<f64>();
        let drawn = seams.iter().find(|seam| {
            place -= seam.length();
            place < 0.0
        });
        let seam = drawn.or(seams.last()).ok_or(cut_short(0.0))?;
        let room = seam.length() - reach;
        if room < 0.0 {
            return Err(cut_short((seam.length() - 2.0 * clear as f64 * spacing).max(0.0)));
        }
        let from = rng.random::<f64>() * if seam.closed { seam.length() } else { room };
        let refuse = |why| RejectedProposal { why, run: self.wanted.length };
        let profile = self.fillet_profile(seam.openings([from, from + reach])).map_err(refuse)?;
        let points: Vec<_> = (0..=steps + 2 * clear)
            .map(|i| seam.point_at(self.search.surface.part, from + i as f64 * spacing))
            .collect();
        let stretch = self.layout().stretch(profile.width, 0.0);
        let mut curve = WeldCurve::frame(&points, stretch, &CurvatureProfile::constant(0.0));
        curve.measure_curvature();
        self.finish_fillet(curve, profile, &mut rng).map_err(refuse)
    }

    /// Fillet of the requested width in a corner whose angle is within this range [rad].
    fn fillet_profile(&self, [narrow, wide]: [f64; 2]) -> Result<BeadProfile, Rejection> {
        let fits = wide - narrow <= OPENING_CHANGE && narrow >= OPENINGS[0] && wide <= OPENINGS[1];
        let opening = 0.5 * (narrow + wide);
        let profile = BeadProfile::fillet(self.profile.width, opening, self.search.request.convexity);
        if fits && profile.toe_angle() > 0.0 { Ok(profile) } else { Err(Rejection::Tilt) }
    }

    fn finish_fillet(
        &self,
        curve: WeldCurve,
        profile: BeadProfile,
        rng: &mut Pcg64Mcg,
    ) -> Result<Candidate, Rejection> {
        self.bends_gently(&curve)?;
        self.keeps_apart(&curve)?;
        let root_depth = ROOT_SHARE * profile.width;
        let stride = (POINTS_PER_WIDTH / 4.0) as usize;
        if let Some(why) =
            curve.points.iter().step_by(stride).find_map(|point| self.off_walls(point, &profile, root_depth))
        {
            return Err(why);
        }
        self.sees_the_sky(&curve)?;
        let form = BeadForm::new(self.search.request.form, [self.wanted.length, profile.width, profile.height], rng);
        let bead = sweep_formed(&curve, &profile, &form, root_depth).map_err(|_| Rejection::Fold)?;
        let cuts = self.cuts(&curve, &profile, &form, rng)?;
        Ok(Candidate { curve, bead, root_depth, profile, form, cuts })
    }

    /// Reason why a section does not fit its corner: its face must be in open space, its base inside the walls.
    fn off_walls(&self, point: &CurvePoint, profile: &BeadProfile, root_depth: f64) -> Option<Rejection> {
        let at = |y: f64, z: f64| point.position + y * point.side + z * point.normal;
        let outside = |point: DVec3| self.search.surface.is_open_space(point);
        let inside = |point: DVec3| self.search.surface.winding.winding_number(point) > 0.5;
        let (toe, base) = (0.5 * profile.width, 0.5 * profile.width + 0.8 * root_depth);
        let above = 1.02 * profile.height.max(profile.toe_height);
        if !(outside(at(0.0, above)) && [-0.5, 0.5].iter().all(|share| outside(at(share * toe, above)))) {
            return Some(Rejection::Wall);
        }
        let buried = [at(-base, profile.toe_height), at(base, profile.toe_height), at(0.0, -0.8 * root_depth)];
        (!buried.into_iter().all(inside)).then_some(Rejection::Thin)
    }
}
