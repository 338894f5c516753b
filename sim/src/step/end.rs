//! The squares in contact at one end of a step, one lane each.

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
        self.depth.clear();
        self.share.clear();
        for &line in lines {
            let share = squares.share[line as usize];
            self.share.push(share);
            self.depth.push(if share > 0.0 { squares.mean_depth[line as usize] / share } else { 0.0 });
        }
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

/// One lane at one end.
pub(super) struct Side {
    pub(super) depth: f64,
    pub(super) share: f64,
    pub(super) pressure: f64,
    pub(super) rate: f64,
}

impl Side {
    pub(super) fn of(end: &End, lane: usize) -> Self {
        Self { depth: end.depth[lane], share: end.share[lane], pressure: end.pressure[lane], rate: end.rate[lane] }
    }
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
