//! Formulas as a graph with common subexpressions shared. It separates values computed per step from values per lane.

use std::collections::BTreeMap;

use super::definition::Rows;
use super::op::Op;
use super::variable::Variable;

/// Index of a node.
pub type Id = u32;

/// Value that a leaf reads.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Load {
    /// A number, by its bit pattern.
    Constant(u64),
    /// A parameter: index of its first value, and how its row is chosen.
    Parameter(usize, Rows),
    /// A variable of the step.
    Step(Variable),
    /// Duration of the step.
    Elapsed,
    /// A state of the tool.
    ToolState(usize),
    /// A variable with one value per lane.
    Lane(Variable),
    /// A state of the lane's workpiece cell.
    CellState(usize),
    /// A state of the tool cell that is itself the lane.
    OwnToolCell(usize),
    /// A state of the tool cell over the lane.
    ToolCellOver(usize),
}

impl Load {
    fn is_lane(self) -> bool {
        matches!(self, Self::Lane(_) | Self::CellState(_) | Self::OwnToolCell(_) | Self::ToolCellOver(_))
    }
}

/// Kind of node.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Node {
    /// A leaf.
    Load(Load),
    /// An operation; unused arguments are 0.
    Apply(Op, [Id; 3]),
}

/// Nodes in topological order: arguments precede the operations that use them.
#[derive(Default)]
pub struct Graph {
    nodes: Vec<Node>,
    lanes: Vec<bool>,
    known: BTreeMap<Node, Id>,
}

impl Graph {
    /// The nodes.
    pub fn nodes(&self) -> &[Node] {
        &self.nodes
    }

    /// True if a node has one value per lane.
    pub fn is_lane(&self, id: Id) -> bool {
        self.lanes[id as usize]
    }

    /// Adds a number.
    pub fn constant(&mut self, value: f64) -> Id {
        self.load(Load::Constant(value.to_bits()))
    }

    /// Adds a leaf.
    pub fn load(&mut self, load: Load) -> Id {
        self.add(Node::Load(load), load.is_lane())
    }

    /// Adds an operation. Operations on numbers alone are folded to a constant.
    pub fn apply(&mut self, op: Op, arguments: &[Id]) -> Id {
        let values: Vec<f64> = arguments.iter().filter_map(|id| self.value(*id)).collect();
        let mut padded = [0; 3];
        padded[..arguments.len()].copy_from_slice(arguments);
        if values.len() == arguments.len() {
            let mut numbers = [0.0; 3];
            numbers[..values.len()].copy_from_slice(&values);
            return self.constant(op.apply(numbers));
        }
        let is_lane = arguments.iter().any(|id| self.is_lane(*id));
        self.add(Node::Apply(op, padded), is_lane)
    }

    fn value(&self, id: Id) -> Option<f64> {
        match self.nodes[id as usize] {
            Node::Load(Load::Constant(bits)) => Some(f64::from_bits(bits)),
            _ => None,
        }
    }

    fn add(&mut self, node: Node, is_lane: bool) -> Id {
        *self.known.entry(node).or_insert_with(|| {
            self.nodes.push(node);
            self.lanes.push(is_lane);
            (self.nodes.len() - 1) as Id
        })
    }

    /// Marks the nodes on which `outputs` depend.
    pub fn reached(&self, outputs: &[Id]) -> Vec<bool> {
        let mut reached = vec![false; self.nodes.len()];
        outputs.iter().for_each(|id| reached[*id as usize] = true);
        for id in (0..self.nodes.len()).rev() {
            if let (true, Node::Apply(op, arguments)) = (reached[id], self.nodes[id]) {
                arguments[..op.arity()].iter().for_each(|argument| reached[*argument as usize] = true);
            }
        }
        reached
    }
}
