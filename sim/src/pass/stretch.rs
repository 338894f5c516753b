//! A pass in stretches: who moves the tool decides, stretch by stretch, where it goes on and how hard it presses.

use sdf_bake::BrickGrid;

use crate::control::Motion;
use crate::record::PassRecord;
use crate::settings::{Pass, PassError};
use crate::step::{Runner, Suspended};
use effects::{Reset, States};

/// A pass between two stretches: the controller's motion, what formulas remember, and what was read of the field.
///
/// Between stretches the surface may have sunk further than the field shows: see [`Underway::settle`].
#[derive(Default)]
pub struct Underway(Option<Suspended>);

impl Underway {
    /// Travel and speed of the tool along its approach axis; at rest on its path before the first stretch.
    pub fn motion(&self) -> Motion {
        self.0.as_ref().map_or(Motion::default(), |kept| kept.motion)
    }

    /// Writes back into the field what the surface lost. The next stretch reads the field again, so that results differ by
    /// rounding from those of a pass that was not settled here.
    pub fn settle(&mut self, grid: &mut BrickGrid) {
        if let Some(kept) = &mut self.0 {
            kept.settle(grid);
        }
    }

    /// A copy of a pass that is settled. Who goes on from the copy, with a copy of field and tool, gets the same bytes.
    ///
    /// # Panics
    /// If the pass went on since [`Underway::settle`].
    #[must_use]
    pub fn copy(&self) -> Self {
        Self(self.0.as_ref().map(Suspended::copy))
    }
}

/// Runs a pass on to the time `until` [s] since it began; changes `grid` and the tool's `states` as
/// [`run_pass`](crate::run_pass) does. Returns what this stretch did; its log has no approach and no retract.
///
/// The path's times are those since the pass began. It may lead beyond `until`: then what is read of the surface serves
/// the next stretch, too, if the tool goes on so.
///
/// # Errors
/// As [`run_pass`](crate::run_pass), but for a contact too soft. The pass is then over: `underway` is a new one.
pub fn run_stretch(
    grid: &mut BrickGrid,
    pass: Pass,
    states: &mut States,
    (underway, until): (&mut Underway, f64),
) -> Result<PassRecord, PassError> {
    pass.settings.check(grid, pass.tool)?;
    let longest_step = pass.settings.longest_step(pass.model)?;
    let kept = underway.0.take();
    if kept.is_none() {
        states.reset(pass.model, Reset::Pass);
    }
    let mut runner = Runner::new(grid, pass, states, longest_step).until(until);
    if let Some(kept) = kept {
        runner.take_up(kept);
    }
    let begun = runner.time();
    while runner.time() < until {
        if let Err(error) = runner.step() {
            runner.write_back();
            return Err(PassError::Formula { time: runner.time(), error });
        }
    }
    let (mut record, kept) = runner.suspend();
    underway.0 = Some(kept);
    record.end_stretch(until - begun);
    Ok(record)
}
