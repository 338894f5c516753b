//! A device for the tests, or a loud word where there is none.

use shaders::device::{BackendChoice, Device, open};

/// Any adapter, software drivers included. Without one this says which test did not run, and fails where
/// `ROBOFIN_REQUIRE_GPU=1` promises an adapter.
pub(crate) fn device(untested: &str) -> Option<Device> {
    match open(BackendChoice::Gpu) {
        Ok(opened) => {
            println!("{untested}: on {}", opened.decision.reason);
            opened.device
        }
        Err(error) => {
            let promised = std::env::var("ROBOFIN_REQUIRE_GPU").is_ok_and(|value| value == "1");
            assert!(!promised, "ROBOFIN_REQUIRE_GPU=1, but: {error}");
            eprintln!("NOT TESTED: {untested}: {error}");
            None
        }
    }
}
