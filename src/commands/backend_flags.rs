//! Flag for the backend of work that a GPU can do.

use anyhow::Result;
use clap::Args;
use shaders::Device;
use shaders::device::{BackendChoice, open};

use crate::console::Console;
use crate::wrong_use;

/// Choice of the backend.
#[derive(Clone, Debug, Args)]
pub(super) struct BackendFlags {
    /// Where it runs: `auto` takes a graphics processor where there is a real one, else the CPU; `gpu` any adapter,
    /// software drivers included.
    #[arg(long, value_name = "auto|cpu|gpu", default_value = "auto")]
    backend: BackendChoice,
}

/// Returns the name of a backend for records: `cpu`, or the adapter.
pub(super) fn name_of(device: Option<&Device>) -> String {
    device.map_or_else(|| "cpu".to_owned(), |device| device.adapter().to_string())
}

impl BackendFlags {
    /// Returns true if `--backend gpu` was given.
    pub(super) fn is_gpu(&self) -> bool {
        self.backend == BackendChoice::Gpu
    }

    /// Returns the device, or `None` for the CPU; reports the choice and its reason in one line. `refusal` names the
    /// part of the run that the device does not support. Drivers may write to standard error while they load, so the
    /// input must be checked before.
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
