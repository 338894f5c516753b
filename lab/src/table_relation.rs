//! Relation of a table's removals to its settings. Every law says that the removal grows with the work: load × duration
//! when grinding, load × speed × duration when sanding. Where it does not grow with them at all, rows are out of order or
//! a column holds another quantity.

use nalgebra::{DMatrix, DVector};
use statrs::distribution::{ContinuousCDF, StudentsT};

use super::table_noise::{DEPENDENT, Declared, is_timed};
use crate::criteria::SIGNIFICANCE_LEVEL;
use effects::Signal;
use trials::table::{Row, Table};

/// Exponent of the removal over the work, and its interval.
struct Exponent {
    value: f64,
    low: f64,
    high: f64,
}

/// States that the removals do not depend on the work; `None` if they do, or if the rows cannot tell.
///
/// The exponent of the dependence is that of a regression of logarithms beside groups, measured states, use and time.
/// The removals are unrelated to the settings if its interval holds 0, no dependence, but not 1, the base law.
pub(super) fn unrelated(table: &Table, rows: &[usize]) -> Option<String> {
    let timed = is_timed(table);
    let amount = |row: &Row| Some((row.removal_rate? * row.duration.unwrap_or(1.0)).ln());
    // Eq. (1) has no speed, Eq. (2) has.
    let speed = |row: &Row| row.speed.filter(|_| table.process.signal() == Signal::Dose);
    let load = |row: &Row| row.pressure.or(row.force);
    let work = |row: &Row| load(row).unwrap_or(1.0) * speed(row).unwrap_or(1.0);
    let pair = |row: &Row| match (timed, row.duration) {
        // The time was measured: the removal over the work of one second.
        (true, Some(duration)) => Some((amount(row)? - work(row).ln(), duration.ln())),
        (_, duration) => Some((work(row).ln() + duration.unwrap_or(1.0).ln(), amount(row)?)),
    };
    let (settings, removals): (Vec<f64>, Vec<f64>) =
        rows.iter().map(|&at| pair(&table.rows[at])).collect::<Option<Vec<_>>>()?.into_iter().unzip();
    let Exponent { value, low, high } = exponent(&Declared::new(table, rows).beside_settings(), &settings, &removals)?;
    let given = |value: &dyn Fn(&Row) -> Option<f64>| table.rows.iter().any(|row| value(row).is_some());
    let factors = [("load", given(&load)), ("speed", given(&speed)), ("duration", given(&|row| row.duration))];
    let factors: Vec<&str> = factors.into_iter().filter(|(_, is_given)| *is_given).map(|(name, _)| name).collect();
    (low <= 0.0 && high < 1.0).then(|| {
        format!(
            "the removal does not grow with {} (it goes as this to the power {value:.2}, \
             95 %: {low:.2} to {high:.2}, and 1 is the base law): rows may be out of order, or a column may hold another \
             quantity; no effect can be named from it",
            factors.join(" × ")
        )
    })
}

/// Exponent of `target` over `settings`, both as logarithms, beside other `columns`; `None` without a degree of freedom
/// or if the settings do not vary beside the columns.
fn exponent(columns: &[Vec<f64>], settings: &[f64], target: &[f64]) -> Option<Exponent> {
    let design = DMatrix::from_fn(target.len(), columns.len(), |row, column| columns[column][row]);
    let svd = design.clone().svd(true, true);
    let least = DEPENDENT * design.norm().max(f64::MIN_POSITIVE);
    let freedom = target.len().checked_sub(svd.rank(least) + 1).filter(|left| *left > 0)? as f64;
    let beside = |values: &[f64]| {
        let values = DVector::from_column_slice(values);
        Some(&values - &design * svd.solve(&values, least).ok()?)
    };
    let (x, y) = (beside(settings)?, beside(target)?);
    let varied = x.norm_squared();
    if varied <= DEPENDENT * target.len() as f64 {
        return None;
    }
    let value = x.dot(&y) / varied;
    let sigma = ((y - &x * value).norm_squared() / freedom / varied).sqrt();
    let reach = sigma * StudentsT::new(0.0, 1.0, freedom).ok()?.inverse_cdf(1.0 - 0.5 * SIGNIFICANCE_LEVEL);
    Some(Exponent { value, low: value - reach, high: value + reach })
}

#[cfg(test)]
mod tests {
    use super::*;
    use random::Stream;

    /// Interval of the exponent of 40 rows in two groups, drawn with an exponent and a noise.
    fn drawn(power: f64, noise: f64, seed: u64) -> Exponent {
        let mut stream = Stream::of(seed, "relation");
        let group = |k: usize| f64::from(u8::from(k % 2 == 1));
        let settings: Vec<f64> = (0..40).map(|_| 0.8 * stream.normal()).collect();
        let target: Vec<f64> =
            settings.iter().enumerate().map(|(k, x)| power * x + 3.0 * group(k) + noise * stream.normal()).collect();
        let columns = [0.0, 1.0].map(|of| (0..40).map(|k| f64::from(u8::from(group(k) == of))).collect::<Vec<f64>>());
        exponent(&columns, &settings, &target).unwrap()
    }

    #[test]
    fn the_interval_holds_the_exponent_that_was_drawn() {
        let holds = |power: f64, seed: u64| {
            let Exponent { low, high, .. } = drawn(power, 0.3, seed);
            (low..=high).contains(&power)
        };
        let held = (0..200).filter(|&seed| holds([0.0, 0.5, 1.0][seed as usize % 3], seed)).count();
        // 190 expected, standard deviation 3.1.
        assert!((180..=199).contains(&held), "{held} of 200");
    }

    #[test]
    fn settings_that_do_not_vary_tell_nothing() {
        assert!(exponent(&[vec![1.0; 5]], &[2.0; 5], &[1.0, 2.0, 1.0, 2.0, 1.0]).is_none());
        assert!(exponent(&[vec![1.0; 2]], &[2.0, 1.0], &[1.0, 2.0]).is_none());
    }
}
