//! Integration of the lanes over a step, in the processor's widest SIMD lanes.

use super::contact_state::ContactState;
use crate::phi_functions::PhiWeights;
pub(super) use shaders::constants::PROBE;

/// Relative difference of decay up to which two lanes are integrated with the same weights.
const SAME_DECAY: f64 = 1e-6;

/// Results of a step for each lane; the buffers are reused.
#[derive(Clone, Debug, Default)]
pub(super) struct Relaxed {
    /// Recession over the step, mean over the cell [m].
    pub(super) recession: Vec<f64>,
    /// Pressure at the end of the step, mean over the cell [Pa].
    pub(super) end_load: Vec<f64>,
    /// The same, averaged over the step.
    pub(super) mean_load: Vec<f64>,
    /// Stiffness: decrease of the load at the end as the tool is lifted, -dp/dz [Pa/m].
    pub(super) stiffness: Vec<f64>,
    /// Relaxation of each lane in the step, λ dt [1].
    pub(super) relaxation: Vec<f64>,
}

impl Relaxed {
    /// Replaces a lane's recession by a recession and its mean over the step [m].
    pub(super) fn recede(
        &mut self,
        lane: usize,
        (start, end): (&ContactState, &ContactState),
        (recession, mean): (f64, f64),
    ) {
        let load = |end: &ContactState| end.pressure[lane] * end.share[lane];
        let deeper = if start.depth[lane] > end.depth[lane] { start } else { end };
        let stiffness = if deeper.depth[lane] > 0.0 { deeper.pressure[lane] / deeper.depth[lane] } else { 0.0 };
        let mean_depth = end.depth[lane] * end.share[lane];
        let left = if mean_depth > 0.0 { (1.0 - recession / mean_depth).max(0.0) } else { 0.0 };
        self.recession[lane] = recession;
        self.end_load[lane] = load(end) * left;
        self.mean_load[lane] = (0.5 * (load(start) + load(end)) - stiffness * mean).max(0.0);
    }
}

/// Integrates the lanes over a step of `dt` [s].
pub(super) struct IntegrateLanes<'a> {
    pub(super) start: &'a ContactState,
    pub(super) end: &'a ContactState,
    /// Recession speed at a slightly greater depth than that of the deeper end [m/s].
    pub(super) probe: &'a [f64],
    pub(super) dt: f64,
    /// Bulge: excess of the depth in the middle of the step over the mean of both ends, without recession [m].
    pub(super) bulge: f64,
    pub(super) out: &'a mut Relaxed,
}

impl pulp::NullaryFnOnce for IntegrateLanes<'_> {
    type Output = ();

    #[inline(always)]
    fn call(self) {
        let Self { start, end, probe, dt, bulge, out } = self;
        let count = probe.len();
        let Relaxed { recession, end_load, mean_load, stiffness, relaxation } = &mut *out;
        for lanes in [recession, end_load, mean_load, stiffness, relaxation] {
            lanes.resize(count, 0.0);
        }
        set_relaxation(start, end, (probe, dt), &mut out.relaxation);
        let mut decay = PhiWeights::new(0.0);
        let mut first = 0;
        while first < count {
            let is_other = |x: f64, decay: &PhiWeights| (x - decay.x).abs() > SAME_DECAY * decay.x;
            if is_other(out.relaxation[first], &decay) {
                decay = PhiWeights::new(out.relaxation[first]);
            }
            let more = out.relaxation[first + 1..].iter().take_while(|x| !is_other(**x, &decay)).count();
            let next = first + 1 + more;
            integrate(start, end, (&decay, dt, bulge), (first, next - first), out);
            first = next;
        }
    }
}

#[inline(always)]
fn set_relaxation(start: &ContactState, end: &ContactState, (probe, dt): (&[f64], f64), out: &mut [f64]) {
    let count = out.len();
    let (own_a, own_b) = (&start.own[..count], &end.own[..count]);
    let (rate_a, rate_b, probe) = (&start.rate[..count], &end.rate[..count], &probe[..count]);
    for lane in 0..count {
        let is_start = own_a[lane] > own_b[lane];
        let depth = if is_start { own_a[lane] } else { own_b[lane] };
        let rate = if is_start { rate_a[lane] } else { rate_b[lane] };
        let slope = (probe[lane] - rate) / (PROBE * depth);
        out[lane] = if depth > 0.0 { slope.max(0.0) * dt } else { 0.0 };
    }
}

/// Integrates `count` lanes from `first` on that share the same weights.
#[inline(always)]
fn integrate(
    start: &ContactState,
    end: &ContactState,
    (decay, dt, bulge): (&PhiWeights, f64, f64),
    (first, count): (usize, usize),
    out: &mut Relaxed,
) {
    let bulged = bulge * decay.bulge_gain();
    let lanes = first..first + count;
    let (depth_a, depth_b) = (&start.depth[lanes.clone()], &end.depth[lanes.clone()]);
    let (share_a, share_b) = (&start.share[lanes.clone()], &end.share[lanes.clone()]);
    let (pressure_a, pressure_b) = (&start.pressure[lanes.clone()], &end.pressure[lanes.clone()]);
    let (rate_a, rate_b) = (&start.rate[lanes.clone()], &end.rate[lanes.clone()]);
    let flat = &end.flat[lanes.clone()];
    let (cover_a, cover_b) = (&start.cover[lanes.clone()], &end.cover[lanes.clone()]);
    let (recessions, end_loads) = (&mut out.recession[lanes.clone()], &mut out.end_load[lanes.clone()]);
    let (mean_loads, stiffnesses) = (&mut out.mean_load[lanes.clone()], &mut out.stiffness[lanes]);
    for lane in 0..count {
        let is_start = depth_a[lane] > depth_b[lane];
        let deeper = if is_start { depth_a[lane] } else { depth_b[lane] };
        let highest = if is_start { pressure_a[lane] } else { pressure_b[lane] };
        let (rate_a, rate_b) = (rate_a[lane] * cover_a[lane], rate_b[lane] * cover_b[lane]);
        let more = if (rate_a > 0.0) & (rate_b > 0.0) { bulged * cover_b[lane] * flat[lane] } else { 0.0 };
        let recession = dt * (rate_a * decay.phi1 + (rate_b - rate_a) * decay.phi2) + more;
        let (load_a, load_b) = (pressure_a[lane] * share_a[lane], pressure_b[lane] * share_b[lane]);
        let mean_depth = depth_b[lane] * share_b[lane];
        let left = if mean_depth > 0.0 { (1.0 - recession / mean_depth).max(0.0) } else { 0.0 };
        // Mean over the step of the accumulated recession.
        let mean_recession = dt * (rate_a * decay.psi1 + (rate_b - rate_a) * decay.psi2);
        let stiffness = if deeper > 0.0 { highest / deeper } else { 0.0 };
        recessions[lane] = recession;
        end_loads[lane] = load_b * left;
        mean_loads[lane] = (0.5 * (load_a + load_b) - stiffness * mean_recession).max(0.0);
        stiffnesses[lane] = stiffness * share_b[lane] * (1.0 - decay.x * decay.phi2);
    }
}
