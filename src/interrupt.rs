//! Signals that end the program: what was staged is removed, then it ends with 128 and the signal's number.

use std::sync::atomic::{AtomicBool, Ordering};

/// True while a signal is ending the program.
static ENDING: AtomicBool = AtomicBool::new(false);

/// Listens to SIGINT, SIGTERM and SIGHUP from now on, but for those that the caller had the program ignore.
#[cfg(unix)]
pub(crate) fn listen() {
    use signal_hook::consts::{SIGHUP, SIGINT, SIGTERM};
    let wanted = [SIGINT, SIGTERM, SIGHUP].into_iter().filter(|&signal| !is_ignored(signal));
    // Without a listener the program ends at once, as it would without this; the next run removes what is left.
    let Ok(mut signals) = signal_hook::iterator::Signals::new(wanted) else { return };
    std::thread::spawn(move || {
        if let Some(signal) = signals.forever().next() {
            ENDING.store(true, Ordering::SeqCst);
            let _nothing_moves = files::remove_all();
            eprintln!("interrupted: nothing unfinished is left behind");
            std::process::exit(128 + signal);
        }
    });
}

/// On this system a signal ends the program at once; the next run removes what is left.
#[cfg(not(unix))]
pub(crate) fn listen() {}

/// Whether a signal was ignored when the program began, as `nohup` has it; Linux says so in hexadecimal digits.
#[cfg(unix)]
fn is_ignored(signal: i32) -> bool {
    let status = std::fs::read_to_string("/proc/self/status").unwrap_or_default();
    let line = status.lines().find_map(|line| line.strip_prefix("SigIgn:"));
    let ignored = line.and_then(|digits| u64::from_str_radix(digits.trim(), 16).ok());
    ignored.is_some_and(|ignored| ignored >> (signal - 1) & 1 == 1)
}

/// Waits for the end where a signal has begun it: what fails meanwhile fails because its place was removed.
pub(crate) fn wait_if_ending() {
    while ENDING.load(Ordering::SeqCst) {
        std::thread::park();
    }
}
