//! Writes the programs of a model as WGSL, in the form of `no_model.wgsl`: the same operations in the same order.
//!
//! Values per step are computed by one invocation and stored; formulas over lanes read them. Parameters stay numbers in
//! a buffer, so that trials with other values share the text.

use std::fmt::Write as _;

use super::compiled::CompiledModel;
use super::definition::{Holder, Rows};
use super::graph::{Load, Node};
use super::op::Op;
use super::program::{Input, LaneOp, Operand, Program};
use super::variable::{Hook, Per, Variable};

/// A model in the form that a device runs.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct DeviceModel {
    /// WGSL text of all formulas.
    pub text: String,
    /// Index of the first parameter among a trial's values; the variables precede it.
    pub parameters: usize,
    /// Index of the tool's first state.
    pub tool_states: usize,
    /// Index of the first state of the tool's first cell; all cells of a state, then the next state.
    pub cell_states: usize,
    /// Number of values of a trial; the simulator's sums follow them.
    pub values: usize,
}

/// The part of a model that a device cannot run.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum UnsupportedPart {
    /// A variable that needs a pass over the whole height field.
    #[error("the hook {0} reads edge_distance")]
    EdgeDistance(Hook),
    /// A state of the workpiece's cells.
    #[error("`{0}` is a state of the workpiece's cells")]
    WorkpieceState(String),
}

/// Means and sums over tool cells that formulas may read, in their order after the share in contact.
const CELL_SUMS: [Variable; 6] = [
    Variable::Pressure,
    Variable::SlipSpeed,
    Variable::Rate,
    Variable::DoseRate,
    Variable::CellRemovalRate,
    Variable::CellDoseVolumeRate,
];

/// Hooks over lanes.
const LANE_HOOKS: [Hook; 4] = [Hook::Shape, Hook::Pressure, Hook::Rate, Hook::Dose];
/// Hooks with one value per step, or five.
const STEP_HOOKS: [Hook; 3] = [Hook::Pose, Hook::Spindle, Hook::Force];

impl DeviceModel {
    /// Writes a model for a tool with this number of cells.
    pub fn new(model: &CompiledModel, tool_cells: usize) -> Result<Self, UnsupportedPart> {
        let reads_edges = |place: &Hook| model.needs(*place).contains(&Variable::EdgeDistance);
        if let Some(place) = LANE_HOOKS.into_iter().find(reads_edges) {
            return Err(UnsupportedPart::EdgeDistance(place));
        }
        if let Some(state) = model.cell_states().first() {
            return Err(UnsupportedPart::WorkpieceState(state.name.clone()));
        }
        let count = |holder: Holder| model.structure.states.of(holder).len();
        let parameters = Variable::COUNT;
        let tool_states = parameters + model.values.len();
        let cell_states = tool_states + count(Holder::Tool);
        let sums = cell_states + count(Holder::ToolCell) * tool_cells;
        let kept = sums + (1 + CELL_SUMS.len()) * tool_cells;
        let mut text = String::new();
        for variable in Variable::ALL.iter().filter(|variable| variable.row().per == Per::Step) {
            let _ = writeln!(text, "const V_{}: u32 = {}u;", variable.name().to_uppercase(), *variable as usize);
        }
        for (name, at) in [
            ("PARAMETERS", parameters),
            ("TOOL_STATES", tool_states),
            ("CELL_STATES", cell_states),
            ("CELL_SUMS", sums),
        ] {
            let _ = writeln!(text, "const {name}_AT: u32 = {at}u;");
        }
        for place in [Hook::Pose, Hook::Shape, Hook::Spindle, Hook::Force] {
            let name = place.name().to_uppercase();
            let _ = writeln!(text, "const HAS_{name}: bool = {};", model.has(place));
        }
        let _ = writeln!(text, "const HAS_TOOL_CELLS: bool = {};", model.needs_tool_cells());
        let mut writer = Writer { text, kept };
        STEP_HOOKS.into_iter().for_each(|place| writer.step_hook(place, model.program(place)));
        let keep: Vec<String> = LANE_HOOKS.map(|place| writer.lane_hook(place, model.program(place))).into();
        writer.function("prepare_lanes()", &keep.concat());
        writer.states(model);
        let _ = writeln!(writer.text, "\nconst PARTIALS_AT: u32 = {}u;", writer.kept);
        let values = writer.kept;
        Ok(Self { text: writer.text, parameters, tool_states, cell_states, values })
    }
}

/// Builder of the WGSL text.
struct Writer {
    text: String,
    /// Index among the values at which the next result is stored.
    kept: usize,
}

impl Writer {
    fn function(&mut self, head: &str, body: &str) {
        let _ = write!(self.text, "\nfn {head} {{\n{body}}}\n");
    }

    /// Writes a hook that one invocation runs.
    fn step_hook(&mut self, place: Hook, program: &Program) {
        let results: Vec<String> = program.outputs.iter().map(|output| scalar_name("s", output)).collect();
        let (kind, result) = match place {
            Hook::Pose => ("array<f32, 5>", format!("array<f32, 5>({})", results.join(", "))),
            _ => ("f32", results[0].clone()),
        };
        let body = format!("{}    return {result};\n", scalars("s", program));
        self.function(&format!("formula_{}() -> {kind}", place.name()), &body);
    }

    /// Writes a hook over lanes. Returns the text that prepares it.
    fn lane_hook(&mut self, place: Hook, program: &Program) -> String {
        let prefix = &place.name()[..2];
        let first = self.kept;
        let prepared = scalars(prefix, program) + &self.keep(prefix, program);
        let body = lanes(program, first, |input| match input {
            Input::Variable(variable) => format!("lane.{}", variable.name()),
            Input::CellState(_) | Input::OwnToolCell(_) => unreachable!("a hook has no such lanes"),
        });
        let result = lane_operand(&program.outputs[0]);
        self.function(
            &format!("formula_{}(lane: Lane) -> f32", place.name()),
            &format!("{body}    return {result};\n"),
        );
        prepared
    }

    /// Writes the states of the tool and of its cells.
    fn states(&mut self, model: &CompiledModel) {
        let (tool, cells) = (model.program(Hook::ToolState), model.program(Hook::ToolCell));
        let first = self.kept;
        let mut prepared = scalars("c", cells) + &self.keep("c", cells) + &scalars("t", tool);
        for (index, output) in tool.outputs.iter().enumerate() {
            let result = scalar_name("t", output);
            let _ = writeln!(prepared, "    note_fault({result}, FAULT_TOOL_STATE);");
            let _ = writeln!(prepared, "    set_value(TOOL_STATES_AT + {index}u, {result});");
        }
        self.function("prepare_states()", &prepared);
        let mut body = lanes(cells, first, |input| match input {
            Input::Variable(Variable::ToolY) => "cell_middle(cell)".to_owned(),
            Input::Variable(Variable::CellFaceArea) => "cell_area(cell)".to_owned(),
            Input::Variable(variable) => {
                let sum = CELL_SUMS.iter().position(|known| *known == variable);
                format!("value(CELL_SUMS_AT + {}u * TOOL_CELLS + cell)", 1 + sum.expect("a sum over tool cells"))
            }
            Input::OwnToolCell(index) => format!("value(CELL_STATES_AT + {index}u * TOOL_CELLS + cell)"),
            Input::CellState(_) => unreachable!("a tool cell has no workpiece cell"),
        });
        for (index, output) in cells.outputs.iter().enumerate() {
            let result = lane_operand(output);
            let _ = writeln!(body, "    note_bad({result}, FAULT_TOOL_CELL);");
            let _ = writeln!(body, "    set_value(CELL_STATES_AT + {index}u * TOOL_CELLS + cell, {result});");
        }
        self.function("advance_tool_cell(cell: u32)", &body);
    }

    /// Stores the results of a step program that its lane program reads, in order.
    fn keep(&mut self, prefix: &str, program: &Program) -> String {
        let mut text = String::new();
        for index in read_by_lanes(program) {
            let _ = writeln!(text, "    set_value({}u, {prefix}{index});", self.kept);
            self.kept += 1;
        }
        text
    }
}

/// Results of the step program that the lane program or its outputs read, in order.
fn read_by_lanes(program: &Program) -> Vec<u32> {
    let arguments = program.steps.iter().flat_map(|step| match step.op {
        LaneOp::Apply(op) => &step.arguments[..op.arity()],
        LaneOp::ToolCellOver(_) => &[],
    });
    let scalar = |operand: &Operand| match operand {
        Operand::Scalar(index) => Some(*index),
        _ => None,
    };
    let mut read: Vec<u32> = arguments.chain(&program.outputs).filter_map(scalar).collect();
    read.sort_unstable();
    read.dedup();
    read
}

/// Writes the step program, one constant per result.
fn scalars(prefix: &str, program: &Program) -> String {
    let mut text = String::new();
    for (index, node) in program.scalars.iter().enumerate() {
        let value = match *node {
            Node::Load(load) => loaded(load),
            Node::Apply(op, arguments) => applied(op, &arguments.map(|id| format!("{prefix}{id}"))),
        };
        let _ = writeln!(text, "    let {prefix}{index} = {value};");
    }
    text
}

fn scalar_name(prefix: &str, operand: &Operand) -> String {
    let Operand::Scalar(index) = operand else { unreachable!("one value per step") };
    format!("{prefix}{index}")
}

fn loaded(load: Load) -> String {
    match load {
        Load::Constant(bits) => number(f64::from_bits(bits)),
        Load::Parameter(first, Rows::Pass) => format!("value(PARAMETERS_AT + {first}u + setup.pass_row)"),
        Load::Parameter(first, _) => format!("value(PARAMETERS_AT + {first}u)"),
        Load::Step(variable) => format!("value({}u)", variable as usize),
        Load::Elapsed => "state.dt".to_owned(),
        Load::ToolState(index) => format!("value(TOOL_STATES_AT + {index}u)"),
        Load::Lane(_) | Load::CellState(_) | Load::OwnToolCell(_) | Load::ToolCellOver(_) => {
            unreachable!("a step program reads no lanes")
        }
    }
}

/// Formats a number as an f32 of WGSL.
fn number(value: f64) -> String {
    let value = value as f32;
    match value {
        _ if value.is_nan() => "(setup.infinity - setup.infinity)".to_owned(),
        f32::INFINITY => "setup.infinity".to_owned(),
        f32::NEG_INFINITY => "(-setup.infinity)".to_owned(),
        _ => format!("({value:?}f)"),
    }
}

/// Writes the lane program: stored values from `first` on, inputs, and one constant per operation.
fn lanes(program: &Program, first: usize, input: impl Fn(Input) -> String) -> String {
    let mut text = String::new();
    for (at, index) in (first..).zip(read_by_lanes(program)) {
        let _ = writeln!(text, "    let k{index} = value({at}u);");
    }
    for (index, read) in program.inputs.iter().enumerate() {
        let _ = writeln!(text, "    let i{index} = {};", input(*read));
    }
    for register in 0..program.registers {
        let _ = writeln!(text, "    var r{register} = 0.0;");
    }
    for step in &program.steps {
        let value = match step.op {
            LaneOp::ToolCellOver(state) => {
                format!("tool_cell_over(CELL_STATES_AT + {state}u * TOOL_CELLS, lane.tool_cell)")
            }
            LaneOp::Apply(op) => applied(op, &step.arguments.map(|operand| lane_operand(&operand))),
        };
        let _ = writeln!(text, "    r{} = {value};", step.to);
    }
    text
}

fn lane_operand(operand: &Operand) -> String {
    match operand {
        Operand::Scalar(index) => format!("k{index}"),
        Operand::Input(index) => format!("i{index}"),
        Operand::Register(index) => format!("r{index}"),
    }
}

fn applied(op: Op, [a, b, c]: &[String; 3]) -> String {
    match op {
        Op::Add => format!("({a} + {b})"),
        Op::Sub => format!("({a} - {b})"),
        Op::Mul => format!("({a} * {b})"),
        Op::Div => format!("({a} / {b})"),
        Op::Neg => format!("(-{a})"),
        Op::Sqrt => format!("sqrt({a})"),
        Op::Abs => format!("abs({a})"),
        Op::Pow => format!("op_pow({a}, {b})"),
        Op::Less => format!("op_less({a}, {b})"),
        Op::LessEqual => format!("op_less_equal({a}, {b})"),
        Op::Equal => format!("op_equal({a}, {b})"),
        Op::If => format!("op_if({a}, {b}, {c})"),
        Op::Min => format!("op_min({a}, {b})"),
        Op::Max => format!("op_max({a}, {b})"),
        Op::Exp => format!("op_exp({a})"),
        Op::Log => format!("op_log({a})"),
        Op::Sin => format!("op_sin({a})"),
        Op::Cos => format!("op_cos({a})"),
        Op::Tanh => format!("op_tanh({a})"),
        Op::Sign => format!("op_sign({a})"),
    }
}
