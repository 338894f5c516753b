//! Numerical codes for a missing value, such as -9999.

use instruments::text_table::TextTable;

use crate::trial::TrialError;

/// Codes that loggers and spreadsheets write for a missing value.
const MARKS: [f64; 10] = [-99.0, -999.0, -9999.0, -99_999.0, 999.0, 9999.0, 99_999.0, -32_768.0, 1e30, -1e30];
/// A code lies at least this many ranges of the other values away from them, and is at least as many times as large.
const APART: f64 = 3.0;

/// Codes for missing values, by column.
pub(super) struct Marks(Vec<Vec<f64>>);

impl Marks {
    /// Searches all numbers of a file. A number is a code only if no other value of its column comes near it: 999 N
    /// among loads of 100 to 900 N is a load.
    pub(super) fn find(text: &TextTable) -> Result<Self, TrialError> {
        let mut columns: Vec<Vec<f64>> = Vec::new();
        let mut is_header = true;
        text.rows(|row| {
            if std::mem::take(&mut is_header) {
                columns = vec![Vec::new(); row.len()];
                return Ok::<_, TrialError>(true);
            }
            for (at, values) in columns.iter_mut().enumerate().take(row.len()) {
                values.extend(row.number(at).ok().flatten().filter(|value| value.is_finite()));
            }
            Ok(true)
        })?;
        Ok(Self(columns.iter().map(|values| marks(values)).collect()))
    }

    /// Returns true if a number of a column is a code for a missing value.
    pub(super) fn has(&self, column: usize, value: f64) -> bool {
        self.0.get(column).is_some_and(|marks| marks.contains(&value))
    }
}

fn marks(values: &[f64]) -> Vec<f64> {
    let (marked, rest): (Vec<f64>, Vec<f64>) = values.iter().partition(|value| MARKS.contains(value));
    let (low, high) = rest.iter().fold((f64::INFINITY, f64::NEG_INFINITY), |(l, h), v| (l.min(*v), h.max(*v)));
    let size = low.abs().max(high.abs());
    let is_apart = |mark: &f64| {
        let distance = (low - mark).max(mark - high);
        let has_own_sign = if *mark < 0.0 { low >= 0.0 } else { high <= 0.0 };
        distance > APART * (high - low) && (has_own_sign || mark.abs() > APART * size)
    };
    let mut marks: Vec<f64> = MARKS.into_iter().filter(|mark| marked.contains(mark)).collect();
    marks.retain(|mark| !rest.is_empty() && is_apart(mark));
    marks
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_number_is_a_mark_only_far_from_all_others() {
        assert_eq!(marks(&[20.5, 21.0, -9999.0, 22.0]), [-9999.0]);
        assert_eq!(marks(&[20.0, 20.0, -99.0]), [-99.0]);
        assert_eq!(marks(&[5000.0, 5010.0, -9999.0]), [-9999.0]);
        assert!(marks(&[100.0, 500.0, 999.0]).is_empty(), "a load among loads");
        assert!(marks(&[-90.0, -95.0, -99.0]).is_empty(), "a temperature among temperatures");
        assert!(marks(&[-999.0, -999.0]).is_empty(), "nothing to compare with");
    }
}
