//! The effect language: laws and effects as files of formulas, read, checked, compiled and run.

mod call;
mod check;
mod compiled;
mod definition;
mod dimension;
mod edit;
mod error;
mod graph;
mod inputs;
mod interpret;
mod lanes;
mod library;
mod lower;
mod math;
mod model;
mod null;
mod op;
mod parse;
mod program;
mod read;
mod scope;
mod slots;
mod states;
mod syntax;
mod toml_text;
mod unit;
mod variable;

pub use call::Call;
pub use compiled::{CellState, CompiledModel, PoseChange};
pub use definition::{
    ByProcess, Change, Definition, Effect, Formula, Holder, Kind, Motion, Parameter, Process, Reset, Rows, Scale, State,
};
pub use dimension::Dimension;
pub use edit::{Edit, candidates};
pub use error::{BadResult, EffectError, Problem, RunError};
pub use inputs::{Lanes, StepValues};
pub use library::{EFFECTS, LAWS, Library, check_file};
pub use model::{Model, ModelError, ModelPart};
pub use parse::SyntaxError;
pub use slots::{ParameterSlot, RowCounts};
pub use states::States;
pub use unit::{Unit, UnitError};
pub use variable::{Per, Place, TABLE, Variable, VariableRow};

#[cfg(test)]
mod tests;
