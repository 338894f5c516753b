//! `robofin backends`: lists the devices, and compares them with the CPU.

use anyhow::{Result, bail};
use clap::Args;
use serde::Serialize;
use shaders::device::{self, BackendChoice};
use shaders::{SELF_CHECK_LIMIT, self_check};

use crate::console::Console;

#[derive(Debug, Args)]
#[command(
    after_help = "Example:\n  robofin backends --json\n\nWGPU_BACKEND and WGPU_ADAPTER_NAME choose among several devices."
)]
pub(super) struct BackendsArgs {}

/// The answer of `backends --json`.
#[derive(Serialize)]
struct BackendsAnswer {
    /// Backend chosen by `auto`, and the reason.
    auto: String,
    adapters: Vec<AdapterAnswer>,
    /// Largest difference of a sampled field between the first adapter and the CPU [voxels].
    self_check_voxels: Option<f32>,
}

#[derive(Serialize)]
struct AdapterAnswer {
    name: String,
    backend: String,
    driver: String,
    kind: String,
    storage_binding_bytes: u64,
    buffer_bytes: u64,
}

pub(super) fn run(_args: &BackendsArgs, console: &Console) -> Result<()> {
    let survey = device::survey();
    console.step("cpu", format!("{} threads", rayon::current_num_threads()));
    for adapter in &survey.adapters.found {
        console.step("adapter", adapter.to_string());
    }
    for passed_over in &survey.adapters.passed_over {
        console.step("left out", passed_over);
    }
    console.step("auto", &survey.auto.reason);
    let difference = match survey.gpu {
        Ok(_) => check_device(console)?,
        Err(_) => None,
    };
    let adapters = survey.adapters.found.iter().map(|adapter| AdapterAnswer {
        name: adapter.name.clone(),
        backend: adapter.backend.clone(),
        driver: adapter.driver.clone(),
        kind: adapter.kind.to_string(),
        storage_binding_bytes: adapter.limits.storage_binding_bytes,
        buffer_bytes: adapter.limits.buffer_bytes,
    });
    let answer = BackendsAnswer {
        auto: survey.auto.reason.clone(),
        adapters: adapters.collect(),
        self_check_voxels: difference,
    };
    console.answer(&answer)?;
    match difference {
        None => Ok(()),
        Some(difference) if difference <= SELF_CHECK_LIMIT => Ok(()),
        Some(difference) => {
            bail!("the device differs from the CPU by {difference} voxels; at most {SELF_CHECK_LIMIT} is accepted")
        }
    }
}

fn check_device(console: &Console) -> Result<Option<f32>> {
    let Some(device) = device::open(BackendChoice::Gpu)?.device else {
        return Ok(None);
    };
    let difference = self_check(&device)?;
    console.step(
        "check",
        format!("{}: field samples differ from the CPU by at most {difference:.1e} voxels", device.adapter().name),
    );
    Ok(Some(difference))
}
