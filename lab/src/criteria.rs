//! The numbers that decide: every threshold, level, number of draws and prior of the laboratory, declared once.
//!
//! A number stands here if another value of it could change what is found, named or said. Not here: constants of nature,
//! nominal values that a table leaves open, and dampings and lengths of iterations that end at the same place.
//! The modules use these constants and keep no copies. [`CRITERIA`] lists them; every result holds their values
//! ([`CriterionValues`]), and `docs/diagnosis.md` shows the list.

#[macro_use]
mod table;
mod columns;
mod criterion;
mod experiments;
mod frame;
mod unlisted;

pub use columns::*;
pub use criterion::{Criterion, CriterionValues};
pub use experiments::*;
pub use frame::*;
pub use unlisted::*;

use {columns::OF_COLUMNS, experiments::OF_EXPERIMENTS, frame::OF_FRAME, unlisted::OF_UNLISTED_EFFECTS};

/// All criteria.
pub const CRITERIA: &[Criterion] = &table::joined::<{ FIRST.len() + LAST.len() }>(FIRST, LAST);
const FIRST: &[Criterion] = &table::joined::<{ OF_METHOD.len() + MORE.len() }>(OF_METHOD, MORE);
const MORE: &[Criterion] = &table::joined::<{ OF_COLUMNS.len() + OF_FRAME.len() }>(OF_COLUMNS, OF_FRAME);
const LAST: &[Criterion] =
    &table::joined::<{ OF_UNLISTED_EFFECTS.len() + OF_EXPERIMENTS.len() }>(OF_UNLISTED_EFFECTS, OF_EXPERIMENTS);

criteria! {
    OF_METHOD;
    // Measurements as data.
    /// Fewest pixels along the side of a tile.
    TILE_LEAST_SIDE: usize = 3, "px", "chosen";
    /// Most tiles of a scan: their covariance is a dense matrix.
    TILES_PER_SCAN: usize = 1000, "1", "chosen";
    /// Share of a tile's pixels that must be known.
    TILE_KNOWN_SHARE: f64 = 0.4, "1", "chosen";
    /// Deviation of a tile's mean, in robust standard deviations, beyond which it counts no more for the noise.
    NOISE_CUT_SIGMAS: f64 = 4.0, "σ", "derived: one in 16,000 of normal means is cut";
    /// Share of the known tiles that blocks without holes must cover for their noise to be fitted.
    NOISE_BLOCK_SHARE: f64 = 0.5, "1", "chosen: the most likely noise of half of the surface";
    /// Tiles along and across that share a block when residuals are drawn again.
    TILE_BLOCK_SIDE: usize = 4, "1", "chosen";
    /// Steps beyond which a simulation is abandoned, over those of the base model's longest pass.
    SIMULATION_STEP_RATIO: usize = 3, "1", "chosen";
    /// Fewest steps that the base model's longest pass counts as, for the limit of a simulation.
    SIMULATION_LEAST_STEPS: usize = 1000, "1", "chosen";
    /// Largest voxel of the simulation when sanding.
    SANDING_VOXEL_PIXELS: f64 = 4.0, "px",
        "chosen; measured: borders move by about a tenth of a pixel (docs/diagnosis.md, Limits)";
    /// Voxels across half the tool that a simulation of sanding aims at.
    SANDING_VOXELS_ACROSS: f64 = 16.0, "1", "chosen";
    /// Prior standard deviation of a scan's height.
    POSE_HEIGHT_SIGMA: f64 = 50e-6, "m", "chosen";
    /// Prior standard deviation of a scan's tilt, as the height that it gives at the map's half diagonal.
    POSE_TILT_SIGMA: f64 = 50e-6, "m", "chosen";
    /// Prior standard deviation of a scan's lateral shift.
    POSE_SHIFT_SIGMA: f64 = 100e-6, "m", "chosen";
    /// Prior standard deviation of when a controller took over, before the first row in contact, in rows of the log.
    PASS_BEGIN_SIGMA: f64 = 0.577, "1", "derived: root mean square of a uniform law over the row before";
    /// Prior standard deviation of when a tool was lifted off, in rows of the log.
    PASS_END_SIGMA: f64 = 0.289, "1", "derived: uniform law over a row";
    /// Error of a tile's mean by what its lattice does not tell, over the noise, above which it is a rim.
    RIM_NOISE_SHARE: f64 = 0.25, "σ", "chosen: of the variance of the other tiles at most a sixteenth is the lattice";
    /// Removed depth at which the noise of the scan before has fallen to 1/e, in tile sigmas, until it is measured.
    SCAN_NOISE_DECAY_SIGMAS: f64 = 3.0, "σ", "chosen: a first guess, replaced by a simulation from the repeated scan";
    /// Change of height from which a pixel counts as changed and the instrument blurs it again.
    CHANGED_HEIGHT: f64 = 2e-6, "m", "chosen";
    /// Widest blur of the instrument that is fitted.
    BLUR_WIDEST: f64 = 2.0, "px", "chosen";
    /// Distance from the exposed border within which a tile shows its distance, over the tool's half width.
    BORDER_REACH: f64 = 0.5, "half widths", "chosen";
    /// Pixels around one whose majority says whether it is exposed.
    BORDER_MAJORITY_RADIUS: i64 = 2, "px", "chosen";
    /// Least scatter of the exposed border as single pixels show it.
    BORDER_SCATTER_LEAST: f64 = 0.3, "px", "chosen: a mask shows no more, and the simulation has a lattice of its own";
    /// Least standard deviation of the border's mean place along one tile.
    BORDER_TILE_ERROR_LEAST: f64 = 0.5, "px",
        "chosen: a mask shows no more, and the simulation has a lattice of its own";
    /// Least noise floor of the border's place.
    BORDER_FLOOR_LEAST: f64 = 0.5, "px",
        "chosen: one pixel shows no more about the place of a border (docs/diagnosis.md, step 3)";
    /// Errors of dose and coating together, over those of the dose alone.
    COATING_ERROR_RATIO: f64 = 2.0, "1",
        "chosen: a coating is no more even than a dose is known (docs/diagnosis.md, step 3)";
    /// Prior standard deviation of the logarithm of a group's gain.
    GROUP_GAIN_SIGMA: f64 = 1.0, "1", "chosen";
    /// Most rows in a block when residuals are drawn again.
    ROW_BLOCK_LENGTH: usize = 5, "1", "chosen";
    /// Fewest blocks into which rows are cut.
    ROW_BLOCKS_LEAST: usize = 10, "1", "derived: their signs have more combinations than are drawn, 2¹⁰ and 400";
    /// Share of the median removal below which the prediction of a row counts as that share.
    PREDICTION_LEAST_SHARE: f64 = 1e-3, "1", "chosen";
    /// Whitened residual from which a row is an outlier.
    OUTLIER_SIGMAS: f64 = 5.0, "σ", "chosen";
    /// Residual of a row, in robust standard deviations of all, beyond which covariates leave it out.
    GROSS_RESIDUAL_SIGMAS: f64 = 5.0, "σ", "chosen";
    /// Logarithm of a ratio of settings below which they are equal.
    SAME_SETTING: f64 = 0.01, "1", "chosen";
    /// Logarithm of a ratio of loads below which they are equal: they may be means and follow the part's shape.
    SAME_LOAD: f64 = 0.05, "1", "chosen";
    /// Pairs of equal rows from which the noise of a row comes from repeats alone.
    REPEATS_LEAST: usize = 20, "1", "chosen";
    /// Least noise of the logarithm of a row's removal.
    ROW_NOISE_LEAST: f64 = 1e-3, "1", "chosen";
    /// Degrees of freedom from which outliers are left out of the noise of rows: a median of fewer is no scale.
    ROW_NOISE_ROBUST_LEAST: usize = 10, "1", "chosen";
    /// Rows for each column of a regression from which squares of the settings are among the columns.
    ROW_SQUARES_LEAST: usize = 3, "1", "chosen";
    /// Levels of a setting from which its square is: on three, a parabola is a gain of each level.
    ROW_SQUARE_LEVELS_LEAST: usize = 5, "1", "chosen: two more than a parabola has parameters";
    /// Deviation beyond which a row counts linearly in the regression behind its noise.
    ROW_REGRESSION_CUT: f64 = 1.345, "σ", "convention: 95 % efficiency where the errors are normal (Huber 1964)";
    /// Change of the logarithm of a prediction below which an effect or parameter changes nothing in a table.
    PREDICTION_CHANGE_LEAST: f64 = 1e-6, "1", "chosen";
    /// Factor from a table's rate constant to its bounds.
    RATE_RANGE_FACTOR: f64 = 1e3, "1", "chosen";
    /// Factor from the greatest use of a tool in a table to the bounds of what effects compare it with.
    SPAN_RANGE_FACTOR: f64 = 30.0, "1", "chosen: use of a thirtieth changes 3 %, use of thirty leaves e⁻³⁰";
    /// Greatest change of the logarithm of the rate over the range of a column.
    COLUMN_CHANGE_MOST: f64 = 4.6, "1", "chosen: a hundredfold";
    /// Such a change that is tried first.
    COLUMN_CHANGE_TYPICAL: f64 = 0.1, "1", "chosen";
    /// Correlation of the changes of two effects in the rows of a table from which they are one and the same.
    SAME_RESPONSE: f64 = 0.999, "1", "chosen";
    // Fits.
    /// Residual beyond which it counts linearly in the sum of squares.
    HUBER_CONSTANT: f64 = 2.5, "σ", "chosen; the loss: Huber 1964";
    /// Δχ², over χ² per datum where that is above one, below which a promised step ends a fit.
    FIT_CONVERGED_DELTA_CHI2: f64 = 0.05, "1", "derived: a fifth of a standard deviation";
    /// Times that the derivatives of a calibration are made.
    FIT_DERIVATIVES: usize = 8, "1", "chosen";
    /// Most steps of a calibration.
    FIT_STEPS: usize = 25, "1", "chosen";
    /// Times that derivatives are made by a fit that only finds the place for the next.
    ROUGH_FIT_DERIVATIVES: usize = 2, "1", "chosen";
    /// Most steps of a fit that only finds the place for the next.
    ROUGH_FIT_STEPS: usize = 8, "1", "chosen";
    /// Times that derivatives are made where a fit goes on after its data were seen better.
    RENEWED_FIT_DERIVATIVES: usize = 2, "1", "chosen: along the principal directions";
    /// Most steps of a fit that goes on after its data were seen better.
    RENEWED_FIT_STEPS: usize = 10, "1", "chosen";
    /// χ² per datum above which a calibration starts again from both sides of its end.
    RESTART_CHI2_PER_DATUM: f64 = 1.3, "1", "chosen: three times the tenth by which noise from one repeat errs";
    /// Most of the fits begun elsewhere that go on after a rough start.
    RESTARTS_FITTED: usize = 2, "1", "chosen";
    /// Factor on a ratio of the base laws from one start of their fit to the next.
    START_RATIO: f64 = 10.0, "1", "chosen: an order of magnitude; the library's ranges have two to five";
    /// Error of the logarithm of the totals at which the rate of a start is found.
    START_RATE_TOLERANCE: f64 = 0.01, "1", "chosen: a step of the fit that follows";
    /// Way from the end of a calibration to where it starts again along the softest direction.
    RESTART_DISTANCE: f64 = 0.4, "coordinates", "chosen";
    /// Change of all whitened data together that a finite difference aims at.
    DERIVATIVE_CHANGE_AIM: f64 = 12.0, "σ", "chosen: above the simulation's own unevenness (docs/diagnosis.md, step 4)";
    /// Change below which the difference is made again over a longer step.
    DERIVATIVE_CHANGE_LEAST: f64 = 8.0, "σ",
        "measured: simulations that differ by nothing of weight differ by 2 (docs/diagnosis.md, step 4)";
    /// Change above which the difference is made again over a shorter step.
    DERIVATIVE_CHANGE_MOST: f64 = 60.0, "σ", "chosen";
    /// Share of the whole misfit that a difference may change where that is more.
    DERIVATIVE_CHANGE_SHARE: f64 = 0.3, "1", "chosen";
    /// Longest step of a finite difference.
    DERIVATIVE_LONGEST_STEP: f64 = 0.5, "coordinates", "chosen";
    /// Times as far from its null, or factor on both ends on a scale of ratios, that an effect's parameter may go beyond its range.
    RANGE_EXTENSION: f64 = 3.0, "1", "chosen: the library's ranges are what was seen elsewhere";
    /// The same for a parameter of a base law, which every campaign has.
    LAW_RANGE_EXTENSION: f64 = 27.0, "1", "chosen: three times threefold";
    /// Way from a bound, over the width of the range, up to which a value lies on it.
    BOUND_SHARE: f64 = 1e-3, "1", "chosen";
    /// Error of the logarithm of the totals at which the staged order has found the rate.
    STAGED_RATE_TOLERANCE: f64 = 1e-4, "1", "chosen";
    /// Half width of a 95 % interval.
    INTERVAL_SIGMAS: f64 = 1.96, "σ", "convention: normal law";
    /// Half width of an interval, over its range, beyond which a parameter is not identifiable.
    NOT_IDENTIFIABLE_SHARE: f64 = 0.5, "1", "chosen: the interval is as wide as the range (docs/calibration.md)";
    /// Correlation of two parameters from which it is put into words.
    STRONG_CORRELATION: f64 = 0.95, "1", "chosen";
    /// Residual, in robust standard deviations, beyond which it counts no more for the spread of all.
    SPREAD_CUT_SIGMAS: f64 = 3.0, "σ", "chosen";
    // First look at effects.
    /// Ratio of greatest to least value from which a parameter's range is wide.
    PROBE_WIDE_RATIO: f64 = 100.0, "1", "chosen";
    /// Place of the lower value tried in a range that is not wide, as a share of its logarithm.
    PROBE_NARROW_LOW: f64 = 0.35, "1", "chosen";
    /// Place of the upper value tried in a range that is not wide, as a share of its logarithm.
    PROBE_NARROW_HIGH: f64 = 0.65, "1", "chosen";
    /// Place of the lowest value tried in a wide range, as a share of its logarithm.
    PROBE_WIDE_LOW: f64 = 0.25, "1", "chosen";
    /// Place of the middle value tried in a wide range, as a share of its logarithm.
    PROBE_WIDE_MIDDLE: f64 = 0.5, "1", "chosen";
    /// Place of the highest value tried in a wide range, as a share of its logarithm.
    PROBE_WIDE_HIGH: f64 = 0.75, "1", "chosen";
    /// Place in its range of the lower value tried of a parameter of shape.
    PROBE_SHAPE_LOW: f64 = 0.25, "1", "chosen";
    /// Place in its range of the upper value tried of a parameter of shape.
    PROBE_SHAPE_HIGH: f64 = 0.6, "1", "chosen";
    /// Share of a range that stands for a typical value where the library gives the null.
    PROBE_TYPICAL_SHARE: f64 = 0.1, "1", "chosen";
    /// Change of all whitened data together, beside the base parameters, that a simulated size should make.
    PROBE_CHANGE_SIGMAS: f64 = 12.0, "σ",
        "chosen: a far larger change bends away from small effects, a smaller one from large";
    /// Change that a simulated size should make where that is more, over the base fit's residuals.
    PROBE_CHANGE_SHARE: f64 = 0.5, "1", "chosen";
    /// Ratio by which a simulated size may miss that change before another one is simulated.
    PROBE_MISS_RATIO: f64 = 3.0, "1", "chosen";
    /// Least way between two simulated sizes, over that from the null.
    PROBE_LEAST_DISTANCE: f64 = 0.2, "1", "chosen";
    /// Larger sizes that are simulated where the data ask for them.
    LARGER_PROBES: usize = 3, "1", "chosen";
    /// Largest ratio of such a larger size to the one before.
    LARGER_PROBE_RATIO: f64 = 4.0, "1", "chosen";
    /// Expected Δχ² from which a larger size is simulated.
    LARGER_PROBE_DELTA_CHI2: f64 = 16.0, "1", "chosen";
    /// Ratio to a simulated size up to which its change is extrapolated.
    EXTRAPOLATION_MOST: f64 = 1.5, "1", "chosen";
    /// Share of an effect's change that must be left beside the base parameters: less is rounding.
    DISTINCT_CHANGE_SHARE: f64 = 1e-3, "1", "chosen";
    /// Change of the base parameters' making, when they follow an effect, from which both are simulated together.
    FOLLOWED_SIGMAS: f64 = 12.0, "σ", "chosen";
    /// Times that an effect and the base parameters that follow it are simulated together.
    FOLLOWED_STEPS: usize = 2, "1", "chosen";
    /// Share of the best shape's expected Δχ² from which another shape is fitted too.
    SHAPE_GAIN_SHARE: f64 = 0.3, "1", "chosen";
    // Fits of effects and of pairs.
    /// Expected Δχ² up to which an effect is not fitted.
    FITTED_DELTA_CHI2: f64 = 4.0, "1", "chosen";
    /// Most promising effects that are fitted.
    EFFECTS_FITTED: usize = 9, "1", "chosen";
    /// Best effects that are fitted until they converge.
    EFFECTS_REFINED: usize = 4, "1", "chosen";
    /// Starts of an effect that has a parameter of shape.
    STARTS_PER_EFFECT: usize = 2, "1", "chosen";
    /// Share of the best effect's Δχ² from which another is fitted until it converges.
    REFINED_GAIN_SHARE: f64 = 0.3, "1", "chosen";
    /// Share of the best effect's Δχ² that a fit that did not converge needs to go on.
    LAST_FIT_GAIN_SHARE: f64 = 0.7, "1", "chosen";
    /// Δχ² from which a fit goes on that did not converge, or that is within as much of the best, times what that leaves per datum.
    LAST_FIT_DELTA_CHI2: f64 = 40.0, "1", "chosen";
    /// Times that derivatives are made in the first fit of an effect or a pair.
    QUICK_FIT_DERIVATIVES: usize = 0, "1", "chosen";
    /// Most steps of the first fit of an effect or a pair.
    QUICK_FIT_STEPS: usize = 6, "1", "chosen";
    /// Times that derivatives are made in the fit until convergence.
    REFINED_FIT_DERIVATIVES: usize = 2, "1", "chosen";
    /// Most steps of the fit until convergence.
    REFINED_FIT_STEPS: usize = 12, "1", "chosen";
    /// Times that derivatives are made in the fit that goes on.
    LAST_FIT_DERIVATIVES: usize = 3, "1", "chosen";
    /// Most steps of the fit that goes on.
    LAST_FIT_STEPS: usize = 18, "1", "chosen";
    /// Times that derivatives are made in the fit of an effect beside a certain one.
    PARTNER_FIT_DERIVATIVES: usize = 1, "1", "chosen";
    /// Most steps of the fit of an effect beside a certain one.
    PARTNER_FIT_STEPS: usize = 8, "1", "chosen";
    /// Most promising pairs of effects that are fitted.
    PAIRS_FITTED: usize = 9, "1", "chosen";
    /// Best pairs that are fitted until they converge.
    PAIRS_REFINED: usize = 2, "1", "chosen";
    /// Most pairs that are fitted with the same stronger half.
    PAIRS_PER_LEAD: usize = 3, "1", "chosen";
    /// Share of χ² below which a certain effect must bring it for others to be fitted beside it.
    LEAD_CHI2_SHARE: f64 = 0.5, "1", "chosen";
    /// Best effects beside a certain one that are fitted until they converge.
    PARTNERS_REFINED: usize = 4, "1", "chosen";
    /// Squared sine of the angle between two changes up to which they are the same.
    PAIR_SINE_SQUARED: f64 = 1e-3, "1", "chosen";
    // p-values and probabilities.
    /// Probability of a false alarm of a search, of all residual tests together, or of all covariates together.
    SIGNIFICANCE_LEVEL: f64 = 0.05, "1", "convention; corrections: Holm 1979, Westfall and Young 1993";
    /// Draws of residuals with flipped signs behind the p-value of an effect.
    SIGN_FLIP_DRAWS: u64 = 400, "1", "chosen; the method: Wu 1986";
    /// Share of the largest singular value up to which changes of an effect's amplitudes depend on each other.
    DEPENDENT_SHARE: f64 = 1e-3, "1", "chosen";
    /// Fewest folds into which calibration scans are cut: stretches of their passes.
    FOLDS_LEAST: usize = 16, "1", "chosen: tens of folds, as of data that are left out in the literature";
    /// Draws of the folds' weights behind the probabilities of models.
    FOLD_WEIGHT_DRAWS: usize = 1000, "1", "convention: a thousand; the method: Yao and others 2018";
    /// Hats of the closure along the part.
    CLOSURE_PART_ALONG: usize = 13, "1", "chosen: their width is a sixth of the way";
    /// Hats of the closure across the part.
    CLOSURE_PART_ACROSS: usize = 4, "1", "chosen: their width is two thirds of what was touched";
    /// Hats of the closure along each pass.
    CLOSURE_PASS_ALONG: usize = 6, "1", "chosen: their width is two fifths of the way";
    /// Hats of the closure across each pass.
    CLOSURE_PASS_ACROSS: usize = 3, "1", "chosen: their width is what was touched";
    /// Least strength of the closure that is tried, as a share of the removal.
    CLOSURE_STRENGTH_LEAST: f64 = 0.001, "1", "chosen: below what noise lets any scan show";
    /// Ratio of a strength of the closure to the one before.
    CLOSURE_STRENGTH_RATIO: f64 = 2.0, "1", "chosen";
    /// Strengths of the closure that are tried.
    CLOSURE_STRENGTHS: i32 = 10, "1", "chosen: up to half of the removal";
    /// Probability that none of the effects is the cause from which none is named.
    NONE_MOST: f64 = 0.5, "1", "derived: even odds";
    /// Probability from which an effect is named alone.
    NAMED_PROBABILITY: f64 = 0.9, "1", "chosen: nine to one";
    /// Most probability of an effect that cannot be named alone, whatever it fits.
    RESERVED_PROBABILITY: f64 = 0.5, "1", "chosen: even odds, for nothing tests it";
    /// Share of what a model leaves beyond noise from which the effect that explains it is reported as the nearest.
    NEAREST_SHARE: f64 = 0.1, "1", "chosen";
    /// Odds that the value of an effect's parameter lies within what the library lists, and is the same in all passes.
    LISTED_ODDS: f64 = 19.0, "1", "chosen: the library's ranges hold 95 % of what is met";
    /// Effects that may be found one after the other.
    MOST_EFFECTS: usize = 3, "1", "chosen";
    /// Relative distance up to which an amplitude on a scale of ratios is at its null.
    NULL_RATIO: f64 = 0.01, "1", "chosen";
    /// Distance from the null, over the width of the range, below which an amplitude on a linear scale is there.
    NULL_SHARE: f64 = 1e-6, "1", "chosen";
    /// Relative distance from the end of its range up to which an amplitude hits its upper bound.
    FAR_END_RATIO: f64 = 1e-3, "1", "chosen";
    // Sizes and verdicts.
    /// Smooth error of a simulated scan, over the mean removal.
    SMOOTH_ERROR_REMOVAL: f64 = 0.001, "1",
        "measured: another laboratory's scans show it of the law that made them (docs/diagnosis.md, Limits)";
    /// Smooth error of a simulated border of what is exposed, over the way on which dose and coating may err.
    SMOOTH_ERROR_EXPOSURE: f64 = 0.0025, "1",
        "measured: another laboratory's masks show it of the law that made them (docs/diagnosis.md, Limits)";
    /// Error of a simulated pass as a whole, over its smooth error.
    SMOOTH_ERROR_PASS: f64 = 1.5, "1",
        "chosen: another laboratory's removed volumes scatter by 0.14 and 0.21 % about the law that made them, 0.1 % of it noise";
    /// Least size of an effect that is named, over the smooth error.
    EFFECT_SIZE_SMOOTH: f64 = 2.0, "1", "chosen: an effect is no smaller than what the simulation itself may err by";
    /// Least size of an effect that is named, over the noise floor.
    EFFECT_SIZE_FLOOR: f64 = 0.1, "1", "derived: less changes the error by under half a percent";
    /// Change of all whitened data together that is detected in four cases of five.
    DETECTABLE_SIGMAS: f64 = 3.8, "σ",
        "derived: one-sided level of 5 % over thirty effects, 2.94 σ, and a power of 80 %, 0.84 σ";
    /// Share of the effects that must be detectable for a verdict that nothing is missing.
    TESTABLE_SHARE: f64 = 0.5, "1", "chosen";
    /// Unexplained residual, over the mean removal, beyond which something is missing.
    UNEXPLAINED_REMOVAL: f64 = 0.01, "1", "chosen";
    /// Unexplained residual, over the noise, beyond which something is missing.
    UNEXPLAINED_NOISE: f64 = 0.6, "1", "chosen";
    /// Unexplained residual of held-out data, over the mean removal, beyond which a model misses them.
    HELD_OUT_REMOVAL: f64 = 0.02, "1", "chosen: errors of the parameters come on top of those of the simulation";
    /// Unexplained residual of held-out data, over the noise, beyond which a model misses them.
    HELD_OUT_NOISE: f64 = 1.5, "1", "chosen: errors of the parameters come on top of those of the simulation";
    /// Rise of the unexplained residual of held-out data, over the mean removal, that an admissible effect may bring.
    HELD_OUT_RISE_REMOVAL: f64 = 0.005, "1",
        "measured: another laboratory's simulation differs by about 0.5 % of the depth (docs/diagnosis.md, Limits)";
    /// Rise of the unexplained residual of held-out data, over the noise, that an admissible effect may bring.
    HELD_OUT_RISE_NOISE: f64 = 0.6, "1", "chosen";
    /// Share of the unexplained mean square of calibration data that an adequate fit may leave.
    LEFT_CALIBRATION_SHARE: f64 = 0.25, "1", "chosen";
    /// Share of the unexplained mean square of held-out data that an adequate fit may leave.
    LEFT_HELD_OUT_SHARE: f64 = 0.5, "1", "chosen";
    /// Unexplained residual, over the mean removal, beyond which no fit is adequate.
    ADEQUATE_REMOVAL: f64 = 0.03, "1", "chosen";
    /// Unexplained residual, over the noise, beyond which no fit is adequate.
    ADEQUATE_NOISE: f64 = 3.0, "1", "chosen";
    /// Error over its noise floor up to which it is near the noise, and a study ends.
    NEAR_FLOOR_RATIO: f64 = 1.1, "1", "chosen";
    // Comparison.
    /// Draws of noise behind the p-value of a residual test.
    RESIDUAL_TEST_DRAWS: usize = 999, "1", "convention: a thousand with the data";
    /// Fewest tiles of a line whose runs of one sign are counted.
    RUN_LINE_LEAST: usize = 5, "1", "chosen";
    /// Fewest tiles that successive scans must share for a test of what passes leave alike.
    SHARED_TILES_LEAST: usize = 20, "1", "chosen";
    /// Share of the noise of the scan before from which a tile is left out of the test of what passes leave alike.
    SHARED_NOISE_MOST: f64 = 0.1, "1", "chosen: successive scans have that noise in common";
    /// Draws of shifted maps behind the p-value of a covariate.
    COVARIATE_DRAWS: usize = 499, "1", "convention: five hundred with the data";
    /// Draws of blocks behind the bands of a binned mean.
    COVARIATE_BAND_DRAWS: usize = 400, "1", "chosen";
    /// Lower quantile of such a band.
    COVARIATE_BAND_LOW: f64 = 0.025, "1", "convention: 95 % band";
    /// Upper quantile of such a band.
    COVARIATE_BAND_HIGH: f64 = 0.975, "1", "convention: 95 % band";
    /// Most bins of a covariate.
    COVARIATE_BINS: usize = 10, "1", "chosen";
    /// Fewest data of a bin.
    COVARIATE_BIN_LEAST: usize = 8, "1", "chosen";
    /// Fewest data from which covariates are studied.
    COVARIATE_DATA_LEAST: usize = 20, "1", "chosen";
    /// Strength of the ridge beside columns of length one.
    COVARIATE_RIDGE: f64 = 1e-3, "1", "chosen";
    /// Mean number of rows of the pieces of a table that change places.
    ROW_PIECE_LENGTH: f64 = 4.0, "1", "chosen";
    /// Removal from which a tile belongs to a pass's track, over the noise of a tile.
    TRACK_REMOVAL_SIGMAS: f64 = 4.0, "σ", "chosen";
    /// Removal from which a tile belongs to a pass's track, over that of the deepest tenth of the tiles.
    TRACK_REMOVAL_SHARE: f64 = 0.15, "1", "chosen";
    /// Removal from which a pixel may be part of a plateau, over the noise floor.
    PLATEAU_REMOVAL_SIGMAS: f64 = 3.0, "σ", "chosen";
    /// Values of each parameter of a law that are tried on tables, over its whole range.
    TREND_VALUES: usize = 7, "1", "chosen";
    /// Factor from a parameter's best value to those that are tried on scans.
    TREND_FACTOR: f64 = 3.0, "1", "chosen";
    /// Share of the largest prediction up to which a row counts as no removal.
    TREND_REMOVAL_SHARE: f64 = 1e-2, "1", "chosen";
    /// Standard deviations outside the reach of a law beyond which it cannot follow equal passes.
    TREND_SIGMAS: f64 = 3.0, "σ", "convention: three sigmas";
    /// Share of the fall that two effects explain both from which their Shapley values are reported.
    SHAPLEY_OVERLAP: f64 = 0.2, "1", "chosen";
}

#[cfg(test)]
mod tests;
