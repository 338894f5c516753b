//! The tool at one end of a step: the cells under it, and those in contact as lanes.

use std::ops::Range;

use glam::DVec3;

use crate::clock::Phase;
use crate::contact::{Columns, ContactCells, Ground};
use crate::lines::{Lines, Run};
use crate::physics::Physics;
use crate::pose::Placement;
use effects::RunError;
use sdf_bake::simd::in_wide_lanes;

/// The tool at one moment of a step.
#[derive(Clone, Debug, Default)]
pub(crate) struct Side {
    /// The tool's reference point [m].
    pub(super) centre: DVec3,
    pub(super) contact_cells: ContactCells,
    pub(super) lanes: ContactState,
}

impl Side {
    /// Measures the tool at a placement. `gap` receives the distance that effects add between tool and workpiece.
    pub(super) fn measure(
        &mut self,
        place: &Placement,
        ground: &Ground,
        physics: &mut Physics,
        gap: &mut Vec<f64>,
    ) -> Result<(), RunError> {
        self.centre = place.pose.centre;
        physics.gap(place, ground, gap)?;
        self.contact_cells.measure(place, ground, gap);
        physics.lap(Phase::Cells);
        Ok(())
    }
}

/// State of the cells in contact at one end of a step.
#[derive(Clone, Debug, Default)]
pub(crate) struct ContactState {
    /// Mean depth over the share in contact [m].
    pub(super) depth: Vec<f64>,
    pub(super) share: Vec<f64>,
    /// Depth that enters the recession law [m], negative in the air, and the share of the cell that recedes with it.
    pub(super) own: Vec<f64>,
    pub(super) cover: Vec<f64>,
    /// 1 if that depth is the depth at the column, over flat work; 0 if it is the mean over the share in contact.
    pub(super) flat: Vec<f64>,
    /// True if any lane is flat.
    pub(super) is_flat: bool,
    /// Positive part of that depth [m], and the pressure at it [Pa].
    wet: Vec<f64>,
    wet_pressure: Vec<f64>,
    pub(super) pressure: Vec<f64>,
    pub(super) rate: Vec<f64>,
    pub(super) dose_rate: Vec<f64>,
}

impl ContactState {
    /// Copies depth and share of `lines` from the cells.
    pub(super) fn gather(&mut self, contact_cells: &ContactCells, lines: &Lines) {
        let Self { depth, share, .. } = self;
        depth.resize(lines.len(), 0.0);
        share.resize(lines.len(), 0.0);
        in_wide_lanes(
            #[inline(always)]
            || {
                for Run { lines, lanes } in lines.runs() {
                    let (means, shares) =
                        (&contact_cells.mean_depth[lines.clone()], &contact_cells.share[lines.clone()]);
                    let own = depth[lanes.clone()].iter_mut().zip(&mut share[lanes.clone()]);
                    for (((depth, own), mean), share) in own.zip(means).zip(shares) {
                        *own = *share;
                        *depth = if *share > 0.0 { mean / share } else { 0.0 };
                    }
                }
            },
        );
    }

    /// Sets the recession depth to `times` the greater of two, lane by lane.
    pub(super) fn set_deeper(&mut self, one: &Self, other: &Self, times: f64) {
        let depths = one.own.iter().zip(&other.own);
        self.own.clear();
        self.own.extend(depths.map(|(a, b)| if a > b { *a } else { *b } * times));
    }

    /// Evaluates the pressure at the mean depths.
    pub(super) fn press(&mut self, physics: &Physics, depth_rate: &[f64]) -> Result<(), RunError> {
        physics.pressure(&self.depth, depth_rate, &mut self.pressure)
    }

    /// Evaluates the pressure at the mean depths, and the recession speed at the recession depths. Where the two depths
    /// differ, the pressure is taken as proportional to the depth.
    pub(super) fn grind(&mut self, physics: &Physics, depth_rate: &[f64]) -> Result<(), RunError> {
        self.press(physics, depth_rate)?;
        if !self.is_flat {
            return physics.rate(&self.depth, &self.pressure, &mut self.rate);
        }
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

    /// Evaluates the recession speed at the recession depths alone.
    pub(super) fn probe(&mut self, physics: &Physics, depth_rate: &[f64]) -> Result<(), RunError> {
        let Self { own, wet, wet_pressure, rate, .. } = self;
        wet.clear();
        wet.extend(own.iter().map(|own| if *own > 0.0 { *own } else { 0.0 }));
        physics.pressure(wet, depth_rate, wet_pressure)?;
        physics.rate(wet, wet_pressure, rate)
    }

    /// Evaluates the dose per time under the pressures.
    pub(super) fn sand(&mut self, physics: &Physics) -> Result<(), RunError> {
        physics.dose_rate(&self.depth, &self.pressure, &mut self.dose_rate)
    }
}

/// Sets the recession depths at both ends of a step, on a height field `across` columns wide under a tool with certain
/// `bends` (see [`Columns::is_flat`]).
///
/// Over flat work the recession depth is the depth at the column. Then a column meets a threshold when the tool does,
/// and the columns' removal sums to that of the work. Elsewhere the depth within a cell is not known, and the recession
/// depth is the mean over the share in contact. The cell recedes by that share of the rate, so that pressure and
/// removal are consistent.
pub(super) fn gather_receding((start, end): (&mut Side, &mut Side), (across, bends): (usize, [f64; 2]), lines: &Lines) {
    let (before, after) = (&start.contact_cells, &end.contact_cells);
    let (start, end) = (&mut start.lanes, &mut end.lanes);
    for end in [&mut *start, &mut *end] {
        end.own.clone_from(&end.depth);
        end.cover.clone_from(&end.share);
        end.flat.clear();
        end.flat.resize(lines.len(), 0.0);
        end.is_flat = false;
    }
    if bends[0] == 0.0 {
        return;
    }
    let any = in_wide_lanes(
        #[inline(always)]
        || {
            let mut any = false;
            for Run { lines: run, lanes } in lines.runs() {
                let known = after.known(&before.known(run, across), across);
                let columns = [before, after].map(|contact_cells| contact_cells.columns(known.clone(), across));
                let first = lanes.start + (known.start - run.start);
                any |= recede_in_row((start, end), &columns, first..first + known.len(), bends);
            }
            any
        },
    );
    (start.is_flat, end.is_flat) = (any, any);
}

/// The same for the columns of one row, in some `lanes`. Returns true if the work is flat under any.
#[inline(always)]
fn recede_in_row(
    (start, end): (&mut ContactState, &mut ContactState),
    [before, after]: &[Columns; 2],
    lanes: Range<usize>,
    bends: [f64; 2],
) -> bool {
    let count = lanes.len();
    let (before, after) = (before.first(count), after.first(count));
    let (own_a, cover_a) = (&mut start.own[lanes.clone()][..count], &mut start.cover[lanes.clone()][..count]);
    let (own_b, cover_b) = (&mut end.own[lanes.clone()][..count], &mut end.cover[lanes.clone()][..count]);
    let flats = &mut end.flat[lanes][..count];
    let mut any = false;
    for i in 0..count {
        let (a, b) = (before.depth[i], after.depth[i]);
        let is_flat = before.is_flat(i, bends) & after.is_flat(i, bends) & ((a > 0.0) | (b > 0.0));
        let covers = (before.cover(i), after.cover(i));
        // A column in the air takes its cover from the other end of the step.
        let cover_before = if (covers.0 == 0.0) & (a < 0.0) { covers.1 } else { covers.0 };
        let cover_after = if (covers.1 == 0.0) & (b < 0.0) { covers.0 } else { covers.1 };
        own_a[i] = if is_flat { a } else { own_a[i] };
        own_b[i] = if is_flat { b } else { own_b[i] };
        cover_a[i] = if is_flat { cover_before } else { cover_a[i] };
        cover_b[i] = if is_flat { cover_after } else { cover_b[i] };
        flats[i] = f64::from(u8::from(is_flat));
        any |= is_flat;
    }
    any
}
