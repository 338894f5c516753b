//! Lowers the formulas of a whole model at one hook to a graph.

use std::collections::BTreeMap;

use super::definition::{Effect, Formula, Motion, Rows};
use super::graph::{Graph, Id, Load};
use super::interpret::lag;
use super::op::Op;
use super::process::Process;
use super::scope::{Scope, Symbol};
use super::syntax::{Expr, Node};
use super::variable::{Hook, Variable};

/// A law or effect of a model, with the indices of its parameters and states in the whole model.
#[derive(Clone, Debug)]
pub struct Part {
    /// The law or effect.
    pub effect: Effect,
    /// Index of the first row of each parameter, among all values.
    pub parameters: Vec<usize>,
    /// Index of each state, among all states with the same holder.
    pub states: Vec<usize>,
}

/// Lowers formulas at one hook.
pub struct Lowering<'a> {
    /// The graph so far.
    pub graph: Graph,
    place: Hook,
    process: Process,
    laws: &'a [Effect],
    law_parts: &'a [Part],
    /// Current values of the hook.
    current: Vec<(Variable, Id)>,
    /// Nodes of the names of the current part, so that a repeated definition is lowered once.
    named: BTreeMap<Symbol, Id>,
}

impl<'a> Lowering<'a> {
    /// Starts with the simulator's values; a law supplies the values that it defines.
    pub fn new(place: Hook, process: Process, laws: &'a [Effect], law_parts: &'a [Part]) -> Self {
        let (graph, current, named) = (Graph::default(), Vec::new(), BTreeMap::new());
        let mut lowering = Self { graph, place, process, laws, law_parts, current, named };
        for &value in place.values() {
            let start = match value.start() {
                Some(start) => lowering.graph.constant(start),
                None if value.is_lane_at(place) => lowering.graph.load(Load::Lane(value)),
                None => lowering.graph.load(Load::Step(value)),
            };
            lowering.current.push((value, start));
        }
        lowering
    }

    /// Applies the changes of a law or effect at this hook.
    pub fn apply(&mut self, part: &Part) {
        let place = self.place;
        self.named.clear();
        let changes = part.effect.changes.iter().filter(|change| change.hook == place);
        // All formulas of one effect read the values before it.
        let changed: Vec<(Variable, Id)> =
            changes.map(|change| (change.value, self.formula(part, &change.formula))).collect();
        for (value, id) in changed {
            self.set(value, id);
        }
    }

    fn set(&mut self, value: Variable, id: Id) {
        if let Some(entry) = self.current.iter_mut().find(|(known, _)| *known == value) {
            entry.1 = id;
        }
    }

    /// Returns the current values, in the order of [`Hook::values`].
    pub fn outputs(&self) -> Vec<Id> {
        self.current.iter().map(|(_, id)| *id).collect()
    }

    /// Returns the node of a state after the step.
    pub fn advanced(&mut self, part: &Part, index: usize) -> Id {
        self.named.clear();
        let state = &part.effect.states[index];
        let old = self.state(part, index);
        let elapsed = self.graph.load(Load::Elapsed);
        let moved = match &state.motion {
            Motion::Rate(rate) => {
                let rate = self.formula(part, rate);
                let change = self.graph.apply(Op::Mul, &[elapsed, rate]);
                self.graph.apply(Op::Add, &[old, change])
            }
            Motion::Relax { target, time } => {
                let (target, time) = (self.formula(part, target), self.formula(part, time));
                self.relaxed(old, target, time, elapsed)
            }
        };
        let [low, high] = state.bounds.map(|bound| self.graph.constant(bound));
        let above = self.graph.apply(Op::Max, &[moved, low]);
        self.graph.apply(Op::Min, &[above, high])
    }

    /// Exact solution for a target that is constant during the step; time constant 0 gives the target.
    fn relaxed(&mut self, old: Id, target: Id, time: Id, elapsed: Id) -> Id {
        let [zero, one] = [0.0, 1.0].map(|value| self.graph.constant(value));
        let back = self.graph.apply(Op::Neg, &[elapsed]);
        let exponent = self.graph.apply(Op::Div, &[back, time]);
        let left = self.graph.apply(Op::Exp, &[exponent]);
        let passed = self.graph.apply(Op::Sub, &[one, left]);
        let distance = self.graph.apply(Op::Sub, &[target, old]);
        let change = self.graph.apply(Op::Mul, &[distance, passed]);
        let moved = self.graph.apply(Op::Add, &[old, change]);
        let at_once = self.graph.apply(Op::Equal, &[time, zero]);
        self.graph.apply(Op::If, &[at_once, target, moved])
    }

    fn formula(&mut self, part: &Part, formula: &Formula) -> Id {
        self.expr(part, &formula.tree)
    }

    fn expr(&mut self, part: &Part, expr: &Expr) -> Id {
        match &expr.node {
            Node::Number(value, _) => self.graph.constant(*value),
            Node::Name(name) => {
                let scope = Scope::new(&part.effect, self.place, self.laws).within(self.process);
                let symbol = scope.find(name).expect("names are checked before");
                self.symbol(part, symbol)
            }
            Node::Apply(op, arguments) => {
                let ids: Vec<Id> = arguments.iter().map(|argument| self.expr(part, argument)).collect();
                self.graph.apply(*op, &ids)
            }
        }
    }

    fn symbol(&mut self, part: &Part, symbol: Symbol) -> Id {
        if let Some(id) = self.named.get(&symbol) {
            return *id;
        }
        let id = self.lowered(part, symbol);
        self.named.insert(symbol, id);
        id
    }

    fn lowered(&mut self, part: &Part, symbol: Symbol) -> Id {
        match symbol {
            Symbol::Parameter(index) => self.parameter(part, index),
            Symbol::Law(law, index) => self.parameter(&self.law_parts[law], index),
            Symbol::Definition(index) => self.formula(part, &part.effect.definitions[index].formula),
            Symbol::Variable(variable) => match self.current.iter().find(|(value, _)| *value == variable) {
                Some((_, id)) => *id,
                None if variable.is_lane_at(self.place) => self.graph.load(Load::Lane(variable)),
                None => self.graph.load(Load::Step(variable)),
            },
            Symbol::State(index) => {
                let stored = self.state(part, index);
                let Some((parameter, target)) = lag(&part.effect, &part.effect.states[index]) else { return stored };
                let (time, zero) = (self.parameter(part, parameter), self.graph.constant(0.0));
                let target = self.formula(part, target);
                let at_once = self.graph.apply(Op::Equal, &[time, zero]);
                self.graph.apply(Op::If, &[at_once, target, stored])
            }
        }
    }

    fn parameter(&mut self, part: &Part, index: usize) -> Id {
        let rows: Rows = part.effect.parameters[index].per;
        self.graph.load(Load::Parameter(part.parameters[index], rows))
    }

    fn state(&mut self, part: &Part, index: usize) -> Id {
        use super::definition::Holder::{Tool, ToolCell, WorkpieceCell};
        let number = part.states[index];
        self.graph.load(match part.effect.states[index].per {
            Tool => Load::ToolState(number),
            ToolCell if self.place == Hook::ToolCell => Load::OwnToolCell(number),
            ToolCell => Load::ToolCellOver(number),
            WorkpieceCell => Load::CellState(number),
        })
    }
}
