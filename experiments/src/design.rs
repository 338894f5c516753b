//! A candidate trial and its cost.

use trials::trial::{Pass, Trial};

use lab::Worth;
use lab::criteria::{TRIAL_DRESSING_MINUTES, TRIAL_SCAN_MINUTES, TRIAL_SETUP_MINUTES};

/// A candidate trial on one new workpiece.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Design {
    /// Difference from the trial that was made, in words.
    pub(super) what: String,
    /// The trial; if the tool is dressed in between, the workpiece continues in the next one.
    pub(super) stages: Vec<Trial>,
    /// Number of scans of each surface that are averaged.
    pub(super) scans: usize,
}

impl Design {
    /// All passes, in order of time.
    pub(super) fn passes(&self) -> impl Iterator<Item = &Pass> {
        self.stages.iter().flat_map(|stage| &stage.passes)
    }

    /// Number of new workpieces.
    pub(super) fn workpieces(&self) -> usize {
        1
    }

    /// Expected time [min]: setup of the workpiece, passes and pauses, scans (two before the first pass and one after
    /// each) and dressings.
    pub(super) fn minutes(&self) -> f64 {
        let scans = self.scans * (2 + self.passes().count());
        let dressings = self.stages.iter().filter(|stage| stage.fresh).count();
        TRIAL_SETUP_MINUTES * self.workpieces() as f64
            + TRIAL_SCAN_MINUTES * scans as f64
            + TRIAL_DRESSING_MINUTES * dressings as f64
            + self.stages.iter().map(duration).sum::<f64>() / 60.0
    }

    /// Cost, and information per minute.
    ///
    /// - `information`: lower bound of the expected information [nat]
    pub(super) fn worth(&self, information: f64) -> Worth {
        let minutes = self.minutes();
        Worth {
            minutes,
            workpieces: self.workpieces(),
            expected_information_nats: information,
            nats_per_minute: information / minutes,
        }
    }
}

/// Duration of all logs of a trial and of the pauses between them [s]. A clock that is reset gives no pause.
fn duration(trial: &Trial) -> f64 {
    let (mut total, mut end) = (0.0, None);
    for pass in &trial.passes {
        let (Some(first), Some(last)) = (pass.log.rows.first(), pass.log.rows.last()) else { continue };
        total += last.time - first.time + end.map_or(0.0, |end| f64::max(first.time - end, 0.0));
        end = Some(last.time);
    }
    total
}
