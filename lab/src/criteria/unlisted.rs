//! Criteria of the search for unlisted effects.

use super::Criterion;

criteria! {
    OF_UNLISTED_EFFECTS;
    /// Most knots of a curve over one variable, and places of a form that are tried over it.
    CURVE_KNOTS: usize = 32, "1", "chosen: a thirtieth of a way is the shortest feature";
    /// Step of a coating's dose behind the slope of the border's place, over the change of the dose.
    CURVE_MASK_STEP: f64 = 0.05, "1", "chosen: a twentieth moves a border by pixels";
    /// Longest length of a curve, over the range of its variable.
    CURVE_LENGTH_GREATEST: f64 = 0.5, "1", "chosen: a bow";
    /// Ratio of a length of a curve to the next.
    CURVE_LENGTH_RATIO: f64 = 2.0, "1", "chosen";
    /// Lengths of a curve that are tried.
    CURVE_LENGTHS: i32 = 5, "1", "chosen: down to the distance of two knots";
    /// Least strength of a curve that is tried, as a share of the rate.
    CURVE_STRENGTH_LEAST: f64 = 0.005, "1", "chosen: below what noise lets any scan show";
    /// Ratio of a strength of a curve to the one before.
    CURVE_STRENGTH_RATIO: f64 = 2.5, "1", "chosen";
    /// Strengths of a curve that are tried.
    CURVE_STRENGTHS: i32 = 7, "1", "chosen: up to all of the rate";
    /// Fewest knots of a variable for forms that have a shape.
    FORM_KNOTS_LEAST: usize = 8, "1", "chosen: fewer values show no shape of three numbers";
    /// Ratio of a width of a form to the next.
    FORM_RATIO: f64 = 1.6, "1", "chosen";
    /// Widths of a form that are tried, from the whole range on.
    FORM_RATIOS: usize = 8, "1", "chosen: down to the distance of two knots";
    /// Prior standard deviation of a form's size.
    FORM_SIZE_SIGMA: f64 = 1.0, "1", "chosen: the rate may double or vanish";
    /// Forms that may be found one after the other.
    FORM_TERMS: usize = 2, "1", "chosen";
    /// Forms that are fitted.
    FORMS_FITTED: usize = 8, "1", "chosen";
    /// Sizes of a form from which its fit may begin.
    FORM_STARTS: i32 = 4, "1", "chosen: a model that has gone astray shows a fortieth of a form (docs/unlisted-effects.md)";
    /// Ratio of such a size to the one before.
    FORM_START_RATIO: f64 = 4.0, "1", "chosen";
    /// Most of them over one variable.
    FORMS_PER_VARIABLE: usize = 2, "1", "chosen";
    /// Best forms that are fitted until they converge.
    FORMS_REFINED: usize = 2, "1", "chosen";
}
