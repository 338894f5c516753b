//! Finishing trials simulated as they were logged.
//!
//! A [`Simulation`] makes the part of a trial from the scan before, and its passes from the logs; a [`Variation`] says what of
//! that was otherwise than logged. A [`CampaignSimulation`] runs trials in order, with a tool that wears from one to the
//! next. A [`SeenSurface`] is what the scanner shows of the part after a pass.
//! A [`PassPlan`] is a pass that was made, with other settings.

mod campaign;
mod pass_plan;
mod scanner;
mod simulation;

pub use campaign::{CampaignError, CampaignSimulation, Stop};
pub use pass_plan::{PassPlan, without_scans};
pub use scanner::{SeenSurface, exposed_share};
pub use simulation::{ModelRun, PassEnds, SimulatedPass, Simulation, SimulationError, TrialState, Variation, lacking};
