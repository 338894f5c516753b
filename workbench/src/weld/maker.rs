//! Runs `robofin weld` in the background: one run at a time, whose lines are its progress.

use std::collections::VecDeque;
use std::io::{BufRead, BufReader, Read};
use std::path::{Path, PathBuf};
use std::process::{Child, Command, Stdio};
use std::sync::{Arc, Mutex, PoisonError};
use std::thread;
use std::time::Instant;

use files::program::Program;
use serde::Serialize;
use tokio::sync::watch;

use super::flags::Flags;
use super::parts::PartFile;
use crate::error::Refusal;
use crate::shell::quoted;

/// Number of last lines that are kept.
const MOST_LINES: usize = 40;
/// Greatest length of a line [bytes].
const LONGEST_LINE: u64 = 4096;

/// An asset to make.
pub(crate) struct Order {
    /// Words of the command line after the program's name.
    words: Vec<String>,
    /// Folder of the asset.
    out: PathBuf,
}

/// How a run ended.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[serde(rename_all = "kebab-case")]
pub(crate) enum Outcome {
    /// The asset exists.
    Made,
    /// The user cancelled it.
    Cancelled,
    /// The program refused, in its words.
    Failed(String),
}

/// A run for the page.
#[derive(Clone, Debug, Serialize)]
#[serde(rename_all = "camelCase")]
pub(crate) struct RunState {
    /// Command line.
    command: String,
    /// Folder of the asset.
    pub(crate) out: PathBuf,
    /// Last lines that it printed.
    lines: VecDeque<String>,
    /// Running time [s].
    seconds: f64,
    /// How it ended; `None` while it runs.
    pub(crate) outcome: Option<Outcome>,
    #[serde(skip)]
    since: Instant,
    #[serde(skip)]
    process: u32,
    #[serde(skip)]
    is_cancelled: bool,
}

/// The last run.
pub(crate) struct Maker {
    run: Arc<Mutex<Option<RunState>>>,
    version: watch::Sender<u64>,
}

impl Default for Maker {
    fn default() -> Self {
        Self { run: Arc::default(), version: watch::Sender::new(1) }
    }
}

impl Order {
    /// Makes the order for an asset in a folder.
    pub(crate) fn new(part: &PartFile, out: &Path, flags: &Flags) -> Self {
        let words = flags.command(&part.path.display().to_string(), &out.display().to_string());
        Self { words, out: out.to_owned() }
    }

    /// Returns the command line for a POSIX shell.
    pub(crate) fn line(&self) -> String {
        let words = self.words.iter().map(|word| quoted(word)).collect::<Vec<_>>();
        format!("robofin {}", words.join(" "))
    }
}

impl Maker {
    /// Starts a run.
    ///
    /// # Errors
    /// If one is running, or the program cannot be started.
    pub(crate) fn start(&self, order: &Order) -> Result<(), Refusal> {
        let mut run = self.run.lock().unwrap_or_else(PoisonError::into_inner);
        if run.as_ref().is_some_and(|run| run.outcome.is_none()) {
            return Err(Refusal::early("an asset is being made; wait for it, or cancel it"));
        }
        let failed = |error: std::io::Error| Refusal::wrong(format!("{}: {error}", order.line()));
        let program = Program::of_this_process().map_err(failed)?;
        let Some((first, rest)) = program.start.split_first() else {
            return Err(Refusal::wrong("the program does not know how it was started"));
        };
        let mut command = Command::new(first);
        command.args(rest).args(&order.words);
        command.stdin(Stdio::null()).stdout(Stdio::null()).stderr(Stdio::piped());
        let child = command.spawn().map_err(failed)?;
        *run = Some(RunState {
            command: order.line(),
            out: order.out.clone(),
            lines: VecDeque::new(),
            seconds: 0.0,
            outcome: None,
            since: Instant::now(),
            process: child.id(),
            is_cancelled: false,
        });
        let (run, version) = (self.run.clone(), self.version.clone());
        thread::spawn(move || follow(child, &run, &version));
        self.version.send_modify(|version| *version += 1);
        Ok(())
    }

    /// Ends the run; its program removes what is unfinished.
    pub(crate) fn cancel(&self) {
        let mut run = self.run.lock().unwrap_or_else(PoisonError::into_inner);
        if let Some(run) = run.as_mut().filter(|run| run.outcome.is_none()) {
            run.is_cancelled = true;
            end(run.process);
        }
    }

    /// Waits for a version later than the known one.
    pub(crate) async fn later_than(&self, known: u64) {
        // The sender lives as long as this, so the wait does not fail.
        let _version = self.version.subscribe().wait_for(|version| *version > known).await.is_ok();
    }

    /// Returns the version and the last run.
    pub(crate) fn state(&self) -> (u64, Option<RunState>) {
        let version = *self.version.borrow();
        let mut run = self.run.lock().unwrap_or_else(PoisonError::into_inner).clone();
        if let Some(run) = run.as_mut().filter(|run| run.outcome.is_none()) {
            run.seconds = run.since.elapsed().as_secs_f64();
        }
        (version, run)
    }
}

/// Asks a process to end.
#[cfg(unix)]
fn end(process: u32) {
    let own = i32::try_from(process).ok().and_then(rustix::process::Pid::from_raw);
    // A process that has ended already needs no signal.
    let _sent = own.is_some_and(|own| rustix::process::kill_process(own, rustix::process::Signal::TERM).is_ok());
}

/// Ends nothing: on this system the run goes on until it is done.
#[cfg(not(unix))]
fn end(_process: u32) {}

/// Reads the lines of a run until it ends.
fn follow(mut child: Child, run: &Mutex<Option<RunState>>, version: &watch::Sender<u64>) {
    let change = |change: &dyn Fn(&mut RunState)| {
        run.lock().unwrap_or_else(PoisonError::into_inner).iter_mut().for_each(change);
        version.send_modify(|version| *version += 1);
    };
    if let Some(output) = child.stderr.take() {
        let mut reader = BufReader::new(output);
        while let Some(line) = next_line(&mut reader) {
            change(&|run| {
                run.lines.push_back(line.clone());
                run.lines.drain(..run.lines.len().saturating_sub(MOST_LINES));
            });
        }
    }
    let ended = child.wait();
    change(&|run| {
        run.seconds = run.since.elapsed().as_secs_f64();
        run.outcome = Some(match &ended {
            Ok(status) if status.success() => Outcome::Made,
            _ if run.is_cancelled => Outcome::Cancelled,
            Ok(_) => Outcome::Failed(reason(&run.lines)),
            Err(error) => Outcome::Failed(error.to_string()),
        });
    });
}

/// Reads a line, or the start of a long one; `None` at the end.
fn next_line(reader: &mut impl BufRead) -> Option<String> {
    let mut bytes = Vec::new();
    let read = reader.by_ref().take(LONGEST_LINE).read_until(b'\n', &mut bytes).unwrap_or(0);
    (read > 0).then(|| String::from_utf8_lossy(&bytes).trim_end().to_owned())
}

/// Words of the error among the last lines.
fn reason(lines: &VecDeque<String>) -> String {
    let begin = lines.iter().rposition(|line| line.starts_with("error:")).unwrap_or(lines.len().saturating_sub(3));
    lines.iter().skip(begin).map(String::as_str).collect::<Vec<_>>().join("\n")
}
