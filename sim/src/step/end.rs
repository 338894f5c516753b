//! The squares in contact at one end of a step, one lane each.

use crate::contact::Squares;
use crate::lines::{Lines, Run};
use crate::physics::Physics;
use effects::RunError;
use sdf_bake::simd::in_wide_lanes;

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
    pub(super) fn gather(&mut self, squares: &Squares, lines: &Lines) {
        let Self { depth, share, .. } = self;
        depth.resize(lines.len(), 0.0);
        share.resize(lines.len(), 0.0);
        in_wide_lanes(
            #[inline(always)]
            || {
                for Run { lines, lanes } in lines.runs() {
                    let (means, shares) = (&squares.mean_depth[lines.clone()], &squares.share[lines.clone()]);
                    share[lanes.clone()].copy_from_slice(shares);
                    for ((depth, mean), share) in depth[lanes.clone()].iter_mut().zip(means).zip(shares) {
                        *depth = if *share > 0.0 { mean / share } else { 0.0 };
                    }
                }
            },
        );
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
