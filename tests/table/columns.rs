//! The form of the rate's dependence on a column is recovered with an interval; a permuted column is not named.

use lab::{DiagnosisSummary, Verdict};
use rand::{RngExt, SeedableRng};
use rand_pcg::Pcg64;
use trials::table::Table;
use trials::trial::Role;

use crate::causes::diagnosed;
use crate::hidden::table;
use crate::synthetic::{Hidden, MANIFEST, NOISE, Work, csv, work};

/// Number of permutations of a column.
const PERMUTATIONS: u64 = 20;

/// Makes rows whose column is permuted, so that it differs from time, and whose rate is a function of it.
fn rows(factor: impl Fn(f64) -> f64, seed: u64) -> Vec<Work> {
    let mut rows = work(Hidden::Nothing, NOISE, seed);
    rows.iter_mut().for_each(|row| row.wear += 20e-9);
    permute(&mut rows, seed);
    rows.iter_mut().for_each(|row| row.depth *= factor(row.wear * 1e9));
    rows
}

/// Permutes the column of rows.
fn permute(rows: &mut [Work], seed: u64) {
    let mut random = Pcg64::seed_from_u64(seed);
    for at in (1..rows.len()).rev() {
        let other = random.random_range(0..=at);
        (rows[at].wear, rows[other].wear) = (rows[other].wear, rows[at].wear);
    }
}

fn declared(rows: &[Work]) -> Table {
    table(&format!("{MANIFEST}usage = {{ column = \"wear\", unit = \"h\" }}\n"), &csv(rows))
}

fn diagnosis(rows: &[Work]) -> DiagnosisSummary {
    diagnosed(&declared(rows))
}

/// Returns the median of the column in calibration rows [h], at which a linear form equals the base law's rate.
fn middle(table: &Table) -> f64 {
    let rows = table.rows.iter().filter(|row| row.role == Role::Calibration);
    let mut values: Vec<f64> = rows.map(|row| row.usage[0] / 3600.0).collect();
    values.sort_by(f64::total_cmp);
    values[values.len() / 2]
}

/// Asserts that a form is found by its effect, and one of its parameters within its interval.
fn finds(factor: impl Fn(f64) -> f64, effect: &str, (parameter, truth): (&str, f64), said: &str) {
    let summary = diagnosis(&rows(factor, 11));
    assert_eq!(summary.verdict, Verdict::Identified, "{effect}");
    let found = &summary.effects[0];
    assert_eq!(found.name, effect);
    let [low, high] = found.parameters[parameter].interval.expect("an interval");
    println!("{effect}.{parameter}: {low} to {high} for {truth}");
    let width = high - low;
    assert!(low - 0.3 * width < truth && truth < high + 0.3 * width, "{effect}: {low} to {high} for {truth}");
    assert!(width < 0.5 * truth.abs(), "{effect}: {low} to {high}");
    assert!(summary.sentence.contains(said), "{}", summary.sentence);
    // The other forms are listed, each with the reason why it is rejected.
    let others: Vec<_> = summary.suspects.iter().filter(|other| other.name.ends_with("column-wear")).collect();
    assert!(others.len() > 1, "{effect}");
    let is_out = |other: &&&lab::EffectSummary| other.name != effect && other.ruled_out.is_none() && other.search == 1;
    assert!(!others.iter().any(|other| is_out(&other)), "{effect}");
}

#[test]
fn an_exponential_is_found() {
    finds(|wear| (-3e-3 * wear).exp(), "column-wear", ("change", -3e-3), "The rate changes by -0.");
}

#[test]
fn a_line_is_found() {
    let line = |wear: f64| 1.0 - 1.6e-3 * wear;
    let truth = -1.6e-3 / line(middle(&declared(&rows(line, 11))));
    finds(line, "line-of-column-wear", ("change", truth), "of its value in the middle");
}

#[test]
fn a_power_is_found() {
    finds(|wear| (wear / 290.0).powf(-0.4), "power-of-column-wear", ("exponent", -0.4), "with the power -0.");
}

#[test]
fn a_floor_is_found() {
    let floor = |wear: f64| 1.0 - 0.5 * (1.0 - (-(wear - 20.0) / 80.0).exp());
    finds(floor, "floor-of-column-wear", ("scale", 80.0), "1/e of that is left after");
}

/// A permutation may be named with a probability below the level of 5 %, so one of twenty is allowed.
#[test]
fn a_permuted_column_is_not_named() {
    let mut named = 0;
    for seed in 0..PERMUTATIONS {
        let mut rows = rows(|wear| (-1e-3 * wear).exp(), seed);
        permute(&mut rows, 1000 + seed);
        let summary = diagnosis(&rows);
        named += usize::from(summary.effects.iter().any(|effect| effect.name.ends_with("column-wear")));
    }
    println!("{named} of {PERMUTATIONS} permuted columns are named");
    assert!(named <= 1, "{named}");
}
