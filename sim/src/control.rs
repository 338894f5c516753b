//! Force controllers: they set the tool's travel along the approach axis from the nominal path.

use shaders::constants::EVALUATIONS;
use shaders::constants::FIRST_NUDGE;
use shaders::constants::FIRST_STRIDE;

use crate::phi_functions::PhiWeights;

/// Travel and speed of a tool along its approach axis.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Motion {
    /// Travel from the nominal path, positive away from the part [m].
    pub travel: f64,
    /// [m/s]
    pub speed: f64,
}

/// Equation to be solved for the end of a step: `F = F_set + B z' + M z''` with backward differences, where F is the
/// mean force over the step.
#[derive(Clone, Copy, Debug)]
pub struct Balance {
    /// Motion at the start of the step.
    pub from: Motion,
    /// Contact at the start of the step.
    pub start: StartContact,
    /// F_set [N].
    pub setpoint: f64,
    /// B [N s/m]; 0 for an ideal controller.
    pub damping: f64,
    /// M [kg]; 0 for an ideal controller.
    pub mass: f64,
    /// Length of the step [s]; 0 for a static balance.
    pub dt: f64,
    /// Weight of the end force in the mean over the step, 1/2 to 1: exact for a spring on a damper.
    pub weight: f64,
    /// Tolerance of the force [N].
    pub tolerance: f64,
    /// Lowest and highest travel [m].
    pub bounds: (f64, f64),
    /// Greatest change of the force in the step, and greatest inertial force [N]; `None` if any are allowed.
    pub allowed: Option<(f64, f64)>,
}

/// Contact at the start of a step.
#[derive(Clone, Copy, Debug, Default)]
pub struct StartContact {
    /// Force that the controller reads [N].
    pub force: f64,
    /// -dF/dz [N/m].
    pub stiffness: f64,
    /// Speed of the surface along the tool's travel in the last step [m/s].
    pub surface_speed: f64,
}

/// Force at a travel, its stiffness -dF/dz [N/m], and the maximum depth under the tool (negative: the gap) [m].
#[derive(Clone, Copy, Debug)]
pub struct Response {
    /// Force that the controller reads [N].
    pub force: f64,
    /// [N/m]
    pub stiffness: f64,
    /// Maximum depth under the working surface [m]; -∞ where there is no surface.
    pub depth: f64,
}

/// Result of the search for a balance.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Found<T> {
    /// The balance.
    Balance(T),
    /// Nothing is touched within the bounds.
    Nothing,
    /// In the balance, the changes in the step would be greater than those allowed.
    TooFast,
}

impl<T> Found<T> {
    /// The balance in other terms.
    pub fn map<U>(self, express: impl FnOnce(T) -> U) -> Found<U> {
        match self {
            Self::Balance(balance) => Found::Balance(express(balance)),
            Self::Nothing => Found::Nothing,
            Self::TooFast => Found::TooFast,
        }
    }

    /// The balance, if there is one.
    pub fn balance(self) -> Option<T> {
        match self {
            Self::Balance(balance) => Some(balance),
            Self::Nothing | Self::TooFast => None,
        }
    }
}

impl Balance {
    /// Travel at which the balance is foreseen [m]: that of a spring on a surface that moves as in the last step. Under
    /// an ideal controller the tool goes on as before: it is balanced at the start, and the spring of a first touch, far
    /// softer than the patch into which it grows, would take it through the part.
    pub fn foreseen(&self) -> f64 {
        let Self { from, start, damping, mass, dt, weight, .. } = *self;
        if dt == 0.0 || damping + mass == 0.0 {
            return from.travel + dt * from.speed;
        }
        let spring = weight * start.stiffness * dt;
        let resistance = damping + mass / dt + spring;
        let excess = start.force - self.setpoint + mass / dt * from.speed + spring * start.surface_speed;
        from.travel + dt * excess / resistance
    }

    /// True if greater changes than those allowed are foreseen.
    pub fn is_foreseen_too_fast(&self) -> bool {
        let (travel, StartContact { force, stiffness, surface_speed }) = (self.foreseen(), self.start);
        let sinking = self.from.travel + self.dt * surface_speed - travel;
        self.is_too_fast(travel, force + stiffness * sinking, 0.0)
    }

    /// Finds the travel near `guess`, safeguarded by brackets. The steps are Newton's, with a slope that is scaled by
    /// what the step before it has shown: a stiffness misses what the law adds where it depends on the speed of the
    /// approach or on the state, and Newton's steps alone would then converge slowly, or not at all. `scale` is that
    /// share of the slope; the next search goes on from it. The search ends as soon as the balance is sure to be
    /// [`Found::TooFast`].
    ///
    /// # Errors
    /// The first error of `respond`.
    pub fn solve<E>(
        &self,
        guess: f64,
        scale: &mut f64,
        mut respond: impl FnMut(f64) -> Result<Response, E>,
    ) -> Result<Found<f64>, E> {
        let mut search = Search::new(self, *scale);
        let mut travel = guess.clamp(self.bounds.0, self.bounds.1);
        let mut force = self.start.force;
        for _ in 0..EVALUATIONS {
            let response = respond(travel)?;
            force = response.force;
            let excess = self.excess(travel, force);
            if excess.abs() <= self.tolerance {
                break;
            }
            if self.is_too_fast(travel, force, excess.abs()) {
                return Ok(Found::TooFast);
            }
            let Some(next) = search.next(travel, excess, &response) else { return Ok(Found::Nothing) };
            *scale = search.scale;
            if search.high - search.low < 1e-14 {
                travel = search.low;
                break;
            }
            travel = next;
        }
        Ok(if self.is_too_fast(travel, force, 0.0) { Found::TooFast } else { Found::Balance(travel) })
    }

    /// Rate at which damping and inertia grow with the depth [N/m].
    fn drag(&self) -> f64 {
        if self.dt > 0.0 { self.damping / self.dt + self.mass / (self.dt * self.dt) } else { 0.0 }
    }

    /// True if the balance is sure to change more than is allowed, seen from a travel at which the force is in excess
    /// by `doubt` [N]: force, damping and inertia all grow with the depth, so each of them is at most as far from its
    /// value in the balance.
    fn is_too_fast(&self, travel: f64, force: f64, doubt: f64) -> bool {
        let Some((change, inertia)) = self.allowed else { return false };
        let speed = (travel - self.from.travel) / self.dt;
        let inertial_force = (self.mass * (speed - self.from.speed) / self.dt).abs();
        inertial_force - doubt > inertia || (force - self.start.force).abs() - doubt / self.weight > change
    }

    /// Force in excess of the controller's law [N].
    fn excess(&self, travel: f64, force: f64) -> f64 {
        if self.dt == 0.0 {
            return force - self.setpoint;
        }
        let speed = (travel - self.from.travel) / self.dt;
        let mean = self.start.force + self.weight * (force - self.start.force);
        mean - self.setpoint - self.damping * speed - self.mass * (speed - self.from.speed) / self.dt
    }
}

/// A search for a balance in progress.
struct Search<'a> {
    balance: &'a Balance,
    /// Travels known to be too low and too high [m].
    low: f64,
    high: f64,
    /// Longest next motion into a surface that was just touched [m].
    stride: f64,
    /// Next motion into a surface without a force [m].
    nudge: f64,
    /// Share of the slope that was seen.
    scale: f64,
    before: Option<Evaluation>,
}

impl<'a> Search<'a> {
    fn new(balance: &'a Balance, scale: f64) -> Self {
        let (low, high) = (f64::NEG_INFINITY, f64::INFINITY);
        Self { balance, low, high, stride: FIRST_STRIDE, nudge: 0.5 * FIRST_NUDGE, scale, before: None }
    }

    /// The travel to be tried after one with an excess force [N]; `None` if nothing is touched within the bounds.
    fn next(&mut self, travel: f64, excess: f64, response: &Response) -> Option<f64> {
        if excess > 0.0 {
            self.low = travel
        } else {
            self.high = travel
        }
        let step = self.step(travel, excess, response)?;
        let next = match (step > self.low, step < self.high) {
            (true, true) => step,
            _ if self.low.is_finite() && self.high.is_finite() => 0.5 * (self.low + self.high),
            _ => step,
        };
        let lowest = self.balance.bounds.0;
        if next.is_nan() || (next < lowest && self.high <= lowest) {
            return None;
        }
        // The first touch of a wide tool is so soft that the step overshoots far below the balance.
        Some(next.max(lowest))
    }

    /// The end of a step of the search.
    fn step(&mut self, travel: f64, excess: f64, response: &Response) -> Option<f64> {
        let slope = self.balance.weight * response.stiffness + self.balance.drag();
        if slope > 0.0 {
            let now = Evaluation { travel, excess, slope };
            self.scale = self.before.and_then(|before| now.scale(before)).unwrap_or(self.scale);
            self.before = Some(now);
            // A first touch is far softer than the patch into which it grows.
            let next = travel + excess / (self.scale * slope);
            self.stride *= 4.0;
            return Some(if self.low.is_finite() { next } else { next.max(travel - self.stride) });
        }
        // Moves down to the surface and a little into it, more each time: a patch far below a voxel has no force.
        self.nudge *= 2.0;
        (response.depth > f64::NEG_INFINITY).then(|| travel + response.depth.min(0.0) * (1.0 + 1e-9) - self.nudge)
    }
}

/// A travel [m], its excess force [N], and the fall of the excess per travel that the stiffness promises [N/m].
#[derive(Clone, Copy)]
struct Evaluation {
    travel: f64,
    excess: f64,
    slope: f64,
}

impl Evaluation {
    /// Fall of the excess force since the evaluation before, as a share of the mean slope of both (trapezoidal rule);
    /// `None` unless it falls. Where the slopes are true it is 1 for a quadratic force, so steps are Newton's; where
    /// all are wrong by one factor, steps are secants.
    fn scale(self, before: Self) -> Option<f64> {
        let promised = 0.5 * (before.slope + self.slope) * (self.travel - before.travel);
        let scale = (before.excess - self.excess) / promised;
        (scale > 0.0 && scale.is_finite()).then_some(scale)
    }
}

/// Weight of the end of a step in the mean of a force that decays as `exp(-x)` towards a constant. With it, a step of
/// any length is exact for a spring on a damper (exponential fitting, Liniger and Willoughby 1970): 1/2 for a short
/// step, 1 for a long one.
pub(crate) fn end_weight(x: f64) -> f64 {
    let decay = PhiWeights::new(x);
    decay.phi2 / decay.phi1
}

/// One sample of an admittance controller (semi-implicit Euler) for a force reading `force` [N].
pub fn admittance_sample(motion: Motion, force: f64, setpoint: f64, (mass, damping): (f64, f64), dt: f64) -> Motion {
    // The damping uses the speed at the end of the sample, so M may be zero.
    let speed = (mass * motion.speed + dt * (force - setpoint)) / (mass + dt * damping);
    Motion { travel: motion.travel + dt * speed, speed }
}

#[cfg(test)]
mod tests;
