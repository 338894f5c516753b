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
    /// F_set [N].
    pub setpoint: f64,
    /// B [N s/m]; 0 for an ideal controller.
    pub damping: f64,
    /// M [kg]; 0 for an ideal controller.
    pub mass: f64,
    /// Length of the step [s]; 0 for a static balance.
    pub dt: f64,
    /// Force at the start of the step [N].
    pub start_force: f64,
    /// Weight of the end force in the mean over the step, 1/2 to 1: exact for a spring on a damper.
    pub weight: f64,
    /// Tolerance of the force [N].
    pub tolerance: f64,
    /// Lowest and highest travel [m].
    pub bounds: (f64, f64),
}

/// Force at a travel, its stiffness -dF/dz [N/m], and the maximum depth under the tool (negative: the gap) [m].
#[derive(Clone, Copy, Debug)]
pub struct Response {
    /// [N]
    pub force: f64,
    /// [N/m]
    pub stiffness: f64,
    /// Maximum depth under the working surface [m]; -∞ where there is no surface.
    pub depth: f64,
}

impl Balance {
    /// Finds the travel near `guess`, safeguarded by brackets; `None` if nothing is touched within the bounds. The
    /// steps are Newton's, with a slope that is scaled by what the step before it has shown: a stiffness misses what
    /// the law adds where it depends on the speed of the approach or on the state, and Newton's steps alone would then
    /// converge slowly, or not at all.
    ///
    /// # Errors
    /// The first error of `respond`.
    pub fn solve<E>(&self, guess: f64, mut respond: impl FnMut(f64) -> Result<Response, E>) -> Result<Option<f64>, E> {
        let (mut low, mut high) = (f64::NEG_INFINITY, f64::INFINITY);
        let (mut stride, mut nudge) = (FIRST_STRIDE, 0.5 * FIRST_NUDGE);
        let mut travel = guess.clamp(self.bounds.0, self.bounds.1);
        let mut before = None;
        let drag = if self.dt > 0.0 { self.damping / self.dt + self.mass / (self.dt * self.dt) } else { 0.0 };
        for _ in 0..EVALUATIONS {
            let response = respond(travel)?;
            let excess = self.excess(travel, response.force);
            if excess.abs() <= self.tolerance {
                return Ok(Some(travel));
            }
            if excess > 0.0 {
                low = travel
            } else {
                high = travel
            }
            let slope = self.weight * response.stiffness + drag;
            let step = if slope > 0.0 {
                let now = Evaluation { travel, excess, slope };
                let scale = before.and_then(|before| now.scale(before)).unwrap_or(1.0);
                before = Some(now);
                // A first touch is far softer than the patch into which it grows.
                let next = travel + excess / (scale * slope);
                stride *= 4.0;
                if low.is_finite() { next } else { next.max(travel - stride) }
            } else if response.depth == f64::NEG_INFINITY {
                return Ok(None);
            } else {
                // Moves down to the surface and a little into it, more each time: a patch far below a voxel has no
                // force.
                nudge *= 2.0;
                travel + response.depth.min(0.0) * (1.0 + 1e-9) - nudge
            };
            travel = match (step > low, step < high) {
                (true, true) => step,
                _ if low.is_finite() && high.is_finite() => 0.5 * (low + high),
                _ => step,
            };
            if travel.is_nan() || travel < self.bounds.0 {
                // The first touch of a wide tool is so soft that the step overshoots far below the balance.
                if travel.is_nan() || high <= self.bounds.0 {
                    return Ok(None);
                }
                travel = self.bounds.0;
            }
            if high - low < 1e-14 {
                return Ok(Some(low));
            }
        }
        Ok(Some(travel))
    }

    /// Force in excess of the controller's law [N].
    fn excess(&self, travel: f64, force: f64) -> f64 {
        if self.dt == 0.0 {
            return force - self.setpoint;
        }
        let speed = (travel - self.from.travel) / self.dt;
        let force = self.start_force + self.weight * (force - self.start_force);
        force - self.setpoint - self.damping * speed - self.mass * (speed - self.from.speed) / self.dt
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
mod tests {
    use super::*;

    /// Balance of an ideal controller.
    const IDEAL: Balance = Balance {
        from: Motion { travel: 0.0, speed: 0.0 },
        setpoint: 15.0,
        damping: 0.0,
        mass: 0.0,
        dt: 0.01,
        start_force: 0.0,
        weight: 1.0,
        tolerance: 1e-9,
        bounds: (-0.02, 0.02),
    };

    #[test]
    fn a_linear_spring_is_balanced_from_the_air_and_from_too_deep() {
        let spring = |z: f64| {
            let stiffness = if z < 0.0 { 1e6 } else { 0.0 };
            Ok::<_, ()>(Response { force: (-1e6 * z).max(0.0), stiffness, depth: -z })
        };
        for guess in [0.01, -0.015, 0.0] {
            let travel = IDEAL.solve(guess, spring).unwrap().expect("a balance");
            assert!((travel + 15e-6).abs() < 1e-12, "{travel}");
        }
        // A disc on a dome meets 20 N/m at first, and 3e4 N/m in the end.
        let dome = |z: f64| {
            let depth = (-z - 1e-3).max(0.0);
            let stiffness = 20.0 * f64::from(depth > 0.0) + 6e7 * depth;
            Ok::<_, ()>(Response { force: 20.0 * depth + 3e7 * depth * depth, stiffness, depth: -z - 1e-3 })
        };
        let travel = IDEAL.solve(0.01, dome).unwrap().expect("a balance");
        assert!((dome(travel).unwrap().force - 15.0).abs() < 1e-6, "{travel}");
        let nothing = |_| Ok::<_, ()>(Response { force: 0.0, stiffness: 0.0, depth: f64::NEG_INFINITY });
        assert_eq!(IDEAL.solve(0.0, nothing), Ok(None));
    }

    #[test]
    fn a_contact_stiffer_than_its_reported_stiffness_is_balanced_within_few_evaluations() {
        // Newton's steps with half of the true stiffness or less would go round for ever.
        for share in [0.5, 0.3, 0.01] {
            let mut evaluations = 0;
            let travel = IDEAL.solve(-1e-6, |z: f64| {
                evaluations += 1;
                Ok::<_, ()>(Response { force: (-1e6 * z).max(0.0), stiffness: share * 1e6, depth: -z })
            });
            assert!((travel.unwrap().expect("a balance") + 15e-6).abs() < 1e-12);
            assert!(evaluations <= 8, "{share}: {evaluations}");
        }
    }

    #[test]
    fn steps_on_a_quadratic_contact_of_the_reported_stiffness_are_newtons() {
        let contact = |depth: f64| (1e6 * depth + 2e10 * depth * depth, 1e6 + 4e10 * depth);
        let mut depths = Vec::new();
        let travel = IDEAL.solve(-50e-6, |z: f64| {
            depths.push(-z);
            let (force, stiffness) = contact(-z);
            Ok::<_, ()>(Response { force, stiffness, depth: -z })
        });
        assert!((contact(-travel.unwrap().expect("a balance")).0 - 15.0).abs() < 1e-9);
        for pair in depths.windows(2) {
            let (force, stiffness) = contact(pair[0]);
            assert!((pair[1] - (pair[0] + (15.0 - force) / stiffness)).abs() < 1e-13, "{depths:?}");
        }
        assert!(depths.len() >= 4, "{depths:?}");
    }

    #[test]
    fn a_step_of_any_length_on_a_spring_and_a_damper_is_exact() {
        let (spring, damping, setpoint) = (1e6, 1500.0, 15.0);
        for dt in [1e-5, 1e-3, 1e-2, 1.0] {
            let x = dt * spring / damping;
            let balance = Balance {
                from: Motion::default(),
                setpoint,
                damping,
                mass: 0.0,
                dt,
                start_force: 0.0,
                weight: end_weight(x),
                tolerance: 1e-9,
                bounds: (-0.02, 0.02),
            };
            let respond = |z: f64| Ok::<_, ()>(Response { force: -spring * z, stiffness: spring, depth: -z });
            let travel = balance.solve(0.0, respond).unwrap().expect("a balance");
            let exact = setpoint * -(-x).exp_m1() / spring;
            assert!((travel + exact).abs() < 1e-9 * exact + 1e-14, "{dt} s: {travel} {exact}");
        }
    }

    #[test]
    fn an_admittance_on_a_flat_spring_approaches_the_setpoint_as_the_closed_form_says() {
        // M = 0: F = F_d (1 - exp(-t/tau)), tau = B/(K A).
        let (spring, damping, setpoint, dt) = (1e6, 1500.0, 15.0, 1e-6);
        let mut motion = Motion::default();
        for _ in 0..1500 {
            motion = admittance_sample(motion, -spring * motion.travel, setpoint, (0.0, damping), dt);
        }
        let force = -spring * motion.travel;
        let exact = setpoint * (1.0 - (-1500.0 * dt * spring / damping).exp());
        assert!((force / exact - 1.0).abs() < 1e-3, "{force} {exact}");
    }
}
