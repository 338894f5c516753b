//! Where work runs that a graphics processor can do.

use anyhow::Result;
use clap::Args;
use shaders::Device;
use shaders::device::{BackendChoice, open};

use crate::console::Console;
use crate::wrong_use;

/// Choice of the backend.
#[derive(Clone, Debug, Args)]
pub(super) struct BackendFlags {
    /// Where it runs: `auto` takes a graphics processor where there is a real one, else the CPU; `gpu` any adapter, software
    /// drivers included.
    #[arg(long, value_name = "auto|cpu|gpu", default_value = "auto")]
    backend: BackendChoice,
}

/// Name of a backend for records: `cpu`, or the adapter.
pub(super) fn name_of(device: Option<&Device>) -> String {
    device.map_or_else(|| "cpu".to_owned(), |device| device.adapter().to_string())
}

impl BackendFlags {
    /// Whether a device was asked for by name.
    pub(super) fn is_gpu(&self) -> bool {
        self.backend == BackendChoice::Gpu
    }

    /// The device, or `None` for the CPU; one line says which and why. `refusal` is what of the run the device cannot do.
    /// Drivers may write to standard error as they are loaded: call it when the input has been checked.
    pub(super) fn device(&self, refusal: Option<String>, console: &Console) -> Result<Option<Device>> {
        match (refusal, self.backend) {
            (Some(what), BackendChoice::Gpu) => {
                Err(wrong_use(format!("--backend gpu: it does not run {what}; cpu and auto are accepted")))
            }
            (Some(what), BackendChoice::Auto) => {
                console.step("backend", format!("CPU: the GPU backend does not run {what}"));
                Ok(None)
            }
            (_, choice) => {
                let opened = open(choice)?;
                console.step("backend", &opened.decision.reason);
                Ok(opened.device)
            }
        }
    }
}
