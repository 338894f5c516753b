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
    /// Depth that recedes by the law [m], negative in the air, and the share of the square that recedes with it.
    pub(super) own: Vec<f64>,
    pub(super) cover: Vec<f64>,
    /// 1 where that is the depth at the column, over flat work; 0 where it is the mean over the wet share.
    pub(super) flat: Vec<f64>,
    /// That depth where it is positive, 0 elsewhere [m], and the pressure there [Pa].
    wet: Vec<f64>,
    wet_pressure: Vec<f64>,
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

    /// Takes `times` the greater of two depths that recede, lane by lane.
    pub(super) fn set_deeper(&mut self, one: &Self, other: &Self, times: f64) {
        let depths = one.own.iter().zip(&other.own);
        self.own.clear();
        self.own.extend(depths.map(|(a, b)| if a > b { *a } else { *b } * times));
    }

    /// Pressure at the depths.
    pub(super) fn press(&mut self, physics: &Physics, depth_rate: &[f64]) -> Result<(), RunError> {
        physics.pressure(&self.depth, depth_rate, &mut self.pressure)
    }

    /// Pressure at the depths, and recession speed at those that recede: where the two differ, the pressure is straight in the
    /// depth.
    pub(super) fn grind(&mut self, physics: &Physics, depth_rate: &[f64]) -> Result<(), RunError> {
        self.press(physics, depth_rate)?;
        let Self { depth, own, wet, pressure, wet_pressure, rate, .. } = self;
        wet.clear();
        wet.extend(own.iter().map(|own| if *own > 0.0 { *own } else { 0.0 }));
        wet_pressure.clear();
        let pressures = wet.iter().zip(&*depth).zip(&*pressure);
        wet_pressure.extend(pressures.map(|((wet, depth), pressure)| {
            if wet == depth { *pressure } else { pressure * (wet / depth.max(f64::MIN_POSITIVE)) }
        }));
        physics.rate(wet, wet_pressure, rate)
    }

    /// Recession speed at the depths that recede alone.
    pub(super) fn probe(&mut self, physics: &Physics, depth_rate: &[f64]) -> Result<(), RunError> {
        let Self { own, wet, wet_pressure, rate, .. } = self;
        wet.clear();
        wet.extend(own.iter().map(|own| if *own > 0.0 { *own } else { 0.0 }));
        physics.pressure(wet, depth_rate, wet_pressure)?;
        physics.rate(wet, wet_pressure, rate)
    }

    /// Dose per time under the pressures.
    pub(super) fn sand(&mut self, physics: &Physics) -> Result<(), RunError> {
        physics.dose_rate(&self.depth, &self.pressure, &mut self.dose_rate)
    }
}

/// Takes the depths that recede at both ends of a step, on a sheet `across` lines wide under a tool of certain `bends` (see
/// [`Squares::flat_column`]).
///
/// Over flat work that is the depth at the column: then a column meets a threshold when the tool does, and the sum of what
/// columns lose is that of the work. Elsewhere the depth within a square is not known; there it is the mean over the wet share, of
/// which the square recedes by that share, so that pressure and removal go together.
pub(super) fn gather_receding(
    (start, end): (&mut End, &mut End),
    (before, after): (&Squares, &Squares),
    (across, bends): (usize, [f64; 2]),
    lines: &Lines,
) {
    for end in [&mut *start, &mut *end] {
        end.own.clone_from(&end.depth);
        end.cover.clone_from(&end.share);
        end.flat.clear();
        end.flat.resize(lines.len(), 0.0);
    }
    if bends[0] == 0.0 {
        return;
    }
    for (lane, &line) in lines.list().iter().enumerate() {
        let columns = [before, after].map(|squares| squares.flat_column(line as usize, across, bends));
        if let [Some(a), Some(b)] = columns
            && a.0.max(b.0) > 0.0
        {
            // A column in the air has the cover that it has at the other end.
            let in_air = |one: (f64, f64), other: (f64, f64)| if one.0 < 0.0 && one.1 == 0.0 { other.1 } else { one.1 };
            (start.own[lane], start.cover[lane]) = (a.0, in_air(a, b));
            (end.own[lane], end.cover[lane]) = (b.0, in_air(b, a));
            (start.flat[lane], end.flat[lane]) = (1.0, 1.0);
        }
    }
}
