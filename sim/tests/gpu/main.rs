//! The simulator on the device: the same passes as on the CPU.
//!
//! All tests share a device, and so the kernels compiled on it: compilation takes most of the time on a software
//! driver.

mod batch;
#[path = "../common/mod.rs"]
mod common;
mod effects;
#[path = "../../../tests/program/faulty_driver.rs"]
mod faulty_driver;
mod parity;

use std::sync::OnceLock;

use shaders::Device;

/// The device that the tests share; `None` if none is available and none is required.
pub(crate) fn device() -> Option<&'static Device> {
    static DEVICE: OnceLock<Option<Device>> = OnceLock::new();
    DEVICE.get_or_init(|| shaders::testing::device("the simulator on the device")).as_ref()
}
