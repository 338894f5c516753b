//! The numbers that decide: every threshold, level, number of draws and prior of the laboratory, declared once.
//!
//! A number stands here if another value of it could change what is found, named or said. Not here: constants of
//! nature, nominal values that a table leaves open, and dampings and lengths of iterations that end at the same place.
//! The laboratory uses these constants and keeps no copies. [`CRITERIA`] lists them; every result holds their values
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
    /// Minimum side length of a tile.
    TILE_LEAST_SIDE: usize = 3, "px", "chosen";
    /// Maximum number of tiles per scan; their covariance is a dense matrix.
    TILES_PER_SCAN: usize = 1000, "1", "chosen";
    /// Minimum share of a tile's pixels that must be known.
    TILE_KNOWN_SHARE: f64 = 0.4, "1", "chosen";
    /// Deviation of a tile's mean, in standard deviations, at which it is clipped for the noise estimate.
    NOISE_CUT_SIGMAS: f64 = 4.0, "σ", "derived: one in 16,000 normally distributed means is clipped";
    /// Minimum share of the known tiles that blocks without holes cover, for a fit of the noise model.
    NOISE_BLOCK_SHARE: f64 = 0.5, "1", "chosen: the maximum-likelihood noise of half of the surface";
    /// Side of a block of tiles whose residuals may be correlated and are resampled together, in tiles.
    TILE_BLOCK_SIDE: usize = 4, "1", "chosen";
    /// Number of steps above which a simulated pass is abandoned, relative to the base model's longest pass.
    SIMULATION_STEP_RATIO: usize = 3, "1", "chosen";
    /// Minimum step count assumed for the base model's longest pass in the step limit of a simulated pass.
    SIMULATION_LEAST_STEPS: usize = 1000, "1", "chosen";
    /// Maximum voxel size of a sanding simulation.
    SANDING_VOXEL_PIXELS: f64 = 4.0, "px",
        "chosen; measured: borders move by about a tenth of a pixel (docs/diagnosis.md, Limits)";
    /// Target number of voxels across half the tool in a sanding simulation.
    SANDING_VOXELS_ACROSS: f64 = 16.0, "1", "chosen";
    /// Prior standard deviation of a scan's height.
    POSE_HEIGHT_SIGMA: f64 = 50e-6, "m", "chosen";
    /// Prior standard deviation of a scan's tilt, as the height change over half the map's diagonal.
    POSE_TILT_SIGMA: f64 = 50e-6, "m", "chosen";
    /// Prior standard deviation of a scan's lateral shift, and of the way that its turn moves the map's corners.
    POSE_SHIFT_SIGMA: f64 = 100e-6, "m", "chosen";
    /// Prior standard deviation of the controller's start before the first row in contact, in rows of the log.
    PASS_BEGIN_SIGMA: f64 = 0.577, "1", "derived: root mean square of a uniform distribution over the previous row";
    /// Prior standard deviation of the time at which the tool was lifted off, in rows of the log.
    PASS_END_SIGMA: f64 = 0.289, "1", "derived: uniform distribution over a row";
    /// Ratio of the lattice error of a tile's mean to the noise, above which the tile is a rim.
    RIM_NOISE_SHARE: f64 = 0.25, "σ", "chosen: at most a sixteenth of the other tiles' variance is lattice error";
    /// Initial guess of the removed depth at which the first scan's noise falls to 1/e, relative to the tile noise.
    SCAN_NOISE_DECAY_SIGMAS: f64 = 3.0, "σ", "chosen: a first guess, replaced by a simulation from the repeated scan";
    /// Height change above which a pixel counts as changed and the instrument's blur is applied to it.
    CHANGED_HEIGHT: f64 = 2e-6, "m", "chosen";
    /// Maximum standard deviation of the instrument's fitted blur.
    BLUR_WIDEST: f64 = 2.0, "px", "chosen";
    /// Maximum distance from the exposed border that a tile measures, relative to the tool's half width.
    BORDER_REACH: f64 = 0.5, "half widths", "chosen";
    /// Half side of the square of pixels whose majority decides if its central pixel is exposed.
    BORDER_MAJORITY_RADIUS: usize = 2, "px", "chosen";
    /// Minimum scatter of the exposed border, estimated from single pixels.
    BORDER_SCATTER_LEAST: f64 = 0.3, "px", "chosen: resolution of a mask, and the simulation has its own lattice";
    /// Minimum noise floor of the border's position.
    BORDER_FLOOR_LEAST: f64 = 0.5, "px",
        "chosen: one pixel does not determine a border's position better (docs/diagnosis.md, step 3)";
    /// Ratio of the combined error of dose and coating to the error of the dose alone.
    COATING_ERROR_RATIO: f64 = 2.0, "1",
        "chosen: a coating is no more uniform than the dose is accurate (docs/diagnosis.md, step 3)";
    /// Prior standard deviation of the logarithm of a group's gain.
    GROUP_GAIN_SIGMA: f64 = 1.0, "1", "chosen";
    /// Maximum number of rows in a block whose residuals may be correlated and are resampled together.
    ROW_BLOCK_LENGTH: usize = 5, "1", "chosen";
    /// Minimum number of blocks into which rows are divided.
    ROW_BLOCKS_LEAST: usize = 10, "1", "derived: their signs have 2¹⁰ combinations, more than the 400 that are drawn";
    /// Lower limit of a row's predicted removal, relative to the median removal.
    PREDICTION_LEAST_SHARE: f64 = 1e-3, "1", "chosen";
    /// Absolute whitened residual above which a row is an outlier.
    OUTLIER_SIGMAS: f64 = 5.0, "σ", "chosen";
    /// Deviation from the median residual, in robust standard deviations, above which covariates exclude a row.
    GROSS_RESIDUAL_SIGMAS: f64 = 5.0, "σ", "chosen";
    /// Absolute logarithm of the ratio of two settings below which they count as equal.
    SAME_SETTING: f64 = 0.01, "1", "chosen";
    /// Absolute log ratio of two loads below which they count as equal: they may be means that follow the part's shape.
    SAME_LOAD: f64 = 0.05, "1", "chosen";
    /// Minimum number of pairs of rows for an estimate of the row noise from their differences.
    REPEATS_LEAST: usize = 20, "1", "chosen";
    /// Minimum noise of the logarithm of a row's removal.
    ROW_NOISE_LEAST: f64 = 1e-3, "1", "chosen";
    /// Minimum degrees of freedom for excluding outliers from the row noise: a median of fewer is not a reliable scale.
    ROW_NOISE_ROBUST_LEAST: usize = 10, "1", "chosen";
    /// Minimum number of rows per column for a regression that includes squares of the settings.
    ROW_SQUARES_LEAST: usize = 3, "1", "chosen";
    /// Minimum number of levels of a setting for its square: on three levels, a parabola fits any values.
    ROW_SQUARE_LEVELS_LEAST: usize = 5, "1", "chosen: two more than the parameters of a parabola";
    /// Residual above which Huber's loss is linear in the regression that estimates the row noise.
    ROW_REGRESSION_CUT: f64 = 1.345, "σ", "convention: 95 % efficiency for normal errors (Huber 1964)";
    /// Change of the logarithm of predictions below which an effect or parameter has no influence on a table.
    PREDICTION_CHANGE_LEAST: f64 = 1e-6, "1", "chosen";
    /// Factor between a table's initial rate constant and each of its bounds.
    RATE_RANGE_FACTOR: f64 = 1e3, "1", "chosen";
    /// Factor between a tool's greatest use in a table and the bounds of parameters that are compared with it.
    SPAN_RANGE_FACTOR: f64 = 30.0, "1", "chosen: a ratio of use to parameter of 1/30 changes 3 %, of 30 leaves e⁻³⁰";
    /// Maximum change of the logarithm of the rate over the range of a column.
    COLUMN_CHANGE_MOST: f64 = 4.6, "1", "chosen: a factor of 100";
    /// Change of the logarithm of the rate over the range of a column that is used as the first probe.
    COLUMN_CHANGE_TYPICAL: f64 = 0.1, "1", "chosen";
    /// Absolute correlation of two effects' changes of the rows of a table above which they are the same effect.
    SAME_RESPONSE: f64 = 0.999, "1", "chosen";
    // Fits.
    /// Absolute residual above which the robust loss is linear instead of quadratic.
    HUBER_CONSTANT: f64 = 2.5, "σ", "chosen; loss: Huber 1964";
    /// Convergence tolerance of a fit: predicted Δχ² of a step, relative to χ² per datum where that exceeds one.
    FIT_CONVERGED_DELTA_CHI2: f64 = 0.05, "1", "derived: a fifth of a standard deviation";
    /// Maximum number of derivative computations in a calibration.
    FIT_DERIVATIVES: usize = 8, "1", "chosen";
    /// Maximum number of steps in a calibration.
    FIT_STEPS: usize = 25, "1", "chosen";
    /// Maximum number of derivative computations in a rough fit.
    ROUGH_FIT_DERIVATIVES: usize = 2, "1", "chosen";
    /// Maximum number of steps in a rough fit.
    ROUGH_FIT_STEPS: usize = 8, "1", "chosen";
    /// Maximum number of derivative computations in a fit that continues after its data were refined.
    RENEWED_FIT_DERIVATIVES: usize = 2, "1", "chosen: along the principal directions";
    /// Maximum number of steps in a fit that continues after its data were refined.
    RENEWED_FIT_STEPS: usize = 10, "1", "chosen";
    /// χ² per datum above which a fit is restarted from other values.
    RESTART_CHI2_PER_DATUM: f64 = 1.3, "1", "chosen: one plus three times the error of noise from one repeat, 0.1";
    /// Maximum number of rough restarts of a calibration that are completed.
    RESTARTS_FITTED: usize = 2, "1", "chosen";
    /// Factor by which a log-scale law parameter other than the rate is multiplied or divided for other starts.
    START_RATIO: f64 = 10.0, "1", "chosen: an order of magnitude; the library's ranges span two to five";
    /// Tolerance of the mean log ratio of measured to predicted totals for the rate of a start.
    START_RATE_TOLERANCE: f64 = 0.01, "1", "chosen: a step of the fit that follows";
    /// Largest coordinate change from a fit's result to its restarts along the least determined direction.
    RESTART_DISTANCE: f64 = 0.4, "coordinates", "chosen";
    /// Least change of a coordinate from one minimum of a poor fit to another beside which effects are looked at, too.
    MINIMUM_APART: f64 = 0.4, "coordinates", "chosen: the way of a restart";
    /// Norm of the difference of the whitened data between simulations without a significant difference.
    NUMERICAL_NOISE: f64 = 2.0, "σ", "measured: docs/diagnosis.md, step 4";
    /// Target norm of the change of the whitened data over a finite-difference step.
    DERIVATIVE_CHANGE_AIM: f64 = 12.0, "σ", "chosen: above the numerical noise (docs/diagnosis.md, step 4)";
    /// Norm of the data's change below which a finite difference is repeated with a longer step.
    DERIVATIVE_CHANGE_LEAST: f64 = 8.0, "σ",
        "measured: simulations without a significant difference differ by 2 (docs/diagnosis.md, step 4)";
    /// Norm of the data's change above which a finite difference is repeated with a shorter step.
    DERIVATIVE_CHANGE_MOST: f64 = 60.0, "σ", "chosen";
    /// Ratio of the change's norm to √χ² up to which a finite difference is kept, where that limit is larger.
    DERIVATIVE_CHANGE_SHARE: f64 = 0.3, "1", "chosen";
    /// Maximum finite-difference step.
    DERIVATIVE_LONGEST_STEP: f64 = 0.5, "coordinates", "chosen";
    /// Factor by which a fit may exceed an effect's range: of the distance from the null, or of both log-scale ends.
    RANGE_EXTENSION: f64 = 3.0, "1", "chosen: the library's ranges are values observed elsewhere";
    /// Factor by which a fit may exceed the range of a parameter of a base law, which every campaign has.
    LAW_RANGE_EXTENSION: f64 = 27.0, "1", "chosen: a factor of three, three times";
    /// Distance from a bound, relative to the width of the range, up to which a value lies on the bound.
    BOUND_SHARE: f64 = 1e-3, "1", "chosen";
    /// Tolerance of the mean log ratio of measured to predicted totals for the rate in the staged order.
    STAGED_RATE_TOLERANCE: f64 = 1e-4, "1", "chosen";
    /// Half width of a 95 % interval.
    INTERVAL_SIGMAS: f64 = 1.96, "σ", "convention: normal distribution";
    /// Ratio of an interval's half width to the parameter's range above which the parameter is not identifiable.
    NOT_IDENTIFIABLE_SHARE: f64 = 0.5, "1", "chosen: the interval is as wide as the range (docs/calibration.md)";
    /// Minimum absolute correlation of two parameters that is reported in a sentence.
    STRONG_CORRELATION: f64 = 0.95, "1", "chosen";
    /// Absolute residual, in robust standard deviations, at which residuals are clipped for their spread.
    SPREAD_CUT_SIGMAS: f64 = 3.0, "σ", "chosen";
    // First look at effects.
    /// Ratio of a log-scale range's upper end to its lower end above which the range is wide.
    PROBE_WIDE_RATIO: f64 = 100.0, "1", "chosen";
    /// Lower probe in a range that is not wide, as a fraction of the logarithmic range.
    PROBE_NARROW_LOW: f64 = 0.35, "1", "chosen";
    /// Upper probe in a range that is not wide, as a fraction of the logarithmic range.
    PROBE_NARROW_HIGH: f64 = 0.65, "1", "chosen";
    /// Lowest probe in a wide range, as a fraction of the logarithmic range.
    PROBE_WIDE_LOW: f64 = 0.25, "1", "chosen";
    /// Middle probe in a wide range, as a fraction of the logarithmic range.
    PROBE_WIDE_MIDDLE: f64 = 0.5, "1", "chosen";
    /// Highest probe in a wide range, as a fraction of the logarithmic range.
    PROBE_WIDE_HIGH: f64 = 0.75, "1", "chosen";
    /// Lower probe of a shape parameter, as a fraction of its range.
    PROBE_SHAPE_LOW: f64 = 0.25, "1", "chosen";
    /// Upper probe of a shape parameter, as a fraction of its range.
    PROBE_SHAPE_HIGH: f64 = 0.6, "1", "chosen";
    /// Distance of the probe from the null, relative to the range, where the library's default is the null.
    PROBE_TYPICAL_SHARE: f64 = 0.1, "1", "chosen";
    /// Target norm of a probe's change of the whitened data, without the part that base parameters compensate.
    PROBE_CHANGE_SIGMAS: f64 = 12.0, "σ",
        "chosen: a far larger change is not linear down to small effects, a smaller one not up to large ones";
    /// Ratio of a probe's target change to the norm of the base fit's residuals, used where it is larger.
    PROBE_CHANGE_SHARE: f64 = 0.5, "1", "chosen";
    /// Ratio of the closest probe's change to its target, or the inverse, from which another probe is simulated.
    PROBE_MISS_RATIO: f64 = 3.0, "1", "chosen";
    /// Minimum distance of a new probe from another, relative to the other's distance from the null.
    PROBE_LEAST_DISTANCE: f64 = 0.2, "1", "chosen";
    /// Maximum number of additional larger probes where the data require them.
    LARGER_PROBES: usize = 3, "1", "chosen";
    /// Maximum ratio of a larger probe to the one from which it is extrapolated.
    LARGER_PROBE_RATIO: f64 = 4.0, "1", "chosen";
    /// Minimum expected Δχ² for which a larger probe is simulated.
    LARGER_PROBE_DELTA_CHI2: f64 = 16.0, "1", "chosen";
    /// Maximum ratio of a size to a probe for a linear extrapolation of the probe's change.
    EXTRAPOLATION_MOST: f64 = 1.5, "1", "chosen";
    /// Minimum share of an effect's change that base parameters do not compensate: less is rounding error.
    DISTINCT_CHANGE_SHARE: f64 = 1e-3, "1", "chosen";
    /// Minimum norm of the change that base parameters compensate, for which both are simulated together.
    FOLLOWED_SIGMAS: f64 = 12.0, "σ", "chosen";
    /// Maximum number of simulations of an effect together with compensating base parameters.
    FOLLOWED_STEPS: usize = 2, "1", "chosen";
    /// Minimum ratio of another shape's expected Δχ² to that of the best shape for a fit from both.
    SHAPE_GAIN_SHARE: f64 = 0.3, "1", "chosen";
    // Fits of effects and of pairs.
    /// Expected Δχ² above which an effect may be fitted.
    FITTED_DELTA_CHI2: f64 = 4.0, "1", "chosen";
    /// Maximum number of effects that are fitted, in descending order of expected Δχ².
    EFFECTS_FITTED: usize = 9, "1", "chosen";
    /// Maximum number of effects whose quick fit is refined, the best first.
    EFFECTS_REFINED: usize = 4, "1", "chosen";
    /// Maximum number of starts of the fit of an effect with a shape parameter.
    STARTS_PER_EFFECT: usize = 2, "1", "chosen";
    /// Minimum ratio of an effect's Δχ² to that of the best effect for a refined fit, and for a final fit after it.
    REFINED_GAIN_SHARE: f64 = 0.3, "1", "chosen";
    /// Minimum Δχ² for a final fit.
    LAST_FIT_DELTA_CHI2: f64 = 40.0, "1", "chosen";
    /// Maximum number of derivative computations in the quick first fit of an effect or a pair.
    QUICK_FIT_DERIVATIVES: usize = 0, "1", "chosen";
    /// Maximum number of steps in the quick first fit of an effect or a pair.
    QUICK_FIT_STEPS: usize = 6, "1", "chosen";
    /// Maximum number of derivative computations in a refined fit.
    REFINED_FIT_DERIVATIVES: usize = 2, "1", "chosen";
    /// Maximum number of steps in a refined fit.
    REFINED_FIT_STEPS: usize = 12, "1", "chosen";
    /// Maximum number of derivative computations in a final fit.
    LAST_FIT_DERIVATIVES: usize = 3, "1", "chosen";
    /// Maximum number of steps in a final fit.
    LAST_FIT_STEPS: usize = 18, "1", "chosen";
    /// Maximum number of derivative computations in the fit of an effect together with a dominant one.
    PARTNER_FIT_DERIVATIVES: usize = 1, "1", "chosen";
    /// Maximum number of steps in the fit of an effect together with a dominant one.
    PARTNER_FIT_STEPS: usize = 8, "1", "chosen";
    /// Maximum number of pairs of effects that are fitted, in ascending order of expected χ².
    PAIRS_FITTED: usize = 9, "1", "chosen";
    /// Maximum number of pairs whose quick fit is refined, the best first.
    PAIRS_REFINED: usize = 2, "1", "chosen";
    /// Maximum number of fitted pairs with the same leading effect.
    PAIRS_PER_LEAD: usize = 3, "1", "chosen";
    /// Ratio of χ² with an effect to χ² of the base model below which the effect may be dominant.
    LEAD_CHI2_SHARE: f64 = 0.5, "1", "chosen";
    /// Maximum number of pairs with a dominant effect whose fit is refined.
    PARTNERS_REFINED: usize = 4, "1", "chosen";
    /// Squared sine of the angle between two changes up to which they are collinear.
    PAIR_SINE_SQUARED: f64 = 1e-3, "1", "chosen";
    // p-values and probabilities.
    /// Family-wise significance level of a search, of all residual tests, and of all covariates.
    SIGNIFICANCE_LEVEL: f64 = 0.05, "1", "convention; corrections: Holm 1979, Westfall and Young 1993";
    /// Number of sign-flip draws of the residuals for the p-value of an effect.
    SIGN_FLIP_DRAWS: u64 = 400, "1", "chosen; method: Wu 1986";
    /// Singular value, relative to the largest, up to which changes by an effect's sizes are linearly dependent.
    DEPENDENT_SHARE: f64 = 1e-3, "1", "chosen";
    /// Minimum number of folds of the calibration scans; a fold is a stretch of a pass.
    FOLDS_LEAST: usize = 16, "1", "chosen: tens of folds, as in cross-validation in the literature";
    /// Number of bootstrap draws of the fold weights for the probabilities of models.
    FOLD_WEIGHT_DRAWS: usize = 1000, "1", "convention: a thousand; method: Yao and others 2018";
    /// Hat functions of the closure along the part.
    CLOSURE_PART_ALONG: usize = 13, "1", "chosen: their width is a sixth of the touched length";
    /// Hat functions of the closure across the part.
    CLOSURE_PART_ACROSS: usize = 4, "1", "chosen: their width is two thirds of the touched width";
    /// Hat functions of the closure along each pass.
    CLOSURE_PASS_ALONG: usize = 6, "1", "chosen: their width is two fifths of the touched length";
    /// Hat functions of the closure across each pass.
    CLOSURE_PASS_ACROSS: usize = 3, "1", "chosen: their width is the touched width";
    /// Minimum strength of the closure that is tried, relative to the removal.
    CLOSURE_STRENGTH_LEAST: f64 = 0.001, "1", "chosen: below the strength that noise allows any scan to resolve";
    /// Ratio of successive strengths of the closure.
    CLOSURE_STRENGTH_RATIO: f64 = 2.0, "1", "chosen";
    /// Number of strengths of the closure that are tried.
    CLOSURE_STRENGTHS: i32 = 10, "1", "chosen: up to half of the removal";
    /// Probability that none of the effects is the cause, at or above which no effect is named.
    NONE_MOST: f64 = 0.5, "1", "derived: even odds";
    /// Minimum probability for naming an effect alone.
    NAMED_PROBABILITY: f64 = 0.9, "1", "chosen: odds of nine to one";
    /// Maximum probability of an effect that cannot be named alone, however well it fits.
    RESERVED_PROBABILITY: f64 = 0.5, "1", "chosen: even odds, because nothing tests it";
    /// Minimum share of the excess χ² that an effect must explain to be reported as the nearest.
    NEAREST_SHARE: f64 = 0.1, "1", "chosen";
    /// Prior odds that a parameter of an effect lies within the library's range and is the same in all passes.
    LISTED_ODDS: f64 = 19.0, "1", "chosen: the library's ranges contain 95 % of the values that occur";
    /// Maximum number of effects that are found one after the other.
    MOST_EFFECTS: usize = 3, "1", "chosen";
    /// Relative distance from the range's end at the null up to which a log-scale size is at the null.
    NULL_RATIO: f64 = 0.01, "1", "chosen";
    /// Distance from the null, relative to the width of the range, below which a linear-scale size is at the null.
    NULL_SHARE: f64 = 1e-6, "1", "chosen";
    /// Relative distance from an end of its range other than the null up to which a size is on that bound.
    FAR_END_RATIO: f64 = 1e-3, "1", "chosen";
    // Sizes and verdicts.
    /// Smooth error of a simulated scan, relative to the mean removal.
    SMOOTH_ERROR_REMOVAL: f64 = 0.001, "1",
        "measured: error of the law that made another laboratory's scans (docs/diagnosis.md, Limits)";
    /// Smooth error of a simulated exposed border, relative to the distance that replaces the removal.
    SMOOTH_ERROR_EXPOSURE: f64 = 0.0025, "1",
        "measured: error of the law that made another laboratory's masks (docs/diagnosis.md, Limits)";
    /// Ratio of a simulated border's smooth error in the intervals of parameters to that of the other laboratory's law.
    SMOOTH_ERROR_BORDER: f64 = 1.6, "1", "measured: stiffness of 48 campaigns with nothing hidden (docs/calibration.md)";
    /// Ratio of the error common to all tiles of a simulated pass to its smooth error.
    SMOOTH_ERROR_PASS: f64 = 1.5, "1",
        "chosen: another laboratory's removed volumes scatter by 0.14 and 0.21 % about their law, 0.1 % of it noise";
    /// Minimum size of a named effect, relative to the smooth error.
    EFFECT_SIZE_SMOOTH: f64 = 2.0, "1", "chosen: a smaller effect may be an error of the simulation itself";
    /// Minimum size of a named effect, relative to the noise floor; the larger limit applies.
    EFFECT_SIZE_FLOOR: f64 = 0.1, "1", "derived: a smaller effect changes the error by less than half a percent";
    /// Norm of the change of the whitened data that is detected with a power of 80 %.
    DETECTABLE_SIGMAS: f64 = 3.8, "σ",
        "derived: one-sided level of 5 % over thirty effects, 2.94 σ, and a power of 80 %, 0.84 σ";
    /// Minimum share of the effects that must be detectable for the verdict that nothing is missing.
    TESTABLE_SHARE: f64 = 0.5, "1", "chosen";
    /// Threshold of the unexplained residual for a missing effect, relative to the mean removal.
    UNEXPLAINED_REMOVAL: f64 = 0.01, "1", "chosen";
    /// Threshold of the unexplained residual for a missing effect, relative to the noise; the larger one applies.
    UNEXPLAINED_NOISE: f64 = 0.6, "1", "chosen";
    /// Unexplained residual of held-out data above which a model misses them, relative to the mean removal.
    HELD_OUT_REMOVAL: f64 = 0.02, "1", "chosen: errors of the parameters add to those of the simulation";
    /// Threshold of the held-out data's unexplained residual, relative to the noise; the larger one applies.
    HELD_OUT_NOISE: f64 = 1.5, "1", "chosen: errors of the parameters add to those of the simulation";
    /// Maximum share of the calibration data's unexplained mean square that an adequate fit leaves.
    LEFT_CALIBRATION_SHARE: f64 = 0.25, "1", "chosen";
    /// Maximum share of the held-out data's unexplained mean square that an adequate fit leaves.
    LEFT_HELD_OUT_SHARE: f64 = 0.5, "1", "chosen";
    /// Threshold of the unexplained residual above which no fit is adequate, relative to the mean removal.
    ADEQUATE_REMOVAL: f64 = 0.03, "1", "chosen";
    /// Threshold of the unexplained residual for adequate fits, relative to the noise; the larger one applies.
    ADEQUATE_NOISE: f64 = 3.0, "1", "chosen";
    /// Ratio of the error to its noise floor up to which the error is near the noise and a study ends.
    NEAR_FLOOR_RATIO: f64 = 1.1, "1", "chosen";
    // Comparison.
    /// Number of noise draws for the p-value of a residual test.
    RESIDUAL_TEST_DRAWS: usize = 999, "1", "convention: a thousand including the data";
    /// Minimum number of tiles in a line whose runs of one sign are counted.
    RUN_LINE_LEAST: usize = 5, "1", "chosen";
    /// Minimum number of tiles that successive scans must share for the test of correlation between passes.
    SHARED_TILES_LEAST: usize = 20, "1", "chosen";
    /// Remaining share of the first scan's noise from which the test of correlation between passes omits a tile.
    SHARED_NOISE_MOST: f64 = 0.1, "1", "chosen: successive scans share that noise";
    /// Number of permutation draws of shifted maps for the p-value of a covariate.
    COVARIATE_DRAWS: usize = 499, "1", "convention: five hundred including the data";
    /// Number of block-bootstrap draws for the bands of a binned mean.
    COVARIATE_BAND_DRAWS: usize = 400, "1", "chosen";
    /// Lower quantile of the band of a binned mean.
    COVARIATE_BAND_LOW: f64 = 0.025, "1", "convention: 95 % band";
    /// Upper quantile of the band of a binned mean.
    COVARIATE_BAND_HIGH: f64 = 0.975, "1", "convention: 95 % band";
    /// Maximum number of bins of a covariate.
    COVARIATE_BINS: usize = 10, "1", "chosen";
    /// Minimum mean number of data per bin of a covariate, if it has more than three bins.
    COVARIATE_BIN_LEAST: usize = 8, "1", "chosen";
    /// Minimum number of data for a study of covariates.
    COVARIATE_DATA_LEAST: usize = 20, "1", "chosen";
    /// Ridge parameter of the joint regression on covariates, for columns of unit length.
    COVARIATE_RIDGE: f64 = 1e-3, "1", "chosen";
    /// Mean number of rows in the pieces of a table that a permutation draw reorders.
    ROW_PIECE_LENGTH: f64 = 4.0, "1", "chosen";
    /// Threshold of the removal for a tile of a pass's track, relative to the noise of a tile.
    TRACK_REMOVAL_SIGMAS: f64 = 4.0, "σ", "chosen";
    /// Threshold of the removal for a tile of a track, relative to its 90 % quantile; the larger one applies.
    TRACK_REMOVAL_SHARE: f64 = 0.15, "1", "chosen";
    /// Greatest removal of a section above which it may have a plateau, relative to the noise floor.
    PLATEAU_REMOVAL_SIGMAS: f64 = 3.0, "σ", "chosen";
    /// Number of grid values over the whole range of each parameter of a law, for trends in tables.
    TREND_VALUES: usize = 7, "1", "chosen";
    /// Factor by which each parameter of a law is multiplied and divided, for trends in scans.
    TREND_FACTOR: f64 = 3.0, "1", "chosen";
    /// Prediction, relative to the largest, up to which a row counts as no removal.
    TREND_REMOVAL_SHARE: f64 = 1e-2, "1", "chosen";
    /// Number of standard deviations outside a law's range of changes above which it cannot follow equal passes.
    TREND_SIGMAS: f64 = 3.0, "σ", "convention: three sigmas";
    /// Share of the joint Δχ² that two effects both explain, above which their Shapley values are reported.
    SHAPLEY_OVERLAP: f64 = 0.2, "1", "chosen";
}

#[cfg(test)]
mod tests;
