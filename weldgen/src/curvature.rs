//! Geodesic curvature of a weld curve as a function of arc length.

use rand::RngExt;
use std::f64::consts::TAU;

/// Number of sines in a random shape.
const WAVES: usize = 16;
/// Gain, relative to the gain without a limit, at which the limiter has turned a shape into almost a rectangle.
const MOST_GAIN: f64 = 64.0;
/// Bisections of the gain, to a relative precision of 1e-7.
const GAIN_STEPS: usize = 24;

/// κ_g(s) [1/m], piecewise linear between evenly spaced knots and constant beyond them.
///
/// Positive values turn to the left: towards normal × tangent.
#[derive(Clone, Debug, PartialEq)]
pub struct CurvatureProfile {
    first: f64,
    spacing: f64,
    knots: Vec<f64>,
}

/// The linear segment of a profile at some arc length.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Stretch {
    /// Curvature [1/m].
    pub(crate) value: f64,
    /// Slope of the curvature over arc length [1/m²].
    pub(crate) slope: f64,
    /// Arc length to the end of the segment [m].
    pub(crate) left: f64,
}

impl CurvatureProfile {
    /// A constant curvature [1/m]; 0 gives a geodesic.
    pub fn constant(curvature: f64) -> Self {
        Self { first: 0.0, spacing: 1.0, knots: vec![curvature] }
    }

    /// Piecewise linear profile through curvatures [1/m] at arc lengths `first + i·spacing` [m].
    ///
    /// `None` unless all numbers are finite, the spacing is positive and there is at least one knot.
    pub fn linear(first: f64, spacing: f64, knots: Vec<f64>) -> Option<Self> {
        let proper = first.is_finite() && spacing.is_finite() && spacing > 0.0 && !knots.is_empty();
        (proper && knots.iter().all(|knot| knot.is_finite())).then_some(Self { first, spacing, knots })
    }

    /// A smooth random shape over `[-reach, reach]`: a Gaussian process of unit variance whose correlation at a
    /// distance Δ is exp(−Δ²/2ℓ²), with ℓ the `correlation` length [m].
    ///
    /// Sum of sixteen sines with random phases and with wavenumbers drawn from that spectrum (Shinozuka & Jan 1972).
    pub fn random(reach: f64, correlation: f64, rng: &mut impl RngExt) -> Self {
        let waves: [(f64, f64); WAVES] = std::array::from_fn(|_| {
            let radius = (-2.0 * (1.0 - rng.random::<f64>()).ln()).sqrt();
            let normal = radius * (TAU * rng.random::<f64>()).cos();
            (normal / correlation, TAU * rng.random::<f64>())
        });
        let count = 2 * ((16.0 * reach / correlation).ceil() as usize).clamp(8, 4096);
        let spacing = 2.0 * reach / count as f64;
        let at = |i: usize| {
            let s = i as f64 * spacing - reach;
            (2.0 / WAVES as f64).sqrt() * waves.iter().map(|(rate, phase)| (rate * s + phase).sin()).sum::<f64>()
        };
        Self { first: -reach, spacing, knots: (0..=count).map(at).collect() }
    }

    /// Converts the shape to a curvature of root mean square `rms` [1/m] over `[from, to]` that never exceeds `max`
    /// [1/m]: κ = max · tanh(g · shape / max), with the gain g found by bisection.
    ///
    /// If the shape is zero on the interval, or `rms` is so close to `max` that no gain reaches it, the nearest
    /// curvature is returned.
    pub fn limited_to(&self, rms: f64, max: f64, [from, to]: [f64; 2]) -> Self {
        let with_gain = |gain: f64| {
            let limit = |knot: &f64| if max.is_finite() { max * (gain * knot / max).tanh() } else { gain * knot };
            Self { knots: self.knots.iter().map(limit).collect(), first: self.first, spacing: self.spacing }
        };
        let start = rms / self.rms(from, to);
        if !start.is_finite() || rms == 0.0 {
            return Self { knots: vec![0.0; self.knots.len()], ..with_gain(0.0) };
        }
        let falls_short = |gain: f64| with_gain(gain).rms(from, to) < rms;
        let (mut low, mut high) = (0.5 * start, start);
        while falls_short(high) && high < MOST_GAIN * start {
            (low, high) = (high, 2.0 * high);
        }
        for _ in 0..GAIN_STEPS {
            let middle = 0.5 * (low + high);
            if falls_short(middle) { low = middle } else { high = middle }
        }
        with_gain(high)
    }

    /// κ_g [1/m] at arc length `s` [m].
    pub fn at(&self, s: f64) -> f64 {
        self.stretch(s).value
    }

    /// Profile for travel from `s = 0` in the opposite direction: left and right are exchanged.
    pub fn reversed(&self) -> Self {
        let last = self.first + self.spacing * (self.knots.len() - 1) as f64;
        Self { first: -last, spacing: self.spacing, knots: self.knots.iter().rev().map(|knot| -knot).collect() }
    }

    /// True if every curvature is finite.
    pub(crate) fn is_finite(&self) -> bool {
        self.knots.iter().all(|knot| knot.is_finite())
    }

    /// Greatest magnitude [1/m].
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
        // Positions slightly past a knot count as beyond it, so that stepping from knot to knot makes progress.
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
