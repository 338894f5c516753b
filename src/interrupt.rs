//! Signals that end the program: staged files are removed, then it exits with 128 plus the signal's number.

use std::sync::atomic::{AtomicBool, Ordering};

/// True while a signal is ending the program.
static ENDING: AtomicBool = AtomicBool::new(false);

/// Installs a handler of SIGINT, SIGTERM and SIGHUP, except for those that the caller has set to be ignored.
#[cfg(unix)]
pub(crate) fn listen() {
    use signal_hook::consts::{SIGHUP, SIGINT, SIGTERM};
    let wanted = [SIGINT, SIGTERM, SIGHUP].into_iter().filter(|&signal| !is_ignored(signal));
    // Without the handler a signal ends the program at once, and the next run removes the leftovers.
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

/// Does nothing: on this system a signal ends the program at once, and the next run removes the leftovers.
#[cfg(not(unix))]
pub(crate) fn listen() {}

/// Returns true if a signal was ignored when the program started, for example by `nohup`; Linux reports a mask.
#[cfg(unix)]
fn is_ignored(signal: i32) -> bool {
    let status = std::fs::read_to_string("/proc/self/status").unwrap_or_default();
    let line = status.lines().find_map(|line| line.strip_prefix("SigIgn:"));
    let ignored = line.and_then(|digits| u64::from_str_radix(digits.trim(), 16).ok());
    ignored.is_some_and(|ignored| ignored >> (signal - 1) & 1 == 1)
}

/// Waits for the exit if a signal has begun it, because failures at that time come from the removal of staged files.
pub(crate) fn wait_if_ending() {
    while ENDING.load(Ordering::SeqCst) {
        std::thread::park();
    }
}
