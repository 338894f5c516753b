//! The squares in contact at one end of a step, one lane each.

use super::lanes::runs_with_lanes;
use crate::contact::Squares;
use crate::effect::RunError;
use crate::physics::Physics;

/// State of the squares in contact at one end of a step.
#[derive(Clone, Debug, Default)]
pub(super) struct End {
    /// Mean depth over the wet share [m].
    pub(super) depth: Vec<f64>,
    pub(super) share: Vec<f64>,
    pub(super) pressure: Vec<f64>,
    pub(super) rate: Vec<f64>,
    pub(super) dose_rate: Vec<f64>,
}

impl End {
    /// Takes depth and share of `lines` from the squares.
    pub(super) fn gather(&mut self, squares: &Squares, lines: &[u32]) {
        let Self { depth, share, .. } = self;
        depth.resize(lines.len(), 0.0);
        share.resize(lines.len(), 0.0);
        pulp::Arch::new().dispatch(|| {
            for (run, lanes) in runs_with_lanes(lines) {
                let (means, shares) = (&squares.mean_depth[run.clone()], &squares.share[run]);
                share[lanes.clone()].copy_from_slice(shares);
                for ((depth, mean), share) in depth[lanes].iter_mut().zip(means).zip(shares) {
                    *depth = if *share > 0.0 { mean / share } else { 0.0 };
                }
            }
        });
    }

    /// Pressure at the depths.
    pub(super) fn press(&mut self, physics: &Physics, depth_rate: &[f64]) -> Result<(), RunError> {
        physics.pressure(&self.depth, depth_rate, &mut self.pressure)
    }

    /// Pressure and recession speed at the depths.
    pub(super) fn grind(&mut self, physics: &Physics, depth_rate: &[f64]) -> Result<(), RunError> {
        self.press(physics, depth_rate)?;
        physics.rate(&self.depth, &self.pressure, &mut self.rate)
    }

    /// Dose per time under the pressures.
    pub(super) fn sand(&mut self, physics: &Physics) -> Result<(), RunError> {
        physics.dose_rate(&self.depth, &self.pressure, &mut self.dose_rate)
    }
}

/// Lines that are in either of two lists in order, in order.
pub(super) fn merge(a: &[u32], b: &[u32], lines: &mut Vec<u32>) {
    lines.clear();
    let (mut i, mut j) = (0, 0);
    while i < a.len() && j < b.len() {
        let (first, second) = (a[i], b[j]);
        lines.push(first.min(second));
        i += usize::from(first <= second);
        j += usize::from(second <= first);
    }
    lines.extend_from_slice(&a[i..]);
    lines.extend_from_slice(&b[j..]);
}

#[cfg(test)]
mod tests {
    #[test]
    fn lists_in_order_are_merged_without_doubles() {
        let mut lines = vec![9];
        super::merge(&[1, 4, 5], &[0, 4, 7], &mut lines);
        assert_eq!(lines, [0, 1, 4, 5, 7]);
    }
}
