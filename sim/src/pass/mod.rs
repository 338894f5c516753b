//! One pass: the tool follows its path, the controller holds the force, the surface recedes or loses its coating.
//!
//! While the tool moves a fraction of a voxel, the contact is stepped on a height field read from the distance field.
//! Then the recession is written back and the next height field is read. A step is as long as the tool needs for about
//! half a voxel. Where the controller's own dynamics matter, a step is as short as the controller's period.

mod idle_pause;
mod stretch;

pub use idle_pause::rest;
pub use stretch::{Underway, run_stretch};

use sdf_bake::BrickGrid;

use crate::record::PassRecord;
use crate::settings::{Pass, PassError};
use crate::step::Runner;
use effects::{Reset, States};

/// Progress of a pass.
#[derive(Clone, Copy, Debug)]
pub struct Progress {
    /// Time simulated [s].
    pub time: f64,
    /// Time of the whole pass [s].
    pub duration: f64,
    /// Current force [N]; 0 in the air.
    pub force: f64,
}

/// Runs one pass: changes `grid` and the tool's `states`, returns the log and what was removed.
///
/// # Errors
/// A setting out of range, a band that is too thin, a contact too soft for the setpoint throughout, more steps than
/// allowed, or a formula that gives no finite number: then the field holds the last good state.
pub fn run_pass(
    grid: &mut BrickGrid,
    pass: Pass,
    states: &mut States,
    progress: &mut dyn FnMut(Progress),
) -> Result<PassRecord, PassError> {
    pass.settings.check(grid, pass.tool)?;
    let longest_step = pass.settings.longest_step(pass.model)?;
    pass.settings.check_steps(pass.path.duration(), longest_step)?;
    states.reset(pass.model, Reset::Pass);
    let duration = pass.path.duration();
    let mut runner = Runner::new(grid, pass, states, longest_step);
    while runner.time() < duration {
        let time = runner.time();
        if let Some(most) = pass.settings.most_steps.filter(|most| runner.steps() >= *most) {
            runner.write_back();
            return Err(PassError::TooManySteps { time, most });
        }
        match runner.step() {
            Ok(force) => progress(Progress { time: runner.time(), duration, force }),
            Err(error) => {
                runner.write_back();
                return Err(PassError::Formula { time, error });
            }
        }
    }
    runner.finish()
}
