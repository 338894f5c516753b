//! Timer of the phases of a simulation, for benchmarks. No result depends on it.

use std::sync::atomic::{AtomicU64, Ordering};
use std::time::Instant;

/// Phase of the work on a pass.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Phase {
    /// Height fields are read from the distance field.
    Read,
    /// Cell depths under the tool are measured, for every trial of the force balance.
    Cells,
    /// Cells in contact are gathered into lanes, and the model's formulas are evaluated on them.
    Model,
    /// Lanes are integrated over the step, and their forces are summed.
    Integrate,
    /// An accepted step is summed, applied to the height field and logged.
    Apply,
    /// The recession of a height field is written into the distance field.
    Write,
}

impl Phase {
    /// All phases, in the order of a step.
    pub const ALL: [Self; 6] = [Self::Read, Self::Cells, Self::Model, Self::Integrate, Self::Apply, Self::Write];
}

/// Sums of the time of each [`Phase`].
#[derive(Debug)]
pub struct Clock {
    begun: Instant,
    /// Time of the last call since `begun` [ns].
    last: AtomicU64,
    /// Time of each [`Phase`] [ns].
    spent: [AtomicU64; Phase::ALL.len()],
}

impl Default for Clock {
    fn default() -> Self {
        Self { begun: Instant::now(), last: AtomicU64::new(0), spent: Default::default() }
    }
}

impl Clock {
    /// Seconds spent on a phase so far.
    pub fn seconds(&self, phase: Phase) -> f64 {
        self.spent[phase as usize].load(Ordering::Relaxed) as f64 * 1e-9
    }

    /// Discards the time since the last call.
    pub(crate) fn skip(&self) {
        self.last.store(self.begun.elapsed().as_nanos() as u64, Ordering::Relaxed);
    }

    /// Adds the time since the last call to a phase.
    pub(crate) fn lap(&self, phase: Phase) {
        let now = self.begun.elapsed().as_nanos() as u64;
        let last = self.last.swap(now, Ordering::Relaxed);
        self.spent[phase as usize].fetch_add(now.saturating_sub(last), Ordering::Relaxed);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn laps_count_for_their_phase_and_what_is_skipped_for_none() {
        let clock = Clock::default();
        let pause = || std::thread::sleep(std::time::Duration::from_millis(20));
        pause();
        clock.skip();
        clock.lap(Phase::Read);
        pause();
        clock.lap(Phase::Write);
        assert!(clock.seconds(Phase::Read) < 0.02 && clock.seconds(Phase::Write) >= 0.02);
        assert_eq!(clock.seconds(Phase::Model), 0.0);
    }
}
