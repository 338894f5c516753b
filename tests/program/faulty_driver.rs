//! A driver with injected faults: a Vulkan layer, `faulty_driver.c`, between the loader and the real driver.
//!
//! It is compiled on first use, with the `cc` with which Rust links programs on Linux.

use std::fs;
use std::path::Path;
use std::process::Command;
use std::sync::LazyLock;

use tempfile::TempDir;

const LAYER: &str = "VK_LAYER_ROBOFIN_faulty_driver";

/// Folder of the layer.
static FOLDER: LazyLock<TempDir> = LazyLock::new(|| {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let place = |name: &str| folder.path().join(name);
    fs::write(place("faulty_driver.c"), include_str!("faulty_driver.c")).expect("the layer's text");
    let manifest = format!(
        r#"{{"file_format_version": "1.2.0", "layer": {{"name": "{LAYER}", "type": "GLOBAL", "api_version": "1.3.0",
           "library_path": "./libfaulty_driver.so", "implementation_version": "1", "description": "faults",
           "device_extensions": [{{"name": "VK_EXT_memory_budget", "spec_version": "1", "entrypoints": []}}]}}}}"#
    );
    fs::write(place("faulty_driver.json"), manifest).expect("the layer's manifest");
    let cc = ["-Wall", "-Wextra", "-Werror", "-O1", "-shared", "-fPIC", "-o", "libfaulty_driver.so", "faulty_driver.c"];
    let compiled = Command::new("cc").args(cc).current_dir(folder.path()).output().expect("cc, which Rust links with");
    assert!(compiled.status.success(), "{}", String::from_utf8_lossy(&compiled.stderr));
    folder
});

/// Returns true if faults can be injected: with a Vulkan driver, on Linux. Otherwise reports the skipped test.
pub(crate) fn can_be_made(untested: &str) -> bool {
    let Some(device) = shaders::testing::device(untested) else { return false };
    let there = cfg!(target_os = "linux") && device.adapter().backend == "vulkan";
    if !there {
        eprintln!("NOT TESTED: {untested}: the faulty driver is a Vulkan layer for Linux");
    }
    there
}

/// Places the layer before a program's driver; `settings` are listed in `faulty_driver.c`.
pub(crate) fn with_faults<'a>(command: &'a mut Command, settings: &[(&str, &str)]) -> &'a mut Command {
    command.envs([("VK_LAYER_PATH", FOLDER.path())]).env("VK_INSTANCE_LAYERS", LAYER).env("NODEVICE_SELECT", "1");
    for (name, value) in settings {
        command.env(format!("FAULTY_DRIVER_{name}"), value);
    }
    command
}

/// Returns the numbers of submissions and of refused allocations that the layer wrote to the file in `NOTES`.
pub(crate) fn counted(notes: &Path) -> (usize, usize) {
    let notes = fs::read(notes).expect("a file with notes");
    let count = |what: u8| notes.iter().filter(|note| **note == what).count();
    (count(b'.'), count(b'!'))
}
