//! A trial that could be made, and what it costs.

use trials::trial::{Pass, Trial};

use crate::criteria::{TRIAL_DRESSING_MINUTES, TRIAL_SCAN_MINUTES, TRIAL_SETUP_MINUTES};

/// A trial that could be made, on one new workpiece.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Design {
    /// Difference to the trial that was made, in words.
    pub(super) what: String,
    /// The trial; where the tool is dressed in between, the workpiece goes on in the next one.
    pub(super) stages: Vec<Trial>,
    /// Scans of each surface whose mean counts as one.
    pub(super) scans: usize,
}

impl Design {
    /// All passes, in order of time.
    pub(super) fn passes(&self) -> impl Iterator<Item = &Pass> {
        self.stages.iter().flat_map(|stage| &stage.passes)
    }

    /// New workpieces.
    pub(super) fn workpieces(&self) -> usize {
        1
    }

    /// Expected time [min]: to set up the workpiece, for the passes and pauses, for all scans (two before the first pass and
    /// one after each) and for each dressing.
    pub(super) fn minutes(&self) -> f64 {
        let scans = self.scans * (2 + self.passes().count());
        let dressings = self.stages.iter().filter(|stage| stage.fresh).count();
        TRIAL_SETUP_MINUTES * self.workpieces() as f64
            + TRIAL_SCAN_MINUTES * scans as f64
            + TRIAL_DRESSING_MINUTES * dressings as f64
            + self.stages.iter().map(duration).sum::<f64>() / 60.0
    }
}

/// Time of all logs of a trial and of the pauses between them [s]. A clock that starts again says nothing of a pause.
fn duration(trial: &Trial) -> f64 {
    let (mut total, mut end) = (0.0, None);
    for pass in &trial.passes {
        let (Some(first), Some(last)) = (pass.log.rows.first(), pass.log.rows.last()) else { continue };
        total += last.time - first.time + end.map_or(0.0, |end| f64::max(first.time - end, 0.0));
        end = Some(last.time);
    }
    total
}
