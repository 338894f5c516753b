//! Odds at which an alternative reading of the files leads to refusal.
//!
//! If the files are right, a likelihood ratio exceeds `k` with a probability of at most `1 / k` (Markov's inequality),
//! and one of `n` ratios with at most `n / k` (Bonferroni).

/// Probability that one family of readings refuses a valid trial.
const FALSE_ALARM: f64 = 1e-3;
/// Odds for a note.
pub(super) const NOTED: f64 = 100.0;
/// Displacements that hidden effects cause: of a tool's centre point or a clock (ranges of `path-offset` and
/// `clock-offset` [m, s]), and of a scan (`scan-shift` [m]).
const PATH_OFFSET: f64 = 1e-3;
const CLOCK_OFFSET: f64 = 0.2;
const SCAN_SHIFT: f64 = 0.5e-3;

/// Logarithm of the odds above which one of `readings` alternative readings leads to refusal.
pub(super) fn refusing(readings: usize) -> f64 {
    (readings as f64 / FALSE_ALARM).ln()
}

/// Largest displacement that effects cause at this feed [m/s]; it is not a fault of the files [m].
pub(super) fn displaced_by_effects(feed: f64) -> f64 {
    SCAN_SHIFT + PATH_OFFSET.max(CLOCK_OFFSET * feed)
}
