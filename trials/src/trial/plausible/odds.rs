//! From which odds one reading of the files is refused for another.
//!
//! Where the files are right, a likelihood ratio exceeds `k` with a chance of `1 / k` at most (Markov's inequality), and one
//! of `n` ratios with `n / k` (Bonferroni).

/// Chance that a sound trial is refused by one family of readings.
const FALSE_ALARM: f64 = 1e-3;
/// Odds that are worth a note.
pub(super) const NOTED: f64 = 100.0;
/// Displacements that hidden effects make: of a tool's centre point or a clock (ranges of `path-offset` and `clock-offset`
/// [m, s]), and of a scan (`scan-shift` [m]).
const PATH_OFFSET: f64 = 1e-3;
const CLOCK_OFFSET: f64 = 0.2;
const SCAN_SHIFT: f64 = 0.5e-3;

/// Logarithm of the odds from which one of `readings` is refused.
pub(super) fn refusing(readings: usize) -> f64 {
    (readings as f64 / FALSE_ALARM).ln()
}

/// Greatest displacement that effects make at this feed [m/s], which is no fault of the files [m].
pub(super) fn displaced_by_effects(feed: f64) -> f64 {
    SCAN_SHIFT + PATH_OFFSET.max(CLOCK_OFFSET * feed)
}
