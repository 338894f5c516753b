//! Numbers of the robot's frame and clock.

use super::Criterion;

criteria! {
    OF_FRAME;
    /// Prior standard deviation of the part's place, along x and y, between robot and scanner.
    PART_SHIFT_SIGMA: f64 = 100e-6, "m", "chosen: the frames may differ by about 100 µm (docs/diagnosis.md, Limits)";
    /// Way on a path that logs may be off before they are moved.
    FRAME_REACH: f64 = 200e-6, "m", "derived: two standard deviations of the part's place, which every fit leaves free";
    /// Way on a path from which logs that were moved are moved again.
    FRAME_SETTLED: f64 = 20e-6, "m", "chosen: a fifth of the standard deviation of the part's place";
    /// Standard deviation of a smooth change of the removal beside which the frame offset is sought, as a share of it.
    FRAME_SMOOTH_SHARE: f64 = 0.3, "1", "chosen: of the order of what effects of the library change";
    /// Odds from which frame or clock are off, and from which more of their quantities are.
    FRAME_ODDS: f64 = 19.0, "1", "convention: 95 %";
    /// Standard deviation of a quantity of the frame offset, over the one beforehand, from which the scans do not show it.
    FRAME_SHOWN_SHARE: f64 = 0.9, "1", "chosen: a fifth of what was not known is known";
}
