//! The pause before a pass: the tool's states evolve while it is idle.

use crate::measured::Readings;
use crate::settings::{LONGEST_STEP, Pass};
use crate::step_values::Moment;
use crate::tool_cells::{CellSums, ToolCells};
use effects::{RunError, States, StepValues, Variable};

/// Advances a tool's states by `duration` [s] before `pass` begins, with all speeds, forces and rates at zero: states
/// that recover in time recover.
///
/// # Errors
/// A formula that gives no finite number.
pub fn rest(pass: &Pass, states: &mut States, duration: f64) -> Result<(), RunError> {
    let (tool, cells) = states.values();
    if tool.is_empty() && cells.is_empty() {
        return Ok(());
    }
    let mut step = StepValues::new();
    Moment::new(pass).enter(pass, pass.path.at(0.0).pose(pass.tool), 0.0, &mut step);
    let mut step = step.at_rest();
    let readings = Readings::new(pass.model, pass.measured);
    readings.set_states(pass.model, 0.0, states);
    readings.set_step(0.0, &mut step);
    let (cells, nothing) = (ToolCells::of(pass.tool), CellSums::default());
    let count = (duration / LONGEST_STEP).ceil();
    for number in 0..count as usize {
        let left = duration * (1.0 - number as f64 / count);
        step.set(Variable::TrialTime, pass.trial_time - left);
        nothing.advance(&cells, pass.model, states, (&step, duration / count))?;
    }
    Ok(())
}
