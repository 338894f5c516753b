//! A device for the tests and benchmarks of all crates with kernels, or a clear message if none is available.

use std::time::Instant;

use crate::buffers::zeros;
use crate::device::{BackendChoice, Device, DeviceFault, open};

/// Bytes per copy when measuring bandwidth: more than caches hold.
const COPIED: u64 = 64 << 20;
/// Number of copies of one measurement.
const COPIES: u32 = 32;

/// Opens any adapter, software drivers included. Without one, says on standard error which test did not run.
///
/// # Panics
/// Without an adapter if `ROBOFIN_REQUIRE_GPU=1` requires one, so that no test passes without running.
pub fn device(untested: &str) -> Option<Device> {
    match open(BackendChoice::Gpu) {
        Ok(opened) => opened.device,
        Err(error) => {
            let promised = std::env::var("ROBOFIN_REQUIRE_GPU").is_ok_and(|value| value == "1");
            assert!(!promised, "ROBOFIN_REQUIRE_GPU=1, but {untested} cannot be tested: {error}");
            eprintln!("NOT TESTED: {untested}: {error}");
            None
        }
    }
}

/// Bytes that the device reads and writes per second when it copies from buffer to buffer.
///
/// # Errors
/// [`DeviceFault`] if the device fails.
pub fn copy_bandwidth(device: &Device) -> Result<f64, DeviceFault> {
    let copy = |copies: u32| {
        device.guarded("copying", |device| {
            let [from, to] = ["from", "to"].map(|label| zeros(device, label, COPIED, wgpu::BufferUsages::STORAGE));
            let mut encoder = device.device.create_command_encoder(&wgpu::CommandEncoderDescriptor::default());
            for _ in 0..copies {
                encoder.copy_buffer_to_buffer(&from, 0, &to, 0, COPIED);
            }
            let started = Instant::now();
            device.queue.submit([encoder.finish()]);
            let waited = device.device.poll(wgpu::PollType::wait_indefinitely());
            waited.map(|_| started.elapsed().as_secs_f64())
        })
    };
    let mut seconds = 0.0;
    // The first copies allocate the memory.
    for copies in [2, COPIES] {
        seconds = copy(copies)?.map_err(|error| device.fault("copying", &error))?;
    }
    Ok(2.0 * f64::from(COPIES) * COPIED as f64 / seconds)
}

/// Destroys the device, as a driver reset does.
pub fn lose(device: &Device) {
    device.device.destroy();
}
