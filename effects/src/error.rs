//! Errors of formula files, with the details needed to correct them.

use super::dimension::Dimension;
use super::parse::SyntaxError;
use super::unit::UnitError;
use super::variable::{Hook, Variable};

/// A fault in an effect or model file, with its position.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[error("{file}:{line}:{column}: {key}: {problem}")]
pub struct EffectError {
    /// Name of the file.
    pub file: String,
    /// Line, from 1.
    pub line: usize,
    /// Column, counted in characters from 1.
    pub column: usize,
    /// Key of the file, such as `modify.rate`.
    pub key: String,
    /// The fault found there.
    pub problem: Box<Problem>,
}

/// Kind of fault.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum Problem {
    /// Text that is not TOML.
    #[error("this is not TOML: {0}")]
    Toml(String),
    /// A key without meaning here.
    #[error("unknown key {found}; accepted are {accepted}")]
    UnknownKey {
        /// The key.
        found: String,
        /// Accepted keys.
        accepted: String,
    },
    /// A missing key.
    #[error("`{0}` is missing")]
    Missing(String),
    /// A value that is not accepted.
    #[error("found {found}, {expected} is expected")]
    Value {
        /// Value found.
        found: String,
        /// Values that are accepted.
        expected: String,
    },
    /// A unit that cannot be parsed.
    #[error(transparent)]
    Unit(#[from] UnitError),
    /// A formula that cannot be parsed.
    #[error(transparent)]
    Syntax(#[from] SyntaxError),
    /// A name that is unknown at the hook where it is used.
    #[error("`{name}` is not known at the hook {place}{hint}; available are {available}")]
    UnknownName {
        /// The name.
        name: String,
        /// Hook at which the formula is evaluated.
        place: Hook,
        /// A likely intended name, or the hooks at which the name is known.
        hint: String,
        /// Available names with their units.
        available: String,
    },
    /// Quantities of mismatched dimension.
    #[error("{what} has the unit {found}, {expected} is expected")]
    Dimension {
        /// The part of the formula.
        what: String,
        /// Its unit.
        found: Dimension,
        /// Expected dimension.
        expected: String,
    },
    /// Definitions that depend on each other in a circle.
    #[error("circular definitions: {0}")]
    Cycle(String),
    /// A formula that is not finite at the null value.
    #[error("at the null value the formula gives {result}: {cause}; with {inputs}")]
    BrokenAtNull {
        /// Result of the formula.
        result: f64,
        /// Operation that gave the first value that is not finite, and its position.
        cause: String,
        /// Values of the variables.
        inputs: String,
    },
    /// An effect that does not vanish at its null value.
    #[error(
        "at the null value the effect must vanish exactly, but it turns {value} = {before:?} into {after:?}; with {inputs}"
    )]
    NotNull {
        /// The value that the formula modifies.
        value: Variable,
        /// Value before the effect.
        before: f64,
        /// Value after the effect.
        after: f64,
        /// Values of the variables.
        inputs: String,
    },
    /// A name that is already used.
    #[error("the name `{name}` is taken by {owner}; choose another")]
    Taken {
        /// The name.
        name: String,
        /// Owner of the name.
        owner: String,
    },
}

/// An error while a model runs, such as a value that is not finite.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum RunError {
    /// A formula whose result is not finite.
    #[error(transparent)]
    Result(Box<BadResult>),
    /// An input from the simulator that is not finite.
    #[error("the simulation gives {variable} = {value} at the hook {place}, lane {lane}; a finite number is expected")]
    Input {
        /// The variable.
        variable: String,
        /// Its value.
        value: f64,
        /// The hook.
        place: Hook,
        /// The first lane with such a value.
        lane: usize,
    },
    /// A lane variable that is missing or of the wrong length.
    #[error("{variable} has {found} values at the hook {place}, {expected} are expected")]
    Shape {
        /// The variable.
        variable: String,
        /// Number of values supplied.
        found: usize,
        /// Number of lanes.
        expected: usize,
        /// The hook.
        place: Hook,
    },
}

/// A formula whose result is not finite.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[error("{file}:{line}: {key}: `{formula}` gives {result} at the hook {place}: {cause}; with {inputs}")]
pub struct BadResult {
    /// File of the effect.
    pub file: String,
    /// Line of the formula.
    pub line: usize,
    /// Key of the formula.
    pub key: String,
    /// The formula.
    pub formula: String,
    /// Result of the formula.
    pub result: f64,
    /// Hook at which it is evaluated.
    pub place: Hook,
    /// Operation that gave the first value that is not finite.
    pub cause: String,
    /// Values of the variables in the first such lane.
    pub inputs: String,
}
