//! A segment of a planar curve whose curvature changes linearly: a segment of a clothoid.

use glam::DVec2;

/// A planar curve from `start` along `heading`, with curvature `curvature + slope·σ` at arc length σ.
#[derive(Clone, Copy, Debug)]
pub(super) struct Arc {
    pub(super) start: DVec2,
    /// Unit vector.
    pub(super) heading: DVec2,
    pub(super) curvature: f64,
    pub(super) slope: f64,
}

/// Greatest heading change [rad] of one arc; five Gauss points then give the position exactly to rounding.
pub(super) const LARGEST_TURN: f64 = 0.25;

/// Five-point Gauss-Legendre nodes and weights on [-1, 1].
const GAUSS: [(f64, f64); 5] = [
    (-0.906_179_845_938_664, 0.236_926_885_056_189_1),
    (-0.538_469_310_105_683_1, 0.478_628_670_499_366_5),
    (0.0, 0.568_888_888_888_888_9),
    (0.538_469_310_105_683_1, 0.478_628_670_499_366_5),
    (0.906_179_845_938_664, 0.236_926_885_056_189_1),
];

impl Arc {
    pub(super) fn point(&self, length: f64) -> DVec2 {
        if self.is_straight() {
            return self.start + length * self.heading;
        }
        let half = 0.5 * length;
        let sum: DVec2 = GAUSS.iter().map(|(node, weight)| *weight * self.heading_at(half * (node + 1.0))).sum();
        self.start + half * sum
    }

    pub(super) fn is_straight(&self) -> bool {
        self.curvature == 0.0 && self.slope == 0.0
    }

    pub(super) fn heading_at(&self, length: f64) -> DVec2 {
        DVec2::from_angle(length * (self.curvature + 0.5 * self.slope * length)).rotate(self.heading)
    }

    /// Arc length at which the curve leaves the half-plane to the left of a line, within `length`.
    ///
    /// - `on`, `along`: a point of the line and its unit direction
    /// - `slack`: distance outside that still counts as on the line
    ///
    /// The arc turns in one direction and by at most [`LARGEST_TURN`], so its distance from the line has at most one
    /// extremum:
    ///
    /// ```text
    ///          .-'''-.          rises, then falls: leaves on the second stretch
    ///   ----o'---------'x----   the line
    /// ```
    pub(super) fn leaves(&self, on: DVec2, along: DVec2, length: f64, slack: f64) -> Option<f64> {
        if self.is_straight() {
            let (height, rise) = (along.perp_dot(self.start - on), along.perp_dot(self.heading));
            return (rise < 0.0 && height + rise * length < -slack).then(|| (-height / rise).max(0.0));
        }
        // The line is out of reach: no point of the arc is farther from its start than the arc's length.
        if along.perp_dot(self.start - on) > length {
            return None;
        }
        let height = |s: f64| along.perp_dot(self.point(s) - on);
        let rise = |s: f64| along.perp_dot(self.heading_at(s));
        let (first, last) = (rise(0.0), rise(length));
        let extremum = match first {
            _ if first * last < 0.0 => root(rise, |_| f64::NAN, 0.0, length),
            0.0 => 0.0,
            _ => length,
        };
        for (from, to, falls) in [(0.0, extremum, first < 0.0), (extremum, length, last < 0.0)] {
            if falls && height(to) < -slack {
                return Some(if height(from) <= 0.0 { from } else { root(height, rise, from, to) });
            }
        }
        None
    }
}

/// Finds the root of a function that changes sign once between `low` and `high`: Newton's method kept inside the
/// bracket.
fn root(value: impl Fn(f64) -> f64, slope: impl Fn(f64) -> f64, mut low: f64, mut high: f64) -> f64 {
    let (at_low, at_high) = (value(low), value(high));
    let sign_low = at_low.signum();
    // The secant's root is already close, because the arcs turn little.
    let chord = low + (high - low) * at_low / (at_low - at_high);
    let mut x = if chord > low && chord < high { chord } else { 0.5 * (low + high) };
    for _ in 0..80 {
        let y = value(x);
        if y == 0.0 {
            return x;
        }
        if y.signum() == sign_low {
            low = x
        } else {
            high = x
        }
        let newton = x - y / slope(x);
        let next = if newton > low && newton < high { newton } else { 0.5 * (low + high) };
        if (next - x).abs() <= 4.0 * f64::EPSILON * next.abs() {
            return next;
        }
        x = next;
    }
    x
}
