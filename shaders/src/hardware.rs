//! Detection of a graphics processor without loading a driver.

/// Entries of `/dev` that kernel drivers make for graphics processors: NVIDIA's, WSL's, Adreno's, Mali's.
#[cfg(target_os = "linux")]
const NODES: [&str; 4] = ["nvidia", "dxg", "kgsl", "mali"];
/// Prefix of the entries for all others, in `/dev/dri`.
#[cfg(target_os = "linux")]
const RENDER_NODE: &str = "renderD";

/// Returns true if there is certainly no graphics processor. Loading the drivers just to find that out takes a tenth of
/// a second, and some drivers write to standard error.
#[cfg(target_os = "linux")]
pub(crate) fn is_absent() -> bool {
    let holds = |folder: &str, begins: &[&str]| {
        let entries = std::fs::read_dir(folder).into_iter().flatten().flatten();
        let names = entries.map(|entry| entry.file_name().to_string_lossy().into_owned());
        names.into_iter().any(|name| begins.iter().any(|begin| name.starts_with(begin)))
    };
    !holds("/dev", &NODES) && !holds("/dev/dri", &[RENDER_NODE])
}

/// On other systems only the drivers know.
#[cfg(not(target_os = "linux"))]
pub(crate) fn is_absent() -> bool {
    false
}
