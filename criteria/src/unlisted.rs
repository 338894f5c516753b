//! Criteria of the search for unlisted effects.

use super::Criterion;

criteria! {
    OF_UNLISTED_EFFECTS;
    /// Maximum number of knots of a curve over one variable, and number of positions at which a form is tried.
    CURVE_KNOTS: usize = 32, "1", "chosen: the shortest feature is a thirtieth of a path";
    /// Finite-difference step of the dose for the slope of the border's position, relative to the dose change.
    CURVE_MASK_STEP: f64 = 0.05, "1", "chosen: a twentieth moves a border by pixels";
    /// Maximum correlation length of a curve, relative to the range of its variable.
    CURVE_LENGTH_GREATEST: f64 = 0.5, "1", "chosen: the curve is a single bow";
    /// Ratio of successive correlation lengths of a curve.
    CURVE_LENGTH_RATIO: f64 = 2.0, "1", "chosen";
    /// Number of correlation lengths of a curve that are tried.
    CURVE_LENGTHS: i32 = 5, "1", "chosen: down to the distance between two knots";
    /// Minimum strength of a curve that is tried, relative to the rate.
    CURVE_STRENGTH_LEAST: f64 = 0.005, "1", "chosen: below the strength that noise allows any scan to resolve";
    /// Ratio of successive strengths of a curve.
    CURVE_STRENGTH_RATIO: f64 = 2.5, "1", "chosen";
    /// Number of strengths of a curve that are tried.
    CURVE_STRENGTHS: i32 = 7, "1", "chosen: up to the whole rate";
    /// Minimum number of knots of a variable for forms with a shape parameter.
    FORM_KNOTS_LEAST: usize = 8, "1", "chosen: fewer values do not determine a shape of three parameters";
    /// Ratio of successive widths of a form.
    FORM_RATIO: f64 = 1.6, "1", "chosen";
    /// Number of widths in the grid of forms, from the whole range down.
    FORM_RATIOS: usize = 8, "1", "chosen: down to the distance between two knots";
    /// Prior standard deviation of a form's size.
    FORM_SIZE_SIGMA: f64 = 1.0, "1", "chosen: the rate may double or vanish";
    /// Maximum number of forms that are found one after the other.
    FORM_TERMS: usize = 2, "1", "chosen";
    /// Maximum number of forms that a screening selects for a fit.
    FORMS_FITTED: usize = 8, "1", "chosen";
    /// Maximum number of sizes of a form from which its fit may start.
    FORM_STARTS: i32 = 4, "1", "chosen: a biased model shows a fortieth of a form (docs/unlisted-effects.md)";
    /// Ratio of successive starting sizes of a form.
    FORM_START_RATIO: f64 = 4.0, "1", "chosen";
    /// Maximum number of forms over one variable that a screening selects.
    FORMS_PER_VARIABLE: usize = 2, "1", "chosen";
    /// Maximum number of forms whose quick fit is refined, the best first.
    FORMS_REFINED: usize = 2, "1", "chosen";
}
