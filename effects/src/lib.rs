//! The effect language: base laws and effects as files of formulas, read, checked, compiled and run over lanes.
//!
//! Text becomes numbers in this order: `toml_text` and `read` take a file apart, `parse` makes trees of its formulas,
//! `check` holds names and dimensions (`scope`) and the null value (`null`) against what they must be, `lower` puts all
//! formulas of a [`Model`] at one place into one `graph`, `program` lays it out, `lanes` runs it, `wgsl` writes it out for a
//! graphics processor. `interpret` evaluates
//! a tree directly: it is what the programs are tested against, and what explains a result that is not finite.
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
//! Nothing here opens a file: texts come with a name for messages.

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
pub use definition::{
    ByProcess, Change, Definition, Effect, Formula, Holder, Kind, Motion, Parameter, Process, Reset, Rows, Scale, State,
};
pub use dimension::Dimension;
pub use edit::{Edit, candidates};
pub use error::{BadResult, EffectError, Problem, RunError};
pub use inputs::{Lanes, StepValues};
pub use library::{EFFECTS, LAWS, Library, check_file};
pub use model::{Model, ModelError, ModelPart};
pub use nearest::hint;
pub use one_line::{Extent, NamedState, OneLine, OneLineError, Unknown};
pub use op::Op;
pub use parameter_vector::{ParameterSlot, RowCounts};
pub use parse::SyntaxError;
pub use states::States;
pub use syntax::{Expr, Node};
pub use unit::{Unit, UnitError};
pub use variable::{Hook, Per, TABLE, Variable, VariableRow};
pub use wgsl::{DeviceModel, Unwritable};

#[cfg(test)]
mod tests;
