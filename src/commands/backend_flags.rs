//! Where passes run.

use anyhow::Result;
use clap::Args;
use shaders::Device;
use shaders::device::{BackendChoice, open};

use crate::console::Console;
use crate::wrong_use;

/// Choice of the backend.
#[derive(Clone, Debug, Args)]
pub(super) struct BackendFlags {
    /// Where passes run: `auto` takes a graphics processor where there is a real one, `gpu` any adapter.
    #[arg(long, value_name = "auto|cpu|gpu", default_value = "cpu")]
    backend: BackendChoice,
}

impl BackendFlags {
    /// The device, or `None` for the CPU; one line says which and why. `refusal` is what of the run the device cannot do.
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
