//! The processor that runs passes: the CPU, or a device.

use effects::States;
use sdf_bake::BrickGrid;
use shaders::Device;
use thiserror::Error;

use crate::gpu::{self, GpuError};
use crate::{Pass, PassError, PassRecord, Progress, run_pass};

/// The processor that runs passes.
#[derive(Clone, Copy)]
pub enum Executor<'d> {
    /// All threads of the CPU.
    Cpu,
    /// A device.
    Device(&'d Device),
}

/// Reason for which a pass failed.
#[derive(Debug, Error)]
pub enum ExecutionError {
    /// On either processor, the pass itself.
    #[error(transparent)]
    Pass(#[from] PassError),
    /// The device.
    #[error(transparent)]
    Device(#[from] GpuError),
}

impl<'d> From<Option<&'d Device>> for Executor<'d> {
    fn from(device: Option<&'d Device>) -> Self {
        device.map_or(Self::Cpu, Self::Device)
    }
}

impl Executor<'_> {
    /// Runs one pass: changes `grid` and the tool's `states`, as [`run_pass`] does.
    ///
    /// # Errors
    /// Those of [`run_pass`] and of [`gpu::run_pass`].
    pub fn run_pass(
        self,
        grid: &mut BrickGrid,
        pass: Pass,
        states: &mut States,
        progress: &mut dyn FnMut(Progress),
    ) -> Result<PassRecord, ExecutionError> {
        Ok(match self {
            Self::Cpu => run_pass(grid, pass, states, progress)?,
            Self::Device(device) => gpu::run_pass(device, grid, pass, states, progress)?,
        })
    }
}
