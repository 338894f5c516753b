//! Criteria for the dependence on columns of tables, logs and trials.

use super::Criterion;

criteria! {
    OF_COLUMNS;
    /// Minimum number of values of a column for a linear form or a power.
    COLUMN_FORM_LEVELS: usize = 3, "1", "chosen: two values show only one change";
    /// Minimum number of values of a column for a form with a floor.
    COLUMN_FLOOR_LEVELS: usize = 5, "1", "chosen: two more than its parameters";
    /// Minimum ratio of the greatest to the least value of a column for a power.
    COLUMN_POWER_RATIO: f64 = 1.5, "1", "chosen: below, a power is almost a line";
    /// Maximum relative change of the rate towards a floor.
    COLUMN_FLOOR_MOST: f64 = 0.95, "1", "chosen: a twentieth is left";
    /// Minimum scale of a floor, relative to the range of its column.
    COLUMN_FLOOR_SHORTEST: f64 = 0.05, "1", "chosen: a shorter scale gives a step";
    /// Maximum scale of a floor, relative to the range of its column.
    COLUMN_FLOOR_LONGEST: f64 = 2.0, "1", "chosen: a longer scale gives a line";
    /// Maximum number of columns of logs and trials that are variables of a search.
    COLUMN_VARIABLES_MOST: usize = 8, "1", "chosen: the sums of all variables fit into one model";
}
