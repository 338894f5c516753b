//! Passes on a graphics processor: many independent trials in one submission, one workgroup each.
//!
//! The device runs the same list of phases as [`crate::run_pass`]. Each shader mirrors a file of this crate: height
//! field, contact, controller, removal, reinitialisation. It computes in f32, with lengths measured from the tool's
//! lowest point and the height field's own level. [`refusal`] names what the device does not support.

mod batch;
mod readback;
mod setup;

pub use batch::{Outcome, Settings, Trial, run_batch, run_pass};

use crate::measured::Readings;
use crate::settings::{Pass, PassError};
use crate::tool_cells;
use effects::{CompiledModel, DeviceModel, Hook};
use robot::Tool;

/// Error of a trial on the device.
#[derive(Debug, thiserror::Error, PartialEq)]
pub enum GpuError {
    /// A feature that the device does not support.
    #[error("the GPU backend does not run {0}: --backend cpu does")]
    Unsupported(String),
    /// An error that the CPU reports, too.
    #[error(transparent)]
    Pass(#[from] PassError),
    /// A formula gives no finite number in f32.
    #[error(
        "at {time:.4} s of the pass: a formula of {effects} gives no finite number at the hook {place}; the part holds the \
         last good state, and --backend cpu shows the formula with its inputs"
    )]
    Formula {
        /// Time in the pass [s].
        time: f64,
        /// The effects that act at the hook, or the base law.
        effects: String,
        /// The hook.
        place: Hook,
    },
    /// The device failed or is out of memory. The part is as it was before the pass.
    #[error("{0}; the part is as it was before the pass")]
    Device(shaders::simulate::SimulateError),
}

/// Names the feature of a pass that the device does not support; `None` if it supports all.
pub fn refusal(pass: &Pass) -> Option<String> {
    if pass.covariates.is_some() {
        return Some("maps of what each place goes through".to_owned());
    }
    if pass.gauge.is_some() {
        return Some("the wrench of the contact".to_owned());
    }
    if let Some(measured) = Readings::new(pass.model, pass.measured).changing() {
        return Some(format!("the column {}, which changes in the course of a pass", measured.name));
    }
    if pass.force.is_some() {
        return Some("a force setpoint that changes in the course of a pass".to_owned());
    }
    refusal_of(pass.tool, pass.model)
}

/// The same for a tool and a model alone.
pub fn refusal_of(tool: &Tool, model: &CompiledModel) -> Option<String> {
    if setup::shape_on_device(tool).is_none() {
        return Some("a tool of this shape".to_owned());
    }
    DeviceModel::new(model, tool_cells::COUNT).err().map(|fault| format!("a model in which {fault}"))
}
