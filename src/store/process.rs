//! Starts the process of an item, and interprets its end.

use std::process::{Command, ExitStatus, Output, Stdio};

use anyhow::{Context, Result};
use files::program::Program;
use serde::{Deserialize, Serialize};

use super::limits::{Limits, TIME_IS_UP, Usage};
use super::{Fault, Stage, StoredItem};
use crate::in_full;

/// Exit code of a Rust program that panicked.
const PANICKED: i32 = 101;
/// Start of the allocator's message when memory runs out.
const OUT_OF_MEMORY: &str = "memory allocation of";

/// Outcome of making an item.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Ending {
    /// It was made.
    Made,
    /// It existed already.
    There,
    /// Another process is making it.
    Busy,
    /// It cannot be made.
    Failed {
        /// Stage at which it failed.
        stage: Stage,
        /// Reason with its causes.
        reason: String,
    },
}

impl Ending {
    /// Converts the result for the item `id` into an outcome.
    pub fn of(id: &str, filled: Result<Option<StoredItem<()>>, Fault>) -> Self {
        match filled {
            Ok(None) => Self::Busy,
            Ok(Some(StoredItem::There(()))) => Self::There,
            Ok(Some(StoredItem::Made(()))) => Self::Made,
            Err(Fault { stage, error }) => {
                // Names of staged files contain the process id; it is removed, so that reasons are the same in every
                // run.
                let ending = format!(".part-{}", std::process::id());
                let reason = in_full(&error).replace(&format!(".{id}{ending}"), id).replace(&ending, "");
                Self::Failed { stage, reason }
            }
        }
    }
}

/// Report of the process of an item: one line of JSON on standard output.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Answer {
    /// Outcome of making the item.
    pub ending: Ending,
    /// Time and memory used by the process.
    pub usage: Usage,
}

/// Runs this program with the arguments that `words` adds, on one thread, as a process that applies `limits` to itself
/// and prints an [`Answer`].
///
/// # Errors
/// If no process can be started.
pub fn run_apart(limits: Limits, words: impl FnOnce(&mut Command) -> &mut Command) -> Result<Answer> {
    let program = Program::of_this_process().context("this program cannot be found, to start it for an item")?;
    let mut command = Command::new(&program.start[0]);
    words(command.args(&program.start[1..]).args(["--threads", "1"]));
    command.stdin(Stdio::piped()).stdout(Stdio::piped()).stderr(Stdio::piped());
    let mut child = command.spawn().context("no process can be started for an item")?;
    // The child's standard input stays open as long as this process lives; the child watches it.
    let lifeline = child.stdin.take();
    let output = child.wait_with_output().context("the process of an item cannot be waited for")?;
    drop(lifeline);
    // A signal from the keyboard ends both processes; it is not a failure of the item.
    crate::interrupt::wait_if_ending();
    Ok(answer(&output, limits))
}

/// Returns the answer that a process printed, or one derived from its exit status.
fn answer(output: &Output, limits: Limits) -> Answer {
    if let (true, Ok(answer)) = (output.status.success(), serde_json::from_slice(&output.stdout)) {
        return answer;
    }
    let errors = String::from_utf8_lossy(&output.stderr);
    let (stage, reason) = match output.status.code() {
        Some(TIME_IS_UP) => (Stage::Limit, format!("it took longer than --time-limit {}", limits.time)),
        _ if errors.contains(OUT_OF_MEMORY) => {
            (Stage::Limit, format!("it needs more memory than --memory-limit {}", limits.memory as f64 * 1e-9))
        }
        Some(PANICKED) => (Stage::Crash, format!("a bug in this program: {}", panic_text(&errors))),
        _ => (Stage::Crash, format!("its process ended with {}: {}", end(output.status), errors.trim())),
    };
    Answer { ending: Ending::Failed { stage, reason }, usage: Usage::default() }
}

/// Returns location and message of a panic, without the thread's name and the hint that follows.
fn panic_text(errors: &str) -> String {
    let lines = errors.lines().skip_while(|line| !line.contains("panicked at "));
    let lines = lines.take_while(|line| !line.starts_with("note: ")).map(str::trim).filter(|line| !line.is_empty());
    let text = lines.collect::<Vec<_>>().join(" ");
    text.split_once("panicked at ").map_or(text.clone(), |(_, rest)| rest.to_owned())
}

fn end(status: ExitStatus) -> String {
    #[cfg(unix)]
    if let Some(signal) = std::os::unix::process::ExitStatusExt::signal(&status) {
        return format!("signal {signal}");
    }
    status.to_string()
}

#[cfg(all(test, unix))]
mod tests {
    use super::*;

    fn reason_of(script: &str) -> (Stage, String) {
        let output = Command::new("sh").args(["-c", script]).output().unwrap();
        match answer(&output, Limits { time: 2.5, memory: 1_500_000_000 }).ending {
            Ending::Failed { stage, reason } => (stage, reason),
            other => panic!("{other:?}"),
        }
    }

    #[test]
    fn each_way_to_end_has_its_reason() {
        assert_eq!(reason_of("exit 124"), (Stage::Limit, "it took longer than --time-limit 2.5".into()));
        let memory = reason_of("echo 'memory allocation of 12 bytes failed' >&2; kill -ABRT $$");
        assert_eq!(memory, (Stage::Limit, "it needs more memory than --memory-limit 1.5".into()));
        let panic = "echo \"thread 'main' (7) panicked at src/a.rs:1:2:\nno such thing\nnote: run with\" >&2; exit 101";
        assert_eq!(reason_of(panic), (Stage::Crash, "a bug in this program: src/a.rs:1:2: no such thing".into()));
        assert_eq!(reason_of("kill -KILL $$"), (Stage::Crash, "its process ended with signal 9: ".into()));
        assert_eq!(reason_of("echo nonsense").0, Stage::Crash);
    }
}
