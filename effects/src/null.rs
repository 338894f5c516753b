//! The null value must be an exact identity: at it, an effect leaves every value unchanged to the last bit.
//!
//! The inputs are a fixed set: both ends of each variable's plausible range, zeros, and values between. States evolve
//! by their own formulas from their initial values.

use super::definition::{Effect, Parameter};
use super::error::{EffectError, Problem};
use super::interpret::Environment;
use super::process::Process;
use super::scope::Scope;
use super::variable::{TABLE, VariableRow};

/// Number of runs, each from the initial states.
const RUNS: u64 = 16;
/// Steps per run.
const STEPS: u64 = 6;
/// Duration of a step [s].
const DURATION: f64 = 0.05;

/// Checks that the effect vanishes at its null values.
pub fn check_null(effect: &Effect, laws: &[Effect]) -> Result<(), EffectError> {
    for process in Process::ALL.into_iter().filter(|process| effect.acts_in(*process)) {
        for run in 0..RUNS {
            let parameters: Vec<f64> =
                effect.parameters.iter().map(|parameter| null_value(parameter, process, run)).collect();
            check_run(effect, laws, (process, run), &parameters)?;
        }
    }
    Ok(())
}

/// Returns the null value, or one of the values of a parameter without a null value.
fn null_value(parameter: &Parameter, process: Process, run: u64) -> f64 {
    let [low, high] = parameter.range.of(process);
    parameter.null.unwrap_or(match run % 3 {
        0 => parameter.default.of(process),
        1 => low,
        _ => high,
    })
}

fn check_run(
    effect: &Effect,
    laws: &[Effect],
    (process, run): (Process, u64),
    parameters: &[f64],
) -> Result<(), EffectError> {
    let law_parameters = law_defaults(laws, process);
    let mut states: Vec<f64> = effect.states.iter().map(|state| state.initial).collect();
    for step in 0..STEPS {
        let variables = probe(run * STEPS + step);
        let at = |place| Environment {
            scope: Scope::new(effect, place, laws),
            parameters,
            law_parameters: &law_parameters,
            variables: &variables,
            states: &states,
        };
        for change in effect.changes_in(process) {
            let environment = at(change.hook);
            let before = variables[change.value as usize];
            let after = environment.evaluate(&change.formula.tree);
            if after == before {
                continue;
            }
            let inputs = environment.inputs(&change.formula);
            let problem = if after.is_finite() {
                Problem::NotNull { value: change.value, before, after, inputs }
            } else {
                Problem::BrokenAtNull { result: after, cause: environment.cause(&change.formula), inputs }
            };
            return Err(environment.scope.error(&change.formula, &change.formula.tree.span, problem));
        }
        let next =
            effect.states.iter().enumerate().map(|(index, state)| at(state.per.place()).advanced(index, DURATION));
        states = next.collect();
    }
    Ok(())
}

/// Default parameters of the laws.
pub fn law_defaults(laws: &[Effect], process: Process) -> Vec<Vec<f64>> {
    let values = |law: &Effect| law.parameters.iter().map(|parameter| parameter.default.of(process)).collect();
    laws.iter().map(values).collect()
}

/// The `index`-th set of inputs, indexed by variable.
pub fn probe(index: u64) -> Vec<f64> {
    let value = |(variable, row): (usize, &VariableRow)| {
        let [low, high] = row.probe;
        let random = scramble(index.wrapping_mul(1009).wrapping_add(variable as u64));
        match index {
            0 => low,
            1 => high,
            _ if random.is_multiple_of(8) && low <= 0.0 && 0.0 <= high => 0.0,
            _ => low + (high - low) * ((random >> 11) as f64 / (1u64 << 53) as f64),
        }
    };
    TABLE.iter().enumerate().map(value).collect()
}

/// A deterministic mixing function of integers (splitmix64, Steele, Lea and Flood 2014).
fn scramble(index: u64) -> u64 {
    let mut z = index.wrapping_add(1).wrapping_mul(0x9e37_79b9_7f4a_7c15);
    z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
    z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
    z ^ (z >> 31)
}
