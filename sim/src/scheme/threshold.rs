//! Cells that start or stop receding within a step, for a law with a threshold.
//!
//! Such a law is taken as linear above its threshold depth. The part of the step in which the depth exceeds the
//! threshold is found on its parabola over time, and only that part is integrated.

use super::contact_state::ContactState;
use super::exponential_integrator::{PROBE, Relaxed};
use crate::phi_functions::PhiWeights;
use shaders::constants::NO_THRESHOLD;

/// Resets lanes without a threshold in their law to the mean depth over their share in contact. For a law that is
/// linear from depth 0 on, the rate at the mean is the mean of the rates, so pressure and removal are consistent.
/// `probe` holds the rates at [`super::exponential_integrator::PROBE`] above the deeper end.
pub(super) fn take_means(start: &mut ContactState, end: &mut ContactState, probe: &mut [f64]) {
    if !end.is_flat {
        return;
    }
    for (lane, probe) in probe.iter_mut().enumerate() {
        if end.flat[lane] == 0.0 {
            continue;
        }
        let deeper = if start.own[lane] > end.own[lane] { &*start } else { &*end };
        let (own, rate) = (deeper.own[lane], deeper.rate[lane]);
        let slope = (*probe - rate) / (PROBE * own);
        if own <= 0.0 || rate <= 0.0 || own - rate / slope > NO_THRESHOLD * own {
            continue;
        }
        for end in [&mut *start, &mut *end] {
            let wet = if end.share[lane] > 0.0 { (rate + slope * (end.depth[lane] - own)).max(0.0) } else { 0.0 };
            (end.own[lane], end.cover[lane], end.rate[lane]) = (end.depth[lane], end.share[lane], wet);
            end.flat[lane] = 0.0;
        }
        let deepest = start.own[lane].max(end.own[lane]);
        *probe = start.rate[lane].max(end.rate[lane]) + slope * PROBE * deepest;
    }
}

/// Corrects the lanes that recede at only one end of a step of `dt` [s]. `bulge` [m] as in
/// [`super::exponential_integrator::IntegrateLanes`].
pub(super) fn cross((start, end): (&ContactState, &ContactState), (dt, bulge): (f64, f64), out: &mut Relaxed) {
    if !end.is_flat {
        return;
    }
    for lane in 0..out.recession.len() {
        if end.flat[lane] == 0.0 || (end.rate[lane] > 0.0) == (start.rate[lane] > 0.0) {
            continue;
        }
        let begins = end.rate[lane] > 0.0;
        let (deeper, other) = if begins { (end, start) } else { (start, end) };
        let (rate, x) = (deeper.rate[lane], out.relaxation[lane]);
        let way = deeper.own[lane] - other.own[lane];
        if x == 0.0 || way <= 0.0 {
            continue;
        }
        let above = (rate * dt / x).min(deeper.own[lane]);
        let crossing = Crossing { above, part: part_above(above, way, bulge).min(1.0), x, bulge };
        let (recession, mean) = if begins { crossing.begins() } else { crossing.ceases() };
        let cover = deeper.cover[lane];
        out.recede(lane, (start, end), (cover * recession, cover * mean));
    }
}

/// A depth that crosses the threshold of a law.
struct Crossing {
    /// Depth above the threshold at the deeper end [m].
    above: f64,
    /// Part of the step in which the depth exceeds the threshold, without recession.
    part: f64,
    /// Relaxation in the step, λ dt.
    x: f64,
    /// As in [`super::exponential_integrator::IntegrateLanes`].
    bulge: f64,
}

impl Crossing {
    /// Recession and its mean over the step [m] of a cell that starts to recede within it.
    fn begins(&self) -> (f64, f64) {
        let decay = PhiWeights::new(self.x * self.part);
        let bulged = self.bulge * self.part * self.part * decay.bulge_gain();
        (self.above * decay.x * decay.phi2 + bulged, self.part * self.above * decay.x * decay.psi2)
    }

    /// The same for a cell that stops. While the tool retreats at a speed s, a depth u above the threshold is gone
    /// after `ln(1 + λ u/s)/λ`.
    fn ceases(&self) -> (f64, f64) {
        let decay = PhiWeights::new(self.x * self.part);
        let log = decay.x.ln_1p() / decay.x;
        let recession = self.above * (1.0 - log) + self.bulge * self.part * self.part * decay.bulge_gain();
        // A rate that falls evenly has taken two thirds on average while it acts.
        (recession, recession * (1.0 - self.part * log / 3.0))
    }
}

/// Part of a step, from its deeper end, in which the depth is less than `above` [m] below that end. Over the step the
/// depth changes by `way` [m] on a parabola that exceeds the straight line by `bulge` [m] in the middle.
fn part_above(above: f64, way: f64, bulge: f64) -> f64 {
    // above = way t - 4 bulge t (1 - t)
    let slope = way - 4.0 * bulge;
    let root = (slope * slope + 16.0 * bulge * above).sqrt();
    if slope > 0.0 { 2.0 * above / (slope + root) } else { (root - slope) / (8.0 * bulge) }
}
