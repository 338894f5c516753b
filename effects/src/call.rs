//! A hook evaluated at one step: the per-step part runs once, then the lanes run.

use super::compiled::CompiledModel;
use super::definition::{Formula, Holder};
use super::error::{BadResult, RunError};
use super::inputs::{Lanes, StepValues};
use super::interpret::Environment;
use super::lanes::{LaneInputs, run};
use super::lower::Part;
use super::program::{Input, MOST_INPUTS, Operand, Program, ScalarInputs};
use super::scope::Scope;
use super::states::States;
use super::variable::{Hook, Variable};

/// A hook of a model prepared for a step. It can be shared among threads and run over any number of lanes.
pub struct Call<'a> {
    model: &'a CompiledModel,
    place: Hook,
    step: &'a StepValues,
    states: &'a States,
    elapsed: f64,
    scalars: Vec<f64>,
}

impl<'a> Call<'a> {
    pub(super) fn new(
        model: &'a CompiledModel,
        place: Hook,
        step: &'a StepValues,
        states: &'a States,
        elapsed: f64,
    ) -> Self {
        let inputs = ScalarInputs { parameters: &model.values, step, tool_states: &states.tool, elapsed };
        let scalars = model.program(place).run_scalars(&inputs);
        Self { model, place, step, states, elapsed, scalars }
    }

    fn program(&self) -> &'a Program {
        self.model.program(self.place)
    }

    /// Evaluates the hook over lanes into `out`, one value per lane [SI].
    ///
    /// # Errors
    /// A result that is not finite, with the formula that gave it; a missing variable.
    pub fn run(&self, lanes: &Lanes, out: &mut [f64]) -> Result<(), RunError> {
        self.run_all(lanes, &mut [out])
    }

    /// Evaluates a hook with several results, as [`Call::run`] does for one.
    pub(super) fn run_all(&self, lanes: &Lanes, outputs: &mut [&mut [f64]]) -> Result<(), RunError> {
        let program = self.program();
        for output in outputs.iter() {
            self.expect_length("the result", output.len(), lanes.len)?;
        }
        if program.reads_tool_cell_over() {
            self.expect_length("the place among the tool cells", lanes.tool_cell.len(), lanes.len)?;
        }
        let mut slices: [&[f64]; MOST_INPUTS] = [&[]; MOST_INPUTS];
        for (slice, input) in slices.iter_mut().zip(&program.inputs) {
            *slice = self.slice(*input, lanes)?;
        }
        let inputs = LaneInputs {
            scalars: &self.scalars,
            slices: &slices,
            tool_cell: lanes.tool_cell,
            tool_states: &self.states.tool_cells,
        };
        if run(program, &inputs, outputs, lanes.len) { Ok(()) } else { Err(self.diagnose_lanes(lanes, outputs)) }
    }

    fn slice<'l>(&self, input: Input, lanes: &Lanes<'l>) -> Result<&'l [f64], RunError>
    where
        'a: 'l,
    {
        let (name, slice) = match input {
            Input::Variable(variable) => (variable.name(), lanes.values[variable as usize]),
            Input::CellState(index) => {
                let name = self.model.cell_states()[index].name.as_str();
                (name, lanes.states.get(index).copied().unwrap_or_default())
            }
            Input::OwnToolCell(index) => ("a state of the tool cells", self.states.tool_cells[index].as_slice()),
        };
        self.expect_length(name, slice.len(), lanes.len)?;
        Ok(slice)
    }

    fn expect_length(&self, variable: &str, found: usize, expected: usize) -> Result<(), RunError> {
        if found == expected {
            return Ok(());
        }
        Err(RunError::Shape { variable: variable.to_owned(), found, expected, place: self.place })
    }

    /// Returns a result of a hook that has one value per step.
    pub(super) fn scalar(&self, output: usize) -> Result<f64, RunError> {
        let Operand::Scalar(index) = self.program().outputs[output] else {
            unreachable!("{} has one value per step", self.place)
        };
        let value = self.scalars[index as usize];
        if value.is_finite() { Ok(value) } else { Err(self.diagnose(&Lanes::new(0), 0)) }
    }

    fn diagnose_lanes(&self, lanes: &Lanes, outputs: &[&mut [f64]]) -> RunError {
        let is_bad = |lane: &usize| outputs.iter().any(|output| !output[*lane].is_finite());
        let lane = (0..lanes.len).find(is_bad).unwrap_or_default();
        self.diagnose(lanes, lane)
    }

    /// Interprets the formulas one by one until one gives a value that is not finite, and reports it.
    fn diagnose(&self, lanes: &Lanes, lane: usize) -> RunError {
        let mut variables = self.step.all().to_vec();
        for (variable, values) in Variable::ALL.iter().zip(&lanes.values) {
            if let Some(value) = values.get(lane) {
                variables[*variable as usize] = *value;
            }
        }
        let fault = self.diagnose_inputs(&variables, lane);
        fault.or_else(|| self.diagnose_formulas(variables, lanes, lane)).unwrap_or_else(|| RunError::Input {
            variable: "a state".to_owned(),
            value: f64::NAN,
            place: self.place,
            lane,
        })
    }

    fn diagnose_inputs(&self, variables: &[f64], lane: usize) -> Option<RunError> {
        let mut needed = self.model.needs(self.place).iter();
        let bad = needed.find(|variable| !variables[**variable as usize].is_finite())?;
        let (variable, value) = (bad.to_string(), variables[*bad as usize]);
        Some(RunError::Input { variable, value, place: self.place, lane })
    }

    fn diagnose_formulas(&self, mut variables: Vec<f64>, lanes: &Lanes, lane: usize) -> Option<RunError> {
        let structure = &self.model.structure;
        for value in self.place.values() {
            if let Some(start) = value.start() {
                variables[*value as usize] = start;
            }
        }
        let laws = structure.law_parts.iter().map(|part| self.parameters(part)).collect::<Vec<_>>();
        for part in structure.law_parts.iter().chain(&structure.effect_parts) {
            let (parameters, states) = (self.parameters(part), self.states_of(part, lanes, lane));
            let scope = Scope::new(&part.effect, self.place, &structure.laws).within(structure.process);
            let environment = Environment {
                scope,
                parameters: &parameters,
                law_parameters: &laws,
                variables: &variables,
                states: &states,
            };
            if let Some(error) = self.diagnose_states(&environment) {
                return Some(error);
            }
            let changes = part.effect.changes.iter().filter(|change| change.hook == self.place);
            let mut changed = Vec::new();
            for change in changes {
                let result = environment.evaluate(&change.formula.tree);
                if !result.is_finite() {
                    return Some(self.bad_result(&environment, &change.formula, result));
                }
                changed.push((change.value, result));
            }
            for (value, result) in changed {
                variables[value as usize] = result;
            }
        }
        None
    }

    fn diagnose_states(&self, environment: &Environment) -> Option<RunError> {
        let effect = environment.scope.effect;
        let mut here = effect.states.iter().enumerate().filter(|(_, state)| state.per.place() == self.place);
        let (_, state) = here.find(|(index, _)| !environment.advanced(*index, self.elapsed).is_finite())?;
        let formulas = super::scope::motion_formulas(state);
        let worst = formulas.iter().find(|(formula, ..)| !environment.evaluate(&formula.tree).is_finite());
        let (formula, ..) = worst.unwrap_or(&formulas[0]);
        Some(self.bad_result(environment, formula, environment.evaluate(&formula.tree)))
    }

    fn parameters(&self, part: &Part) -> Vec<f64> {
        use super::definition::Rows;
        let rows = part.effect.parameters.iter().map(|parameter| match parameter.per {
            Rows::Model => 0,
            Rows::Pass => self.step.pass_row,
            Rows::Scan => self.step.scan_row,
        });
        part.parameters.iter().zip(rows).map(|(first, row)| self.model.values[first + row]).collect()
    }

    fn states_of(&self, part: &Part, lanes: &Lanes, lane: usize) -> Vec<f64> {
        let value = |(state, number): (&super::definition::State, &usize)| match state.per {
            Holder::Tool => self.states.tool[*number],
            Holder::ToolCell if self.place == Hook::ToolCell => self.states.tool_cells[*number][lane],
            Holder::ToolCell => lanes.tool_cell.get(lane).map_or(state.initial, |place| {
                let cells = &self.states.tool_cells[*number];
                cells[(*place as usize).min(cells.len() - 1)]
            }),
            Holder::WorkpieceCell => {
                lanes.states.get(*number).and_then(|values| values.get(lane)).copied().unwrap_or(state.initial)
            }
        };
        part.effect.states.iter().zip(&part.states).map(value).collect()
    }

    fn bad_result(&self, environment: &Environment, formula: &Formula, result: f64) -> RunError {
        let effect = environment.scope.effect;
        let (line, _) = effect.line_column(formula.start);
        RunError::Result(Box::new(BadResult {
            file: effect.file.clone(),
            line,
            key: formula.key.clone(),
            formula: formula.text.clone(),
            result,
            place: self.place,
            cause: environment.cause(formula),
            inputs: environment.inputs(formula),
        }))
    }
}
