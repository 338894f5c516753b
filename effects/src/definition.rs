//! An effect as its file states it: parameters, states and formulas.

use serde::{Deserialize, Serialize};

use super::accepted::Accepted;
use super::syntax::{Expr, Node};
use super::unit::Unit;
use super::variable::{Hook, Variable};

/// A finishing process.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Process {
    /// The surface recedes.
    Grinding,
    /// A coating wears off.
    Sanding,
}

impl Process {
    /// Both processes.
    pub const ALL: [Self; 2] = [Self::Grinding, Self::Sanding];

    /// Name in files.
    pub fn name(self) -> &'static str {
        match self {
            Self::Grinding => "grinding",
            Self::Sanding => "sanding",
        }
    }

    /// The process of this name.
    pub fn from_name(name: &str) -> Option<Self> {
        Self::ALL.into_iter().find(|process| process.name() == name)
    }

    /// Whether the process has this place: grinding has no dose and no exposure, sanding no recession.
    pub fn has(self, place: Hook) -> bool {
        match self {
            Self::Grinding => !matches!(place, Hook::Dose | Hook::Exposure),
            Self::Sanding => place != Hook::Rate,
        }
    }
}

/// A value for each process; most are the same for both.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ByProcess<T> {
    /// When grinding.
    pub grinding: T,
    /// When sanding.
    pub sanding: T,
}

impl<T: Copy> ByProcess<T> {
    /// The same for both.
    pub fn both(value: T) -> Self {
        Self { grinding: value, sanding: value }
    }

    /// The value for a process.
    pub fn of(&self, process: Process) -> T {
        match process {
            Process::Grinding => self.grinding,
            Process::Sanding => self.sanding,
        }
    }
}

/// Whether a file is a base law or modifies one.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Kind {
    /// Gives a value, such as `pressure = stiffness * depth`.
    Law,
    /// Modifies values.
    Effect,
}

/// How many values a parameter has.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Rows {
    /// One.
    Model,
    /// One for each pass.
    Pass,
    /// One for each scan.
    Scan,
}

/// How a parameter is varied.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Scale {
    /// In even steps.
    Linear,
    /// In even ratios.
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
    /// Value at which the effect vanishes. An effect vanishes when all parameters that have one are at it.
    pub null: Option<f64>,
    /// Least and greatest plausible value.
    pub range: ByProcess<[f64; 2]>,
    /// How to vary it.
    pub scale: Scale,
    /// Typical value.
    pub default: ByProcess<f64>,
    /// Whether fits vary it unless told otherwise.
    pub free: ByProcess<bool>,
    /// How many values it has.
    pub per: Rows,
    /// What it is, and where its values come from.
    pub about: String,
    /// Line in the file.
    pub line: usize,
}

impl Parameter {
    /// The values that a model of a process may give it. `range` [SI] replaces its own.
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

/// A formula and its place in the file.
#[derive(Clone, Debug, PartialEq)]
pub struct Formula {
    /// Key in the file, such as `modify.rate`.
    pub key: String,
    /// As written.
    pub text: String,
    /// As a tree.
    pub tree: Expr,
    /// Byte of the file at which the text begins.
    pub start: usize,
}

/// A named part of formulas.
#[derive(Clone, Debug, PartialEq)]
pub struct Definition {
    /// Name in formulas.
    pub name: String,
    /// What it stands for.
    pub formula: Formula,
}

/// Where a state is kept.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Holder {
    /// One value.
    Tool,
    /// One value for each tool cell.
    ToolCell,
    /// One value for each workpiece cell.
    WorkpieceCell,
}

impl Holder {
    /// Where the state's own formulas are evaluated.
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

    /// Whether formulas at `place` may read such a state.
    pub fn is_readable_at(self, place: Hook) -> bool {
        match self {
            Self::Tool => !place.is_scan(),
            Self::ToolCell => place.is_per_lane() && !place.is_scan(),
            Self::WorkpieceCell => place.is_per_lane() && !place.is_scan() && place != Hook::ToolCell,
        }
    }
}

/// When a state returns to its initial value.
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

/// How a state moves.
#[derive(Clone, Debug, PartialEq)]
pub enum Motion {
    /// Its change per time is given.
    Rate(Formula),
    /// It nears a target; after `time` the distance has fallen to 1/e. With `time` 0 it is the target.
    Relax {
        /// Where it goes.
        target: Formula,
        /// How long it takes [s].
        time: Formula,
    },
}

/// A state. Values are in SI units.
#[derive(Clone, Debug, PartialEq)]
pub struct State {
    /// Name in formulas.
    pub name: String,
    /// Where it is kept.
    pub per: Holder,
    /// Its unit.
    pub unit: Unit,
    /// The unit as written; empty until it is inferred from how the state moves.
    pub unit_text: String,
    /// How it moves.
    pub motion: Motion,
    /// Value after a reset.
    pub initial: f64,
    /// When it is reset.
    pub reset: Reset,
    /// Bounds.
    pub bounds: [f64; 2],
    /// Line in the file.
    pub line: usize,
}

impl State {
    /// True of a state of the whole tool whose rate is the number 0: only a measurement changes it.
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
    /// Its new value.
    pub formula: Formula,
}

/// A base law or an effect.
#[derive(Clone, Debug, PartialEq)]
pub struct Effect {
    /// Name in models.
    pub name: String,
    /// Name for people.
    pub title: String,
    /// Where the physics comes from.
    pub source: String,
    /// Law or effect.
    pub kind: Kind,
    /// The only process in which it acts; nothing: every process whose values it changes.
    pub process: Option<Process>,
    /// What it leaves in measurements.
    pub signature: String,
    /// Effects that leave something similar.
    pub confused_with: Vec<String>,
    /// Parameters in the order of the file.
    pub parameters: Vec<Parameter>,
    /// Named parts of formulas.
    pub definitions: Vec<Definition>,
    /// States in the order of the file.
    pub states: Vec<State>,
    /// Formulas in the order of the hooks.
    pub changes: Vec<Change>,
    /// Name of the file.
    pub file: String,
    /// The file.
    pub text: String,
}

impl Effect {
    /// Whether it acts in a process.
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

    /// Whether its changes or their named parts read one of some variables.
    pub fn reads(&self, variables: &[Variable]) -> bool {
        let formulas = self.changes.iter().map(|change| &change.formula);
        let mut all = formulas.chain(self.definitions.iter().map(|definition| &definition.formula));
        let is_one = |name: &str| variables.iter().any(|variable| variable.name() == name);
        all.any(|formula| formula.tree.names().iter().any(|(name, _)| is_one(name)))
    }

    /// The parameter of this name.
    pub fn parameter(&self, name: &str) -> Option<&Parameter> {
        self.parameters.iter().find(|parameter| parameter.name == name)
    }

    /// Line and column, from 1, of a byte of the file.
    pub fn line_column(&self, byte: usize) -> (usize, usize) {
        line_column(&self.text, byte)
    }
}

/// Line and column, from 1, of a byte of a text.
pub fn line_column(text: &str, byte: usize) -> (usize, usize) {
    let before = &text[..text.floor_char_boundary(byte)];
    let line_start = before.rfind('\n').map_or(0, |at| at + 1);
    (before.matches('\n').count() + 1, before[line_start..].chars().count() + 1)
}
