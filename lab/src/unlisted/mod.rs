//! What no effect of the library describes: the rate as a function of one thing that the simulator knows, found from the
//! data and written as an effect file.
//!
//! 1. `variables`: what the rate may depend on, each a formula of the effect language.
//!    `action`: what such an effect may act on: the rate, the pressure, the tool's place, the scanner.
//! 2. `exposure`: one simulation of the fitted model, in which every variable is summed up where something is removed.
//! 3. `basis`: hats over each variable, and what each would change in the whitened data with the contact as it is.
//! 4. `curve`: a smooth curve over each variable, scored by what it predicts of data left out. No simulation.
//! 5. `form`, `screen`: forms of few numbers over each variable, scored in the same way.
//! 6. `trial_fit`: the best are added to the model as effect files, simulated and fitted. `search`: a second look beside the
//!    best of them, for a model that lacks something has gone astray.
//! 7. `chance`: the fall of χ² that noise alone would give the luckiest form.
//! 8. `proposal`: the best that chance does not explain and that predicts the held-out data better than the model without.

mod action;
mod basis;
mod chance;
mod curve;
mod curve_file;
mod exposure;
mod form;
mod form_text;
mod proposal;
mod screen;
mod search;
mod trial_fit;
mod variables;

pub use basis::Basis;
pub(crate) use exposure::Exposures;
pub use proposal::{CurvePoint, FittedForm, Proposal, ProposedForm, propose};
