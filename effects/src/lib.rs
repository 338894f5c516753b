//! The effect language: base laws and effects as files of formulas, which are read, checked, compiled and run over
//! lanes.
//!
//! The stages from text to numbers: `toml_text` and `read` split a file into its entries, `parse` builds the formulas'
//! trees, `check` verifies names and dimensions (`scope`) and the null value (`null`), `lower` combines all formulas of
//! a [`Model`] at one hook into one `graph`, `program` schedules it, `lanes` runs it, and `wgsl` writes it for a GPU.
//! `interpret` evaluates a tree directly: the programs are tested against it, and it explains results that are not
//! finite.
//!
//! ```
//! use effects::{CompiledModel, Lanes, Library, Model, Hook, Process, RowCounts, States, StepValues, Variable};
//!
//! let model = Model::new(Process::Grinding).with("pressure-exponent");
//! let mut model = CompiledModel::new(&model, Library::builtin(), RowCounts::default()).unwrap();
//! model.set(model.index("pressure-exponent.exponent").unwrap(), 0.5);
//!
//! let (step, states) = (StepValues::new(), States::new(&model, 0));
//! let call = model.at(Hook::Rate, &step, &states);
//! let mut rate = [0.0; 2];
//! call.run(&Lanes::new(2).with(Variable::Pressure, &[1e6, 4e6]), &mut rate).unwrap();
//! assert!((rate[1] / rate[0] - 2.0).abs() < 1e-12);   // r ~ p^0.5
//! ```
//!
//! This crate opens no file: texts are passed with a name for messages.

mod accepted;
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
mod nearest;
mod null;
mod one_line;
mod op;
pub mod page;
mod parameter_vector;
mod parse;
mod process;
mod program;
mod read;
mod scope;
mod states;
mod syntax;
mod toml_text;
mod unit;
mod variable;
mod wgsl;

pub use accepted::Accepted;
pub use call::Call;
pub use compiled::{CellState, CompiledModel, PoseChange};
pub use definition::{Change, Definition, Effect, Formula, Holder, Kind, Motion, Parameter, Reset, Rows, Scale, State};
pub use dimension::Dimension;
pub use edit::{Edit, candidates};
pub use error::{BadResult, EffectError, Problem, RunError};
pub use inputs::{Lanes, StepValues};
pub use library::{Library, check_file, files};
pub use model::{Model, ModelError, ModelPart};
pub use nearest::hint;
pub use one_line::{Extent, NamedState, OneLine, OneLineError, Unknown};
pub use op::Op;
pub use parameter_vector::{ParameterSlot, RowCounts};
pub use parse::SyntaxError;
pub use process::{ByProcess, Process, Signal};
pub use states::States;
pub use syntax::{Expr, Node};
pub use unit::{Unit, UnitError};
pub use variable::{Hook, Per, TABLE, Variable, VariableRow};
pub use wgsl::{DeviceModel, UnsupportedPart};

#[cfg(test)]
mod tests;
