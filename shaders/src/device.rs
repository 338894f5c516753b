//! The open device: one adapter, its queue, and a guard that turns every fault into an error.

use std::collections::BTreeMap;
use std::sync::{Arc, Mutex, OnceLock};

use crate::adapters::{self, AdapterReport, Filter};
use crate::choice;
pub use crate::choice::{Backend, BackendChoice, Decision, NoAdapter};
use crate::fault::mib;
pub use crate::fault::{DeviceFault, FaultKind};
use crate::hardware;
use crate::simulate::Kernels;

/// Environment variable of [`memory_percent`].
const MEMORY_VARIABLE: &str = "ROBOFIN_GPU_MEMORY_PERCENT";
/// Its default [%]: the rest is left to other programs and to the driver itself.
const MEMORY_PERCENT: u8 = 90;

/// The adapters of this machine and the choice of `auto`: the data behind `robofin backends`.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Survey {
    /// The adapters and the search criteria.
    pub adapters: adapters::Adapters,
    /// The choice of `--backend auto` here.
    pub auto: Decision,
    /// The choice of `--backend gpu` here, or the error.
    pub gpu: Result<Decision, NoAdapter>,
}

/// Lists the adapters of this machine, under `WGPU_BACKEND` and `WGPU_ADAPTER_NAME`. Opens none.
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
    /// Compiled kernels of the simulator by their formulas; compilation takes seconds on a software driver.
    pub(crate) kernels: Mutex<BTreeMap<String, Arc<Kernels>>>,
    adapter: AdapterReport,
    memory_percent: u8,
    /// Reason for the loss of the device, once it is lost.
    loss: Arc<OnceLock<String>>,
}

/// Result of [`open`]: the decision, and the device if it is the GPU.
#[derive(Debug)]
pub struct Opened {
    /// Backend and reason: one line for the log.
    pub decision: Decision,
    /// The device; `None` on the CPU.
    pub device: Option<Device>,
}

/// Reason why no device was opened.
#[derive(Clone, Debug, thiserror::Error)]
pub enum OpenError {
    /// There is no adapter.
    #[error("--backend gpu: {0}")]
    NoAdapter(#[from] NoAdapter),
    /// The driver refused.
    #[error(
        "{adapter} refused to open: {message} (of the memory that its driver grants, {memory_percent} % may be used: \
         {MEMORY_VARIABLE}); choose another with WGPU_ADAPTER_NAME, or use --backend cpu"
    )]
    Refused {
        /// The adapter.
        adapter: String,
        /// The driver's message.
        message: String,
        /// See [`memory_percent`].
        memory_percent: u8,
    },
    /// The environment variable of [`memory_percent`] is not a percentage.
    #[error("{MEMORY_VARIABLE} is {0:?}: a whole number from 0 to 100 is accepted, {MEMORY_PERCENT} is its default")]
    MemoryPercent(String),
}

/// Share of the driver's memory budget that may be in use [%], from `ROBOFIN_GPU_MEMORY_PERCENT`. Allocations beyond it
/// are refused, if the driver reports its budget; with 0 all are.
///
/// # Errors
/// [`OpenError::MemoryPercent`] if the variable is not a percentage.
pub fn memory_percent() -> Result<u8, OpenError> {
    let Some(text) = std::env::var(MEMORY_VARIABLE).ok().filter(|text| !text.trim().is_empty()) else {
        return Ok(MEMORY_PERCENT);
    };
    text.trim().parse().ok().filter(|percent| *percent <= 100).ok_or(OpenError::MemoryPercent(text))
}

/// Opens a device according to the user's choice, under `WGPU_BACKEND`, `WGPU_ADAPTER_NAME` and
/// `ROBOFIN_GPU_MEMORY_PERCENT`.
///
/// # Errors
/// [`OpenError::NoAdapter`] for `gpu` without an adapter, [`OpenError::Refused`] if the driver opens no device,
/// [`OpenError::MemoryPercent`] for an invalid share of its memory.
pub fn open(choice: BackendChoice) -> Result<Opened, OpenError> {
    open_with(choice, &Filter::from_env(), memory_percent()?)
}

/// As [`open`], with the filter and the share of memory [%] given instead of read from the environment.
///
/// # Errors
/// As [`open`].
pub fn open_with(choice: BackendChoice, filter: &Filter, memory_percent: u8) -> Result<Opened, OpenError> {
    // The CPU needs no driver, so none is loaded.
    if choice == BackendChoice::Cpu {
        return Ok(Opened { decision: choice::decide(choice, &adapters::Adapters::default())?, device: None });
    }
    if choice == BackendChoice::Auto && hardware::is_absent() {
        return Ok(Opened { decision: choice::without_hardware(), device: None });
    }
    let (adapters, handles) = adapters::enumerate(filter, memory_percent);
    let decision = choice::decide(choice, &adapters)?;
    let device = match decision.adapter {
        Some(at) => Some(Device::request(&handles[at], &adapters.found[at], memory_percent)?),
        None => None,
    };
    Ok(Opened { decision, device })
}

impl Device {
    /// The adapter this device is opened on.
    pub fn adapter(&self) -> &AdapterReport {
        &self.adapter
    }

    /// Reason for the loss of the device; `None` while it works.
    pub fn loss(&self) -> Option<&str> {
        self.loss.get().map(String::as_str)
    }

    fn request(handle: &wgpu::Adapter, report: &AdapterReport, memory_percent: u8) -> Result<Self, OpenError> {
        let all = handle.limits();
        // WebGPU's default limits suffice except for the size of the pool; a weak adapter gives its maximum.
        let required_limits = wgpu::Limits {
            max_storage_buffer_binding_size: all.max_storage_buffer_binding_size,
            max_buffer_size: all.max_buffer_size,
            ..wgpu::Limits::default().or_worse_values_from(&all)
        };
        let descriptor = wgpu::DeviceDescriptor {
            label: Some("robofin"),
            required_limits,
            // Arrays are few and large: small memory blocks leave more memory for them.
            memory_hints: wgpu::MemoryHints::MemoryUsage,
            ..Default::default()
        };
        let refused = |error: wgpu::RequestDeviceError| OpenError::Refused {
            adapter: report.to_string(),
            message: error.to_string(),
            memory_percent,
        };
        let (device, queue) = pollster::block_on(handle.request_device(&descriptor)).map_err(refused)?;
        let loss = Arc::new(OnceLock::new());
        let lost = loss.clone();
        device.set_device_lost_callback(move |reason, message| {
            let said = if message.is_empty() { format!("{reason:?}").to_lowercase() } else { message };
            // Called once per device.
            let _ = lost.set(said);
        });
        Ok(Self { device, queue, kernels: Mutex::default(), adapter: report.clone(), memory_percent, loss })
    }

    /// Runs `work` on the device and turns every fault, on which wgpu would panic, into an error.
    ///
    /// # Errors
    /// The first fault; out of memory takes precedence.
    pub(crate) fn guarded<T>(&self, during: &str, work: impl FnOnce(&Self) -> T) -> Result<T, DeviceFault> {
        let internal = self.device.push_error_scope(wgpu::ErrorFilter::Internal);
        let validation = self.device.push_error_scope(wgpu::ErrorFilter::Validation);
        let memory = self.device.push_error_scope(wgpu::ErrorFilter::OutOfMemory);
        let result = work(self);
        let memory = pollster::block_on(memory.pop());
        let validation = pollster::block_on(validation.pop());
        let internal = pollster::block_on(internal.pop());
        match (memory, validation.or(internal)) {
            (Some(_), _) => {
                drop(result);
                self.free();
                Err(self.out_of_memory(during))
            }
            (None, Some(error)) => Err(self.fault(during, &error)),
            // The loss of a device is not reported by any error scope.
            (None, None) => match self.loss() {
                Some(said) => Err(self.fault_of(FaultKind::Lost, during, said.to_owned())),
                None => Ok(result),
            },
        }
    }

    /// Frees dropped buffers: those with pending writes live until the writes are submitted.
    fn free(&self) {
        let memory = self.device.push_error_scope(wgpu::ErrorFilter::OutOfMemory);
        self.queue.submit([]);
        let _ = self.device.poll(wgpu::PollType::wait_indefinitely());
        drop(pollster::block_on(memory.pop()));
    }

    /// A fault of this device; a loss takes precedence as the cause.
    pub(crate) fn fault(&self, during: &str, error: &dyn std::error::Error) -> DeviceFault {
        // Only here does wgpu report that a device was destroyed.
        let _ = self.device.poll(wgpu::PollType::Poll);
        match self.loss() {
            Some(said) => self.fault_of(FaultKind::Lost, during, said.to_owned()),
            None => self.fault_of(FaultKind::Refused, during, error.to_string()),
        }
    }

    fn out_of_memory(&self, during: &str) -> DeviceFault {
        let told = self.device.generate_allocator_report();
        let held = told.map(|report| format!("{} are held already, and ", mib(&report.total_reserved_bytes)));
        let message = format!(
            "{}of the memory that its driver grants {} % may be used ({MEMORY_VARIABLE})",
            held.unwrap_or_default(),
            self.memory_percent
        );
        self.fault_of(FaultKind::OutOfMemory, during, message)
    }

    fn fault_of(&self, kind: FaultKind, during: &str, message: String) -> DeviceFault {
        DeviceFault { adapter: self.adapter.to_string(), during: during.into(), kind, message }
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
