//! An effect as its file defines it: parameters, states and formulas.

use super::accepted::Accepted;
use super::process::{ByProcess, Process};
use super::syntax::{Expr, Node};
use super::unit::Unit;
use super::variable::{Hook, Variable};

/// Kind of file: a base law or an effect that modifies one.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Kind {
    /// Gives a value, such as `pressure = stiffness * depth`.
    Law,
    /// Modifies values.
    Effect,
}

/// Number of values of a parameter.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Rows {
    /// One value.
    Model,
    /// One value for each pass.
    Pass,
    /// One value for each scan.
    Scan,
}

/// Scale on which a parameter is varied.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Scale {
    /// Linear: equal steps.
    Linear,
    /// Logarithmic: equal ratios.
    Log,
}

/// A parameter. Values are in SI units.
#[derive(Clone, Debug, PartialEq)]
pub struct Parameter {
    /// Name in formulas.
    pub name: String,
    /// Symbol in the literature.
    pub symbol: String,
    /// Unit in files and tables.
    pub unit: Unit,
    /// The unit as written.
    pub unit_text: String,
    /// Null value. An effect vanishes if all parameters that have a null value are at it.
    pub null: Option<f64>,
    /// Least and greatest plausible value.
    pub range: ByProcess<[f64; 2]>,
    /// Scale on which it is varied.
    pub scale: Scale,
    /// Typical value.
    pub default: ByProcess<f64>,
    /// True if fits vary it by default.
    pub free: ByProcess<bool>,
    /// Number of its values.
    pub per: Rows,
    /// Description, and source of its values.
    pub about: String,
    /// Line in the file.
    pub line: usize,
}

impl Parameter {
    /// Values that a model of a process may give it. `range` [SI] replaces its own range.
    pub fn accepted(&self, process: Process, range: Option<[f64; 2]>) -> Accepted<'_> {
        Accepted {
            range: range.unwrap_or(self.range.of(process)),
            null: self.null,
            default: self.default.of(process),
            unit: self.unit,
            unit_text: &self.unit_text,
        }
    }
}

/// A formula and its position in the file.
#[derive(Clone, Debug, PartialEq)]
pub struct Formula {
    /// Key in the file, such as `modify.rate`.
    pub key: String,
    /// Text as written.
    pub text: String,
    /// Syntax tree.
    pub tree: Expr,
    /// Byte offset of the text in the file.
    pub start: usize,
}

/// A named subexpression of formulas.
#[derive(Clone, Debug, PartialEq)]
pub struct Definition {
    /// Name in formulas.
    pub name: String,
    /// Formula that it stands for.
    pub formula: Formula,
}

/// Owner of a state.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Holder {
    /// The tool: one value.
    Tool,
    /// Each tool cell: one value per cell.
    ToolCell,
    /// Each workpiece cell: one value per cell.
    WorkpieceCell,
}

impl Holder {
    /// Hook at which the state's own formulas are evaluated.
    pub fn place(self) -> Hook {
        match self {
            Self::Tool => Hook::ToolState,
            Self::ToolCell => Hook::ToolCell,
            Self::WorkpieceCell => Hook::WorkpieceCell,
        }
    }

    /// Name in files.
    pub fn name(self) -> &'static str {
        match self {
            Self::Tool => "tool",
            Self::ToolCell => "tool_cell",
            Self::WorkpieceCell => "workpiece_cell",
        }
    }

    /// True if formulas at `place` may read such a state.
    pub fn is_readable_at(self, place: Hook) -> bool {
        match self {
            Self::Tool => !place.is_scan(),
            Self::ToolCell => place.is_per_lane() && !place.is_scan(),
            Self::WorkpieceCell => place.is_per_lane() && !place.is_scan() && place != Hook::ToolCell,
        }
    }
}

/// Event at which a state returns to its initial value.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Reset {
    /// When the tool is dressed or renewed.
    FreshTool,
    /// Before each workpiece.
    Trial,
    /// Before each pass.
    Pass,
    /// Never.
    Never,
}

/// Evolution of a state in time.
#[derive(Clone, Debug, PartialEq)]
pub enum Motion {
    /// The time derivative is given.
    Rate(Formula),
    /// The state relaxes to a target with time constant `time`. With `time` 0 it equals the target.
    Relax {
        /// Target value.
        target: Formula,
        /// Time constant [s].
        time: Formula,
    },
}

/// A state. Values are in SI units.
#[derive(Clone, Debug, PartialEq)]
pub struct State {
    /// Name in formulas.
    pub name: String,
    /// Owner of the state.
    pub per: Holder,
    /// Unit.
    pub unit: Unit,
    /// The unit as written; empty until it is inferred from the evolution formula.
    pub unit_text: String,
    /// Evolution in time.
    pub motion: Motion,
    /// Value after a reset.
    pub initial: f64,
    /// Event at which it is reset.
    pub reset: Reset,
    /// Lower and upper bound.
    pub bounds: [f64; 2],
    /// Line in the file.
    pub line: usize,
}

impl State {
    /// True for a state of the whole tool whose rate is the number 0: only a measurement changes it.
    pub fn is_held(&self) -> bool {
        let is_zero = |rate: &Formula| matches!(rate.tree.node, Node::Number(value, _) if value == 0.0);
        self.per == Holder::Tool && matches!(&self.motion, Motion::Rate(rate) if is_zero(rate))
    }
}

/// A formula that gives or modifies a value at a hook.
#[derive(Clone, Debug, PartialEq)]
pub struct Change {
    /// The hook.
    pub hook: Hook,
    /// The value.
    pub value: Variable,
    /// Formula of its new value.
    pub formula: Formula,
}

/// A base law or an effect.
#[derive(Clone, Debug, PartialEq)]
pub struct Effect {
    /// Name in models.
    pub name: String,
    /// Descriptive name.
    pub title: String,
    /// Reference for the physics.
    pub source: String,
    /// Law or effect.
    pub kind: Kind,
    /// The only process in which it acts; `None` for every process whose values it changes.
    pub process: Option<Process>,
    /// Pattern that it leaves in measurements.
    pub signature: String,
    /// Effects with a similar signature.
    pub confused_with: Vec<String>,
    /// Place in the order of action: lower numbers act first.
    pub order: u32,
    /// Parameters in the order of the file.
    pub parameters: Vec<Parameter>,
    /// Named subexpressions of formulas.
    pub definitions: Vec<Definition>,
    /// States in the order of the file.
    pub states: Vec<State>,
    /// Formulas in the order of the hooks.
    pub changes: Vec<Change>,
    /// Name of the file.
    pub file: String,
    /// Text of the file.
    pub text: String,
}

impl Effect {
    /// True if it acts in a process.
    pub fn acts_in(&self, process: Process) -> bool {
        self.process.is_none_or(|only| only == process) && self.changes_in(process).next().is_some()
    }

    /// The formulas that act in a process.
    pub fn changes_in(&self, process: Process) -> impl Iterator<Item = &Change> {
        self.changes.iter().filter(move |change| process.has(change.hook))
    }

    /// All formulas of the file.
    pub fn formulas(&self) -> impl Iterator<Item = &Formula> {
        let definitions = self.definitions.iter().map(|definition| &definition.formula);
        let states = self.states.iter().flat_map(|state| match &state.motion {
            Motion::Rate(rate) => [Some(rate), None],
            Motion::Relax { target, time } => [Some(target), Some(time)],
        });
        self.changes.iter().map(|change| &change.formula).chain(definitions).chain(states.flatten())
    }

    /// True if its changes or definitions read one of these variables.
    pub fn reads(&self, variables: &[Variable]) -> bool {
        let formulas = self.changes.iter().map(|change| &change.formula);
        let mut all = formulas.chain(self.definitions.iter().map(|definition| &definition.formula));
        let is_one = |name: &str| variables.iter().any(|variable| variable.name() == name);
        all.any(|formula| formula.tree.names().iter().any(|(name, _)| is_one(name)))
    }

    /// Returns the parameter of this name.
    pub fn parameter(&self, name: &str) -> Option<&Parameter> {
        self.parameters.iter().find(|parameter| parameter.name == name)
    }

    /// Line and column, from 1, of a byte offset in the file.
    pub fn line_column(&self, byte: usize) -> (usize, usize) {
        line_column(&self.text, byte)
    }
}

/// Line and column, from 1, of a byte offset in a text.
pub fn line_column(text: &str, byte: usize) -> (usize, usize) {
    let before = &text[..text.floor_char_boundary(byte)];
    let line_start = before.rfind('\n').map_or(0, |at| at + 1);
    (before.matches('\n').count() + 1, before[line_start..].chars().count() + 1)
}
