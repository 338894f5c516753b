//! Output of the program: messages and progress on standard error; one JSON object, or one a line, on standard output.

use std::io::{ErrorKind, IsTerminal, Write};
use std::sync::atomic::{AtomicUsize, Ordering};
use std::time::{Duration, Instant};

use anyhow::Result;
use indicatif::{ProgressBar, ProgressStyle};
use serde::Serialize;

/// Progress of long work.
pub struct Progress {
    about: String,
    bar: ProgressBar,
    started: Instant,
    quarters: AtomicUsize,
}

impl Progress {
    /// Reports that `done` of `all` parts are done; `what` is the last of them.
    pub fn report(&self, what: &str, done: usize, all: usize) {
        self.bar.set_position((100 * done / all.max(1)) as u64);
        let quarter = 4 * done / all.max(1);
        if self.bar.is_hidden() && self.quarters.fetch_max(quarter, Ordering::Relaxed) < quarter {
            let seconds = self.started.elapsed().as_secs_f64();
            eprintln!("{:>10}  {} % after {seconds:.0} s: {what}", self.about, 25 * quarter);
        }
    }
}

impl Drop for Progress {
    fn drop(&mut self) {
        self.bar.finish_and_clear();
    }
}

/// Ignores a broken pipe on standard output, which means that the reader closed it.
fn unless_closed(written: std::io::Result<()>) -> Result<()> {
    match written {
        Err(error) if error.kind() != ErrorKind::BrokenPipe => Err(error.into()),
        _ => Ok(()),
    }
}

/// Console of the program, for this crate only; the other crates report through return values and callbacks.
pub struct Console {
    json: bool,
    bars: bool,
    steps: bool,
}

impl Console {
    /// Makes a console; `json` is true for JSON answers on standard output.
    pub fn new(json: bool) -> Self {
        Self { json, bars: std::io::stderr().is_terminal(), steps: true }
    }

    /// Makes a console without any output.
    pub fn silent() -> Self {
        Self { json: false, bars: false, steps: false }
    }

    /// Returns true if steps of the work are reported.
    pub fn reports_steps(&self) -> bool {
        self.steps
    }

    /// Reports one step of the work: its subject, and the outcome.
    pub fn step(&self, about: &str, outcome: impl AsRef<str>) {
        if !self.steps {
            return;
        }
        let mut lines = outcome.as_ref().lines();
        eprintln!("{about:>10}  {}", lines.next().unwrap_or_default());
        for line in lines {
            eprintln!("{:>10}  {line}", "");
        }
    }

    /// Prints a result in the layout of a step: on standard output, or on standard error if standard output carries
    /// JSON. A closed output is no error.
    ///
    /// # Errors
    /// If standard output cannot be written.
    pub fn result(&self, about: &str, text: impl AsRef<str>) -> Result<()> {
        if self.json {
            self.step(about, text);
            return Ok(());
        }
        let mut out = std::io::stdout().lock();
        let about = std::iter::once(about).chain(std::iter::repeat(""));
        let mut lines = text.as_ref().lines().zip(about);
        unless_closed(lines.try_for_each(|(line, about)| writeln!(out, "{about:>10}  {line}")))
    }

    /// Prints a text for another program unchanged on standard output; nothing if standard output carries JSON.
    ///
    /// # Errors
    /// If standard output cannot be written.
    pub fn document(&self, text: &str) -> Result<()> {
        if self.json {
            return Ok(());
        }
        unless_closed(std::io::stdout().lock().write_all(text.as_bytes()))
    }

    /// Makes a progress bar on a terminal; a hidden one in a pipe.
    pub fn bar(&self, about: &str, length: u64) -> ProgressBar {
        if !self.bars {
            return ProgressBar::hidden();
        }
        let bar = ProgressBar::new(length);
        if let Ok(style) =
            ProgressStyle::with_template("{prefix:>10}  {bar:40} {percent:>3} %  {elapsed} of about {duration}")
        {
            bar.set_style(style);
        }
        bar.set_prefix(about.to_owned());
        bar.enable_steady_tick(Duration::from_millis(200));
        bar
    }

    /// Makes a progress report: a bar on a terminal, a line for each quarter in a pipe.
    pub fn progress(&self, about: &str) -> Progress {
        let started = Instant::now();
        Progress { about: about.to_owned(), bar: self.bar(about, 100), started, quarters: AtomicUsize::new(0) }
    }

    /// Prints one of several answers as one line of JSON, if JSON was requested.
    ///
    /// # Errors
    /// If the value cannot be written as JSON or standard output is closed.
    pub fn answer_line(&self, value: &impl Serialize) -> Result<()> {
        if self.json {
            let mut out = std::io::stdout().lock();
            serde_json::to_writer(&mut out, value)?;
            writeln!(out)?;
        }
        Ok(())
    }

    /// Prints the answer as JSON, if JSON was requested.
    ///
    /// # Errors
    /// If the value cannot be written as JSON or standard output is closed.
    pub fn answer(&self, value: &impl Serialize) -> Result<()> {
        if self.json {
            let mut out = std::io::stdout().lock();
            serde_json::to_writer_pretty(&mut out, value)?;
            writeln!(out)?;
        }
        Ok(())
    }
}
