//! Correction for laws that are nonlinear in the depth: the result of the linearised law is corrected by evaluating the
//! law at the depth at the end of the step.
//!
//! Let q be that depth. The rate r is taken as linear through the start and q. The pressure is taken as linear through
//! q and the end depth without recession.

use super::contact_state::ContactState;
use super::exponential_integrator::Relaxed;
use crate::phi_functions::PhiWeights;
use shaders::constants::APART;

/// Mean depth over the share in contact [m] after a recession.
pub(super) fn left(depth: f64, share: f64, recession: f64) -> f64 {
    if share > 0.0 { (depth - recession / share).max(0.0) } else { 0.0 }
}

/// Corrects the lanes whose law is nonlinear.
pub(super) fn bend((start, end, reached): (&ContactState, &ContactState, &ContactState), dt: f64, out: &mut Relaxed) {
    for lane in 0..reached.depth.len() {
        let at = |end: &ContactState| LaneState {
            depth: end.depth[lane],
            pressure: end.pressure[lane],
            rate: end.rate[lane],
        };
        let shares = [start.share[lane], end.share[lane]];
        let looks = Looks { start: at(start), end: at(end), reached: at(reached), shares };
        if shares[1] > 0.0 {
            looks.correct(lane, dt, out);
        }
    }
}

/// The law at a depth.
#[derive(Clone, Copy)]
struct LaneState {
    depth: f64,
    pressure: f64,
    rate: f64,
}

/// The law at the start of a step, at its end without recession, and at its end with recession.
struct Looks {
    start: LaneState,
    end: LaneState,
    reached: LaneState,
    /// Shares in contact at start and end.
    shares: [f64; 2],
}

impl Looks {
    fn correct(&self, lane: usize, dt: f64, out: &mut Relaxed) {
        let Self { start, end, reached, shares: [wet_before, wet] } = self;
        let known = out.relaxation[lane] / dt;
        let slope =
            slope((start.depth, start.rate), (reached.depth, reached.rate)).map_or(known, |slope| slope.max(0.0));
        let decay = PhiWeights::new(slope * dt);
        let before = start.rate * wet_before;
        let more = (reached.rate + slope * (end.depth - reached.depth)) * wet - before;
        let recession = dt * (before * decay.phi1 + more * decay.phi2);
        let stiffness = slope_of_pressure(end, reached);
        let depth = left(end.depth, *wet, recession);
        let load = (reached.pressure + stiffness * (depth - reached.depth)).max(0.0) * wet;
        let load_before = start.pressure * wet_before;
        let mean_before = start.depth * wet_before;
        let mean = 0.5 * (mean_before + end.depth * wet) - dt * (before * decay.psi1 + more * decay.psi2);
        let along = self::slope((mean_before, load_before), (depth * wet, load)).unwrap_or(stiffness);
        out.recession[lane] = recession;
        out.end_load[lane] = load;
        out.mean_load[lane] = (load_before + along * (mean - mean_before)).max(0.0);
        out.stiffness[lane] = stiffness * wet * (1.0 - decay.x * decay.phi2);
        out.relaxation[lane] = decay.x;
    }
}

/// Slope between two points; `None` if they are too close.
fn slope(a: (f64, f64), b: (f64, f64)) -> Option<f64> {
    ((b.0 - a.0).abs() > APART * a.0.max(b.0)).then(|| (b.1 - a.1) / (b.0 - a.0))
}

/// Slope of the pressure over the depth [Pa/m].
fn slope_of_pressure(end: &LaneState, reached: &LaneState) -> f64 {
    slope((reached.depth, reached.pressure), (end.depth, end.pressure)).unwrap_or(end.pressure / end.depth)
}
