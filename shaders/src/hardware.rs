//! Whether a machine has a graphics processor at all, found without loading a driver.

/// Entries of `/dev` that kernel drivers make for graphics processors: NVIDIA's, WSL's, Adreno's, Mali's.
#[cfg(target_os = "linux")]
const NODES: [&str; 4] = ["nvidia", "dxg", "kgsl", "mali"];
/// What they make for the others, in `/dev/dri`.
#[cfg(target_os = "linux")]
const RENDER_NODE: &str = "renderD";

/// Whether there is certainly none. Loading the drivers only to learn that takes a tenth of a second, and some of them
/// write to standard error.
#[cfg(target_os = "linux")]
pub(crate) fn is_absent() -> bool {
    let holds = |folder: &str, begins: &[&str]| {
        let entries = std::fs::read_dir(folder).into_iter().flatten().flatten();
        let names = entries.map(|entry| entry.file_name().to_string_lossy().into_owned());
        names.into_iter().any(|name| begins.iter().any(|begin| name.starts_with(begin)))
    };
    !holds("/dev", &NODES) && !holds("/dev/dri", &[RENDER_NODE])
}

/// Elsewhere only the drivers know.
#[cfg(not(target_os = "linux"))]
pub(crate) fn is_absent() -> bool {
    false
}
