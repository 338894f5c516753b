//! A machine without a driver: one clear line and the CPU, or an error that names the package; never a panic.

use std::process::Command;

use shaders::choice::DRIVER_PACKAGE;
use shaders::device::{Backend, BackendChoice, open, survey};

/// Also run by the test below in a process of its own where every driver is hidden.
#[test]
fn the_survey_agrees_with_what_opens() {
    let survey = survey();
    println!("auto: {}", survey.auto.reason);
    assert!(!survey.auto.reason.contains('\n'));
    assert!(survey.adapters.found.is_sorted_by_key(|adapter| adapter.kind));
    match (survey.gpu, open(BackendChoice::Gpu)) {
        (Ok(decision), Ok(opened)) => {
            assert_eq!(opened.decision, decision);
            let device = opened.device.expect("a device beside a GPU decision");
            assert_eq!(*device.adapter(), survey.adapters.found[0]);
        }
        (Err(reason), Err(error)) => {
            println!("gpu: {error}");
            assert!(error.to_string().contains(&reason.to_string()));
            assert_eq!(survey.auto.backend, Backend::Cpu);
        }
        (surveyed, opened) => panic!("surveyed {surveyed:?}, opened {opened:?}"),
    }
    assert_eq!(open(BackendChoice::Auto).expect("auto always has an answer").decision, survey.auto);
}

#[test]
fn with_every_driver_hidden_auto_is_the_cpu_and_gpu_names_the_package() {
    let child = Command::new(std::env::current_exe().expect("this test's own program"))
        .args(["--exact", "the_survey_agrees_with_what_opens", "--nocapture"])
        .env("WGPU_BACKEND", "vulkan")
        .env("VK_DRIVER_FILES", "/nonexistent")
        .env("VK_ICD_FILENAMES", "/nonexistent")
        .env_remove("WGPU_ADAPTER_NAME")
        .output()
        .expect("a child process");
    let said = String::from_utf8_lossy(&child.stdout);
    assert!(child.status.success(), "{said}{}", String::from_utf8_lossy(&child.stderr));
    // If the machine has a graphics processor, `auto` looks for drivers, too.
    for line in ["auto: CPU: ", "gpu: --backend gpu: no graphics adapter found"] {
        let line = said.lines().find(|l| l.contains(line)).unwrap_or_else(|| panic!("no \"{line}\" in {said}"));
        assert!(line.contains(DRIVER_PACKAGE), "{line}");
    }
}
