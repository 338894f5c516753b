//! Resolves the names of a formula and finds its physical dimension.

use std::collections::BTreeMap;
use std::ops::Range;

use super::definition::{Effect, Formula, Motion, State};
use super::dimension::Dimension;
use super::error::{EffectError, Problem};
use super::nearest::near;
use super::op::Op;
use super::process::Process;
use super::syntax::{Expr, Node};
use super::variable::{Hook, Variable};

/// Meaning of a name.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Symbol {
    /// A parameter of the effect.
    Parameter(usize),
    /// A definition of the effect.
    Definition(usize),
    /// A state of the effect.
    State(usize),
    /// A variable that the simulator supplies.
    Variable(Variable),
    /// A parameter of a base law: index of the law, index of the parameter.
    Law(usize, usize),
}

/// Names that formulas of an effect may use at a hook.
#[derive(Clone, Copy)]
pub struct Scope<'a> {
    /// The effect.
    pub effect: &'a Effect,
    /// Hook at which its formula is evaluated.
    pub place: Hook,
    /// Base laws whose parameters are visible.
    pub laws: &'a [Effect],
    /// The only process that reaches the hook; `None` for every process in which the effect acts.
    process: Option<Process>,
}

type Located<T> = Result<T, EffectError>;

/// Dimensions of definitions found so far, so that each is computed once.
type Found = BTreeMap<usize, Option<Dimension>>;

impl<'a> Scope<'a> {
    /// Names for any process.
    pub fn new(effect: &'a Effect, place: Hook, laws: &'a [Effect]) -> Self {
        Self { effect, place, laws, process: None }
    }

    /// Names for one process.
    pub fn within(self, process: Process) -> Self {
        Self { process: Some(process), ..self }
    }

    /// Resolves `name` here.
    pub fn find(&self, name: &str) -> Option<Symbol> {
        let effect = self.effect;
        let parameter = effect.parameters.iter().position(|parameter| parameter.name == name).map(Symbol::Parameter);
        let definition = || effect.definitions.iter().position(|item| item.name == name).map(Symbol::Definition);
        let readable = |state: &State| state.name == name && state.per.is_readable_at(self.place);
        let state = || effect.states.iter().position(readable).map(Symbol::State);
        let variable = || Variable::find(name, self.place).map(Symbol::Variable);
        parameter.or_else(definition).or_else(state).or_else(variable).or_else(|| self.find_in_laws(name))
    }

    /// True if the scope's process has this hook.
    pub fn is_reached(&self) -> bool {
        self.process.is_none_or(|process| process.has(self.place))
    }

    /// Finds a law's parameter; it is visible if the laws of every process with this hook have it.
    fn find_in_laws(&self, name: &str) -> Option<Symbol> {
        let of = |process: Process| {
            self.laws.iter().enumerate().filter(|(_, law)| law.acts_in(process)).find_map(|(index, law)| {
                let parameter = law.parameters.iter().position(|parameter| parameter.name == name)?;
                Some(Symbol::Law(index, parameter))
            })
        };
        let gets_here = |process: &Process| self.process.is_none_or(|only| only == *process);
        let here = |process: &Process| gets_here(process) && self.effect.acts_in(*process) && process.has(self.place);
        let mut found = Process::ALL.into_iter().filter(here).map(of);
        let first = found.next()??;
        found.all(|other| other.is_some()).then_some(first)
    }

    /// Names with units, for messages.
    pub fn available(&self) -> String {
        let effect = self.effect;
        let parameters =
            effect.parameters.iter().map(|parameter| (parameter.name.clone(), parameter.unit_text.clone()));
        let definitions = effect.definitions.iter().map(|item| (item.name.clone(), "let".to_owned()));
        let states = effect.states.iter().filter(|state| state.per.is_readable_at(self.place));
        let states = states.map(|state| (state.name.clone(), state.unit_text.clone()));
        let variables = Variable::at(self.place).map(|v| (v.name().to_owned(), v.row().unit.to_owned()));
        let law_parameters = self.laws.iter().flat_map(|law| &law.parameters);
        let law_parameters = law_parameters
            .filter(|parameter| self.find_in_laws(&parameter.name).is_some())
            .map(|parameter| (parameter.name.clone(), parameter.unit_text.clone()));
        let mut names: Vec<String> = Vec::new();
        for (name, unit) in parameters.chain(definitions).chain(states).chain(variables).chain(law_parameters) {
            let shown = format!("{name} [{unit}]");
            if !names.contains(&shown) {
                names.push(shown);
            }
        }
        names.join(", ")
    }

    /// Makes an error at a part of one of the effect's formulas.
    pub fn error(&self, formula: &Formula, span: &Range<usize>, problem: Problem) -> EffectError {
        let (line, column) = self.effect.line_column(formula.start + span.start);
        let (file, key) = (self.effect.file.clone(), formula.key.clone());
        EffectError { file, line, column, key, problem: Box::new(problem) }
    }

    fn unknown(&self, name: &str) -> Problem {
        let elsewhere = Variable::ALL.iter().find(|variable| variable.name() == name);
        let state = self.effect.states.iter().find(|state| state.name == name);
        let hint = match (elsewhere, state) {
            (Some(variable), _) => {
                let places: Vec<&str> = variable.row().places.iter().map(|place| place.name()).collect();
                format!(" (it is at {})", places.join(", "))
            }
            (None, Some(state)) => format!(" (a state per {} cannot be read here)", state.per.name()),
            (None, None) => self.nearest(name).map_or(String::new(), |near| format!(" (did you mean `{near}`?)")),
        };
        Problem::UnknownName { name: name.to_owned(), place: self.place, hint, available: self.available() }
    }

    fn nearest(&self, name: &str) -> Option<String> {
        let names = self.available();
        near(name, names.split(", ").filter_map(|shown| shown.split(' ').next())).first().map(|near| (*near).to_owned())
    }

    /// Returns the dimension of a formula; `None` for zero, which fits any dimension.
    pub fn dimension(&self, formula: &Formula) -> Located<Option<Dimension>> {
        self.dimension_of(formula, &formula.tree, &mut Found::new())
    }

    /// Checks that a formula has the expected dimension.
    pub fn expect(&self, formula: &Formula, expected: Dimension, of: &str) -> Located<()> {
        match self.dimension(formula)? {
            Some(found) if found != expected => {
                let what = format!("`{}`", formula.text);
                let expected = format!("{expected} (of {of})");
                Err(self.error(formula, &formula.tree.span, Problem::Dimension { what, found, expected }))
            }
            _ => Ok(()),
        }
    }

    fn dimension_of(&self, formula: &Formula, expr: &Expr, found: &mut Found) -> Located<Option<Dimension>> {
        match &expr.node {
            Node::Number(_, dimension) => Ok(*dimension),
            Node::Name(name) => match self.find(name) {
                Some(symbol) => self.dimension_of_symbol(symbol, found),
                None => Err(self.error(formula, &expr.span, self.unknown(name))),
            },
            Node::Apply(op, arguments) => {
                let dimensions = arguments
                    .iter()
                    .map(|argument| self.dimension_of(formula, argument, found))
                    .collect::<Located<Vec<_>>>()?;
                self.combine(*op, formula, arguments, &dimensions)
            }
        }
    }

    fn dimension_of_symbol(&self, symbol: Symbol, found: &mut Found) -> Located<Option<Dimension>> {
        let effect = self.effect;
        Ok(match symbol {
            Symbol::Parameter(index) => Some(effect.parameters[index].unit.dimension),
            Symbol::Variable(variable) => Some(variable.dimension()),
            Symbol::Law(law, index) => Some(self.laws[law].parameters[index].unit.dimension),
            Symbol::Definition(index) => match found.get(&index) {
                Some(known) => *known,
                None => {
                    let formula = &effect.definitions[index].formula;
                    let dimension = self.dimension_of(formula, &formula.tree, found)?;
                    found.insert(index, dimension);
                    dimension
                }
            },
            Symbol::State(index) => Some(effect.states[index].unit.dimension),
        })
    }

    fn combine(
        &self,
        op: Op,
        formula: &Formula,
        arguments: &[Expr],
        dimensions: &[Option<Dimension>],
    ) -> Located<Option<Dimension>> {
        let plain = Some(Dimension::NONE);
        let same =
            |a: usize, b: usize| self.unify(formula, [&arguments[a], &arguments[b]], [dimensions[a], dimensions[b]]);
        let number = |at: usize, of: &str| self.expect_number(formula, &arguments[at], dimensions[at], of);
        match op {
            Op::Add | Op::Sub | Op::Min | Op::Max => same(0, 1),
            Op::Less | Op::LessEqual | Op::Equal => same(0, 1).map(|_| plain),
            Op::If => number(0, "the condition").and_then(|()| same(1, 2)),
            Op::Mul => Ok(dimensions[0].zip(dimensions[1]).map(|(a, b)| a * b)),
            Op::Div => Ok(dimensions[0].zip(dimensions[1]).map(|(a, b)| a / b)),
            Op::Neg | Op::Abs => Ok(dimensions[0]),
            Op::Sign => Ok(plain),
            Op::Exp | Op::Log | Op::Sin | Op::Cos | Op::Tanh => number(0, "its argument").map(|()| plain),
            Op::Sqrt => self.raise(formula, [&arguments[0], &arguments[0]], dimensions[0], 0.5),
            Op::Pow => {
                number(1, "the exponent")?;
                match (dimensions[0], arguments[1].literal()) {
                    (Some(Dimension::NONE), _) => Ok(plain),
                    (base, Some(power)) => self.raise(formula, [&arguments[0], &arguments[1]], base, power),
                    (base, None) => self
                        .expect_number(formula, &arguments[0], base, "the base of a power that is not a plain number")
                        .map(|()| plain),
                }
            }
        }
    }

    fn expect_number(&self, formula: &Formula, expr: &Expr, found: Option<Dimension>, of: &str) -> Located<()> {
        match found {
            Some(found) if !found.is_none() => {
                let what = format!("`{}`", &formula.text[expr.span.clone()]);
                let expected = format!("a plain number ({of})");
                Err(self.error(formula, &expr.span, Problem::Dimension { what, found, expected }))
            }
            _ => Ok(()),
        }
    }

    fn unify(
        &self,
        formula: &Formula,
        [left, right]: [&Expr; 2],
        found: [Option<Dimension>; 2],
    ) -> Located<Option<Dimension>> {
        match found {
            [Some(a), Some(b)] if a != b => {
                let what = format!("`{}`", &formula.text[right.span.clone()]);
                let expected = format!("{a} (as `{}`)", &formula.text[left.span.clone()]);
                Err(self.error(formula, &right.span, Problem::Dimension { what, found: b, expected }))
            }
            [a, b] => Ok(a.or(b)),
        }
    }

    fn raise(
        &self,
        formula: &Formula,
        [base, exponent]: [&Expr; 2],
        dimension: Option<Dimension>,
        power: f64,
    ) -> Located<Option<Dimension>> {
        let Some(dimension) = dimension else { return Ok(None) };
        dimension.to_power(power).map(Some).ok_or_else(|| {
            let what = format!("`{}`", &formula.text[base.span.clone()]);
            let expected = "a plain number, or an exponent that is a multiple of 1/12".to_owned();
            self.error(formula, &exponent.span, Problem::Dimension { what, found: dimension, expected })
        })
    }
}

/// Formulas of a state's evolution, each with its required dimension and a description.
pub fn motion_formulas(state: &State) -> Vec<(&Formula, Dimension, String)> {
    let second = Dimension::whole([0, 0, 1, 0]);
    let unit = state.unit.dimension;
    match &state.motion {
        Motion::Rate(rate) => vec![(rate, unit / second, format!("the change of `{}` per second", state.name))],
        Motion::Relax { target, time } => {
            vec![(target, unit, format!("the state `{}`", state.name)), (time, second, "a time".to_owned())]
        }
    }
}
