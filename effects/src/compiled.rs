//! A model ready to run: the programs of all hooks and states, and the parameter values.

use std::sync::Arc;

use super::call::Call;
use super::check::check_in_model;
use super::definition::{Effect, Holder, Reset, State};
use super::error::RunError;
use super::graph::Id;
use super::inputs::{Lanes, StepValues};
use super::library::Library;
use super::lower::{Lowering, Part};
use super::model::{Model, ModelError};
use super::parameter_vector::{ParameterSlot, RowCounts, Slots};
use super::process::Process;
use super::program::{MOST_INPUTS, MOST_REGISTERS, Program};
use super::states::States;
use super::variable::{Hook, Variable};

/// A state of the workpiece cells; the caller stores its values.
#[derive(Clone, Debug, PartialEq)]
pub struct CellState {
    /// `effect.state`.
    pub name: String,
    /// Initial value of a cell [SI].
    pub initial: f64,
    /// Event at which all cells return to it.
    pub reset: Reset,
}

/// Change of the tool's pose by a model.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PoseChange {
    /// Shift in the tool's frame [m].
    pub offset: [f64; 3],
    /// Rotation about the tool's x [rad].
    pub roll: f64,
    /// Rotation about the tool's y [rad].
    pub pitch: f64,
}

/// Everything that does not depend on parameter values.
pub(super) struct Structure {
    pub(super) process: Process,
    /// The laws, as scopes use them.
    pub(super) laws: Vec<Effect>,
    /// The laws as parts, in the same order.
    pub(super) law_parts: Vec<Part>,
    /// The effects as parts, in the order in which they act.
    pub(super) effect_parts: Vec<Part>,
    /// One program per [`Hook`].
    programs: Vec<Program>,
    needs: Vec<Vec<Variable>>,
    slots: Vec<ParameterSlot>,
    pub(super) states: StateTable,
}

/// The states of a model by holder: part (laws first) and index within the part.
#[derive(Clone, Debug, Default)]
pub(super) struct StateTable {
    pub(super) tool: Vec<(usize, usize)>,
    pub(super) tool_cell: Vec<(usize, usize)>,
    pub(super) workpiece_cell: Vec<CellState>,
    cells: Vec<(usize, usize)>,
}

impl StateTable {
    pub(super) fn of(&self, holder: Holder) -> &[(usize, usize)] {
        match holder {
            Holder::Tool => &self.tool,
            Holder::ToolCell => &self.tool_cell,
            Holder::WorkpieceCell => &self.cells,
        }
    }
}

/// A model compiled to programs, with its parameter values. Cloning copies only the values.
#[derive(Clone)]
pub struct CompiledModel {
    pub(super) structure: Arc<Structure>,
    pub(super) values: Vec<f64>,
}

/// All hooks that have a program.
const PLACES: [Hook; 12] = [
    Hook::Pose,
    Hook::Shape,
    Hook::Pressure,
    Hook::Spindle,
    Hook::Force,
    Hook::Rate,
    Hook::Dose,
    Hook::Height,
    Hook::Exposure,
    Hook::ToolState,
    Hook::ToolCell,
    Hook::WorkpieceCell,
];

impl CompiledModel {
    /// True for the same laws and effects with exactly the same values, compiled for the same campaign.
    pub fn is_same(&self, other: &Self) -> bool {
        let bits = |model: &Self| -> Vec<u64> { model.values.iter().map(|value| value.to_bits()).collect() };
        let has_same_effects = || self.process() == other.process() && self.effects().eq(other.effects());
        bits(self) == bits(other) && (Arc::ptr_eq(&self.structure, &other.structure) || has_same_effects())
    }

    /// Compiles a model for a campaign with the given numbers of passes and scans. Effects act in the library's order,
    /// whatever their order in the model.
    ///
    /// # Errors
    /// An unknown law or effect, an unknown parameter, or a formula that is too large.
    pub fn new(model: &Model, library: &Library, rows: RowCounts) -> Result<Self, ModelError> {
        let laws: Vec<Effect> = model.resolve_laws(library)?.into_iter().cloned().collect();
        let effects = model.resolve_effects(library)?;
        let mut slots = Slots::new(model, rows);
        let mut states = StateTable::default();
        let mut parts = Vec::new();
        for effect in laws.iter().chain(effects) {
            check_in_model(effect, &laws, model.process)?;
            let parameters = slots.add(effect)?;
            let numbers = states.add(parts.len(), effect);
            parts.push(Part { effect: effect.clone(), parameters, states: numbers });
        }
        let effect_parts = parts.split_off(laws.len());
        let mut structure = Structure {
            process: model.process,
            laws,
            law_parts: parts,
            effect_parts,
            programs: Vec::new(),
            needs: Vec::new(),
            slots: slots.slots,
            states,
        };
        for place in PLACES {
            let program = structure.compile(place)?;
            structure.needs.push(program.variables());
            structure.programs.push(program);
        }
        Ok(Self { structure: Arc::new(structure), values: slots.values })
    }

    /// The process.
    pub fn process(&self) -> Process {
        self.structure.process
    }

    /// Its laws, then its effects in the order in which they act.
    pub fn effects(&self) -> impl Iterator<Item = &Effect> {
        let Structure { law_parts, effect_parts, .. } = &*self.structure;
        law_parts.iter().chain(effect_parts).map(|part| &part.effect)
    }

    /// States of the whole tool with their effects, in the order of [`States::values`](super::States::values).
    pub fn tool_states(&self) -> impl Iterator<Item = (&Effect, &State)> {
        let states = |&(part, state): &(usize, usize)| {
            let effect = &self.structure.part(part).effect;
            (effect, &effect.states[state])
        };
        self.structure.states.of(Holder::Tool).iter().map(states)
    }

    /// True if an effect acts at a hook. Otherwise only the base law, or nothing, acts there.
    pub fn has(&self, hook: Hook) -> bool {
        self.structure.process.has(hook)
            && self
                .structure
                .effect_parts
                .iter()
                .any(|part| part.effect.changes.iter().any(|change| change.hook == hook))
    }

    /// The effects that act at a hook and are not at their null value.
    pub fn acting(&self, hook: Hook) -> impl Iterator<Item = &Effect> {
        let Structure { process, effect_parts, slots, .. } = &*self.structure;
        let is_null = |effect: &Effect| {
            let mut own = slots.iter().zip(&self.values).filter(|(slot, _)| slot.owner == effect.name);
            own.all(|(slot, value)| slot.null.is_none_or(|null| null == *value))
        };
        let changes = move |effect: &&Effect| effect.changes_in(*process).any(|change| change.hook == hook);
        effect_parts.iter().map(|part| &part.effect).filter(changes).filter(move |effect| !is_null(effect))
    }

    /// True if pressure or rate may be nonlinear in the depth: an effect acts on one of them and is not at its null
    /// value, or a law is not from the library.
    pub fn may_bend(&self) -> bool {
        let is_own = |part: &Part| !Library::builtin().laws().iter().any(|law| law.name == part.effect.name);
        self.structure.law_parts.iter().any(is_own)
            || [Hook::Pressure, Hook::Rate].into_iter().any(|hook| self.acting(hook).next().is_some())
    }

    /// Variables that formulas read at a hook, which the simulator must supply.
    pub fn needs(&self, place: Hook) -> &[Variable] {
        &self.structure.needs[place as usize]
    }

    /// True if any state is kept per tool cell.
    pub fn needs_tool_cells(&self) -> bool {
        !self.structure.states.tool_cell.is_empty()
    }

    /// True if formulas at a hook read the tool cell over each lane.
    pub fn reads_tool_cells(&self, place: Hook) -> bool {
        self.program(place).reads_tool_cell_over()
    }

    /// States of workpiece cells, whose values the caller stores.
    pub fn cell_states(&self) -> &[CellState] {
        &self.structure.states.workpiece_cell
    }

    /// Parameter slots in a fixed order: laws first, then effects in the order in which they act.
    pub fn parameters(&self) -> &[ParameterSlot] {
        &self.structure.slots
    }

    /// Index among the parameters of `effect.parameter`, or of `effect.parameter[2]` for the second pass or scan.
    pub fn index(&self, name: &str) -> Option<usize> {
        self.structure.slots.iter().position(|slot| slot.name() == name)
    }

    /// A parameter's value [SI].
    pub fn value(&self, index: usize) -> f64 {
        self.values[index]
    }

    /// All parameter values [SI].
    pub fn values(&self) -> &[f64] {
        &self.values
    }

    /// Changes a parameter's value [SI]; nothing is recompiled.
    pub fn set(&mut self, index: usize, value: f64) {
        self.values[index] = value;
    }

    /// Value of a base law's parameter [SI], such as `stiffness`.
    pub fn law_value(&self, name: &str) -> Option<f64> {
        let parts = self.structure.law_parts.iter();
        parts
            .flat_map(|part| part.effect.parameters.iter().zip(&part.parameters))
            .find_map(|(parameter, slot)| (parameter.name == name).then(|| self.values[*slot]))
    }

    /// Prepares a hook for a step: computes everything that has one value per step.
    pub fn at<'a>(&'a self, place: Hook, step: &'a StepValues, states: &'a States) -> Call<'a> {
        Call::new(self, place, step, states, 0.0)
    }

    /// Evaluates offset and tilt of the tool.
    ///
    /// # Errors
    /// A formula whose result is not finite.
    pub fn pose(&self, step: &StepValues, states: &States) -> Result<PoseChange, RunError> {
        let call = self.at(Hook::Pose, step, states);
        let [x, y, z, roll, pitch] = [0, 1, 2, 3, 4].map(|output| call.scalar(output));
        Ok(PoseChange { offset: [x?, y?, z?], roll: roll?, pitch: pitch? })
    }

    /// Evaluates the spindle speed [rad/s] from the nominal [`Variable::SpindleSpeed`].
    ///
    /// # Errors
    /// A formula whose result is not finite.
    pub fn spindle_speed(&self, step: &StepValues, states: &States) -> Result<f64, RunError> {
        self.at(Hook::Spindle, step, states).scalar(0)
    }

    /// Evaluates the force reading that the controller receives [N] from the actual force in
    /// [`Variable::ForceReading`].
    ///
    /// # Errors
    /// A formula whose result is not finite.
    pub fn force_reading(&self, step: &StepValues, states: &States) -> Result<f64, RunError> {
        self.at(Hook::Force, step, states).scalar(0)
    }

    /// Evaluates the dose from which the scanner reports the substrate as exposed; 1 for a perfect scanner.
    ///
    /// # Errors
    /// A formula whose result is not finite.
    pub fn exposure_threshold(&self, step: &StepValues) -> Result<f64, RunError> {
        let states = States::new(self, 1);
        self.at(Hook::Exposure, step, &states).scalar(0)
    }

    /// Advances the states of workpiece cells by `elapsed` [s]: reads old values from `lanes`, writes new ones to
    /// `out`.
    ///
    /// # Errors
    /// A formula whose result is not finite, or lanes of different length.
    pub fn advance_cells(
        &self,
        elapsed: f64,
        (step, states): (&StepValues, &States),
        lanes: &Lanes,
        out: &mut [&mut [f64]],
    ) -> Result<(), RunError> {
        Call::new(self, Hook::WorkpieceCell, step, states, elapsed).run_all(lanes, out)
    }

    pub(super) fn program(&self, place: Hook) -> &Program {
        &self.structure.programs[place as usize]
    }
}

impl Structure {
    /// Part of this index, laws first.
    pub(super) fn part(&self, index: usize) -> &Part {
        let laws = self.law_parts.len();
        if index < laws { &self.law_parts[index] } else { &self.effect_parts[index - laws] }
    }

    fn compile(&self, place: Hook) -> Result<Program, ModelError> {
        let mut lowering = Lowering::new(place, self.process, &self.laws, &self.law_parts);
        let outputs: Vec<Id> = match place {
            Hook::ToolState => self.advance_all(&mut lowering, Holder::Tool),
            Hook::ToolCell => self.advance_all(&mut lowering, Holder::ToolCell),
            Hook::WorkpieceCell => self.advance_all(&mut lowering, Holder::WorkpieceCell),
            hook => {
                if self.process.has(hook) {
                    self.law_parts.iter().chain(&self.effect_parts).for_each(|part| lowering.apply(part));
                }
                lowering.outputs()
            }
        };
        let program = Program::new(&lowering.graph, &outputs);
        let fits = program.registers <= MOST_REGISTERS && program.inputs.len() <= MOST_INPUTS;
        if fits { Ok(program) } else { Err(ModelError::TooLarge { place }) }
    }

    fn advance_all(&self, lowering: &mut Lowering, holder: Holder) -> Vec<Id> {
        let states = self.states.of(holder).iter();
        states.map(|&(part, index)| lowering.advanced(self.part(part), index)).collect()
    }
}

impl StateTable {
    /// Assigns each state of an effect its index among all states with the same holder.
    fn add(&mut self, part: usize, effect: &Effect) -> Vec<usize> {
        let number = |(index, state): (usize, &super::definition::State)| {
            let list = match state.per {
                Holder::Tool => &mut self.tool,
                Holder::ToolCell => &mut self.tool_cell,
                Holder::WorkpieceCell => {
                    let name = format!("{}.{}", effect.name, state.name);
                    self.workpiece_cell.push(CellState { name, initial: state.initial, reset: state.reset });
                    &mut self.cells
                }
            };
            list.push((part, index));
            list.len() - 1
        };
        effect.states.iter().enumerate().map(number).collect()
    }
}
