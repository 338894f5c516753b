//! Environments in which policies grind and sand welds.
//!
//! A [`Task`] is a weld to be finished: the part around it, the target, and the curve that the tool follows. An
//! [`Environment`] is a tool on a copy of that part; an action moves the tool along and across the weld, tilts it and
//! sets the force of its controller. A [`Batch`] steps many environments on several threads.
//!
//! All quantities are in SI units, in the part's frame. This crate opens no file, prints nothing, and draws only from
//! seeds: the same seed and actions give the same bytes on any number of threads.

mod action;
mod batch;
mod curve;
mod environment;
mod error;
mod metrics;
mod observation;
mod picture;
mod randomisation;
mod reward;
mod snapshot;
mod strip;
mod task;

pub use action::{ACTION, Limits};
pub use batch::{Batch, Outputs};
pub use curve::{Curve, Station};
pub use environment::{Environment, Outcome, Setup};
pub use error::EnvironmentError;
pub use metrics::{METRICS, Metrics};
pub use observation::{DEPTH, HEIGHTS, Observation, STATE};
pub use picture::RGB;
pub use randomisation::Randomisation;
pub use snapshot::Snapshot;
pub use strip::Strip;
pub use task::{Task, WeldFacts};
