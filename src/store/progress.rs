//! How a run of many items goes: counts, times, what is left.

use std::time::Instant;

use serde::Serialize;

use super::process::Ending;
use super::run::Outcome;

/// Parts in the training data of the first model of this kind; the time they would take is reported after a run.
const KNOWN_SET: f64 = 8918.0;

/// Counts items while they are made.
pub struct Progress {
    started: Instant,
    summary: Summary,
    done: usize,
    cpu_s: Vec<f64>,
}

/// What a run did.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub struct Summary {
    /// Items of the run.
    pub items: usize,
    /// Items that were made.
    pub made: usize,
    /// Items that were there.
    pub there: usize,
    /// Items that failed.
    pub failed: usize,
    /// Median of the processor time of an item that was made [s].
    pub median_cpu_s: Option<f64>,
    /// Largest memory of an item [MB].
    pub peak_mb: Option<f64>,
    /// Time by the clock [s].
    pub seconds: f64,
    /// Items made in an hour by the clock.
    pub items_per_hour: Option<f64>,
}

/// What to say of one item.
pub struct Line {
    /// Word in front.
    pub about: &'static str,
    text: String,
}

impl Line {
    /// The text; where a bar shows how it goes, only failures have one.
    pub fn text(&self, without_bar: bool) -> Option<&str> {
        (without_bar || self.about == "failed").then_some(&self.text)
    }
}

impl Progress {
    /// Nothing is done yet of `items`.
    pub fn new(items: usize, started: Instant) -> Self {
        let summary = Summary { items, ..Default::default() };
        Self { started, summary, done: 0, cpu_s: Vec::new() }
    }

    /// Counts an item and says what became of it.
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

    /// What is left at the pace so far; nothing at the end and before the first item was made.
    fn time_left(&self) -> String {
        let worked = self.summary.made + self.summary.failed;
        let left = self.summary.items - self.done;
        if worked == 0 || left == 0 {
            return String::new();
        }
        let seconds = self.started.elapsed().as_secs_f64() * left as f64 / worked as f64;
        format!("; about {} left", duration(seconds))
    }

    /// What the run did.
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
    /// For people.
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

    /// How long a known set of parts would take at this pace, for people.
    pub fn outlook(&self) -> Option<String> {
        let whole = duration(3600.0 * KNOWN_SET / self.items_per_hour?);
        Some(format!("{KNOWN_SET:.0} parts, one item each, take {whole}"))
    }
}

/// A duration for people.
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
