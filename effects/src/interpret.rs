//! Direct interpretation of formulas, one number at a time. It is the reference for the lane programs, and finds the
//! operation that gave a value that is not finite.

use std::collections::BTreeMap;

use super::definition::{Effect, Formula, Motion, State};
use super::op::Op;
use super::scope::{Scope, Symbol};
use super::syntax::{Expr, Node};

/// Values of everything that a formula of an effect may name.
pub struct Environment<'a> {
    /// Scope that resolves the names.
    pub scope: Scope<'a>,
    /// Parameters of the effect [SI].
    pub parameters: &'a [f64],
    /// Parameters of the laws [SI].
    pub law_parameters: &'a [Vec<f64>],
    /// Variables [SI], by `Variable`.
    pub variables: &'a [f64],
    /// States of the effect [SI].
    pub states: &'a [f64],
}

/// One evaluation; each definition is computed once, however often it is used.
struct Evaluation<'e, 'a> {
    environment: &'e Environment<'a>,
    named: BTreeMap<Symbol, f64>,
    /// Definitions in which every operation gives a finite value.
    good: Vec<usize>,
}

impl Evaluation<'_, '_> {
    fn of(&mut self, expr: &Expr) -> f64 {
        match &expr.node {
            Node::Number(value, _) => *value,
            Node::Name(name) => self.environment.scope.find(name).map_or(f64::NAN, |symbol| self.value(symbol)),
            Node::Apply(op, arguments) => op.apply(self.arguments(arguments)),
        }
    }

    fn arguments(&mut self, arguments: &[Expr]) -> [f64; 3] {
        let mut values = [0.0; 3];
        for (value, argument) in values.iter_mut().zip(arguments) {
            *value = self.of(argument);
        }
        values
    }

    fn value(&mut self, symbol: Symbol) -> f64 {
        if let Some(value) = self.named.get(&symbol) {
            return *value;
        }
        let Environment { scope, parameters, law_parameters, variables, states } = *self.environment;
        let effect = scope.effect;
        let value = match symbol {
            Symbol::Parameter(index) => parameters[index],
            Symbol::Definition(index) => self.of(&effect.definitions[index].formula.tree),
            Symbol::Variable(variable) => variables[variable as usize],
            Symbol::Law(law, index) => law_parameters[law][index],
            Symbol::State(index) => match lag(effect, &effect.states[index]) {
                Some((parameter, target)) if parameters[parameter] == 0.0 => self.of(&target.tree),
                _ => states[index],
            },
        };
        self.named.insert(symbol, value);
        value
    }

    fn find_fault(&mut self, formula: &Formula, expr: &Expr) -> Option<String> {
        let scope = self.environment.scope;
        match &expr.node {
            Node::Number(..) => None,
            Node::Name(name) => match scope.find(name)? {
                Symbol::Definition(index) if self.good.contains(&index) => None,
                Symbol::Definition(index) => {
                    let inner = &scope.effect.definitions[index].formula;
                    let fault = self.find_fault(inner, &inner.tree);
                    self.good.push(index);
                    fault
                }
                symbol => self.value(symbol).is_nan().then(|| format!("`{name}` is not a number")),
            },
            Node::Apply(op, arguments) => {
                let within = arguments.iter().find_map(|argument| self.find_fault(formula, argument));
                within.or_else(|| {
                    let values = self.arguments(arguments);
                    let fault = fault_of(*op, values, op.apply(values))?;
                    let (line, column) = scope.effect.line_column(formula.start + expr.span.start);
                    Some(format!("{fault} in `{}` at {line}:{column}", &formula.text[expr.span.clone()]))
                })
            }
        }
    }
}

impl Environment<'_> {
    /// Evaluates a formula.
    pub fn evaluate(&self, expr: &Expr) -> f64 {
        self.evaluation().of(expr)
    }

    fn evaluation(&self) -> Evaluation<'_, '_> {
        Evaluation { environment: self, named: BTreeMap::new(), good: Vec::new() }
    }

    /// Evaluates a state after `dt` [s].
    pub fn advanced(&self, index: usize, dt: f64) -> f64 {
        let state = &self.scope.effect.states[index];
        let old = self.states[index];
        let moved = match &state.motion {
            Motion::Rate(rate) => old + dt * self.evaluate(&rate.tree),
            Motion::Relax { target, time } => {
                let (target, time) = (self.evaluate(&target.tree), self.evaluate(&time.tree));
                let passed = 1.0 - super::math::exp(-dt / time);
                if time == 0.0 { target } else { old + (target - old) * passed }
            }
        };
        super::op::min(super::op::max(moved, state.bounds[0]), state.bounds[1])
    }

    /// Describes the innermost operation whose arguments are finite and whose result is not, with its position in the
    /// file.
    pub fn cause(&self, formula: &Formula) -> String {
        let fault = self.evaluation().find_fault(formula, &formula.tree);
        fault.unwrap_or_else(|| "an infinite value is used".to_owned())
    }

    /// Lists the names of a formula with their values.
    pub fn inputs(&self, formula: &Formula) -> String {
        let mut names: Vec<&str> = Vec::new();
        self.collect(&formula.tree, &mut names);
        let mut evaluation = self.evaluation();
        let shown = names.iter().filter_map(|name| {
            let value = self.scope.find(name).map(|symbol| evaluation.value(symbol))?;
            Some(format!("{name} = {value:?}"))
        });
        shown.collect::<Vec<_>>().join(", ")
    }

    fn collect<'b>(&'b self, expr: &'b Expr, names: &mut Vec<&'b str>) {
        for (name, _) in expr.names() {
            if !names.contains(&name) {
                names.push(name);
                if let Some(Symbol::Definition(index)) = self.scope.find(name) {
                    self.collect(&self.scope.effect.definitions[index].formula.tree, names);
                }
            }
        }
    }
}

fn fault_of(op: Op, [a, b, _]: [f64; 3], result: f64) -> Option<&'static str> {
    match op {
        Op::Div if b == 0.0 => Some("division by zero"),
        Op::Sqrt if a < 0.0 => Some("square root of a negative number"),
        Op::Log if a <= 0.0 => Some("logarithm of zero or a negative number"),
        Op::Pow if a < 0.0 => Some("power of a negative number"),
        Op::Pow if a == 0.0 && b < 0.0 => Some("negative power of zero"),
        _ if result.is_nan() => Some("the result is not a number"),
        _ if result.is_infinite() && a.is_finite() && b.is_finite() => Some("the result is too large"),
        _ => None,
    }
}

/// Identifies a lag: a state that relaxes with a time constant that is a parameter with null value 0. At null it equals
/// its target, so that the effect vanishes exactly. Returns the index of the parameter and the target.
pub fn lag<'a>(effect: &Effect, state: &'a State) -> Option<(usize, &'a Formula)> {
    let Motion::Relax { target, time } = &state.motion else { return None };
    let Node::Name(name) = &time.tree.node else { return None };
    let index = effect.parameters.iter().position(|parameter| parameter.name == *name)?;
    (effect.parameters[index].null == Some(0.0)).then_some((index, target))
}
