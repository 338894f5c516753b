//! What can be wrong with a file of formulas, said so that it can be repaired.

use super::dimension::Dimension;
use super::parse::SyntaxError;
use super::unit::UnitError;
use super::variable::{Hook, Variable};

/// A fault in an effect or model file, with its place.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[error("{file}:{line}:{column}: {key}: {problem}")]
pub struct EffectError {
    /// Name of the file.
    pub file: String,
    /// Line, from 1.
    pub line: usize,
    /// Character in the line, from 1.
    pub column: usize,
    /// Key of the file, such as `modify.rate`.
    pub key: String,
    /// What is wrong there.
    pub problem: Box<Problem>,
}

/// What is wrong.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum Problem {
    /// Not TOML.
    #[error("this is not TOML: {0}")]
    Toml(String),
    /// A key that means nothing here.
    #[error("{found} means nothing here; accepted are {accepted}")]
    UnknownKey {
        /// The key.
        found: String,
        /// Keys with a meaning.
        accepted: String,
    },
    /// A key that is missing.
    #[error("`{0}` is missing")]
    Missing(String),
    /// A value that does not fit.
    #[error("found {found}, {expected} is expected")]
    Value {
        /// What stands there.
        found: String,
        /// What would be accepted.
        expected: String,
    },
    /// A unit that cannot be read.
    #[error(transparent)]
    Unit(#[from] UnitError),
    /// A formula that cannot be read.
    #[error(transparent)]
    Syntax(#[from] SyntaxError),
    /// A name that is not known where it is used.
    #[error("`{name}` is not known at the hook {place}{hint}; available are {available}")]
    UnknownName {
        /// The name.
        name: String,
        /// Where the formula is evaluated.
        place: Hook,
        /// A guess at what was meant, or where the name is known.
        hint: String,
        /// Names with their units.
        available: String,
    },
    /// Quantities that do not fit together.
    #[error("{what} has the unit {found}, {expected} is expected")]
    Dimension {
        /// The part of the formula.
        what: String,
        /// Its unit.
        found: Dimension,
        /// What would fit.
        expected: String,
    },
    /// Definitions that need each other.
    #[error("the definitions need each other in a circle: {0}")]
    Cycle(String),
    /// A formula that breaks down at the null value.
    #[error("at the null value the formula gives {result}: {cause}; with {inputs}")]
    BrokenAtNull {
        /// What came out.
        result: f64,
        /// The operation that broke down, and where.
        cause: String,
        /// Values of the variables.
        inputs: String,
    },
    /// An effect that does not vanish.
    #[error(
        "at the null value the effect must vanish exactly, but it turns {value} = {before:?} into {after:?}; with {inputs}"
    )]
    NotNull {
        /// The value that the formula modifies.
        value: Variable,
        /// The value before.
        before: f64,
        /// The value after.
        after: f64,
        /// Values of the variables.
        inputs: String,
    },
    /// A name that is taken.
    #[error("the name `{name}` is taken by {owner}; choose another")]
    Taken {
        /// The name.
        name: String,
        /// What has it.
        owner: String,
    },
}

/// A value that is not finite, found while a model runs.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum RunError {
    /// A formula's result.
    #[error(transparent)]
    Result(Box<BadResult>),
    /// An input that was handed in.
    #[error("the simulator hands {value} as {variable} to the hook {place}, lane {lane}")]
    Input {
        /// The variable.
        variable: String,
        /// Its value.
        value: f64,
        /// The hook.
        place: Hook,
        /// The first such lane.
        lane: usize,
    },
    /// A lane that is missing or of another length.
    #[error("{variable} has {found} values at the hook {place}, {expected} are expected")]
    Shape {
        /// The variable.
        variable: String,
        /// Values handed in.
        found: usize,
        /// Lanes.
        expected: usize,
        /// The hook.
        place: Hook,
    },
}

/// A formula that gave no finite number.
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
    /// What came out.
    pub result: f64,
    /// Where it is evaluated.
    pub place: Hook,
    /// The operation that broke down.
    pub cause: String,
    /// Values of the variables in the first such lane.
    pub inputs: String,
}
