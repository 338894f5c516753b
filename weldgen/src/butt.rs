//! Proposals of butt welds: stretches of plane cuts through a smooth surface without concave edges.

use crate::curvature::CurvatureProfile;
use crate::curve::WeldCurve;
use crate::propose::{Layout, MAX_STEPS, Proposals, RejectedProposal};
use crate::rejection::Rejection;
use crate::request::{Joint, Placement};
use crate::trace::{Trace, TraceEnd, TraceLimits, TracePoint, TraceStart, trace_section};

impl Proposals<'_> {
    /// Kind of joint.
    pub(crate) fn joint(&self) -> Joint {
        match (self.search.along_seams, self.search.request.placement) {
            (true, _) => Joint::Fillet,
            (false, Placement::Butt) => Joint::Butt,
            (false, _) => Joint::BeadOnPlate,
        }
    }

    /// Returns the plane cut through a start, in both directions, with the curvature of the cut.
    pub(crate) fn section(&self, start: TraceStart) -> Result<WeldCurve, RejectedProposal> {
        let layout @ Layout { steps, spacing, clear } = self.layout();
        let whole = steps + 2 * clear;
        let [ahead, back] = [1.0, -1.0]
            .map(|way| self.walk_section(TraceStart { heading: way * start.heading, ..start }, whole as f64 * spacing));
        let [reached, behind] = [&ahead, &back].map(|trace| trace.points.len().saturating_sub(1));
        if reached + behind < whole {
            let end = if back.end == TraceEnd::Length { ahead.end } else { back.end };
            let run = (reached + behind).saturating_sub(2 * clear) as f64 * spacing;
            return Err(RejectedProposal { why: Rejection::cut_short(end), run });
        }
        let behind = behind.min(whole / 2).max(whole - reached.min(whole));
        let turned = |point: &TracePoint| TracePoint { tangent: -point.tangent, ..*point };
        let before = back.points.iter().skip(1).take(behind).rev().map(turned);
        let points: Vec<TracePoint> = before.chain(ahead.points.iter().take(whole - behind + 1).copied()).collect();
        let straight = CurvatureProfile::constant(0.0);
        let mut curve = WeldCurve::frame(&points, layout.stretch(self.profile.width, 0.0), &straight);
        curve.measure_curvature();
        Ok(curve)
    }

    fn walk_section(&self, start: TraceStart, length: f64) -> Trace {
        let (spacing, sharp_angle) = (self.layout().spacing, self.search.request.sharp_angle);
        let limits = TraceLimits { length, spacing, sharp_angle, max_steps: MAX_STEPS };
        trace_section(self.search.surface.part, &self.search.surface.topology, start, limits)
    }
}
