//! Unlisted effects, which the library does not contain: the rate as a function of one variable of the simulator, found
//! from the data and written as an effect file.
//!
//! 1. `variables`: covariates of the rate, each a formula of the effect language. `action`: the quantities that may
//!    change with them: rate, pressure, the tool's place, the scanner's height. `columns`: variables that the files
//!    measure.
//! 2. `exposure`: one simulation of the fitted model, in which every variable is averaged, weighted with the removal.
//! 3. `basis`: hat functions over each variable, and the change of the whitened data by each, at unchanged contact.
//! 4. `curve`: a smooth curve over each variable, scored by cross-validation, without a simulation.
//! 5. `form`, `screen`: forms of few numbers over each variable, scored in the same way.
//! 6. `trial_fit`: the best are added to the model as effect files, simulated and fitted. `search`: a second look
//!    beside the best of them, because the missing effect biases the first model.
//! 7. `null_forms`: the null distribution of the largest Δχ² over all forms.
//! 8. `proposal`: the best form, if it is significant and improves the prediction of held-out data.

mod action;
mod basis;
mod columns;
mod curve;
mod curve_file;
mod exposure;
mod form;
mod form_text;
mod null_forms;
mod proposal;
mod screen;
mod search;
mod trial_fit;
mod variables;

pub use basis::Basis;
pub(crate) use exposure::Exposures;
pub use proposal::{CurvePoint, FittedForm, Proposal, ProposedForm, propose};
