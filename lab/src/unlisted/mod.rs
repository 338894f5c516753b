//! Effects that the library does not hold: the rate as a function of one thing that the simulator knows, found from the data
//! and written as an effect file.
//!
//! 1. `variables`: covariates of the rate, each a formula of the effect language. `action`: the quantities that may change
//!    with them: rate, pressure, the tool's place, the scanner's height. `columns`: variables that the files measure.
//! 2. `exposure`: one simulation of the fitted model, in which every variable is summed up where something is removed.
//! 3. `basis`: hat functions over each variable, and the change of the whitened data by each, with the contact frozen.
//! 4. `curve`: a smooth curve over each variable, scored by cross-validation, without a simulation.
//! 5. `form`, `screen`: forms of few numbers over each variable, scored in the same way.
//! 6. `trial_fit`: the best are added to the model as effect files, simulated and fitted. `search`: a second look beside the
//!    best of them, for a model that lacks something has gone astray.
//! 7. `null_forms`: the Δχ² that noise alone would give the luckiest form.
//! 8. `proposal`: the best that chance does not explain and that predicts the held-out data better than the model without.

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
