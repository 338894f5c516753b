//! Weights of an exponential integrator (Hochbruck and Ostermann 2010, eq. 2.11): φ at the step's end, ψ for its mean.

/// Weights of a step with `x = λ dt`.
pub(crate) struct PhiWeights {
    /// λ dt
    pub(crate) x: f64,
    /// (1 - e^-x)/x
    pub(crate) phi1: f64,
    /// (x - 1 + e^-x)/x²
    pub(crate) phi2: f64,
    /// (1 - φ1)/x
    pub(crate) psi1: f64,
    /// (1/2 - φ2)/x
    pub(crate) psi2: f64,
}

impl PhiWeights {
    /// Recession over a step per bulge. The bulge is the excess of the depth over its linear course in the middle of
    /// the step, for a parabola over time.
    pub(crate) fn bulge_gain(&self) -> f64 {
        4.0 * self.x * (self.phi2 - 2.0 * self.psi2)
    }

    pub(crate) fn new(x: f64) -> Self {
        if x < 1e-2 {
            // Series, because the closed forms cancel.
            return Self {
                x,
                phi1: 1.0 - x / 2.0 * (1.0 - x / 3.0 * (1.0 - x / 4.0)),
                phi2: 0.5 - x / 6.0 * (1.0 - x / 4.0 * (1.0 - x / 5.0)),
                psi1: 0.5 - x / 6.0 * (1.0 - x / 4.0 * (1.0 - x / 5.0)),
                psi2: 1.0 / 6.0 - x / 24.0 * (1.0 - x / 5.0 * (1.0 - x / 6.0)),
            };
        }
        let phi1 = -(-x).exp_m1() / x;
        let phi2 = (1.0 - phi1) / x;
        Self { x, phi1, phi2, psi1: phi2, psi2: (0.5 - phi2) / x }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn series_and_closed_forms_of_the_weights_meet() {
        let (low, high) = (PhiWeights::new(1e-2 - 1e-9), PhiWeights::new(1e-2 + 1e-9));
        for (a, b) in [(low.phi1, high.phi1), (low.phi2, high.phi2), (low.psi1, high.psi1), (low.psi2, high.psi2)] {
            assert!((a - b).abs() < 1e-8, "{a} {b}");
        }
    }

    #[test]
    fn the_weights_solve_the_linear_equation() {
        // m' = s - λ m from m = a, without recession it would end at b: compare with many small steps.
        let (a, b, lambda, dt) = (2.0, 3.0, 5.0, 0.3);
        let n = 200_000;
        let (mut m, mut removed, mut mean) = (a, 0.0, 0.0);
        for _ in 0..n {
            let h = dt / f64::from(n);
            let rate = lambda * (m + 0.5 * h * ((b - a) / dt - lambda * m));
            removed += h * rate;
            m += h * ((b - a) / dt - rate);
            mean += removed / f64::from(n);
        }
        let decay = PhiWeights::new(lambda * dt);
        let step = dt * lambda * (a * decay.phi1 + (b - a) * decay.phi2);
        let step_mean = dt * lambda * (a * decay.psi1 + (b - a) * decay.psi2);
        assert!((step / removed - 1.0).abs() < 1e-6, "{step} {removed}");
        assert!((step_mean / mean - 1.0).abs() < 1e-5, "{step_mean} {mean}");
    }
}
