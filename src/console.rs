//! What people and machines see: sentences and bars on standard error, one JSON object on standard output, or one a line.

use std::io::{IsTerminal, Write};
use std::time::Duration;

use anyhow::Result;
use indicatif::{ProgressBar, ProgressStyle};
use serde::Serialize;

/// The program's voice. Only the command line holds one; libraries report by values and callbacks.
pub struct Console {
    json: bool,
    bars: bool,
    steps: bool,
}

impl Console {
    /// `json`: whether the answer is one JSON object on standard output, or one a line.
    pub fn new(json: bool) -> Self {
        Self { json, bars: std::io::stderr().is_terminal(), steps: true }
    }

    /// Says nothing, neither to people nor to machines.
    pub fn silent() -> Self {
        Self { json: false, bars: false, steps: false }
    }

    /// One step of the work, in one line: what it is about, and what came out.
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

    /// A bar on a terminal, nothing in a pipe.
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

    /// One of several answers to the machine, as one line of JSON, if it was asked for.
    ///
    /// # Errors
    /// When the value cannot be written as JSON or standard output is closed.
    pub fn answer_line(&self, value: &impl Serialize) -> Result<()> {
        if self.json {
            let mut out = std::io::stdout().lock();
            serde_json::to_writer(&mut out, value)?;
            writeln!(out)?;
        }
        Ok(())
    }

    /// The machine's answer, if it was asked for.
    ///
    /// # Errors
    /// When the value cannot be written as JSON or standard output is closed.
    pub fn answer(&self, value: &impl Serialize) -> Result<()> {
        if self.json {
            let mut out = std::io::stdout().lock();
            serde_json::to_writer_pretty(&mut out, value)?;
            writeln!(out)?;
        }
        Ok(())
    }
}
