//! Simulation of finishing trials from their logs.
//!
//! A [`Simulation`] builds the part of a trial from the scan before, and its passes from the logs; a [`Variation`]
//! changes these inputs. A [`CampaignSimulation`] runs trials in order, with a tool that wears from one to the next. A
//! [`SeenSurface`] is the surface of the part at the scanner's pixels after a pass. A [`PassPlan`] is an executed pass
//! with other settings.

mod blur;
mod campaign;
mod pass_plan;
mod recent;
mod scanner;
mod simulation;

pub use blur::blurred;
pub use campaign::{CampaignError, CampaignSimulation, Stop};
pub use pass_plan::{PassPlan, without_scans};
pub use scanner::{SeenSurface, exposed_share};
pub use simulation::{ModelRun, PassEnds, RunState, SimulatedPass, Simulation, SimulationError, Variation, lacking};
