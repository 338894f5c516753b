//! A pass in stretches: after each, the caller decides on the further path and setpoint.

use sdf_bake::BrickGrid;

use crate::control::Motion;
use crate::record::PassRecord;
use crate::settings::{Pass, PassError};
use crate::step::{Runner, Suspended};
use effects::{Reset, States};

/// A pass between two stretches: the controller's motion, the states of formulas, and the height fields in use.
///
/// Between stretches the surface may have receded further than the field shows: see [`Underway::settle`].
#[derive(Default)]
pub struct Underway(Option<Suspended>);

impl Underway {
    /// Travel and speed of the tool along its approach axis; zero before the first stretch.
    pub fn motion(&self) -> Motion {
        self.0.as_ref().map_or(Motion::default(), |kept| kept.motion)
    }

    /// Writes the recession back into the field. The next stretch reads the field again, so its results differ by
    /// rounding from those of a pass that was not settled here.
    pub fn settle(&mut self, grid: &mut BrickGrid) {
        if let Some(kept) = &mut self.0 {
            kept.settle(grid);
        }
    }

    /// A copy of a settled pass. Continuing from the copy, with a copy of field and tool, gives the same bytes.
    ///
    /// # Panics
    /// If the pass was continued since [`Underway::settle`].
    #[must_use]
    pub fn copy(&self) -> Self {
        Self(self.0.as_ref().map(Suspended::copy))
    }
}

/// Continues a pass to the time `until` [s] since it began; changes `grid` and the tool's `states` as
/// [`run_pass`](crate::run_pass) does. Returns the record of this stretch; its log has no approach and no retract.
///
/// The path's times are measured from the beginning of the pass. The path may extend beyond `until`: then the height
/// field that was read also serves the next stretch, if the tool continues on that path.
///
/// # Errors
/// As for [`run_pass`](crate::run_pass), except a contact that is too soft. The pass is then over and `underway` is
/// reset.
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
