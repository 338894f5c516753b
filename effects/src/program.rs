//! A graph scheduled as two straight-line programs: one runs once per step, the other over lanes.

use super::definition::Rows;
use super::graph::{Graph, Id, Load, Node};
use super::inputs::StepValues;
use super::op::Op;
use super::variable::Variable;

/// Greatest number of lane registers of a program.
pub const MOST_REGISTERS: usize = 128;
/// Greatest number of lane variables and states that a program reads.
pub const MOST_INPUTS: usize = 64;

/// Source of an argument of the lane program.
#[derive(Clone, Copy, Debug)]
pub enum Operand {
    /// A result of the step program.
    Scalar(u32),
    /// An input slice.
    Input(u32),
    /// A register.
    Register(u32),
}

/// A slice that the lane program reads.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Input {
    /// A variable.
    Variable(Variable),
    /// A state of the workpiece cells.
    CellState(usize),
    /// A state of the tool cells, if they are the lanes.
    OwnToolCell(usize),
}

/// Operation of the lane program.
#[derive(Clone, Copy, Debug)]
pub enum LaneOp {
    /// Computes a value.
    Apply(Op),
    /// Reads a state of the tool cell over the lane.
    ToolCellOver(usize),
}

/// One instruction of the lane program.
#[derive(Clone, Copy, Debug)]
pub struct LaneStep {
    /// The operation.
    pub op: LaneOp,
    /// Its arguments.
    pub arguments: [Operand; 3],
    /// Register of the result; always different from the arguments' registers.
    pub to: usize,
}

/// The programs of one hook.
#[derive(Clone, Debug)]
pub struct Program {
    /// The step program.
    pub scalars: Vec<Node>,
    /// Slices that the lane program reads.
    pub inputs: Vec<Input>,
    /// The lane program.
    pub steps: Vec<LaneStep>,
    /// Locations of the results.
    pub outputs: Vec<Operand>,
    /// Number of registers.
    pub registers: usize,
}

/// Inputs of the step program.
pub struct ScalarInputs<'a> {
    /// All parameters [SI].
    pub parameters: &'a [f64],
    /// The step.
    pub step: &'a StepValues,
    /// States of the tool [SI].
    pub tool_states: &'a [f64],
    /// Duration of the step [s].
    pub elapsed: f64,
}

impl Program {
    /// Schedules the part of a graph on which `outputs` depend.
    pub fn new(graph: &Graph, outputs: &[Id]) -> Self {
        let reached = graph.reached(outputs);
        let mut layout = Layout::new(graph, &reached, outputs);
        for id in (0..graph.nodes().len() as Id).filter(|id| reached[*id as usize]) {
            if graph.is_lane(id) { layout.place_lane(id) } else { layout.place_scalar(id) }
        }
        let outputs = outputs.iter().map(|id| layout.operand(*id)).collect();
        let Layout { scalars, inputs, steps, registers, .. } = layout;
        Self { scalars, inputs, steps, outputs, registers }
    }

    /// Variables that the programs read.
    pub fn variables(&self) -> Vec<Variable> {
        let step = self.scalars.iter().filter_map(|node| match node {
            Node::Load(Load::Step(variable)) => Some(*variable),
            _ => None,
        });
        let lanes = self.inputs.iter().filter_map(|input| match input {
            Input::Variable(variable) => Some(*variable),
            _ => None,
        });
        let mut variables: Vec<Variable> = step.chain(lanes).collect();
        variables.sort();
        variables
    }

    /// True if the lane program reads the tool cell over each lane.
    pub fn reads_tool_cell_over(&self) -> bool {
        self.steps.iter().any(|step| matches!(step.op, LaneOp::ToolCellOver(_)))
    }

    /// Runs the step program.
    pub fn run_scalars(&self, inputs: &ScalarInputs) -> Vec<f64> {
        let mut values: Vec<f64> = Vec::with_capacity(self.scalars.len());
        for node in &self.scalars {
            let value = match *node {
                Node::Apply(op, arguments) => {
                    op.apply(arguments.map(|id| values.get(id as usize).copied().unwrap_or_default()))
                }
                Node::Load(load) => inputs.read(load),
            };
            values.push(value);
        }
        values
    }
}

impl ScalarInputs<'_> {
    fn read(&self, load: Load) -> f64 {
        match load {
            Load::Constant(bits) => f64::from_bits(bits),
            Load::Parameter(first, Rows::Model) => self.parameters[first],
            Load::Parameter(first, Rows::Pass) => self.parameters[first + self.step.pass_row],
            Load::Parameter(first, Rows::Scan) => self.parameters[first + self.step.scan_row],
            Load::Step(variable) => self.step.get(variable),
            Load::Elapsed => self.elapsed,
            Load::ToolState(index) => self.tool_states[index],
            Load::Lane(_) | Load::CellState(_) | Load::OwnToolCell(_) | Load::ToolCellOver(_) => {
                unreachable!("a step program reads no lanes")
            }
        }
    }
}

struct Layout<'a> {
    graph: &'a Graph,
    /// For each node, the last node that reads it; outputs are read at the end.
    last_use: Vec<Id>,
    /// Location of each node, once it is assigned.
    places: Vec<Option<Operand>>,
    free: Vec<usize>,
    scalars: Vec<Node>,
    inputs: Vec<Input>,
    steps: Vec<LaneStep>,
    registers: usize,
}

impl<'a> Layout<'a> {
    fn new(graph: &'a Graph, reached: &[bool], outputs: &[Id]) -> Self {
        let count = graph.nodes().len();
        let mut last_use = vec![0; count];
        for id in (0..count).filter(|id| reached[*id]) {
            if let Node::Apply(op, arguments) = graph.nodes()[id] {
                arguments[..op.arity()].iter().for_each(|argument| last_use[*argument as usize] = id as Id);
            }
        }
        outputs.iter().for_each(|id| last_use[*id as usize] = Id::MAX);
        let (places, free) = (vec![None; count], Vec::new());
        Self { graph, last_use, places, free, scalars: vec![], inputs: vec![], steps: vec![], registers: 0 }
    }

    fn operand(&self, id: Id) -> Operand {
        self.places[id as usize].expect("arguments come before what reads them")
    }

    fn place_scalar(&mut self, id: Id) {
        let node = match self.graph.nodes()[id as usize] {
            Node::Apply(op, arguments) => {
                let mut placed = [0; 3];
                for (to, argument) in placed.iter_mut().zip(&arguments[..op.arity()]) {
                    let Operand::Scalar(index) = self.operand(*argument) else {
                        unreachable!("what depends on a lane is a lane")
                    };
                    *to = index;
                }
                Node::Apply(op, placed)
            }
            leaf => leaf,
        };
        self.places[id as usize] = Some(Operand::Scalar(self.scalars.len() as u32));
        self.scalars.push(node);
    }

    fn place_lane(&mut self, id: Id) {
        let input = match self.graph.nodes()[id as usize] {
            Node::Load(Load::Lane(variable)) => Input::Variable(variable),
            Node::Load(Load::CellState(index)) => Input::CellState(index),
            Node::Load(Load::OwnToolCell(index)) => Input::OwnToolCell(index),
            Node::Load(Load::ToolCellOver(index)) => return self.push(id, LaneOp::ToolCellOver(index), &[]),
            Node::Apply(op, arguments) => return self.push(id, LaneOp::Apply(op), &arguments[..op.arity()]),
            Node::Load(_) => unreachable!("other leaves have one value per step"),
        };
        self.places[id as usize] = Some(Operand::Input(self.inputs.len() as u32));
        self.inputs.push(input);
    }

    fn push(&mut self, id: Id, op: LaneOp, arguments: &[Id]) {
        let mut operands = [Operand::Register(u32::MAX); 3];
        for (operand, argument) in operands.iter_mut().zip(arguments) {
            *operand = self.operand(*argument);
        }
        let to = self.free.pop().unwrap_or_else(|| {
            self.registers += 1;
            self.registers - 1
        });
        // Freed only now, so that the result never overwrites an argument that is being read.
        for (index, argument) in arguments.iter().enumerate() {
            if let Operand::Register(register) = operands[index]
                && self.last_use[*argument as usize] == id
                && !arguments[..index].contains(argument)
            {
                self.free.push(register as usize);
            }
        }
        self.places[id as usize] = Some(Operand::Register(to as u32));
        self.steps.push(LaneStep { op, arguments: operands, to });
    }
}
