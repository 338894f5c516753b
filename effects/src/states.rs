//! States of the tool: of the whole tool and of each of its cells.

use super::call::Call;
use super::compiled::CompiledModel;
use super::definition::{Holder, Reset};
use super::error::RunError;
use super::inputs::{Lanes, StepValues};
use super::variable::Hook;

/// States of a tool [SI].
#[derive(Clone, Debug, PartialEq)]
pub struct States {
    pub(super) tool: Vec<f64>,
    /// For each state, one value per cell.
    pub(super) tool_cells: Vec<Vec<f64>>,
    scratch: Vec<Vec<f64>>,
}

impl States {
    /// States of a fresh tool with this number of cells.
    pub fn new(model: &CompiledModel, tool_cells: usize) -> Self {
        let initial = |holder: Holder| {
            let list = model.structure.states.of(holder).iter();
            list.map(|&(part, state)| model.structure.part(part).effect.states[state].initial).collect::<Vec<f64>>()
        };
        let cells: Vec<Vec<f64>> =
            initial(Holder::ToolCell).into_iter().map(|value| vec![value; tool_cells.max(1)]).collect();
        Self { tool: initial(Holder::Tool), scratch: cells.clone(), tool_cells: cells }
    }

    /// Restores a tool from [`States::values`]; `None` if the numbers of states or cells do not match the model's.
    pub fn restored(model: &CompiledModel, (tool, tool_cells): (Vec<f64>, Vec<Vec<f64>>)) -> Option<Self> {
        let of = |holder| model.structure.states.of(holder).len();
        let fits = tool.len() == of(Holder::Tool) && tool_cells.len() == of(Holder::ToolCell);
        let even = tool_cells.windows(2).all(|pair| pair[0].len() == pair[1].len());
        (fits && even).then(|| Self { tool, scratch: tool_cells.clone(), tool_cells })
    }

    /// States of the tool, and for each state of its cells a list over the cells [SI], in the order of the model.
    pub fn values(&self) -> (&[f64], &[Vec<f64>]) {
        (&self.tool, &self.tool_cells)
    }

    /// Sets a state of the tool to a measured value [SI], clamped to the state's bounds.
    ///
    /// - `index`: index in the tool's states of [`States::values`]
    ///
    /// # Panics
    /// If there is no such state.
    pub fn measure(&mut self, model: &CompiledModel, index: usize, value: f64) {
        let (part, state) = model.structure.states.of(Holder::Tool)[index];
        let [least, greatest] = model.structure.part(part).effect.states[state].bounds;
        self.tool[index] = value.max(least).min(greatest);
    }

    /// Resets the states that an event resets to their initial values. A new trial is also a new pass; dressing the
    /// tool is neither.
    pub fn reset(&mut self, model: &CompiledModel, event: Reset) {
        let resets = |reset: Reset| reset == event || (event == Reset::Trial && reset == Reset::Pass);
        let structure = &model.structure;
        let state = |(part, state): (usize, usize)| &structure.part(part).effect.states[state];
        for (value, at) in self.tool.iter_mut().zip(structure.states.of(Holder::Tool)) {
            if resets(state(*at).reset) {
                *value = state(*at).initial;
            }
        }
        for (cells, at) in self.tool_cells.iter_mut().zip(structure.states.of(Holder::ToolCell)) {
            if resets(state(*at).reset) {
                cells.fill(state(*at).initial);
            }
        }
    }

    /// Advances all states by `elapsed` [s]. `step` holds the values of the completed step, `tool_lanes` those of the
    /// tool cells.
    ///
    /// # Errors
    /// A formula whose result is not finite, or a number of lanes other than that of cells; the states are then
    /// unchanged.
    pub fn advance(
        &mut self,
        model: &CompiledModel,
        elapsed: f64,
        step: &StepValues,
        tool_lanes: &Lanes,
    ) -> Result<(), RunError> {
        let mut scratch = std::mem::take(&mut self.scratch);
        let moved = self.moved(model, elapsed, (step, tool_lanes), &mut scratch);
        self.scratch = scratch;
        self.tool = moved?;
        std::mem::swap(&mut self.tool_cells, &mut self.scratch);
        Ok(())
    }

    fn moved(
        &self,
        model: &CompiledModel,
        elapsed: f64,
        (step, tool_lanes): (&StepValues, &Lanes),
        cells: &mut [Vec<f64>],
    ) -> Result<Vec<f64>, RunError> {
        if !cells.is_empty() {
            let mut outputs: Vec<&mut [f64]> = cells.iter_mut().map(Vec::as_mut_slice).collect();
            Call::new(model, Hook::ToolCell, step, self, elapsed).run_all(tool_lanes, &mut outputs)?;
        }
        let call = Call::new(model, Hook::ToolState, step, self, elapsed);
        (0..self.tool.len()).map(|index| call.scalar(index)).collect()
    }

    /// Value of a tool state `effect.state` [SI].
    pub fn tool_state(&self, model: &CompiledModel, name: &str) -> Option<f64> {
        let index = position(model, Holder::Tool, name)?;
        Some(self.tool[index])
    }

    /// Values of a tool cell state `effect.state` [SI].
    pub fn tool_cell_state(&self, model: &CompiledModel, name: &str) -> Option<&[f64]> {
        let index = position(model, Holder::ToolCell, name)?;
        Some(&self.tool_cells[index])
    }
}

fn position(model: &CompiledModel, holder: Holder, name: &str) -> Option<usize> {
    let structure = &model.structure;
    structure.states.of(holder).iter().position(|&(part, state)| {
        let effect = &structure.part(part).effect;
        name.strip_prefix(effect.name.as_str()).and_then(|rest| rest.strip_prefix('.'))
            == Some(&effect.states[state].name)
    })
}
