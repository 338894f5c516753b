//! A device for the tests of every room that has kernels, or a loud word where there is none.

use crate::device::{BackendChoice, Device, open};

/// Any adapter, software drivers included. Without one this says on standard error what was not tested.
///
/// # Panics
/// Without an adapter where `ROBOFIN_REQUIRE_GPU=1` promises one, so that no test passes by not running.
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

/// Takes the device away, as a driver that is reset does.
pub fn lose(device: &Device) {
    device.device.destroy();
}
