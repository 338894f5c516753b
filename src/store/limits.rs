//! Limits of the process of one item: its memory, its time, and the lifetime of its parent process.

use std::io::Read;
use std::sync::mpsc::{RecvTimeoutError, channel};
use std::thread;
use std::time::Duration;

use anyhow::Result;
use serde::{Deserialize, Serialize};

/// Exit code of a process that exceeded its time limit.
pub const TIME_IS_UP: i32 = 124;
/// Exit code of a process whose parent has ended.
const ORPHANED: i32 = 125;

/// Limits of time and memory for the process of one item.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Limits {
    /// Wall time [s].
    pub time: f64,
    /// Address space [bytes].
    pub memory: u64,
}

/// Resources used by a process.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Usage {
    /// Processor time of all threads [s].
    pub cpu_s: f64,
    /// Peak resident memory [bytes]; 0 if the system does not report it.
    pub peak_bytes: u64,
}

impl Limits {
    /// Applies the limits to this process: it ends when it exceeds its time or memory, and when its standard input is
    /// closed, which happens when its parent ends in any way.
    ///
    /// # Errors
    /// If the system refuses a limit, or does not support it.
    pub fn bind(&self) -> Result<()> {
        limit_memory(self.memory)?;
        let (sender, parent) = channel();
        thread::spawn(move || {
            // Nothing is ever sent; the end of the stream, or an error, means that the parent has ended.
            let _ = std::io::stdin().read_to_end(&mut Vec::new());
            let _ = sender.send(());
        });
        let time = Duration::from_secs_f64(self.time);
        thread::spawn(move || match parent.recv_timeout(time) {
            Err(RecvTimeoutError::Timeout) => std::process::exit(TIME_IS_UP),
            _ => std::process::exit(ORPHANED),
        });
        Ok(())
    }
}

impl Usage {
    /// Returns the resources that this process has used so far.
    pub fn now() -> Self {
        Self { cpu_s: cpu_s(), peak_bytes: peak_bytes().unwrap_or_default() }
    }
}

#[cfg(unix)]
fn limit_memory(bytes: u64) -> Result<()> {
    use rustix::process::{Resource, Rlimit, setrlimit};
    let limit = Rlimit { current: Some(bytes), maximum: Some(bytes) };
    setrlimit(Resource::As, limit).map_err(|error| anyhow::anyhow!("--memory-limit cannot be set: {error}"))
}

#[cfg(not(unix))]
fn limit_memory(_: u64) -> Result<()> {
    anyhow::bail!("--memory-limit cannot be held on this system, so no item is made")
}

#[cfg(unix)]
fn cpu_s() -> f64 {
    let time = rustix::time::clock_gettime(rustix::time::ClockId::ProcessCPUTime);
    time.tv_sec as f64 + 1e-9 * time.tv_nsec as f64
}

#[cfg(not(unix))]
fn cpu_s() -> f64 {
    0.0
}

/// Reads the peak memory from Linux, in kibibytes, as `VmHWM: 12345 kB`.
fn peak_bytes() -> Option<u64> {
    let status = std::fs::read_to_string("/proc/self/status").ok()?;
    let line = status.lines().find_map(|line| line.strip_prefix("VmHWM:"))?;
    let kibibytes: u64 = line.trim().strip_suffix("kB")?.trim().parse().ok()?;
    Some(1024 * kibibytes)
}
