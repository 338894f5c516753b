//! Criteria for the dependence on columns of tables, logs and trials.

use super::Criterion;

criteria! {
    OF_COLUMNS;
    /// Fewest values of a column that show a line or a power.
    COLUMN_FORM_LEVELS: usize = 3, "1", "chosen: two values have one change";
    /// Fewest values of a column that show a floor.
    COLUMN_FLOOR_LEVELS: usize = 5, "1", "chosen: two more than its numbers";
    /// Least ratio of the greatest to the least value of a column that shows a power.
    COLUMN_POWER_RATIO: f64 = 1.5, "1", "chosen: below, a power is a line";
    /// Greatest change of the rate towards a floor.
    COLUMN_FLOOR_MOST: f64 = 0.95, "1", "chosen: a twentieth is left";
    /// Least scale of a floor over the range of its column.
    COLUMN_FLOOR_SHORTEST: f64 = 0.05, "1", "chosen: shorter ones are a step";
    /// Greatest scale of a floor over the range of its column.
    COLUMN_FLOOR_LONGEST: f64 = 2.0, "1", "chosen: longer ones are a line";
    /// Most columns of logs and trials that are variables of a search.
    COLUMN_VARIABLES_MOST: usize = 8, "1", "chosen: the sums of all variables fit into one model";
}
