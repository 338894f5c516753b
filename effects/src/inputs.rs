//! Inputs of the formulas from the simulator: values per step, and lanes of cells or pixels.

use super::variable::{Per, Variable};

/// Values of all variables that have one value per step [SI].
#[derive(Clone, Debug, PartialEq)]
pub struct StepValues {
    values: [f64; Variable::COUNT],
    /// Row, from 0, of parameters with one value per pass.
    pub pass_row: usize,
    /// Row, from 0, of parameters with one value per scan.
    pub scan_row: usize,
}

/// Variables that keep their value while the tool rests: those of the tool, and the clock.
const KEPT_AT_REST: [Variable; 8] = [
    Variable::ToolRadius,
    Variable::ToolWidth,
    Variable::ToolFaceArea,
    Variable::TemperatureLogged,
    Variable::PassNumber,
    Variable::Time,
    Variable::TrialTime,
    Variable::ForceSetpoint,
];

impl Default for StepValues {
    fn default() -> Self {
        Self::new()
    }
}

impl StepValues {
    /// A tool of zero size at rest, at room temperature.
    pub fn new() -> Self {
        let mut step = Self { values: [0.0; Variable::COUNT], pass_row: 0, scan_row: 0 };
        step.set(Variable::TemperatureLogged, 293.15);
        step.set(Variable::PassNumber, 1.0);
        step
    }

    /// The value of a variable [SI].
    pub fn get(&self, variable: Variable) -> f64 {
        self.values[variable as usize]
    }

    /// Sets a variable [SI].
    ///
    /// # Panics
    /// If the variable has one value per cell or pixel.
    pub fn set(&mut self, variable: Variable, value: f64) -> &mut Self {
        assert!(variable.row().per == Per::Step, "{variable} has a value per lane, not per step");
        self.values[variable as usize] = value;
        self
    }

    /// Returns the same tool and clock with all speeds, forces and rates at zero: a pause.
    pub fn at_rest(&self) -> Self {
        let mut rest = Self { pass_row: self.pass_row, scan_row: self.scan_row, ..Self::new() };
        for variable in KEPT_AT_REST {
            rest.set(variable, self.get(variable));
        }
        rest
    }

    /// All values, by [`Variable`].
    pub(super) fn all(&self) -> &[f64; Variable::COUNT] {
        &self.values
    }
}

/// Values of cells or pixels [SI], one borrowed slice per variable, all of equal length.
#[derive(Clone, Copy)]
pub struct Lanes<'a> {
    pub(super) len: usize,
    pub(super) values: [&'a [f64]; Variable::COUNT],
    pub(super) tool_cell: &'a [f64],
    pub(super) states: &'a [&'a [f64]],
}

impl<'a> Lanes<'a> {
    /// Lanes without variables.
    pub fn new(len: usize) -> Self {
        Self { len, values: [&[]; Variable::COUNT], tool_cell: &[], states: &[] }
    }

    /// Adds a variable.
    #[must_use]
    #[inline]
    pub fn with(mut self, variable: Variable, values: &'a [f64]) -> Self {
        self.set(variable, values);
        self
    }

    /// The same in place.
    #[inline]
    pub fn set(&mut self, variable: Variable, values: &'a [f64]) {
        self.values[variable as usize] = values;
    }

    /// Adds the fractional tool cell index of each contact cell: 2.25 is a quarter of the way from the centre of cell 2
    /// to that of cell 3.
    #[must_use]
    #[inline]
    pub fn with_tool_cell(mut self, places: &'a [f64]) -> Self {
        self.tool_cell = places;
        self
    }

    /// Adds the states of the workpiece cells, in the order of `CompiledModel::cell_states`.
    #[must_use]
    #[inline]
    pub fn with_states(mut self, states: &'a [&'a [f64]]) -> Self {
        self.states = states;
        self
    }
}
