//! Progress of a run of many items: counts, times, time left.

use std::time::Instant;

use serde::Serialize;

use super::process::Ending;
use super::run::Outcome;

/// Number of parts in the training data of the first model of this kind; a run reports the time they would take.
const KNOWN_SET: f64 = 8918.0;

/// Counts items while they are made.
pub struct Progress {
    started: Instant,
    summary: Summary,
    done: usize,
    cpu_s: Vec<f64>,
}

/// Summary of a run.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub struct Summary {
    /// Number of items in the run.
    pub items: usize,
    /// Number of items made.
    pub made: usize,
    /// Number of items that existed already.
    pub there: usize,
    /// Number of items that failed.
    pub failed: usize,
    /// Median processor time of the items made [s].
    pub median_cpu_s: Option<f64>,
    /// Peak memory of an item [MB].
    pub peak_mb: Option<f64>,
    /// Wall time [s].
    pub seconds: f64,
    /// Items made per hour of wall time.
    pub items_per_hour: Option<f64>,
}

/// Message on one item.
pub struct Line {
    /// Label of the message.
    pub about: &'static str,
    text: String,
}

impl Line {
    /// Returns the text; with a progress bar, only failures have one.
    pub fn text(&self, without_bar: bool) -> Option<&str> {
        (without_bar || self.about == "failed").then_some(&self.text)
    }
}

impl Progress {
    /// Starts the count of `items` items.
    pub fn new(items: usize, started: Instant) -> Self {
        let summary = Summary { items, ..Default::default() };
        Self { started, summary, done: 0, cpu_s: Vec::new() }
    }

    /// Counts an item and returns its message.
    pub fn count(&mut self, outcome: &Outcome) -> Line {
        self.done += 1;
        let usage = outcome.usage;
        let (about, found) = match &outcome.ending {
            Ending::Made => {
                self.summary.made += 1;
                self.cpu_s.push(usage.cpu_s);
                let peak = self.summary.peak_mb.unwrap_or(0.0).max(usage.peak_bytes as f64 * 1e-6);
                self.summary.peak_mb = Some(peak).filter(|&peak| peak > 0.0);
                ("made", format!("{:.2} s of processor, {:.0} MB", usage.cpu_s, usage.peak_bytes as f64 * 1e-6))
            }
            Ending::There | Ending::Busy => {
                self.summary.there += 1;
                ("there", "complete".to_owned())
            }
            Ending::Failed { reason, .. } => {
                self.summary.failed += 1;
                ("failed", reason.clone())
            }
        };
        let name = outcome.source.file_name().unwrap_or_default().to_string_lossy();
        let of = self.summary.items;
        Line { about, text: format!("{}/{of} {} of {name}: {found}{}", self.done, outcome.id, self.time_left()) }
    }

    /// Describes the time left at the current pace; empty at the end and before the first item was made.
    fn time_left(&self) -> String {
        let worked = self.summary.made + self.summary.failed;
        let left = self.summary.items - self.done;
        if worked == 0 || left == 0 {
            return String::new();
        }
        let seconds = self.started.elapsed().as_secs_f64() * left as f64 / worked as f64;
        format!("; about {} left", duration(seconds))
    }

    /// Returns the summary of the run.
    pub fn summary(mut self) -> Summary {
        self.cpu_s.sort_by(f64::total_cmp);
        self.summary.median_cpu_s = self.cpu_s.get(self.cpu_s.len() / 2).copied();
        self.summary.seconds = self.started.elapsed().as_secs_f64();
        self.summary.items_per_hour =
            (self.summary.made > 0).then(|| 3600.0 * self.summary.made as f64 / self.summary.seconds);
        self.summary
    }
}

impl Summary {
    /// Describes the run for people.
    pub fn describe(&self, jobs: usize) -> String {
        let Self { made, there, failed, seconds, .. } = self;
        let mut text = format!("{made} made, {there} there, {failed} failed in {}", duration(*seconds));
        if let (Some(cpu_s), Some(peak_mb)) = (self.median_cpu_s, self.peak_mb) {
            text += &format!("\nan item takes {cpu_s:.2} s of processor in the median, and at most {peak_mb:.0} MB");
        }
        if let Some(pace) = self.items_per_hour {
            text += &format!("\n{pace:.0} items an hour with {jobs} at once");
        }
        text
    }

    /// Describes the time for a known set of parts at this pace.
    pub fn outlook(&self) -> Option<String> {
        let whole = duration(3600.0 * KNOWN_SET / self.items_per_hour?);
        Some(format!("{KNOWN_SET:.0} parts, one item each, take {whole}"))
    }
}

/// Formats a duration for people.
fn duration(seconds: f64) -> String {
    match seconds {
        0.0..90.0 => format!("{seconds:.0} s"),
        90.0..5400.0 => format!("{:.0} min", seconds / 60.0),
        _ => format!("{:.1} h", seconds / 3600.0),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::store::Stage;
    use crate::store::limits::Usage;

    #[test]
    fn a_run_is_counted_and_told() {
        let mut progress = Progress::new(3, Instant::now());
        let outcome = |ending, cpu_s| Outcome {
            id: "0-0000".into(),
            source: "parts/a.obj".into(),
            ending,
            usage: Usage { cpu_s, peak_bytes: 50_000_000 },
            seconds: cpu_s,
        };
        let line = progress.count(&outcome(Ending::Made, 0.5));
        assert!(line.text(true).is_some_and(|text| text.starts_with("1/3 0-0000 of a.obj: 0.50 s")), "{}", line.text);
        assert_eq!(line.text(false), None);
        let stage = Stage::Weld;
        let line = progress.count(&outcome(Ending::Failed { stage, reason: "no place".into() }, 0.1));
        assert!(line.text(false).is_some_and(|text| text.contains("no place; about")), "{}", line.text);
        progress.count(&outcome(Ending::There, 0.0));
        let summary = progress.summary();
        assert_eq!((summary.made, summary.there, summary.failed), (1, 1, 1));
        assert_eq!((summary.median_cpu_s, summary.peak_mb), (Some(0.5), Some(50.0)));
        assert_eq!([30.0, 600.0, 36_000.0].map(duration), ["30 s", "10 min", "10.0 h"]);
    }
}
