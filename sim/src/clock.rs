//! Where the time of a simulation goes, for those who measure its speed. Nothing that is simulated depends on it.

use std::sync::atomic::{AtomicU64, Ordering};
use std::time::Instant;

/// A part of the work on a pass.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Phase {
    /// Sheets are read from the field.
    Read,
    /// Squares are measured under the tool, for every try of the balance.
    Squares,
    /// Squares in contact are gathered as lanes, and the model's formulas run over them.
    Model,
    /// Lanes are integrated over the step, and their force is summed.
    Integrate,
    /// A step that is accepted is summed up, applied to the sheet and logged.
    Apply,
    /// What a sheet lost is written into the field.
    Write,
}

impl Phase {
    /// All, in the order of a step.
    pub const ALL: [Self; 6] = [Self::Read, Self::Squares, Self::Model, Self::Integrate, Self::Apply, Self::Write];
}

/// Sums up the time of each [`Phase`].
#[derive(Debug)]
pub struct Clock {
    begun: Instant,
    /// Since `begun` [ns].
    last: AtomicU64,
    /// By [`Phase`] [ns].
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

    /// Lets the time that has gone by count for nothing.
    pub(crate) fn skip(&self) {
        self.last.store(self.begun.elapsed().as_nanos() as u64, Ordering::Relaxed);
    }

    /// Counts the time since the last call for a phase.
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
