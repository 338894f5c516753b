//! Numbers of the robot's frame and clock.

use super::Criterion;

criteria! {
    OF_FRAME;
    /// Prior standard deviation of the part's position along x and y between robot and scanner.
    PART_SHIFT_SIGMA: f64 = 100e-6, "m", "chosen: the frames may differ by about 100 µm (docs/diagnosis.md, Limits)";
    /// Displacement of the path above which logs are moved.
    FRAME_REACH: f64 = 200e-6, "m",
        "derived: two standard deviations of the part's position, a nuisance parameter of every fit";
    /// Further displacement of the path above which moved logs are moved again.
    FRAME_SETTLED: f64 = 20e-6, "m", "chosen: a fifth of the standard deviation of the part's position";
    /// Prior standard deviation of a smooth relative change of the removal, fitted together with the frame offset.
    FRAME_SMOOTH_SHARE: f64 = 0.3, "1", "chosen: the order of magnitude of changes by effects of the library";
    /// Odds above which a frame or clock error is accepted, also against causes with fewer free quantities.
    FRAME_ODDS: f64 = 19.0, "1", "convention: 95 %";
    /// Ratio of a frame quantity's posterior to prior standard deviation from which it is not identifiable.
    FRAME_SHOWN_SHARE: f64 = 0.9, "1", "chosen: a fifth of the prior variance is removed";
}
