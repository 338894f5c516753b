//! Agreed values of the criteria: a change of one is a decision, which the documents must explain.

use std::collections::BTreeSet;
use std::fs;
use std::path::Path;

use super::{CRITERIA, CriterionValues};

/// Names and values.
const AGREED: &[(&str, f64)] = &[
    ("PART_SHIFT_SIGMA", 0.0001),
    ("FRAME_REACH", 0.0002),
    ("FRAME_SETTLED", 0.00002),
    ("FRAME_SMOOTH_SHARE", 0.3),
    ("FRAME_ODDS", 19.0),
    ("FRAME_SHOWN_SHARE", 0.9),
    ("TILE_LEAST_SIDE", 3.0),
    ("TILES_PER_SCAN", 1000.0),
    ("TILE_KNOWN_SHARE", 0.4),
    ("NOISE_CUT_SIGMAS", 4.0),
    ("NOISE_BLOCK_SHARE", 0.5),
    ("TILE_BLOCK_SIDE", 4.0),
    ("SIMULATION_STEP_RATIO", 3.0),
    ("SIMULATION_LEAST_STEPS", 1000.0),
    ("SANDING_VOXEL_PIXELS", 4.0),
    ("SANDING_VOXELS_ACROSS", 16.0),
    ("POSE_HEIGHT_SIGMA", 0.00005),
    ("POSE_TILT_SIGMA", 0.00005),
    ("POSE_SHIFT_SIGMA", 0.0001),
    ("PASS_BEGIN_SIGMA", 0.577),
    ("PASS_END_SIGMA", 0.289),
    ("RIM_NOISE_SHARE", 0.25),
    ("SCAN_NOISE_DECAY_SIGMAS", 3.0),
    ("CHANGED_HEIGHT", 0.000002),
    ("BLUR_WIDEST", 2.0),
    ("BORDER_REACH", 0.5),
    ("BORDER_MAJORITY_RADIUS", 2.0),
    ("BORDER_SCATTER_LEAST", 0.3),
    ("BORDER_FLOOR_LEAST", 0.5),
    ("COATING_ERROR_RATIO", 2.0),
    ("GROUP_GAIN_SIGMA", 1.0),
    ("ROW_BLOCK_LENGTH", 5.0),
    ("ROW_BLOCKS_LEAST", 10.0),
    ("PREDICTION_LEAST_SHARE", 0.001),
    ("OUTLIER_SIGMAS", 5.0),
    ("GROSS_RESIDUAL_SIGMAS", 5.0),
    ("SAME_SETTING", 0.01),
    ("SAME_LOAD", 0.05),
    ("REPEATS_LEAST", 20.0),
    ("ROW_NOISE_LEAST", 0.001),
    ("ROW_NOISE_ROBUST_LEAST", 10.0),
    ("ROW_SQUARES_LEAST", 3.0),
    ("ROW_SQUARE_LEVELS_LEAST", 5.0),
    ("ROW_REGRESSION_CUT", 1.345),
    ("PREDICTION_CHANGE_LEAST", 0.000001),
    ("RATE_RANGE_FACTOR", 1000.0),
    ("SPAN_RANGE_FACTOR", 30.0),
    ("COLUMN_CHANGE_MOST", 4.6),
    ("COLUMN_CHANGE_TYPICAL", 0.1),
    ("SAME_RESPONSE", 0.999),
    ("HUBER_CONSTANT", 2.5),
    ("FIT_CONVERGED_DELTA_CHI2", 0.05),
    ("FIT_DERIVATIVES", 8.0),
    ("FIT_STEPS", 25.0),
    ("ROUGH_FIT_DERIVATIVES", 2.0),
    ("ROUGH_FIT_STEPS", 8.0),
    ("RENEWED_FIT_DERIVATIVES", 2.0),
    ("RENEWED_FIT_STEPS", 10.0),
    ("RESTART_CHI2_PER_DATUM", 1.3),
    ("RESTARTS_FITTED", 2.0),
    ("START_RATIO", 10.0),
    ("START_RATE_TOLERANCE", 0.01),
    ("RESTART_DISTANCE", 0.4),
    ("MINIMUM_APART", 0.4),
    ("NUMERICAL_NOISE", 2.0),
    ("DERIVATIVE_CHANGE_AIM", 12.0),
    ("DERIVATIVE_CHANGE_LEAST", 8.0),
    ("DERIVATIVE_CHANGE_MOST", 60.0),
    ("DERIVATIVE_CHANGE_SHARE", 0.3),
    ("DERIVATIVE_LONGEST_STEP", 0.5),
    ("RANGE_EXTENSION", 3.0),
    ("LAW_RANGE_EXTENSION", 27.0),
    ("BOUND_SHARE", 0.001),
    ("STAGED_RATE_TOLERANCE", 0.0001),
    ("INTERVAL_SIGMAS", 1.96),
    ("NOT_IDENTIFIABLE_SHARE", 0.5),
    ("STRONG_CORRELATION", 0.95),
    ("SPREAD_CUT_SIGMAS", 3.0),
    ("PROBE_WIDE_RATIO", 100.0),
    ("PROBE_NARROW_LOW", 0.35),
    ("PROBE_NARROW_HIGH", 0.65),
    ("PROBE_WIDE_LOW", 0.25),
    ("PROBE_WIDE_MIDDLE", 0.5),
    ("PROBE_WIDE_HIGH", 0.75),
    ("PROBE_SHAPE_LOW", 0.25),
    ("PROBE_SHAPE_HIGH", 0.6),
    ("PROBE_TYPICAL_SHARE", 0.1),
    ("PROBE_CHANGE_SIGMAS", 12.0),
    ("PROBE_CHANGE_SHARE", 0.5),
    ("PROBE_MISS_RATIO", 3.0),
    ("PROBE_LEAST_DISTANCE", 0.2),
    ("LARGER_PROBES", 3.0),
    ("LARGER_PROBE_RATIO", 4.0),
    ("LARGER_PROBE_DELTA_CHI2", 16.0),
    ("EXTRAPOLATION_MOST", 1.5),
    ("DISTINCT_CHANGE_SHARE", 0.001),
    ("FOLLOWED_SIGMAS", 12.0),
    ("FOLLOWED_STEPS", 2.0),
    ("SHAPE_GAIN_SHARE", 0.3),
    ("FITTED_DELTA_CHI2", 4.0),
    ("EFFECTS_FITTED", 9.0),
    ("EFFECTS_REFINED", 4.0),
    ("STARTS_PER_EFFECT", 2.0),
    ("REFINED_GAIN_SHARE", 0.3),
    ("LAST_FIT_DELTA_CHI2", 40.0),
    ("QUICK_FIT_DERIVATIVES", 0.0),
    ("QUICK_FIT_STEPS", 6.0),
    ("REFINED_FIT_DERIVATIVES", 2.0),
    ("REFINED_FIT_STEPS", 12.0),
    ("LAST_FIT_DERIVATIVES", 3.0),
    ("LAST_FIT_STEPS", 18.0),
    ("PARTNER_FIT_DERIVATIVES", 1.0),
    ("PARTNER_FIT_STEPS", 8.0),
    ("FIRST_LOOK_EFFECTS", 5.0),
    ("COARSE_VOXEL_RATIO", 2.0),
    ("MAPPING_ROUNDS", 4.0),
    ("ATTEMPT_STARTS", 12.0),
    ("ATTEMPT_FITS", 1.0),
    ("ATTEMPT_ROUNDS", 2.0),
    ("PAIRS_FITTED", 9.0),
    ("PAIRS_REFINED", 2.0),
    ("PAIRS_PER_LEAD", 3.0),
    ("LEAD_CHI2_SHARE", 0.5),
    ("PARTNERS_REFINED", 4.0),
    ("PAIR_SINE_SQUARED", 0.001),
    ("SIGNIFICANCE_LEVEL", 0.05),
    ("SIGN_FLIP_DRAWS", 400.0),
    ("DEPENDENT_SHARE", 0.001),
    ("FOLDS_LEAST", 16.0),
    ("FOLD_WEIGHT_DRAWS", 1000.0),
    ("CLOSURE_PART_ALONG", 13.0),
    ("CLOSURE_PART_ACROSS", 4.0),
    ("CLOSURE_PASS_ALONG", 6.0),
    ("CLOSURE_PASS_ACROSS", 3.0),
    ("CLOSURE_STRENGTH_LEAST", 0.001),
    ("CLOSURE_STRENGTH_RATIO", 2.0),
    ("CLOSURE_STRENGTHS", 10.0),
    ("NONE_MOST", 0.5),
    ("NAMED_PROBABILITY", 0.9),
    ("RESERVED_PROBABILITY", 0.5),
    ("NEAREST_SHARE", 0.1),
    ("LISTED_ODDS", 19.0),
    ("MOST_EFFECTS", 3.0),
    ("NULL_RATIO", 0.01),
    ("NULL_SHARE", 0.000001),
    ("FAR_END_RATIO", 0.001),
    ("SMOOTH_ERROR_REMOVAL", 0.001),
    ("SMOOTH_ERROR_EXPOSURE", 0.0025),
    ("SMOOTH_ERROR_BORDER", 1.6),
    ("SMOOTH_ERROR_PASS", 1.5),
    ("EFFECT_SIZE_SMOOTH", 2.0),
    ("EFFECT_SIZE_FLOOR", 0.1),
    ("DETECTABLE_SIGMAS", 3.8),
    ("TESTABLE_SHARE", 0.5),
    ("UNEXPLAINED_REMOVAL", 0.01),
    ("UNEXPLAINED_NOISE", 0.6),
    ("HELD_OUT_REMOVAL", 0.02),
    ("HELD_OUT_NOISE", 1.5),
    ("LEFT_CALIBRATION_SHARE", 0.25),
    ("LEFT_HELD_OUT_SHARE", 0.5),
    ("ADEQUATE_REMOVAL", 0.03),
    ("ADEQUATE_NOISE", 3.0),
    ("NEAR_FLOOR_RATIO", 1.1),
    ("NEXT_TRIAL_HYPOTHESES", 4.0),
    ("NEXT_TRIAL_RUNNERS_UP", 5.0),
    ("NEXT_TRIAL_VOXEL_RATIO", 2.0),
    ("NEXT_TRIAL_TILES", 300.0),
    ("TRIAL_SETUP_MINUTES", 15.0),
    ("TRIAL_SCAN_MINUTES", 4.0),
    ("TRIAL_DRESSING_MINUTES", 5.0),
    ("RESIDUAL_TEST_DRAWS", 999.0),
    ("RUN_LINE_LEAST", 5.0),
    ("SHARED_TILES_LEAST", 20.0),
    ("SHARED_NOISE_MOST", 0.1),
    ("COVARIATE_DRAWS", 499.0),
    ("COVARIATE_BAND_DRAWS", 400.0),
    ("COVARIATE_BAND_LOW", 0.025),
    ("COVARIATE_BAND_HIGH", 0.975),
    ("COVARIATE_BINS", 10.0),
    ("COVARIATE_BIN_LEAST", 8.0),
    ("COVARIATE_DATA_LEAST", 20.0),
    ("COVARIATE_RIDGE", 0.001),
    ("ROW_PIECE_LENGTH", 4.0),
    ("TRACK_REMOVAL_SIGMAS", 4.0),
    ("TRACK_REMOVAL_SHARE", 0.15),
    ("PLATEAU_REMOVAL_SIGMAS", 3.0),
    ("TREND_VALUES", 7.0),
    ("TREND_FACTOR", 3.0),
    ("TREND_REMOVAL_SHARE", 0.01),
    ("TREND_SIGMAS", 3.0),
    ("SHAPLEY_OVERLAP", 0.2),
    ("COLUMN_FORM_LEVELS", 3.0),
    ("COLUMN_FLOOR_LEVELS", 5.0),
    ("COLUMN_POWER_RATIO", 1.5),
    ("COLUMN_FLOOR_MOST", 0.95),
    ("COLUMN_FLOOR_SHORTEST", 0.05),
    ("COLUMN_FLOOR_LONGEST", 2.0),
    ("COLUMN_VARIABLES_MOST", 8.0),
    ("CURVE_KNOTS", 32.0),
    ("CURVE_MASK_STEP", 0.05),
    ("CURVE_LENGTH_GREATEST", 0.5),
    ("CURVE_LENGTH_RATIO", 2.0),
    ("CURVE_LENGTHS", 5.0),
    ("CURVE_STRENGTH_LEAST", 0.005),
    ("CURVE_STRENGTH_RATIO", 2.5),
    ("CURVE_STRENGTHS", 7.0),
    ("FORM_KNOTS_LEAST", 8.0),
    ("FORM_RATIO", 1.6),
    ("FORM_RATIOS", 8.0),
    ("FORM_SIZE_SIGMA", 1.0),
    ("FORM_TERMS", 2.0),
    ("FORMS_FITTED", 8.0),
    ("FORM_STARTS", 4.0),
    ("FORM_START_RATIO", 4.0),
    ("FORMS_PER_VARIABLE", 2.0),
    ("FORMS_REFINED", 2.0),
];

fn root() -> &'static Path {
    Path::new(env!("CARGO_MANIFEST_DIR"))
}

#[test]
fn the_criteria_are_those_that_were_agreed_on() {
    let reason = "write the reason into docs/diagnosis.md, section Criteria, and then the value into this test";
    for (name, value) in AGREED {
        let now = CRITERIA.iter().find(|criterion| criterion.name == *name).map(|criterion| criterion.value);
        assert_eq!(now, Some(*value), "{name} was {value}: {reason}");
    }
    for criterion in CRITERIA {
        let is_known = AGREED.iter().any(|(name, _)| *name == criterion.name);
        assert!(is_known, "{} is new: {reason}", criterion.name);
    }
}

#[test]
fn each_criterion_has_a_name_of_its_own_a_meaning_and_a_source() {
    let names: BTreeSet<&str> = CRITERIA.iter().map(|criterion| criterion.name).collect();
    assert_eq!(names.len(), CRITERIA.len());
    let meanings: BTreeSet<&str> = CRITERIA.iter().map(|criterion| criterion.meaning).collect();
    assert_eq!(meanings.len(), CRITERIA.len(), "two criteria have one meaning");
    let origins = ["chosen", "convention", "measured: ", "derived"];
    for criterion in CRITERIA {
        assert!(criterion.meaning.ends_with('.') && !criterion.unit.is_empty(), "{criterion:?}");
        assert!(origins.iter().any(|origin| criterion.source.starts_with(origin)), "{criterion:?}");
    }
}

#[test]
fn the_table_of_the_documents_is_that_of_the_code() {
    let page = fs::read_to_string(root().join("../docs/diagnosis.md")).unwrap();
    let (_, rest) = page.split_once("<!-- criteria -->\n").unwrap();
    let shown = rest.split_once("<!-- /criteria -->").unwrap().0;
    let mut table = "| criterion | value | unit | meaning | source |\n|---|---|---|---|---|\n".to_owned();
    for one in CRITERIA {
        table += &format!("| `{}` | {} | {} | {} | {} |\n", one.name, one.value, one.unit, one.meaning, one.source);
    }
    assert!(shown == table, "docs/diagnosis.md, section Criteria, should hold:\n{table}");
}

#[test]
fn every_result_holds_all_values_under_their_names() {
    let values = serde_json::to_value(CriterionValues).unwrap();
    assert_eq!(values.as_object().unwrap().len(), CRITERIA.len());
    for criterion in CRITERIA {
        assert_eq!(values[criterion.name], criterion.value);
    }
}

#[test]
fn the_laboratory_uses_every_criterion() {
    let sources = ["../lab/src", "../experiments/src", "../study/src"]
        .into_iter()
        .flat_map(|folder| walkdir::WalkDir::new(root().join(folder)))
        .map(|entry| entry.unwrap().into_path());
    let sources = sources.filter(|path| path.extension().is_some_and(|end| end == "rs"));
    let text: String = sources.map(|path| fs::read_to_string(path).unwrap()).collect();
    let words: BTreeSet<&str> = text.split(|c: char| !c.is_alphanumeric() && c != '_').collect();
    for criterion in CRITERIA {
        assert!(words.contains(criterion.name), "{} decides nothing", criterion.name);
    }
}
