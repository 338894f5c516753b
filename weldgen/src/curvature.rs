//! Geodesic curvature as a function of arc length: the steering of a weld curve.

use rand::RngExt;
use std::f64::consts::TAU;

/// κ_g(s) [1/m], piecewise linear between evenly spaced knots and constant beyond them.
///
/// Positive values steer to the left: towards normal × tangent.
#[derive(Clone, Debug, PartialEq)]
pub struct CurvatureProfile {
    first: f64,
    spacing: f64,
    knots: Vec<f64>,
}

/// The straight stretch of a profile at some arc length.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Stretch {
    /// Curvature here [1/m].
    pub(crate) value: f64,
    /// Its change per arc length [1/m²].
    pub(crate) slope: f64,
    /// Arc length to the end of the stretch [m].
    pub(crate) left: f64,
}

impl CurvatureProfile {
    /// The same curvature [1/m] everywhere; 0 is a geodesic.
    pub fn constant(curvature: f64) -> Self {
        Self { first: 0.0, spacing: 1.0, knots: vec![curvature] }
    }

    /// Curvatures [1/m] at arc lengths `first + i·spacing` [m].
    ///
    /// `None` unless all numbers are finite, the spacing is positive and there is a knot.
    pub fn linear(first: f64, spacing: f64, knots: Vec<f64>) -> Option<Self> {
        let proper = first.is_finite() && spacing.is_finite() && spacing > 0.0 && !knots.is_empty();
        (proper && knots.iter().all(|knot| knot.is_finite())).then_some(Self { first, spacing, knots })
    }

    /// A smooth random profile over `[-reach, reach]` whose root mean square is `rms` [1/m], capped at `max` [1/m].
    ///
    /// Four harmonics of random phase with periods down to `correlation` [m]. Where the cap binds, the whole profile
    /// is scaled down, which keeps it smooth.
    pub fn smooth(reach: f64, correlation: f64, rms: f64, max: f64, rng: &mut impl RngExt) -> Self {
        let waves: [(f64, f64, f64); 4] = std::array::from_fn(|i| {
            let period = correlation * 4.0 / (i + 1) as f64;
            (TAU / period, TAU * rng.random::<f64>(), rng.random::<f64>() + 0.1)
        });
        let count = 2 * ((32.0 * reach / correlation).ceil() as usize).clamp(8, 4096);
        let spacing = 2.0 * reach / count as f64;
        let at = |i: usize| {
            let s = i as f64 * spacing - reach;
            waves.iter().map(|(rate, phase, size)| size * (rate * s + phase).sin()).sum::<f64>()
        };
        let knots: Vec<f64> = (0..=count).map(at).collect();
        let shape = Self { first: -reach, spacing, knots };
        let scale = (rms / shape.rms(-reach, reach)).min(max / shape.max_abs());
        let scale = if scale.is_finite() { scale } else { 0.0 };
        Self { knots: shape.knots.iter().map(|knot| knot * scale).collect(), ..shape }
    }

    /// κ_g [1/m] at arc length `s` [m].
    pub fn at(&self, s: f64) -> f64 {
        self.stretch(s).value
    }

    /// The profile met when the curve is walked from `s = 0` the other way: left and right change places.
    pub fn reversed(&self) -> Self {
        let last = self.first + self.spacing * (self.knots.len() - 1) as f64;
        Self { first: -last, spacing: self.spacing, knots: self.knots.iter().rev().map(|knot| -knot).collect() }
    }

    /// The profile times a factor, so that its root mean square over `[from, to]` is `rms` [1/m].
    ///
    /// Where the largest magnitude over the interval would pass `max` [1/m], the factor stops there.
    pub(crate) fn scaled_to(&self, rms: f64, max: f64, [from, to]: [f64; 2]) -> Self {
        let count = 256;
        let sample = |i: u32| self.at(from + (to - from) * f64::from(i) / f64::from(count)).abs();
        let peak = (0..=count).map(sample).fold(0.0, f64::max);
        let factor = (rms / self.rms(from, to)).min(max / peak);
        let factor = if factor.is_finite() { factor } else { 1.0 };
        Self { knots: self.knots.iter().map(|knot| knot * factor).collect(), first: self.first, spacing: self.spacing }
    }

    /// Whether every curvature is a number.
    pub(crate) fn is_finite(&self) -> bool {
        self.knots.iter().all(|knot| knot.is_finite())
    }

    /// Largest magnitude [1/m].
    pub fn max_abs(&self) -> f64 {
        self.knots.iter().fold(0.0, |max, knot| knot.abs().max(max))
    }

    /// Root mean square [1/m] over `[from, to]`, by Simpson's rule on pieces no longer than the knot spacing.
    pub fn rms(&self, from: f64, to: f64) -> f64 {
        let count = (2.0 * (to - from) / self.spacing).ceil().clamp(1.0, 1e5);
        let step = (to - from) / count;
        let piece = |i: f64| {
            let s = from + i * step;
            let [a, b, c] = [s, s + 0.5 * step, s + step].map(|s| self.at(s).powi(2));
            (a + 4.0 * b + c) / 6.0
        };
        ((0..count as u32).map(|i| piece(f64::from(i))).sum::<f64>() / count).sqrt()
    }

    pub(crate) fn stretch(&self, s: f64) -> Stretch {
        // A hair past a knot counts as beyond it, so that walking from knot to knot makes progress.
        let place = (s - self.first) / self.spacing + 1e-9;
        let last = self.knots.len() - 1;
        if place < 0.0 {
            return Stretch { value: self.knots[0], slope: 0.0, left: self.first - s };
        }
        let index = place as usize;
        if index >= last {
            return Stretch { value: self.knots[last], slope: 0.0, left: f64::INFINITY };
        }
        let start = self.first + index as f64 * self.spacing;
        let slope = (self.knots[index + 1] - self.knots[index]) / self.spacing;
        Stretch { value: self.knots[index] + slope * (s - start), slope, left: start + self.spacing - s }
    }
}
