//! The open device: one adapter, its queue, and a guard that turns every fault into an error.

use std::collections::BTreeMap;
use std::sync::{Arc, Mutex};

use crate::adapters::{self, AdapterReport, Filter};
use crate::choice;
pub use crate::choice::{Backend, BackendChoice, Decision, NoAdapter};
use crate::hardware;
use crate::simulate::Kernels;

/// What this machine has and what `auto` makes of it: the data behind `robofin backends`.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Survey {
    /// The adapters and what was looked for.
    pub adapters: adapters::Adapters,
    /// What `--backend auto` takes here.
    pub auto: Decision,
    /// What `--backend gpu` takes here, or why it fails.
    pub gpu: Result<Decision, NoAdapter>,
}

/// Looks at the adapters of this machine, under `WGPU_BACKEND` and `WGPU_ADAPTER_NAME`. Opens none.
pub fn survey() -> Survey {
    let adapters = adapters::list(&Filter::from_env());
    let auto = if hardware::is_absent() { choice::without_hardware() } else { choice::auto(&adapters) };
    Survey { auto, gpu: choice::decide(BackendChoice::Gpu, &adapters), adapters }
}

/// An open device and its queue.
#[derive(Debug)]
pub struct Device {
    pub(crate) device: wgpu::Device,
    pub(crate) queue: wgpu::Queue,
    /// Kernels of the simulator that were compiled, by their formulas: it takes seconds on a software driver.
    pub(crate) kernels: Mutex<BTreeMap<String, Arc<Kernels>>>,
    adapter: AdapterReport,
}

/// What [`open`] gives: the decision, and the device where it is the GPU.
#[derive(Debug)]
pub struct Opened {
    /// Where the work runs, and why: one line for the log.
    pub decision: Decision,
    /// The device; `None` on the CPU.
    pub device: Option<Device>,
}

/// Why no device was opened.
#[derive(Clone, Debug, thiserror::Error)]
pub enum OpenError {
    /// There is no adapter.
    #[error("--backend gpu: {0}")]
    NoAdapter(#[from] NoAdapter),
    /// The driver refused.
    #[error("{adapter} refused to open: {message}; choose another with WGPU_ADAPTER_NAME, or use --backend cpu")]
    Refused {
        /// The adapter.
        adapter: String,
        /// The driver's words.
        message: String,
    },
}

/// A fault of the device or of what was asked of it.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("{adapter} failed while {during}: {message}; --backend cpu does the same work")]
pub struct DeviceFault {
    /// The adapter.
    pub adapter: String,
    /// What was being done.
    pub during: String,
    /// The driver's or the validator's words.
    pub message: String,
    /// Whether less work at once might have gone well.
    pub out_of_memory: bool,
}

/// Opens a device as the user chose, under `WGPU_BACKEND` and `WGPU_ADAPTER_NAME`.
///
/// # Errors
/// [`OpenError::NoAdapter`] for `gpu` without an adapter, [`OpenError::Refused`] where the driver gives no device.
pub fn open(choice: BackendChoice) -> Result<Opened, OpenError> {
    open_with(choice, &Filter::from_env())
}

/// As [`open`], with the filter given instead of read from the environment.
///
/// # Errors
/// As [`open`].
pub fn open_with(choice: BackendChoice, filter: &Filter) -> Result<Opened, OpenError> {
    // The CPU needs no driver, so none is loaded.
    if choice == BackendChoice::Cpu {
        return Ok(Opened { decision: choice::decide(choice, &adapters::Adapters::default())?, device: None });
    }
    if choice == BackendChoice::Auto && hardware::is_absent() {
        return Ok(Opened { decision: choice::without_hardware(), device: None });
    }
    let (adapters, handles) = adapters::enumerate(filter);
    let decision = choice::decide(choice, &adapters)?;
    let device = match decision.adapter {
        Some(at) => Some(Device::request(&handles[at], &adapters.found[at])?),
        None => None,
    };
    Ok(Opened { decision, device })
}

impl Device {
    /// The adapter this device is opened on.
    pub fn adapter(&self) -> &AdapterReport {
        &self.adapter
    }

    fn request(handle: &wgpu::Adapter, report: &AdapterReport) -> Result<Self, OpenError> {
        let all = handle.limits();
        // WebGPU's defaults are enough but for the size of the pool; a weak adapter gives what it has.
        let required_limits = wgpu::Limits {
            max_storage_buffer_binding_size: all.max_storage_buffer_binding_size,
            max_buffer_size: all.max_buffer_size,
            ..wgpu::Limits::default().or_worse_values_from(&all)
        };
        let descriptor = wgpu::DeviceDescriptor { label: Some("robofin"), required_limits, ..Default::default() };
        let (device, queue) = pollster::block_on(handle.request_device(&descriptor))
            .map_err(|error| OpenError::Refused { adapter: report.to_string(), message: error.to_string() })?;
        Ok(Self { device, queue, kernels: Mutex::default(), adapter: report.clone() })
    }

    /// Runs `work` on the device and turns whatever goes wrong in it, which wgpu would panic on, into an error.
    ///
    /// # Errors
    /// The first fault, out of memory before the others.
    pub(crate) fn guarded<T>(&self, during: &str, work: impl FnOnce(&Self) -> T) -> Result<T, DeviceFault> {
        let internal = self.device.push_error_scope(wgpu::ErrorFilter::Internal);
        let validation = self.device.push_error_scope(wgpu::ErrorFilter::Validation);
        let memory = self.device.push_error_scope(wgpu::ErrorFilter::OutOfMemory);
        let result = work(self);
        let memory = pollster::block_on(memory.pop());
        let validation = pollster::block_on(validation.pop());
        let internal = pollster::block_on(internal.pop());
        let out_of_memory = memory.is_some();
        match memory.or(validation).or(internal) {
            Some(error) => Err(DeviceFault { out_of_memory, ..self.fault(during, &error) }),
            None => Ok(result),
        }
    }

    /// A fault of this device.
    pub(crate) fn fault(&self, during: &str, error: &dyn std::error::Error) -> DeviceFault {
        let adapter = self.adapter.to_string();
        DeviceFault { adapter, during: during.into(), message: error.to_string(), out_of_memory: false }
    }
}

#[cfg(test)]
mod tests {
    #[test]
    fn a_fault_that_wgpu_would_panic_on_is_an_error_that_names_the_adapter() {
        let Some(device) = crate::testing::device("the guard around device work") else { return };
        let too_large = wgpu::BufferDescriptor {
            label: None,
            size: device.device.limits().max_buffer_size + 4,
            usage: wgpu::BufferUsages::STORAGE,
            mapped_at_creation: false,
        };
        let fault = device.guarded("making a buffer", |device| device.device.create_buffer(&too_large)).unwrap_err();
        assert!(fault.to_string().contains(&device.adapter().name), "{fault}");
        assert!(fault.to_string().contains("making a buffer"), "{fault}");
        assert_eq!(device.guarded("nothing", |_| 7), Ok(7));
    }
}
