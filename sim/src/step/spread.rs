//! Two points of each square in contact, for laws that are not linear: where a threshold lies among the depths of a square,
//! the rate at their mean is less than the mean of the rates.

use crate::contact::{Squares, runs};

/// Least distance of the points from the mean depth, of that depth.
const LEAST: f64 = 1e-3;

/// One of Gauss's two points of the depths in each square.
#[derive(Clone, Debug, Default)]
pub(super) struct Point {
    /// [m]
    pub(super) depth: Vec<f64>,
    pub(super) pressure: Vec<f64>,
    pub(super) rate: Vec<f64>,
}

/// Puts the points as far from the mean depths as the depths of each square are spread: they rise evenly across it, and
/// from zero where only a part of it is wet.
pub(super) struct Spread<'a> {
    pub(super) squares: &'a Squares,
    /// Lines in a row of the window.
    pub(super) across: usize,
    pub(super) lines: &'a [u32],
    /// Mean depths of the lines [m].
    pub(super) mean: &'a [f64],
    pub(super) points: &'a mut [Point; 2],
}

impl pulp::NullaryFnOnce for Spread<'_> {
    type Output = ();

    #[inline(always)]
    fn call(self) {
        let Self { squares, across, lines, mean, points: [shallow, deep] } = self;
        shallow.depth.resize(lines.len(), 0.0);
        deep.depth.resize(lines.len(), 0.0);
        let mut first = 0;
        for run in runs(lines) {
            let count = run.len();
            let from = |line: usize| &squares.depth[line..line + count];
            let (before, after) = (from(run.start - across), from(run.start + across));
            let (left, right) = (from(run.start - 1), from(run.start + 1));
            let lanes = first..first + count;
            let mean = &mean[lanes.clone()];
            let (shallow, deep) = (&mut shallow.depth[lanes.clone()], &mut deep.depth[lanes]);
            for i in 0..count {
                let (u, v) = (0.25 * (after[i] - before[i]), 0.25 * (right[i] - left[i]));
                let spread = ((u * u + v * v) / 3.0).sqrt().min(mean[i] * (1.0 / 3.0f64).sqrt()).max(LEAST * mean[i]);
                (shallow[i], deep[i]) = (mean[i] - spread, mean[i] + spread);
            }
            first += count;
        }
    }
}
